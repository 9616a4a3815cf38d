"""Drilling cycles of CL data as moves: CYCLE switches one on, and every GOTO is a hole until it is switched off."""

from dataclasses import replace
from typing import Any

import numpy as np

from mathpost.machine import MM_PER_INCH
from mathpost.path.arcs import Cycle
from mathpost.path.cl_lines import REAL, known, need
from mathpost.path.modal import Command
from mathpost.path.moves import Movements
from mathpost.path.orders import BACK, FEED_UNITS, LEAST_FEED
from mathpost.path.pieces import Hole

CYCLES = "DRILL SPOT FACE CSINK CBORE DEEP DEEP2 BRKCHP BORE REAM TAP".split()
PECKED = ("DEEP", "DEEP2", "BRKCHP")
OF_A_CYCLE = {
    **dict.fromkeys(["FEDTO", "DEPTH"], "depth"),
    **{"CLEAR": "clearance", "RAPTO": "approach", "1STPECK": "first"},
    **dict.fromkeys(["RTRCTO", "RETURN"], "retract"),
    **dict.fromkeys(["SUBPECK", "STEP", "INCR"], "following"),
}
DWELLS = ("DWELL", "REV")  # in seconds or turns, also DWELL,REV,n and DWELL,n,REV
CHIP_BREAKING = 0.5  # mm that BRKCHP goes back


class Holes(Movements):
    def __init__(self, name: str, tolerance: float) -> None:
        super().__init__(name, tolerance)
        self.cycle_feed: float | None = None  # mm per turn that the cycle goes at, or None
        self.last: tuple[str, dict[str, Any]] = "", {}  # the cycle that CYCLE/ON resumes, and what its words stated

    def on_cycle(self, words: list[str]) -> None:
        kind, *words = words or [""]
        need(kind != "ON" or self.last[0], "a cycle before CYCLE/ON", "none")
        if kind in ("OFF", "CLEAR", "INIT"):
            need(not words, f"CYCLE/{kind}, and nothing behind it", ",".join(words))
            self.cycle, self.last = None, self.last if kind == "OFF" else ("", {})
            return
        before: dict[str, Any] = {}
        if kind == "ON":  # the last one goes on, with the words behind it in place of its own
            kind, before = self.last
        elif kind == "DRILL" and words[:1] in (["DEEP"], ["BRKCHP"]):  # NX
            kind, words = words[0], words[1:]
        need(kind in CYCLES, f"CYCLE/{', '.join(CYCLES)} or OFF")
        given = before | self.parts_of_a_cycle(words)
        self.cycle, self.last = self.cycle_of(kind, dict(given)), (kind, given)

    def cycle_of(self, kind: str, given: dict[str, Any]) -> Cycle:
        """Return a cycle of what its words state."""
        modal = self.modal
        turning = modal.speed is not None and modal.turning
        need(turning or kind != "TAP", "a turning spindle before CYCLE/TAP", "none")
        feed, per_turn = given.get("feed", (modal.feed, modal.per_turn))
        self.cycle_feed = feed if per_turn else None
        if per_turn:
            feed *= known(modal.speed or None, "SPINDL with turns per minute before a feed per turn", "none")
        given["feed"] = feed
        need(given["feed"] >= LEAST_FEED, "a feed in the cycle or before it", "none")
        # Creo counts RAPTO from CLEAR downwards, the others have one of both.
        clear, approach = given.get("clearance"), given.pop("approach", None)
        if approach is not None:
            given["clearance"] = approach if clear is None else clear - approach
        heights = "depth" in given and given.get("clearance", 0) > 0
        need(heights, "a depth (FEDTO or DEPTH) and a clearance (RAPTO or CLEAR)")
        given["depth"] = abs(given["depth"])  # NX counts upwards, SolidWorks and Creo downwards
        pecks = given.get("first", 0) > 0 or given.get("following", 0) > 0
        need(
            not pecks or kind != "TAP", "a tap that goes down in one: its spindle turns back at the bottom", "STEP"
        )
        need(pecks or kind not in PECKED, f"STEP, how deep {kind} goes at a time", "none")
        if kind == "BRKCHP":
            given["out"] = CHIP_BREAKING
        return Cycle(kind, **given)

    def parts_of_a_cycle(self, words: list[str]) -> dict[str, Any]:
        """Return what words of a cycle state, mm and seconds; "feed" is mm, and whether that is per turn."""
        given: dict[str, Any] = {}
        while words:
            word, *words = words
            if word in ("AUTO", "MANUAL"):
                continue
            own_word = "each number of a cycle after its word, such as DEPTH (in CATIA the PP table writes them)"
            need(not REAL.fullmatch(word), own_word)
            known = [*OF_A_CYCLE, *DWELLS, "TPI", *FEED_UNITS]
            need(word in known, f"one of {', '.join(known)} in a cycle", repr(word))
            name = "dwell" if word in DWELLS else OF_A_CYCLE.get(word, "feed")
            need(name not in given, f"one word for the {name} of a cycle", f"{word}, a second one")
            numbered = bool(words) and REAL.fullmatch(words[0]) is not None
            if name == "retract" and (words[:1] == ["AUTO"] or (word == "RETURN" and not numbered)):
                given[name] = None  # to where the tool came from
                words = words[words[:1] == ["AUTO"] :]
                continue
            turns = word == "REV" or (word == "DWELL" and words[:1] == ["REV"])
            said, *words = words[turns and word == "DWELL" :] or [""]
            value = self.number(said)
            if name == "dwell":
                if words[:1] == ["REV"]:
                    turns, words = True, words[1:]
                given[name] = self.seconds(value, turns)
            elif word == "TPI":
                need(value > 0, "threads per inch, above 0", said)
                given[name] = MM_PER_INCH / value, True
            elif name == "feed":
                given[name] = self.feed_of(value, word)
            else:  # Creo: RETURN,0 is to the retract plane, where the tool came from
                given[name] = value * self.scale if value or word != "RETURN" else None
        return given

    def speed_changed(self) -> None:
        super().speed_changed()
        if self.cycle is not None and self.cycle_feed is not None and self.modal.speed:
            self.cycle = replace(self.cycle, feed=self.cycle_feed * self.modal.speed)

    def on_loadtl(self, words: list[str]) -> None:
        need(self.cycle is None, "CYCLE/OFF before the tool is changed", "a cycle that holds")
        super().on_loadtl(words)

    def drill(self, cycle: Cycle, point: np.ndarray, axis: np.ndarray) -> None:
        """Add the moves of a hole."""
        tapped = cycle.kind == "TAP"
        modal = self.modal
        need(not tapped or modal.turning, "a turning spindle before a hole is tapped", "OFF")
        before = float((np.array(self.point) - point) @ axis) if self.point is not None else cycle.clearance
        heights, rapid, bottom = cycle.heights(before)
        first, after, said_before = self.count, self.count + bottom + 1, len(self.remarks)
        self.go(point + np.outer(heights, axis), axis, feed=cycle.feed, rapid=rapid)
        if cycle.dwell:
            self.command("dwell", cycle.dwell, statement=f"DELAY/{cycle.dwell:g}", record=after)
        if tapped:  # out again with the spindle turning back
            for record, sense in ((after, BACK[modal.sense]), (after + 1, modal.sense)):
                said = f"SPINDL/{modal.speed:g},RPM,{sense}"
                self.command("spindle", modal.speed, sense, statement=said, record=record)
            self.counts["tapped holes, which need a floating holder where the program has moves for them"] += 1
        self.counts["holes of drilling cycles"] += 1
        commands = tuple(command for _, command in self.remarks[said_before:] if isinstance(command, Command))
        self.pieces.append(Hole(first, self.count - 1, cycle, commands))

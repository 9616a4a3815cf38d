"""The words of CL data that change the modal state or command the control: feeds, tools, spindle, coolant, …

`mathpost.path.modal` is the state. Forms are those of NX, Creo, CATIA and SolidWorks, and of post-processors widely
used for them (PTC, "Supported CL Data Commands"; NCCS, PostWorks; ICAM's words as Autodesk writes them).
"""

import math
from typing import Any

from numpy.typing import ArrayLike

from mathpost.machine import MM_PER_INCH
from mathpost.path.cl_lines import LARGEST, REAL, Lines, known, need
from mathpost.path.modal import Command, Modal
from mathpost.path.nc_words import AUXILIARY, WORD

SCALES = {"MM": 1.0, "CM": 10.0, "INCH": MM_PER_INCH, "INCHES": MM_PER_INCH, "IN": MM_PER_INCH}
LEAST_FEED = 0.001  # mm/min, which programs print
LARGEST_TOOL = 99_999_999
LARGEST_OFFSET = 999
BACK = {"CLW": "CCLW", "CCLW": "CLW"}
SENSES = {"CLW": "CLW", "CCLW": "CCLW", "CCW": "CCLW"}
RANGES = ("LOW", "MEDIUM", "HIGH", "AUTO")
COOLANTS = ("FLOOD", "MIST", "THRU", "AIR", "TAP")
OFFSETS = ("ADJUST", "OSETNO", "OFFSET")
OF_A_TOOL = "AUTO MANUAL MILL DRILL TAP BORE REAM".split()  # behind its number: how it comes, what it is
FEED_UNITS = {  # mm in it, None for the unit of the file; and whether it is per turn
    "MMPM": (1.0, False),
    "IPM": (MM_PER_INCH, False),
    "FPM": (12 * MM_PER_INCH, False),
    "PERMIN": (None, False),
    "MMPR": (1.0, True),
    "IPR": (MM_PER_INCH, True),
    "FPR": (12 * MM_PER_INCH, True),
    "PERREV": (None, True),
}
IN_INCHES = ("IPM", "FPM", "IPR", "FPR")
SKIPPED = ("spindle", "coolant", "dwell", "stop", "optional stop", "verbatim")


class Orders(Lines):
    """Takes statements that do not move the tool; ``on_word`` takes the text after the slash of that word."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.modal, self.units_stated = Modal(), False
        self.asked: float | None = None  # mm in the unit of a file that should state none

    def assume(self, unit: str | None, feed: float | None) -> None:
        """Take a unit, one of `SCALES`, and a feed, mm/min, for a file that does not state them."""
        if unit is not None:
            self.on_units([unit.upper()])
            self.asked = self.scale
        if feed is not None:
            need(LEAST_FEED <= feed < LARGEST, f"a feed of at least {LEAST_FEED:g} mm/min", f"{feed:g}")
            self.feed = self.modal.feed = feed

    def command(self, kind: str, *values: Any, statement: str | None = None, record: int | None = None) -> None:
        skip = self.modal.skip
        need(not skip or kind in SKIPPED, "OPSKIP/OFF first: what may be left out cannot be proved", "OPSKIP/ON")
        self.remark(Command(kind, values, statement or self.statement, skip), record)

    # Units and feeds

    def on_units(self, words: list[str]) -> None:
        need(len(words) == 1 and words[0] in SCALES, "UNITS/MM or UNITS/INCH", ",".join(words) or "nothing")
        scale = SCALES[words[0]]
        need(self.asked in (None, scale), "the unit that --unit states, or no --unit")
        self.scale, self.units_stated = scale, True

    def on_rapid(self, words: list[str]) -> None:
        # Neither MODAL nor a feed, which the control would not take.
        need(not words, "RAPID, or RAPID/ and nothing")
        self.rapid = True

    def on_fedrat(self, words: list[str]) -> None:
        if words == ["RAPID"]:
            self.rapid = True
            return
        if words in (["INVERS", "AUTO"], ["INVERS", "OFF"]):  # Creo: how the feed is written, which programs decide
            self.remark()
            return
        units = [word for word in words if word in FEED_UNITS]
        values = [word for word in words if word not in FEED_UNITS]
        one_each, said = len(values) == 1 and len(units) < 2, ",".join(words) or "nothing"
        need(one_each, "FEDRAT/ a number and MMPM, IPM, MMPR or IPR", said)
        value = self.number(values[0])
        self.modal.feed, self.modal.per_turn = self.feed_of(value, units[0] if units else "PERMIN")
        need(self.modal.feed > 0, f"a feed above 0, at least {LEAST_FEED:g} mm/min", f"{value:g}")
        self.speed_changed()

    def feed_of(self, value: float, unit: str) -> tuple[float, bool]:
        """Return a feed in mm, and whether it is per turn."""
        stated = self.units_stated or unit not in IN_INCHES
        need(stated, "UNITS/MM or UNITS/INCH before a feed in inches: the points may be inches, too", "none")
        size, per_turn = FEED_UNITS[unit]
        return value * (self.scale if size is None else size), per_turn

    def speed_changed(self) -> None:
        """Compute the feed per minute anew: a feed per turn follows the spindle."""
        self.feed = self.modal.feed_per_minute
        least = f"a feed above 0, at least {LEAST_FEED:g} mm/min"
        need(math.isnan(self.feed) or self.feed >= LEAST_FEED, least, f"{self.feed:g}")

    def go(self, points: ArrayLike, axis: ArrayLike, **options: Any) -> None:
        """Add records; refuse a move that may be skipped or whose feed is not known."""
        need(
            not self.modal.skip, "OPSKIP/OFF before a move: one that may be left out cannot be proved", "OPSKIP/ON"
        )
        timed = "feed" in options or options.get("rapid", self.rapid) or not self.modal.lacks_speed
        need(timed, "SPINDL with turns per minute before a move with a feed per turn", "none")
        super().go(points, axis, **options)

    # Tools and their offsets

    def on_load(self, words: list[str]) -> None:
        need(words[:1] == ["TOOL"], "LOAD/TOOL, and a number")
        self.on_loadtl(words[1:])

    def on_loadtl(self, words: list[str]) -> None:
        said, *words = words or [""]
        number = self.number(said)
        length: float | None = None
        statement: str | None = None
        offsets: list[int] = []
        need(number == int(number) and 0 <= number <= LARGEST_TOOL, "the number of a tool", said)
        while words:
            word, *words = words
            if word == "LENGTH":
                said, *words = words or [""]
                length = self.number(said) * self.scale
                need(length >= 0, "a tool length, not negative", f"{length:g}")
            elif word in OFFSETS:
                offsets, words = self.offsets(words)
            elif word == "NEXTTL":
                words = words[1:]
            elif word.isdigit() and int(word) <= 99:  # CATIA: of the assembly and its corrector
                self.counts["numbers behind that of a tool, which name nothing"] += 1
            else:
                named = word in OF_A_TOOL or word[0:1] in ("'", '"')
                need(named, "the word LENGTH before a length, OSETNO before the number of an offset", word)
        before = self.modal.loaded
        self.modal.load(int(number), *offsets, *[None] * (2 - len(offsets)))
        self.modal.loaded = int(number), length, self.modal.length_offset, self.modal.radius_offset
        if self.modal.loaded == before:  # CATIA repeats it at each operation: spindle and coolant go on
            self.counts["tools called again that are in the spindle: they stay"] += 1
            self.remark()
            return
        if length is not None:  # in mm, whatever the file is in
            registers = "".join(f",{offset}" for offset in offsets)
            statement = f"LOADTL/{int(number)},LENGTH,{length:g}" + f",OSETNO{registers}" * bool(offsets)
        self.command("tool", int(number), length, self.modal.length_offset, statement=statement)

    def offsets(self, words: list[str]) -> tuple[list[int], list[str]]:
        """Return the numbers of a length offset and, if stated, a radius offset; and the words after them."""
        taken = 2 if len(words) > 1 and words[1].isdigit() else 1
        return [self.offset(word) for word in words[:taken] or [""]], words[taken:]

    def offset(self, word: str) -> int:
        whole = word.isdigit() and int(word) <= LARGEST_OFFSET
        need(whole, f"the number of an offset, whole and up to {LARGEST_OFFSET}", repr(word))
        self.counts["numbers of offsets, which a control that has none takes from the tool's"] += 1
        return int(word)

    def on_toolno(self, words: list[str]) -> None:
        """Take the description of a tool; the numbers of its offsets apply when it is loaded."""
        if "OSETNO" in words and words[0].isdigit():
            offsets, _ = self.offsets(words[words.index("OSETNO") + 1 :])
            self.modal.offsets[int(words[0])] = offsets[0], offsets[1] if len(offsets) > 1 else None
        self.remark()

    def set_offset(self, word: str) -> None:
        """Use the length offset of another number from here on."""
        self.modal.length_offset = self.offset(word)
        self.command("offset", self.modal.length_offset)

    def on_cutcom(self, words: list[str]) -> None:
        side, number, length = None, None, None
        while words:
            word, *words = words
            need(word not in ("ZXPLAN", "YZPLAN"), "CUTCOM in XYPLAN, the plane of programs", word)
            if word in ("LEFT", "RIGHT", "OFF"):
                side = word
            elif word in ("ON", "XYPLAN"):
                side = side or ("ON" if word == "ON" else None)
            elif word == "LENGTH" and words:
                length, *words = words
            elif word == "OSETNO" or word.isdigit():
                said, *words = words or [""] if word == "OSETNO" else [word, *words]
                number = self.offset(said)
            else:
                side = length = None
                break
        need(side or length, "CUTCOM/LEFT, RIGHT, ON or OFF, XYPLAN, OSETNO and the number of an offset")
        if number is not None:
            self.modal.radius_offset = number
        if length is not None:  # a tool length: ON then means no side
            self.set_offset(length)
        elif side == "ON" and self.modal.side is None:  # the side follows
            self.remark()
        else:
            side = self.modal.side if side == "ON" else side
            self.modal.side = self.modal.side if side == "OFF" else side
            self.command("compensation", side, self.modal.radius_number())

    # Spindle, coolant, stops

    def on_spindl(self, words: list[str]) -> None:
        numbers, switched, geared, modal = [], [], False, self.modal
        need(words, "SPINDL/ a number, RPM, CLW or CCLW, ON or OFF", "nothing")
        while words:
            word, *words = words
            if REAL.fullmatch(word):
                numbers.append(word)
            elif word == "RANGE":
                need(words, "RANGE and which", "nothing")
                geared, words = True, words[1:]
            elif word in RANGES:
                geared = True
            elif word in SENSES:
                modal.sense = SENSES[word]
            else:
                switch = word in ("RPM", "ON", "OFF", "STOP")
                need(switch, "SPINDL/ a number, RPM, CLW or CCLW, RANGE, ON or OFF", repr(word))
                switched.append(word)
        need(len(numbers) < 2, "SPINDL/ one number", f"{len(numbers)}")
        modal.turning = not {"OFF", "STOP"} & {*switched}
        if numbers:
            modal.speed = self.number(numbers[0])
            need(modal.speed >= 0, "turns per minute, not negative", numbers[0])
        if geared:
            self.counts["gear ranges of the spindle, left to the control"] += 1
        self.speed_changed()
        self.command("spindle", modal.speed if numbers else None, modal.sense if modal.turning else "OFF")

    def on_coolnt(self, words: list[str]) -> None:
        expected = "COOLNT/ON, FLOOD, MIST, THRU, AIR, TAP or OFF"
        kinds = [word for word in words if word in COOLANTS]
        others = {*words} - {*kinds, "ON", "OFF", *RANGES}
        need(len(kinds) < 2 and not others and {*words} - {*RANGES}, expected)
        self.modal.coolant = kinds[0] if kinds else self.modal.coolant
        if "OFF" in words:
            self.command("coolant", "OFF")
        else:
            self.command("coolant", self.modal.coolant)

    def on_stop(self, words: list[str]) -> None:
        need(not words, "STOP or OPSTOP, and nothing behind it", ",".join(words))
        self.command("optional stop" if self.statement.upper().startswith("OP") else "stop")

    def on_delay(self, words: list[str]) -> None:
        turns, words = "REV" in words, [word for word in words if word != "REV"]
        need(len(words) == 1, "DELAY/ seconds, or DELAY/ turns,REV")
        self.command("dwell", self.seconds(self.number(words[0]), turns))

    def seconds(self, number: float, turns: bool) -> float:
        """Return how long a delay in seconds or in turns of the spindle is."""
        if not turns:
            return number
        speed = known(self.modal.speed or None, "SPINDL with turns per minute before a delay in turns", "none")
        return number * 60 / speed

    def on_opskip(self, words: list[str]) -> None:
        need(words in (["ON"], ["OFF"]), "OPSKIP/ON or OFF")
        self.modal.skip = words == ["ON"]
        self.remark()

    # Words that go into the program unchanged

    def insert(self) -> None:
        """Take the text of INSERT, which APT copies into the program; SolidWorks, with a slash, writes remarks."""
        text = self.statement[len("INSERT") :].strip()
        slash, text = text.startswith("/"), text.removeprefix("/").strip()
        words = text.upper().split()
        nc_words = [match for match in map(WORD.fullmatch, words) if match and len(match[1]) < 3]
        if words and len(nc_words) == len(words):
            self.verbatim(words)
        else:
            comment = slash or text.startswith(("(", ";"))
            need(comment, "INSERT of M words, or of a comment: other words could move the tool", repr(text))
            self.remark()

    def verbatim(self, words: list[str]) -> None:
        allowed = all(AUXILIARY.fullmatch(word) for word in words)
        need(allowed, "M words that move nothing, M0 to M88: others could move the tool", repr(" ".join(words)))
        self.command("verbatim", " ".join(words))

    def on_auxfun(self, words: list[str]) -> None:
        need(len(words) == 1 and words[0].isdigit(), "AUXFUN/ the number of an M word")
        self.verbatim([f"M{int(words[0])}"])

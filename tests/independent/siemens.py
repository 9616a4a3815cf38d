"""SINUMERIK 840D sl: the same blocks with names, calls and `=`.

Programming Manual Fundamentals 6FC5398-1BP40-2BA0 (09/2011): 6 (F, FGROUP, FGREF, G93–G95), 9 (G2/G3 with CR=,
TURN=), 12 (TRANS, SUPA, G53, G153, G500); Job Planning 6FC5398-2BP40: TRAORI, TRAFOOF; Cycles: CYCLE800, CYCLE81 to
CYCLE83. Assumed: F of a block that only turns is in degrees a minute, under TRAORI, too.
"""

import contextlib
import math

import numpy as np

from .machine_model import rotation
from .word_address import TAKES, WordAddress
from .words import Refused, scan, without_comments

GROUPS = {
    "motion": (0, 1, 2, 3), "plane": (17, 18, 19), "distance": (90, 91), "feed": (93, 94, 95),
    "unit": (70, 71, 700, 710), "compensation": (40, 41, 42), "offset": (500, 54, 55, 56, 57),
    "suppress": (53, 153), "path": (60, 64, 641, 642), "stop": (601, 602), "dwell": (4,),
}  # fmt: skip
SILENT = {"MSG", "WAIT", "SOFT", "BRISK", "FFWON", "FFWOF", "COMPOF", "COMPCAD", "COMPCURV", "ORIWKS", "ORIMKS",
          "ORIAXES", "CUT3DC", "CUT2D", "STOPRE", "FIFOCTRL", "ADIS", "UPATH", "SPATH", "CYCLE832",
          "WORKPIECE"}  # fmt: skip


class Siemens(WordAddress):
    def __init__(self, setup, dialect):
        super().__init__(setup, dialect)
        self.length_on = True  # a tool's D1 is on as soon as the tool is
        self.path_axes = None  # FGROUP; None is the default, the geometry axes
        self.reference_radius = {}
        self.modal_cycle = None
        self.ori_wks = False

    def block(self, _):
        text = without_comments(self.text, self.line, False, True).strip()
        if text.startswith("/"):
            text = text[1:]
            if self.setup.optional_skip:
                return
        if not text or text.startswith("%"):
            return
        values, codes, auxiliary, names = {}, [], [], {}
        for word in scan(text, self.line, names=True):
            if word.name == "G" and word.value is not None:
                codes.append(word.value)
            elif word.name == "M" and word.value is not None:
                auxiliary.append(int(word.value))
            elif len(word.name) == 1 and (word.value is not None or word.arguments):
                if word.name in values:
                    self.refuse(f"{word.name} twice")
                values[word.name] = self.value_of(word)
            else:
                names[word.name] = word
        values.pop("N", None)
        self.run(values, self.grouped(codes), auxiliary, names)

    def value_of(self, word):
        if word.arguments is None:
            return word.value
        if word.name == "T":
            return word.arguments[0].strip('"')
        way, inside = word.arguments if len(word.arguments) == 2 else ("", word.arguments[0])
        try:
            number = float(inside)
        except ValueError:
            raise Refused(self.line, f"{word.name}={inside}: no number") from None
        if word.name in self.model.letters and way in ("DC", "ACP", "ACN"):
            now = self.turned[self.model.letters.index(word.name)]
            difference = (number - now) % 360.0
            if (way == "DC" and difference > 180.0) or (way == "ACN" and difference):
                difference -= 360.0
            return now + difference
        if way == "AC":
            return number
        return self.refuse(f"{word.name}={way}(…)")

    def grouped(self, codes):
        groups = {}
        for code in codes:
            if code not in TAKES["siemens"]:
                self.refuse(f"G{code:g} is no code of Siemens")
            name = next(name for name, members in GROUPS.items() if code in members)
            if name in groups:
                self.refuse(f"two codes of the group {name}")
            groups[name] = code
        return groups

    def run(self, values, groups, auxiliary, names):
        if groups.get("dwell"):
            seconds = values["F"] if "F" in values else 60.0 * values["S"] / self.speed
            return self.dwell(seconds)
        self.names(names, values)
        if "unit" in groups:
            groups["unit"] = 20 if groups["unit"] in (70, 700) else 21
        if groups.get("offset") == 500:
            del groups["offset"]
            self.base = np.zeros(3)
        self.modes(values, groups)
        if "T" in values or "D" in values:
            self.tool_words(values)
        for code in auxiliary:
            if code == 6:
                self.change(self.pending if self.pending is not None else self.refuse("M6 without T"))
            elif code == 17:
                self.ended = True
            else:
                self.switch(code, values)
        if "motion" in groups:
            self.motion = groups["motion"]
        if not any(letter in values for letter in "XYZABCIJK"):
            return None
        if "SUPA" in names or "suppress" in groups:
            if self.tcp:
                self.refuse("machine coordinates while TRAORI is active name no slides")
            return self.machine_move(values)
        if self.motion in (2, 3) and "CR" in names:
            values["R"] = names["CR"].value
        self.turns = int(names["TURN"].value) if "TURN" in names else 0
        self.travel(values)
        if self.modal_cycle is not None and any(letter in values for letter in "XYZ"):
            self.call_cycle(self.modal_cycle)
        return None

    def tool_words(self, values):
        if "T" in values:
            self.pending = values["T"]
            with contextlib.suppress(ValueError):
                self.pending = int(float(self.pending))
        if values.get("D") == 0:
            self.length_on = False
            self.update()
        elif "D" in values:
            self.length_on = True
            self.update()

    def change(self, number):
        if self.tcp:
            self.refuse("a tool change under TRAORI")
        self.change_tool(number)

    def names(self, names, values):
        for name, word in names.items():
            if name == "TRAORI":
                if not self.length_on:
                    self.refuse("TRAORI without a tool length")
                self.tcp = True
                self.update()
            elif name == "TRAFOOF":
                self.tcp = False
                self.update()
            elif name == "FGROUP":
                self.path_axes = [axis for axis in word.arguments if axis] or None
                unknown = [axis for axis in word.arguments if axis and axis not in (*"XYZ", *self.model.letters)]
                if unknown:
                    self.refuse(f"FGROUP of {unknown}")
            elif name == "FGREF":
                self.reference_radius[word.arguments[0]] = float(word.arguments[1])
            elif name == "CYCLE800":
                self.swivel(word.arguments)
            elif name == "MCALL":
                if len(names) == 1:
                    self.modal_cycle = None
            elif name in ("CYCLE81", "CYCLE82", "CYCLE83", "CYCLE84", "CYCLE85"):
                if "MCALL" in names:
                    self.modal_cycle = (name, word.arguments)
                else:
                    self.call_cycle((name, word.arguments))
            elif name in ("TRANS", "ATRANS"):
                shift = np.array([values.pop(letter, 0.0) for letter in "XYZ"])
                self.shift = shift + (self.shift if name == "ATRANS" else 0.0)
                self.update()
            elif name == "DIAMOF" or name in ("SUPA", "CR", "TURN") or name in SILENT:
                continue
            else:
                self.refuse(f"{name} is no word that is read here")

    def travel(self, values):
        if self.motion in (2, 3) and self.turns:
            target, angles = self.targets(values)
            centre = self.at + np.array([values.get(letter, 0.0) for letter in "IJK"])
            return self.arc_to(target, angles, self.motion == 2, centre=centre, turns=self.turns)
        return super().travel(values)

    def swivel(self, arguments):
        """CYCLE800(FR, TC, ST, MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, DIR, …); empty brackets undo it."""
        if not any(arguments):
            self.plane = None
            return self.update()
        if self.tcp:
            self.refuse("CYCLE800 under TRAORI")
        number = [float(a) if a and a[0] != '"' else 0.0 for a in (*arguments, *[""] * 15)]
        mode = int(number[3])
        if mode >> 6:
            self.refuse(f"CYCLE800 mode {mode}: only axis by axis is read")
        turn = np.eye(3)
        for place in range(3):  # bits 0-1 the first axis, 2-3 the second, 4-5 the third; each about the turned axes
            axis = (mode >> (2 * place)) & 3
            if axis == 0:
                self.refuse(f"CYCLE800 mode {mode}")
            turn = turn @ rotation(np.eye(3)[axis - 1], number[7 + place])
        origin = np.array(number[4:7]) + turn @ np.array(number[10:13])
        self.plane = (turn, origin)
        self.update()
        if int(number[13]):
            found = self.model.angles_for(turn[:, 2], self.turned)
            if not found:
                self.refuse("the plane is out of reach")
            self.go("rapid", self.at, found[0])
        return None

    def call_cycle(self, cycle):
        """CYCLE81(RTP, RFP, SDIS, DP, DPR), CYCLE82(…, DTB), CYCLE83(…, FDEP, FDPR, DAM, DTB, DTS, FRF, VARI).

        CYCLE84(…, DTB, SDAC, MPIT, PIT, POSS, SST, SST1) taps at PIT · SST, CYCLE85(…, DTB, FFR, RFF) bores.
        """
        name, arguments = cycle
        given = [float(a) if a else None for a in (*arguments, *[""] * 14)]
        surface, safety = given[1], given[2] or 0.0
        depth = given[3] if given[3] is not None else surface - given[4]
        peck = None
        chip_break = False
        if name == "CYCLE83":
            first = given[5] if given[5] is not None else surface - (given[6] or 0.0)
            peck = surface + safety - first
            chip_break = not given[11]
            if given[7]:
                self.refuse("CYCLE83 with degression is not read")
        dwell = 0.0 if name == "CYCLE81" else given[8 if name == "CYCLE83" else 5] or 0.0
        feed = None
        if name == "CYCLE84":
            feed = abs(given[8]) * given[10]
        elif name == "CYCLE85":
            feed = given[6]
        position = self.at.copy()
        self.drill(
            position, surface + safety, depth, given[0], peck=peck, chip_break=chip_break, dwell=dwell, feed=feed,
            out="feed" if name in ("CYCLE84", "CYCLE85") else "rapid",
        )  # fmt: skip

    def joint_seconds(self, length, turned, feed):
        """FGROUP: the path is that of its axes; by default X Y Z, and the rotary axes come along."""
        if self.path_axes is None:
            if length > 1e-9:
                return 60.0 * length / feed, "along the slides"
            return 60.0 * turned / feed, "degrees a minute"
        turn = self.turn_of_block
        rotary = 0.0
        for letter, angle in zip(self.model.letters, turn, strict=True):
            if letter in self.path_axes:
                radius = self.reference_radius.get(
                    letter, 180.0 / math.pi
                )  # by default a degree counts a millimetre
                rotary += (math.radians(angle) * radius) ** 2
        linear = length if "X" in self.path_axes else 0.0
        path = math.hypot(linear, math.sqrt(rotary))
        if path < 1e-9:
            return 60.0 * max(length, turned) / feed, "along the axes that move"
        return 60.0 * path / feed, "along the axes of FGROUP"

    def feed_seconds(self, length, turn, feed=None):
        self.turn_of_block = turn
        return super().feed_seconds(length, turn, feed)

"""SINUMERIK 840D sl: the same blocks with names, calls and `=`.

Programming Manual Fundamentals 6FC5398-1BP40-2BA0 (09/2011): 6 (F, G93, G94), 9 (G2/G3), 12 (SUPA, G53, G153);
Job Planning 6FC5398-2BP40: TRAORI, TRAFOOF; Cycles: CYCLE800, CYCLE81 to CYCLE85. Assumed: F of a block that only
turns is in degrees a minute, under TRAORI, too.
"""

import contextlib

import numpy as np

from .machine_model import rotation
from .word_address import TAKES, WordAddress
from .words import scan, without_comments

GROUPS = {
    "motion": (0, 1, 2, 3), "plane": (17, 18, 19), "distance": (90, 91), "feed": (93, 94),
    "unit": (70, 71, 700, 710), "compensation": (40, 41, 42), "offset": (54, 55, 56, 57),
    "suppress": (53, 153), "path": (60, 64, 641, 642), "stop": (601, 602), "dwell": (4,),
}  # fmt: skip
SILENT = {"MSG", "WAIT", "SOFT", "BRISK", "FFWON", "FFWOF", "COMPOF", "COMPCAD", "COMPCURV", "ORIWKS", "ORIMKS",
          "ORIAXES", "CUT3DC", "CUT2D", "STOPRE", "FIFOCTRL", "ADIS", "UPATH", "SPATH", "CYCLE832",
          "WORKPIECE"}  # fmt: skip


class Siemens(WordAddress):
    adds_degrees = False

    def __init__(self, setup, dialect):
        super().__init__(setup, dialect)
        self.length_on = True  # a tool's D1 is on as soon as the tool is
        self.modal_cycle = None
        self.ori_wks = False

    def block(self, _):
        text = without_comments(self.text, self.line, False, True).strip()
        if not text or text.startswith("%"):
            return
        values, codes, auxiliary, names = {}, [], [], {}
        for word in scan(text, self.line, names=True):
            if word.name == "G" and word.value is not None:
                codes.append(word.value)
            elif word.name == "M" and word.value is not None:
                auxiliary.append(int(word.value))
            elif len(word.name) == 1 and word.value is not None:
                if word.name in values:
                    self.refuse(f"{word.name} twice")
                values[word.name] = word.value
            else:
                names[word.name] = word
        values.pop("N", None)
        self.run(values, self.grouped(codes), auxiliary, names)

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
        self.names(names)
        if "unit" in groups:
            groups["unit"] = 20 if groups["unit"] in (70, 700) else 21
        self.modes(values, groups)
        if "T" in values or "D" in values:
            self.tool_words(values)
        for code in auxiliary:
            if code == 6:
                self.change(self.pending if self.pending is not None else self.refuse("M6 without T"))
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

    def names(self, names):
        for name, word in names.items():
            if name == "TRAORI":
                if not self.length_on:
                    self.refuse("TRAORI without a tool length")
                self.tcp = True
                self.update()
            elif name == "TRAFOOF":
                self.tcp = False
                self.update()
            elif name == "CYCLE800":
                self.swivel(word.arguments)
            elif name == "MCALL":
                if len(names) == 1:
                    self.modal_cycle = None
            elif name in ("CYCLE81", "CYCLE82", "CYCLE83", "CYCLE84", "CYCLE85"):
                if "MCALL" not in names:
                    self.refuse(f"{name} without MCALL is not read here")
                self.modal_cycle = (name, word.arguments)
            elif name == "SUPA" or name in SILENT:
                continue
            else:
                self.refuse(f"{name} is no word that is read here")

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

"""HEIDENHAIN Klartext (conversational programs).

Written from: TNC 640 / TNC 620 User's Manuals (34059x, 34056x), Klartext: "Path functions" (L, CC, C, CP; FMAX
holds for its block, then the last F again), "Feed rate F" (FT in seconds, for its block), "Multiple axis machining"
(M116: without it F of a rotary axis is in degrees a minute; M128: the tip keeps its place on the workpiece,
coordinates turn with the table, reset before M91 and TOOL CALL; PLANE SPATIAL), "Miscellaneous functions" (M91),
"Cycles" (9 dwell, 200, 201, 203, 207, 247). Assumed, as these manuals do not say it: without M128, F of a block of
X Y Z *and* rotary axes adds mm and degrees, as on Fanuc; under M128, F of a block that only turns is in degrees a
minute.
"""

import math

import numpy as np

from .machine_model import rotation
from .reader import Control
from .words import number_end

PATHS = ("L", "C", "CP")
IDLE = {0, 1, 3, 4, 5, 6, 7, 8, 9, 13, 14, 10, 11, 25, 26, 116, 117, 120, 107, 108, 118, 124, 138, 144, 145, 148}
SPINDLES = {3: 3, 4: 4, 5: 5, 13: 3, 14: 4}


class Klartext(Control):
    def __init__(self, setup):
        super().__init__(setup)
        self.length_on = True  # TOOL CALL sets the length off by itself
        self.centre = np.full(3, np.nan)
        self.parameters = {}
        self.cycle = None

    def block(self, line):
        words = line.split(";", 1)[0].split()
        if words and words[0].isdigit():
            words = words[1:]
        if words:
            self.words(words)

    def words(self, words):
        name = words[0].upper()
        two = " ".join(words[:2]).upper()
        if two in ("BEGIN PGM", "BLK FORM", "TOOL DEF"):
            if words[-1].upper() == "INCH":
                self.unit = 25.4
        elif two == "END PGM":
            self.ended = True
        elif two == "TOOL CALL":
            self.tool_call(words[2:])
        elif two == "CYCL DEF":
            self.define(words[2:])
        elif two == "CYCL CALL":
            self.miscellaneous(self.codes(words[2:]))
            self.call()
        elif name == "PLANE":
            self.tilt(words[1:])
        elif name == "CC":
            self.pole(words[1:])
        elif name in PATHS:
            self.path(name, words[1:])
        elif name[0] == "M" and name[1:].isdigit():
            self.miscellaneous(self.codes(words))
        else:
            self.refuse(f"{words[0]} begins no block that is read here")

    # Values.

    def number(self, text):
        if not text or number_end(text, 0) != len(text):
            self.refuse(f"{text!r} is no number")
        return float(text)

    def codes(self, words):
        """The M functions of a block, in order."""
        for word in words:
            if word[0] not in "Mm" or not word[1:].isdigit():
                self.refuse(f"{word!r} is not read here")
        return [int(word[1:]) for word in words]

    # Blocks.

    def tool_call(self, words):
        if self.tcp:
            self.refuse("TOOL CALL while M128 is active")
        if words and (words[0].isdigit() or words[0][0] == '"'):
            self.change_tool(int(words[0]) if words[0].isdigit() else words[0].strip('"'))
            words = words[1:]
        for word in words:
            key, value = word[0].upper(), word[1:]
            if key == "S":
                self.speed = self.number(value)
            elif word.upper() not in ("X", "Y", "Z"):
                self.refuse(f"{word!r} in TOOL CALL")

    def follow(self, on):
        self.tcp = on
        self.update()

    def pole(self, words):
        for word in words:
            incremental = word[0] == "I"
            letter = word[1 if incremental else 0].upper()
            n = "XYZ".index(letter)
            value = self.number(word[2:] if incremental else word[1:]) * self.unit
            self.centre[n] = self.at[n] + value if incremental else value

    def path(self, name, words):
        target, angles = self.at.copy(), self.turned.copy()
        feed, rapid, seconds, clockwise, swept = None, False, None, None, None
        slides = np.full(3, np.nan)
        moved = False
        rest = []
        n = 0
        while n < len(words):
            word = words[n].upper()
            if word[0] == "M" and word[1:].isdigit():
                rest = words[n:]
                break
            letter = word[1] if word[0] == "I" and len(word) > 2 else word[0]
            if word in ("R0", "RL", "RR"):
                self.compensation = {"R0": 40, "RL": 41, "RR": 42}[word]
            elif word == "FMAX":
                rapid = True
            elif word.startswith("FT"):
                seconds = self.number(word[2:])
            elif word.startswith("F"):
                feed = self.number(word[1:]) * self.unit
            elif word in ("DR+", "DR-"):
                clockwise = word == "DR-"
            elif word.startswith("IPA") or word.startswith("PA"):
                swept = (word[0] == "I", self.number(word.lstrip("IPA")))
            elif letter in "XYZ":
                k = "XYZ".index(letter)
                value = self.number(word[2:] if word[0] == "I" else word[1:]) * self.unit
                target[k] = self.at[k] + value if word[0] == "I" else value
                slides[k] = value
                moved = True
            elif letter in self.model.letters:
                k = self.model.letters.index(letter)
                value = self.number(word[2:] if word[0] == "I" else word[1:])
                angles[k] = self.turned[k] + value if word[0] == "I" else value
                moved = True
            else:
                self.refuse(f"{words[n]!r} in a path block")
            n += 1
        if feed is not None:
            self.feed = feed
        codes = self.codes(rest)
        self.miscellaneous([code for code in codes if code != 91])
        kind = "rapid" if rapid else "feed"
        more = {} if seconds is None else {"seconds": seconds}
        if 91 in codes:
            if self.tcp:
                self.refuse("M91 while M128 is active: reset it first")
            self.go_slides(kind, slides, angles, **more)
        elif name == "L":
            if moved:
                self.go(kind, target, angles, **more)
        elif name in ("C", "CP"):
            self.need(clockwise is not None and not np.isnan(self.centre[:2]).all(), f"{name} needs CC and DR")
            self.around(name, target, angles, clockwise, swept, kind)
        else:
            self.refuse(f"{name} is not read here")

    def need(self, holds, why):
        if not holds:
            self.refuse(why)

    def around(self, name, target, angles, clockwise, swept, kind):
        u, v, _ = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}[self.plane_number]
        turns = 0
        if name == "CP":
            self.need(swept is not None, "CP needs an angle")
            start = self.at - self.centre
            begin = math.degrees(math.atan2(start[v], start[u]))
            sweep = swept[1] if swept[0] else (swept[1] - begin) % 360 - (360 if clockwise else 0)
            self.need((sweep < 0) == clockwise, "the sign of IPA against DR")
            radius = math.hypot(start[u], start[v])
            target[u] = self.centre[u] + radius * math.cos(math.radians(begin + sweep))
            target[v] = self.centre[v] + radius * math.sin(math.radians(begin + sweep))
            turns = int(abs(sweep) / 360 - 1e-9)
        self.arc_to(target, angles, clockwise, centre=self.centre, turns=turns, kind=kind)

    def miscellaneous(self, codes):
        for code in codes:
            if code in (128, 129):
                self.follow(code == 128)
            elif code in (2, 30):
                self.ended = False  # END PGM follows
            elif code in SPINDLES:
                self.spindle = SPINDLES[code]
                self.coolant = self.coolant | {8} if code > 9 else self.coolant
            elif code in (7, 8):
                self.coolant = self.coolant | {code}
            elif code == 9:
                self.coolant = frozenset()
            elif code not in IDLE:
                self.refuse(f"M{code} is not read here")

    # Tilted planes and cycles.

    def tilt(self, words):
        text = [word.upper() for word in words]
        if text[0] == "RESET":
            self.plane = None
            return self.update()
        if text[0] != "SPATIAL":
            self.refuse(f"PLANE {text[0]} is not read here")
        angle = {word[:3]: self.number(word[3:]) for word in text[1:] if word[:3] in ("SPA", "SPB", "SPC")}
        self.need(len(angle) == 3, "PLANE SPATIAL needs SPA SPB SPC")
        # About the machine's fixed axes, A first, then B, then C.
        turn = (
            rotation((0, 0, 1), angle["SPC"])
            @ rotation((0, 1, 0), angle["SPB"])
            @ rotation((1, 0, 0), angle["SPA"])
        )
        self.plane = (turn, np.zeros(3))
        self.update()
        found = self.model.angles_for(turn[:, 2], self.turned)
        self.need(bool(found), "the plane is out of reach")
        self.need("TURN" in text, "PLANE without TURN is not read here")
        return self.go("rapid", self.at, found[0])

    def define(self, words):
        number = words[0].split(".")
        if number[0] == "9":
            if words[0] == "9.1":
                self.dwell(self.number(words[-1]))
        elif number[0] in ("247", "200", "201", "203", "207", "32"):
            values = dict(word.split("=", 1) for word in words if "=" in word)
            self.parameters |= {key: self.number(value) for key, value in values.items()}
            if number[0] in ("200", "201", "203", "207"):
                self.cycle = dict(self.parameters) | {"number": int(number[0])}
            elif number[0] == "247":
                preset = int(self.parameters["Q339"])
                self.base = np.array(self.setup.offsets.get(preset, np.zeros(3)), dtype=float)
                self.update()
        else:
            self.refuse(f"CYCL DEF {words[0]} is not read here")

    def call(self):
        """Cycles 200, 201, 203 and 207: Q200 clearance, Q201 depth, Q203 surface, Q204 second clearance, Q206 feed.

        200 and 203 peck by Q202, 203 breaks chips Q213 times before it comes out; 201 comes out at Q208, or at Q206
        if that is 0; 207 goes down and out by Q239 a turn. Q211 is the dwell at the bottom.
        """
        if self.cycle is None:
            self.refuse("a call of no cycle")
        q = self.cycle
        surface = q["Q203"]
        feed, out, peck = q.get("Q206"), "rapid", None
        if q["number"] in (200, 203) and q["Q202"] < abs(q["Q201"]):
            peck = q["Q202"]
        if q["number"] == 201:
            out = "feed"
            if q["Q208"] not in (0, feed):
                self.refuse("another feed out is not read here")
        if q["number"] == 207:
            out, feed = "feed", abs(q["Q239"]) * self.speed
        breaks = q["number"] == 203 and q["Q213"] > abs(q["Q201"]) / q["Q202"]
        self.drill(
            self.at.copy(), surface + q["Q200"], surface + q["Q201"], surface + max(q["Q204"], q["Q200"]),
            peck=peck, chip_break=breaks, dwell=(q["number"] != 207) * q.get("Q211", 0.0), feed=feed, out=out,
        )  # fmt: skip

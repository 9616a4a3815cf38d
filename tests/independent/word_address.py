"""Fanuc, Haas, Mazak, LinuxCNC and Siemens: blocks of addresses.

Written from
- Fanuc: Series 30i/31i/32i User's Manual B-63944EN (G codes of machining centres, group table; canned cycles;
  G53.1, G68.2); "Tool center point control for 5-axis machining", A-79348E (parameter 19696: WKP, coordinates fixed
  to the table); Power Mate i Operator's Manual
  B-63174EN/03, 4.2: `G01 X20.0 C40.0 F300.0` takes √(20² + 40²)/300 min, mm and degrees added as one unit.
- Haas: Mill Operator's Manual, G93 (F in strokes a minute, in each block), G234.
- Mazak: as Fanuc (SMOOTH, EIA/ISO programs, G43.4, G68.2).
- LinuxCNC: documentation "G Codes", after NISTIR 6556 (2000) 2.1.2.5: F counts X Y Z alone if one of them moves,
  else degrees. TCP is switched as the simulated machine of the project does: M68 E3 Q1, then M66 E0 L0.
- Siemens: SINUMERIK 840D sl Programming Manual Fundamentals 6FC5398-1BP40-2BA0 (09/2011), chapter 6: G93 in 1/min;
  Job Planning: TRAORI, CYCLE800.
"""

import numpy as np

from .machine_model import rotation
from .reader import Control
from .words import scan, without_comments

MOTIONS = (0, 1, 2, 3)
CYCLES = (73, 74, 81, 82, 83, 84, 85, 86, 89)  # 74 and 84 tap: down and out at the feed
GROUPS = (
    ("motion", (*MOTIONS, *CYCLES, 80)),
    ("plane", (17, 18, 19)),
    ("distance", (90, 91)),
    ("feed", (93, 94)),
    ("unit", (20, 21)),
    ("compensation", (40, 41, 42)),
    ("length", (43, 49, 43.4, 234)),
    ("return", (98, 99)),
    ("offset", (54, 55, 56, 57, 58, 59)),
    ("tilt", (68.2, 69)),
    ("path", (61, 64)),
    ("once", (4, 53, 53.1, 5.1, 187)),
)
COMMON = {0, 1, 2, 3, 4, 17, 18, 19, 40, 41, 42, 43, 49, 53, 54, 55, 56, 57, 58, 59, 61, 64, 73, 74, 80, 81,
          82, 83, 84, 85, 86, 89, 90, 91, 93, 94, 98, 99, 20, 21}  # fmt: skip
TAKES = {
    "fanuc": COMMON | {43.4, 68.2, 69, 53.1, 5.1},
    "mazak": COMMON | {43.4, 68.2, 69, 53.1, 5.1},
    "haas": COMMON | {234, 187},
    "linuxcnc": COMMON,
    "siemens": {0, 1, 2, 3, 4, 17, 18, 19, 40, 41, 42, 53, 54, 55, 56, 57, 60, 64, 70, 71, 90, 91, 93, 94, 153, 601,
                602, 641, 642, 700, 710},
}  # fmt: skip
AUXILIARY = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 19, 30, 32, 33}  # 10/11, 32/33 …: clamps, of the machine builder
ADDRESSES = set("XYZABCUVWIJKRFSTHDPQLNGM")


class WordAddress(Control):
    def __init__(self, setup, dialect):
        self.dialect = dialect
        super().__init__(setup)
        self.motion = None
        self.cycle = {}
        self.to_initial = True  # G98
        self.initial = None
        self.pending = None  # the tool that T made ready

    def words(self):
        brackets = self.dialect in ("fanuc", "haas", "mazak", "linuxcnc")
        text = without_comments(self.text, self.line, brackets, self.dialect in ("linuxcnc", "siemens"))
        text = text.strip()
        if not text or text.startswith("%"):
            return []
        if text[0] in "Oo" and self.dialect in ("fanuc", "haas", "mazak"):
            return []
        return scan(text, self.line)

    def block(self, _):
        values, codes, auxiliary = {}, [], []
        self.points = set()
        for word in self.words():
            if word.name not in ADDRESSES and not (word.name == "E" and self.dialect in ("linuxcnc", "haas")):
                self.refuse(f"address {word.name}")
            if word.name == "G":
                codes.append(word.value)
            elif word.name == "M":
                auxiliary.append(int(word.value))
            elif word.name in values:
                self.refuse(f"{word.name} twice")
            else:
                values[word.name] = word.value
                if word.point:
                    self.points.add(word.name)
                least = (
                    word.name in "XYZABCIJKRQ" and 5.1 not in codes and self.dialect in ("fanuc", "mazak", "haas")
                )
                if least and not word.point and word.value:
                    self.refuse(f"{word.name}{word.value:g} without a decimal point counts least increments")
        values.pop("N", None)
        self.execute(values, self.in_groups(codes), auxiliary)

    def in_groups(self, codes):
        groups = {}
        for code in codes:
            if code not in TAKES[self.dialect]:
                self.refuse(f"G{code:g} is no code of {self.dialect}")
            name = next((name for name, members in GROUPS if code in members), f"G{code:g}")
            if name in groups:
                self.refuse(f"G{groups[name]:g} and G{code:g} in one block")
            groups[name] = code
        return groups

    # One block, in the order in which a control executes it (NISTIR 6556, table 8; B-63944EN).

    def execute(self, values, groups, auxiliary):
        self.modes(values, groups)
        self.switches(values, auxiliary)
        once = groups.get("once")
        if once == 4:
            return self.dwell(self.pause(values))
        if once in (5.1, 187):
            return None
        if "length" in groups:
            self.length(groups["length"], values)
        if "tilt" in groups:
            self.tilt(groups["tilt"], values)
            return None
        if once == 53.1:
            return self.tool_along_plane()
        if groups.get("motion") in CYCLES or groups.get("motion") == 80 or groups.get("motion") in MOTIONS:
            self.motion = groups["motion"]
            if self.motion not in CYCLES:
                self.initial = None  # the next cycle comes out to where it begins
        if once == 53:
            return self.machine_move(values)
        moves = any(letter in values for letter in "XYZABC")
        if moves or (self.motion in (2, 3) and ("I" in values or "J" in values or "K" in values)):
            self.travel(values)
        return None

    def modes(self, values, groups):
        if "unit" in groups:
            self.unit = 25.4 if groups["unit"] == 20 else 1.0
        if "plane" in groups:
            self.plane_number = int(groups["plane"])
        if "distance" in groups:
            self.absolute = groups["distance"] == 90
        if "feed" in groups and groups["feed"] != self.feed_mode:
            self.feed_mode = int(groups["feed"])
            self.feed = None
        if "F" in values and groups.get("once") != 4:
            self.feed = values["F"] * (1.0 if self.feed_mode == 93 else self.unit)
            self.fresh_feed = True
        else:
            self.fresh_feed = False
        if "S" in values:
            self.speed = values["S"]
        if "compensation" in groups:
            self.compensation = int(groups["compensation"])
        if "return" in groups:
            self.to_initial = groups["return"] == 98
        if "offset" in groups:
            self.work_offset(f"G{groups['offset']:g}")

    def work_offset(self, name):
        if name != "G54" and name not in self.setup.offsets:
            self.refuse(f"{name} is not set up")
        self.offset_name = name
        self.base = np.array(self.setup.offsets.get(name, np.zeros(3)), dtype=float)
        self.update()

    def switches(self, values, auxiliary):
        if "T" in values:
            self.pending = int(values["T"])
        for code in auxiliary:
            self.switch(code, values)

    def switch(self, code, values):
        if self.dialect == "linuxcnc" and code == 68:
            if values.get("E", values.get("P")) is None and "Q" not in values:
                self.refuse("M68 without E and Q")
            self.wanted = values["Q"] != 0
            return
        if self.dialect == "linuxcnc" and code == 66:
            self.tcp = getattr(self, "wanted", self.tcp)
            self.update()
            return
        if code not in AUXILIARY:
            self.refuse(f"M{code} is no code of {self.dialect}")
        if code == 6:
            if self.pending is None:
                self.refuse("M6 without T")
            if self.tcp:
                self.refuse("a tool change under TCP")
            self.change_tool(self.pending)
        elif code in (3, 4, 5):
            self.spindle = code
        elif code in (7, 8):
            self.coolant = self.coolant | {code}
        elif code == 9:
            self.coolant = frozenset()
        elif code in (2, 30):
            self.ended = True

    def pause(self, values):
        if self.dialect == "linuxcnc":
            return values.get("P", 0.0)
        if "P" in values:  # Fanuc: milliseconds; Haas: milliseconds unless it has a decimal point
            return values["P"] if self.dialect == "haas" and "P" in self.points else values["P"] / 1000
        return values.get("X", values.get("U", 0.0))

    def length(self, code, values):
        if code == 49:
            self.length_on = self.tcp = False
            return self.update()
        if code != 234 or "H" in values:
            number = values.get("H", self.tool if self.dialect == "linuxcnc" else None)
            if number is None:
                self.refuse(f"G{code:g} without H")
            self.tool_length = self.setup.lengths.get(int(number), self.model.length)
        elif not self.length_on:
            self.refuse("G234 without H")
        self.length_on = True
        self.tcp = code in (43.4, 234)
        return self.update()

    def tilt(self, code, values):
        if code == 69:
            self.plane = None
        else:
            if self.tcp:
                self.refuse("G68.2 under TCP")
            if values.get("P"):
                self.refuse("only G68.2 by Euler angles is read")
            i, j, k = (values.get(letter, 0.0) for letter in "IJK")
            turn = rotation((0, 0, 1), i) @ rotation((1, 0, 0), j) @ rotation((0, 0, 1), k)  # about the turned axes
            self.plane = (turn, np.array([values.get(letter, 0.0) for letter in "XYZ"]) * self.unit)
        self.update()

    def tool_along_plane(self):
        if self.plane is None:
            self.refuse("G53.1 without G68.2")
        found = self.model.angles_for(self.plane[0][:, 2], self.turned)
        if not found:
            self.refuse("the plane is out of reach")
        self.go("rapid", self.at, found[0])

    # Positions.

    def targets(self, values):
        """The program's target and the angles."""
        target = self.at.copy()
        for n, letter in enumerate("XYZ"):
            if letter in values:
                value = values[letter] * self.unit
                target[n] = value if self.absolute else self.at[n] + value
        angles = self.turned.copy()
        for letter in "ABC":
            if letter in values and letter not in self.model.letters:
                self.refuse(f"this machine has no {letter}")
        for n, letter in enumerate(self.model.letters):
            if letter in values:
                angles[n] = values[letter] if self.absolute else self.turned[n] + values[letter]
        return target, angles

    def machine_move(self, values):
        if not self.absolute:
            self.refuse("G53 under G91")
        if self.motion not in (0, 1):
            self.refuse("G53 needs G0 or G1")
        if self.tcp:
            self.refuse("machine coordinates under TCP: end it first")
        slides = np.array([values[letter] * self.unit if letter in values else np.nan for letter in "XYZ"])
        kind = "rapid" if self.motion == 0 else "feed"
        self.go_slides(kind, slides, self.targets(values)[1])

    def travel(self, values):
        if self.motion is None or self.motion == 80:
            self.refuse("axis words without a motion")
        target, angles = self.targets(values)
        if self.motion in CYCLES:
            return self.hole(values)
        if self.motion == 0:
            return self.go("rapid", target, angles)
        if self.feed_mode == 93 and not self.fresh_feed:
            self.refuse("inverse time without F in this block")
        if self.motion == 1:
            return self.go("feed", target, angles)
        centre = self.at.copy()
        if not any(letter in values for letter in "IJK"):
            self.refuse("an arc without its centre")
        for n, letter in enumerate("IJK"):
            centre[n] += values.get(letter, 0.0) * self.unit
        return self.arc_to(target, angles, self.motion == 2, centre=centre)

    def hole(self, values):
        """Canned cycles; R and Z are levels; Q, P, F stay."""
        w = {17: 2, 18: 1, 19: 0}[self.plane_number]
        letter = "XYZ"[w]
        if self.initial is None or self.initial[0] != self.motion:
            self.initial = (self.motion, self.at[w])
            self.cycle = {}
        self.cycle |= {key: values[key] for key in (letter, "R", "Q", "P") if key in values}
        if letter not in self.cycle or "R" not in self.cycle:
            self.refuse("a cycle without depth or R")
        if self.motion in (73, 83) and not self.cycle.get("Q"):
            self.refuse("pecks without Q")
        if self.feed_mode == 93:
            self.refuse("a cycle in inverse time")
        target, angles = self.targets({key: value for key, value in values.items() if key != letter})
        if not self.absolute or not np.array_equal(angles, self.turned, equal_nan=True):
            self.refuse("a cycle in increments or while a rotary axis turns is not read here")
        level, clearance, depth = self.initial[1], self.cycle["R"] * self.unit, self.cycle[letter] * self.unit
        dwell = self.cycle.get("P", 0.0) * (1.0 if self.dialect == "linuxcnc" else 0.001)
        self.drill(
            target, clearance, depth, level if self.to_initial else clearance,
            peck=self.cycle.get("Q", 0.0) * self.unit if self.motion in (73, 83) else None,
            chip_break=self.motion == 73, dwell=dwell if self.motion in (82, 89, 86) else 0.0,
            out="feed" if self.motion in (74, 84, 85, 89) else "rapid",
        )  # fmt: skip


class LinuxCNC(WordAddress):
    adds_degrees = False


def control(dialect, setup):
    from .siemens import Siemens

    kinds = {"siemens": Siemens, "linuxcnc": LinuxCNC}
    return kinds.get(dialect, WordAddress)(setup, dialect)

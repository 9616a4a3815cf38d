"""The words of APT CL files, in three classes.

Modelled words change the motion or the program, and do: a method of `Statements` is called after each. Inert are
names, displays and settings without motion (`INERT`): kept as comments. All others are hazardous. A file that has
one is refused, because leaving it out could leave out or spoil a cut; `HAZARDS` says for some why, and what to do.

Forms differ from system to system; they are those of NX (.cls), Creo (.ncl), CATIA (.aptsource) and SolidWorks.
"""

import math
import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError
from mathpost.path.arcs import SAME_RADIUS, Cycle, arc
from mathpost.path.cl_lines import REAL, UNIT_TOLERANCE, Lines, need
from mathpost.rotation import about, wrap

MM_PER_INCH = 25.4
LEAST_FEED = 0.001  # mm/min, which programs print
MOST_TURNS = 1000  # of a helix
LITERAL = re.compile(r"\(?\s*(CIRCLE|CYLNDR|LINE|POINT)\s*/([-+\d.eE,\s]*)")  # geometry within a statement
FREE_TEXT = "PARTNO PPRINT REMARK INSERT TPRINT CATPROCESS CATPRODUCT OP_NAME PROGRAM"
NAMES = "TOOL PATH/END-OF-PATH/SETUP/BOX/OPFEATSTART/OPFEATEND/MACHIN/MACHINE/SEQNO/FINI/END".split("/")
SETTINGS = (
    "TLDATA CUTTER TOOLNO SELECT SELCTL SELECTL MULTAX INTOL OUTTOL TOLER LINTOL CLEARP CLRSRF OPSKIP LEADER "
    "REWIND CHECK SAFETY TMARK PLABEL AUTOPS PSIS SWITCH ARCSLP DISPLY PAINT MOVE_ATTRIB MILL"
)
INERT = frozenset([*FREE_TEXT.split(), *NAMES, *SETTINGS.split()])
INERT_FAMILIES = ("CSI_",)  # beginnings of words
ALIASES = {"SET": "MODE", "UNIT": "UNITS", "GOFWD": "TLON", "OPSTOP": "STOP", "DWELL": "DELAY"}
HAZARDS = {
    **dict.fromkeys(["ROTHED", "ROTATE"], "it turns an axis; let the CAM system write tool axes instead"),
    **dict.fromkeys(["TRANS", "TRACUT"], "it moves the coordinates; let the CAM system write them moved"),
    "COPY": "it repeats moves; let the CAM system write all of them",
    **dict.fromkeys(["CALSUB", "CALLSUB"], "it calls moves that are elsewhere; let the CAM system write them"),
    **dict.fromkeys(["PREFUN", "AUXFUN", "PPWORD"], "it puts G codes, M codes or words into the program"),
    "RETRCT": "it moves the tool to a plane that another post-processor knows",
}
FEED_UNITS = {"MMPM": 1.0, "IPM": MM_PER_INCH, "PERMIN": None, "MMPR": 1.0, "IPR": MM_PER_INCH, "PERREV": None}
PER_TURN = ("MMPR", "IPR", "PERREV")
BACK = {"CLW": "CCLW", "CCLW": "CLW"}
CYCLES = "DRILL SPOT FACE CSINK CBORE DEEP DEEP2 BRKCHP BORE REAM TAP".split()
OF_A_CYCLE = {
    **dict.fromkeys(["FEDTO", "DEPTH"], "depth"),
    **dict.fromkeys(["RAPTO", "CLEAR"], "clearance"),
    **{"RTRCTO": "retract", "1STPECK": "first", "DWELL": "dwell"},
    **dict.fromkeys(["SUBPECK", "STEP", "INCR"], "following"),
}


@dataclass(frozen=True)
class Command:
    """What the control shall do between two moves; `values` by kind.

    ``"tool"`` (number, length in mm or None), ``"spindle"`` (turns per minute or None, CLW, CCLW or OFF),
    ``"coolant"`` (FLOOD, MIST or OFF), ``"compensation"`` (LEFT, RIGHT or OFF), ``"dwell"`` (seconds), ``"stop"``,
    ``"optional stop"``.
    """

    kind: str
    values: tuple
    statement: str  # the words of the CL file


class Statements(Lines):
    """Takes statements: ``on_word`` what stands behind the slash of that word; arguments as of `cl.read`."""

    def __init__(self, name, tolerance, ignored=()):
        super().__init__(name)
        self.tolerance, self.ignored = tolerance, {word.upper() for word in ignored}
        self.incremental, self.units_stated = False, False
        self.turns, self.turning = None, None  # of the spindle
        self.home, self.tangent, self.cycle = None, None, None
        self.circle, self.arc_before = None, None  # what is known of the arc that comes, and of one that went
        self.table, self.turned = np.zeros(3), np.eye(3)  # by ROTABL: A, B, C, and the axes of the coordinates
        self.unconfirmed = False  # whether the tool axis must still say that this is the way it turned
        self.remarks, self.counts, self.normals = [], Counter(), {}

    def takes_plain(self):
        """Whether a GOTO is now nothing but a move to where it says."""
        special = self.circle or self.arc_before or self.cycle or self.incremental or self.unconfirmed
        return not (special or self.unfinished or self.in_comment or self.rapid)

    def take(self):
        """Take one statement."""
        major, _, minor = self.statement.partition("/")
        upper = major.upper()
        word = " ".join(re.match(r"TOOL\s+PATH|[A-Z_][A-Z0-9_-]*|\S*", upper)[0].split())
        if word != "GOTO":
            self.arc_before = None
        modelled = getattr(self, f"on_{ALIASES.get(word, word).lower()}", None)
        if word in self.ignored:
            self.counts[f"ignored as asked {word}"] += 1
            self.remark()
        elif word in INERT or word.startswith(INERT_FAMILIES):
            self.remark()
        elif word in HAZARDS:
            self.problem(self.start, word, f"other words: {HAZARDS[word]}")
        elif modelled is None:
            self.problem(self.start, "", "a CL statement that is known")
        elif upper.strip().replace(" ", "") not in (word, "TLON,GOFWD"):
            self.problem(self.start, word, f"{word} and a slash")
        else:
            try:
                modelled([each.strip().upper() for each in minor.split(",")] if minor.strip() else [])
            except InputError as error:
                self.problem(self.start, word, error.expected, error.found)

    def remark(self, remark=None, record=None):
        """Keep a remark, by default the statement, before a record, by default the next."""
        self.remarks.append((self.count if record is None else record, remark or self.statement))

    def command(self, kind, *values, statement=None, record=None):
        self.remark(Command(kind, values, statement or self.statement), record)

    def pose(self, words, *counts):
        """The point (mm) or nothing, the axis or the one that holds, and what else so many numbers say."""
        values = self.numbers(words, *counts)
        return self.mm(values[:3]), values[3:6] or self.axis, values[6:]

    def mm(self, values):
        return [value * self.scale for value in values]

    # Moves

    def on_goto(self, words):
        point, axis, normal = self.pose(words, 3, 6, 9)
        if normal:
            self.contact(axis, normal)
        self.confirm_turn(axis)
        if self.incremental:
            point = self.shifted(point)
        arc_before, self.arc_before = self.arc_before, None
        if self.circle is not None:
            centre, normal, turns, goes_on, angle = self.circle
            self.circle = None
            need(self.point, "an arc in the coordinate system of its start", "a different one")
            if angle is not None:
                normal = self.sense(point, centre, normal, angle)
            self.sweep(point, axis, centre, normal, turns)
            self.arc_before = (centre, normal) if goes_on else None
        elif arc_before is not None and self.may_go_on(point, *arc_before):
            found = "a point on the circle before it, to which the arc may go on or a line lead"
            raise InputError("", "an arc of one GOTO (let Creo write no points on arcs, or points only)", found)
        elif self.cycle is not None:
            self.drill(np.array(point), np.array(axis))
        else:
            self.go(point, axis)

    def contact(self, axis, normal):
        """Keep the surface's normal where the tool touches it: for tools other than that of the CL data."""
        outwards = abs(np.linalg.norm(normal) - 1) <= UNIT_TOLERANCE and np.dot(normal, axis) >= -UNIT_TOLERANCE
        need(outwards, "a unit contact normal out of the part, within 90° of the tool axis", f"{normal}")
        need(not (self.circle or self.cycle), "contact normals of single points only", "an arc or a cycle")
        self.normals[self.start] = self.placed(np.array([[0, 0, 0, *normal]], dtype=float).T)[3:, 0].tolist()

    def on_godlta(self, words):
        values = self.mm(self.numbers(words, 1, 3))
        self.go(self.shifted(values if len(values) == 3 else np.multiply(values, self.axis)), self.axis)

    def shifted(self, values):
        need(self.point, "FROM or GOTO before an incremental move", "none")
        return np.add(self.point, values).tolist()

    def on_from(self, words):
        self.home = self.point, self.axis = self.pose(words, 3, 6)[:2]
        self.remark()

    def on_gohome(self, words):
        point, axis, _ = self.pose(words, 0, 3, 6)
        need(point or self.home, "FROM before GOHOME: nothing else says where home is", "none")
        self.go(*((point, axis) if point else self.home), rapid=True)

    def on_tlaxis(self, words):
        length = math.hypot(*(values := self.numbers(words, 3)))
        need(abs(length - 1) <= UNIT_TOLERANCE, f"a unit tool axis (to {UNIT_TOLERANCE})", f"length {length:.6g}")
        self.axis = (self.turned.T @ values).tolist()  # the table turns, the tool axis is said in the part
        self.unconfirmed = bool(self.table.any())

    def on_mode(self, words):
        if self.statement.upper().startswith("SET"):
            words = words[1:] if words[:1] == ["MODE"] else ["?"]
        need(words in (["INCR"], ["ABSOL"], ["MILL"]), "INCR, ABSOL or MILL")
        if words == ["MILL"]:
            self.remark()
        else:
            self.incremental = words == ["INCR"]

    def on_rapid(self, words):
        need(not words, "RAPID, or RAPID/ and nothing")  # MODAL, or a feed that the control does not take from it
        self.rapid = True

    # Arcs

    def on_circle(self, words):
        """The tool goes to the next GOTO on this circle.

        NX writes the radius and tolerances and turns clockwise about the axis; Creo writes the radius, SolidWorks
        none, and both turn right-handed. The turns that NX counts by TIMES are those begun: so published helices
        have the ramp angles that their operations were given.
        """
        turns = 1.0
        if words[-2:-1] == ["TIMES"]:
            turns, words = self.number(words[-1]), words[:-2]
        need(turns in range(1, MOST_TURNS + 1), f"TIMES, and a whole number from 1 to {MOST_TURNS}", f"{turns:g}")
        turned = {"COUNTERCLOCKWISE": 1, "CCLW": 1, "CLOCKWISE": -1, "CLW": -1}.get(words[-1] if words else "")
        values = self.numbers(words[:-1] if turned else words, 6, 7, 11)  # centre, axis, radius …
        here = self.point and not self.incremental and not self.cycle
        need(here, "CIRCLE after a move, in absolute coordinates and outside a cycle")
        centre, sign = self.mm(values[:3]), turned or (-1 if len(values) == 11 else 1)
        self.circle = centre, [sign * value for value in values[3:6]], int(turns) - 1, len(values) == 7, None
        radius = math.dist(*(np.cross(values[3:6], each) for each in (self.point, centre)))
        for stated in self.mm(values[6:7]):
            need(abs(radius - stated) <= SAME_RADIUS, f"a start {stated:g} mm from the centre", f"{radius:.4f}")

    def on_movarc(self, words):
        """The arc of ISO 4343, as Autodesk writes it: centre, axis, radius, ANGLE and how far it turns."""
        need(words[7:-1] == ["ANGLE"], "MOVARC/ 7 numbers, ANGLE and a number")
        self.numbers(words[:7], 7)
        self.on_circle(words[:7])
        angle = self.number(words[8])
        centre, normal, *_ = self.circle
        self.circle = centre, normal, int(max(angle - 1e-3, 0) // 360), False, angle

    def sense(self, point, centre, normal, angle):
        """The axis about which the tool turns right-handed by `angle` (degrees) from where it is to a point."""
        start, end = np.array(self.point) - centre, np.array(point) - centre
        across, along = np.cross(start, end) @ normal, np.cross(normal, start) @ np.cross(normal, end)
        turned = math.degrees(math.atan2(across, along))
        for sign in (1, -1):
            if abs(wrap(sign * turned - angle)) < 0.1:
                return [sign * component for component in normal]
        raise InputError("", f"an arc of {angle:g} degrees to its end", f"{turned % 360:.3f}")

    def may_go_on(self, point, centre, normal):
        """Whether a point is on the circle of the arc that ended, and a chord to it would not do."""
        start, end = np.array(self.point) - centre, np.array(point) - centre
        radius, chord = np.linalg.norm(start), np.linalg.norm(end - start)
        on_it = abs(np.linalg.norm(end) - radius) < 1e-3 and abs((end - start) @ normal) < 1e-3
        return on_it and radius - math.sqrt(max(radius**2 - chord**2 / 4, 0)) > self.tolerance

    def on_indirv(self, words):
        self.tangent = self.numbers(words, 3)

    def on_tlon(self, words):
        """CATIA's arcs: from where the tool is, in the direction of INDIRV, to a line from the centre."""
        found = {name: self.numbers(values.split(",")) for name, values in LITERAL.findall(self.statement.upper())}
        sizes = {name: len(values) for name, values in found.items()}
        tangent, self.tangent = self.tangent, None
        need(self.point and tangent, "a move and INDIRV before TLON,GOFWD", "none")
        if sizes == {"CIRCLE": 4, "LINE": 6}:  # a circle in a plane Z
            values, axis, end = found["CIRCLE"], [0.0, 0.0, 1.0], found["LINE"][3:]
        elif sizes == {"CYLNDR": 7, "POINT": 3}:
            values, axis, end = found["CYLNDR"], found["CYLNDR"][3:6], found["POINT"]
        else:
            raise InputError("", "(CIRCLE/x,y,z,r),ON,(LINE/…) or (CYLNDR/…),ON,(PLANE/…)", None)
        centre, end = (np.array(self.mm(each[:3])) for each in (values, end))
        start, normal = np.array(self.point), np.array(axis)
        spoke = end - centre - (end - centre) @ normal * normal
        need(np.linalg.norm(spoke) > 0, "an end off the centre of the arc", "the centre")
        height = (start - centre) @ normal
        end = centre + spoke * values[-1] * self.scale / np.linalg.norm(spoke) + height * normal
        ahead = np.cross(normal, start - centre) @ tangent
        self.sweep(end, self.axis, centre, normal if ahead > 0 else -normal)

    def sweep(self, point, axis, centre, normal, turns=0):
        """Add an arc as chords, and full turns before it."""
        need(not self.rapid, "an arc at a feed", "RAPID")
        need(np.allclose(axis, self.axis, atol=1e-6), "a tool axis that stands still on an arc", "one that turns")
        self.go(arc(self.point, point, centre, normal, self.tolerance, turns), axis)
        self.counts[f"arcs as chords {self.tolerance:g} mm"] += 1

    # Holes

    def on_cycle(self, words):
        kind, *words = words or [""]
        need(kind != "ON" or self.cycle, "a cycle before CYCLE/ON", "none")
        if kind in ("OFF", "CLEAR", "INIT", "ON"):
            self.cycle = self.cycle if kind == "ON" else None
            return
        if kind == "DRILL" and words[:1] in (["DEEP"], ["BRKCHP"]):  # NX
            kind, words = words[0], words[1:]
        need(kind in CYCLES, f"CYCLE/{', '.join(CYCLES)} or OFF")
        given = {"feed": self.feed}
        while words:
            word, *words = words
            if word in ("AUTO", "MANUAL") or (word in OF_A_CYCLE and words[:1] == ["AUTO"]):
                continue
            own_word = "each number of a cycle after its word, such as DEPTH (in CATIA the PP table writes them)"
            need(not REAL.fullmatch(word), own_word)
            known = [*OF_A_CYCLE, *FEED_UNITS]
            need(word in known, f"one of {', '.join(known)} in a cycle", repr(word))
            said, *words = words or [""]
            value = self.number(said)
            if word in FEED_UNITS:
                given["feed"] = self.per_minute(value, word)
            else:
                given[OF_A_CYCLE[word]] = value * (1.0 if word == "DWELL" else self.scale)
        need(given["feed"] >= LEAST_FEED, "a feed in the cycle or before it", "none")
        heights = "depth" in given and given.get("clearance", 0) > 0
        need(heights, "a depth (FEDTO or DEPTH) and a clearance (RAPTO or CLEAR)")
        given["depth"] = abs(given["depth"])  # NX counts upwards, SolidWorks and Creo downwards
        if kind == "BRKCHP":
            given["out"] = 0.5
        turning = self.turns is not None and self.turning in BACK
        need(turning or kind != "TAP", "a turning spindle before CYCLE/TAP", "none")
        need(not self.incremental, "a cycle in absolute coordinates", "MODE/INCR")
        self.cycle = Cycle(kind, **given)

    def drill(self, point, axis):
        """Add the moves of a hole."""
        cycle, tapped = self.cycle, self.cycle.kind == "TAP"
        need(not tapped or self.turning in BACK, "a turning spindle before a hole is tapped", self.turning)
        before = float((np.array(self.point) - point) @ axis) if self.point is not None else cycle.clearance
        heights, rapid, bottom = cycle.heights(before)
        after = self.count + bottom + 1
        self.go(point + np.outer(heights, axis), axis, feed=cycle.feed, rapid=rapid)
        if cycle.dwell:
            self.command("dwell", cycle.dwell, statement=f"DELAY/{cycle.dwell:g}", record=after)
        if tapped:  # out again with the spindle turning back
            for record, sense in ((after, BACK[self.turning]), (after + 1, self.turning)):
                said = f"SPINDL/{self.turns:g},RPM,{sense}"
                self.command("spindle", self.turns, sense, statement=said, record=record)
            self.counts["holes tapped as moves: a floating holder is needed"] += 1
        self.counts["holes of drilling cycles as moves"] += 1

    # Units and coordinate systems

    def on_units(self, words):
        scales = {"MM": 1.0, "CM": 10.0, "INCH": MM_PER_INCH, "INCHES": MM_PER_INCH, "IN": MM_PER_INCH}
        need(len(words) == 1 and words[0] in scales, "UNITS/MM or UNITS/INCH", ",".join(words) or "nothing")
        self.scale, self.units_stated = scales[words[0]], True

    def on_msys(self, words):
        """NX: the origin of the coordinate system, its X and its Y."""
        origin, x, y = np.reshape(self.numbers(words, 9), (3, 3))
        self.use_system(np.column_stack([x, y, np.cross(x, y), origin]))

    def on_csys(self, words):
        """The rows of a matrix of 3 by 4 that takes the coordinates to those of the part."""
        self.use_system(np.reshape(self.numbers(words, 12), (3, 4)))

    def use_system(self, matrix):
        """Records go on in another system; all of them are brought into the first."""
        rotation, system = matrix[:, :3], matrix * [1, 1, 1, self.scale]
        square = np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-4) and np.linalg.det(rotation) >= 0
        need(square, "right-handed axes at right angles", str(rotation.round(6).tolist()))
        if self.first_system is None:
            need(not self.count, "the first coordinate system before the first move", "moves before it")
            self.first_system = self.system = system
        if not np.allclose(system, self.system, atol=1e-9):
            self.counts["changes of the coordinate system, brought into the first"] += 1
            self.point = None  # nobody has said it in these coordinates
        self.system = self.first_system if np.allclose(system, self.first_system, atol=1e-9) else system

    def on_rotabl(self, words):
        """The table turns, and the points that follow are in coordinates that stand still while the part turns.

        SolidWorks writes TABLE, and radians from the zero of the table: with CCLW the coordinates turn right-handed
        in the part (in its files TLAXIS is their Z). Others write degrees, from the zero with ATANGL.
        """
        known = {"TABLE", "CCLW", "CLW", "ATANGL", "INCR"}
        axes = [word for word in words if word in ("AAXIS", "BAXIS", "CAXIS")]
        numbers = [word for word in words if REAL.fullmatch(word)]
        one_each = len(axes) == len(numbers) == 1 and {*words} <= {*axes, *numbers, *known}
        need(one_each, "ROTABL/ an angle, AAXIS, BAXIS or CAXIS, and CLW or CCLW")
        need(not self.incremental and self.cycle is None, "ROTABL in absolute coordinates and outside a cycle")
        angle = self.number(numbers[0]) * (-1 if "CLW" in words else 1)
        axis, before = "ABC".index(axes[0][0]), self.turned
        from_zero = {"TABLE", "ATANGL"} & {*words} and "INCR" not in words
        turn = angle if "TABLE" in words else math.radians(angle)
        self.table[axis] = turn if from_zero else turn + self.table[axis]
        a, b, c = (about(direction, angle) for direction, angle in zip(np.eye(3), self.table, strict=True))
        self.turned, self.unconfirmed = np.array(a * b * c, dtype=float), True
        self.axis = (self.turned.T @ before @ self.axis).tolist()
        if self.system is None:
            self.first_system = self.system = np.eye(3, 4)
        standing, origin = np.hsplit(self.system, [3])
        self.use_system(np.hstack([standing @ before.T @ self.turned, origin / self.scale]))

    def confirm_turn(self, axis):
        """Refuse a move after ROTABL if its tool axis does not say which way the table has turned."""
        if self.unconfirmed and (turned := np.abs(self.table) > UNIT_TOLERANCE).any():
            z, said = self.turned[:, 2], self.turned @ axis
            one = "one axis of the table turned by ROTABL: nothing says which carries which"
            need(turned.sum() == 1, one, "several")
            need(not turned[2], "ROTABL across the tool: of a turn about the tool nothing says the sense", "CAXIS")
            along = np.allclose(said, z, atol=UNIT_TOLERANCE)
            z, said = (",".join(f"{value:z.4f}" for value in each) for each in (z, said))
            need(along, f"TLAXIS/{z} of the part, along Z of the table that ROTABL has turned", f"TLAXIS/{said}")
        self.unconfirmed = False

    def on_trntyp(self, words):
        need(words[:1] == ["WORLD"], "TRNTYP/WORLD,0,0,0")
        self.on_origin(words[1:])

    def on_origin(self, words):
        need(not any(self.numbers(words)), "zeros, which change nothing; let the CAM system write it shifted")
        self.remark()

    # Feeds, and what the control shall do

    def on_fedrat(self, words):
        if words == ["RAPID"]:
            self.rapid = True
            return
        units = [word for word in words if word in FEED_UNITS]
        values = [word for word in words if word not in FEED_UNITS]
        one_each, said = len(values) == 1 and len(units) < 2, ",".join(words) or "nothing"
        need(one_each, "FEDRAT/ a number and MMPM, IPM, MMPR or IPR", said)
        value = self.number(values[0])
        feed = self.per_minute(value, units[0] if units else "PERMIN")
        need(feed >= LEAST_FEED, f"a feed above 0, at least {LEAST_FEED:g} mm/min", f"{value:g}")
        self.feed = feed

    def per_minute(self, value, unit):
        """Return a feed in mm/min."""
        stated = self.units_stated or unit not in ("IPM", "IPR")
        need(stated, "UNITS/MM or UNITS/INCH before a feed in inches: the points may be inches, too", "none")
        if unit in PER_TURN:
            need(self.turns, "SPINDL with turns per minute before a feed per turn", "none")
            value *= self.turns
        return value * (self.scale if FEED_UNITS[unit] is None else FEED_UNITS[unit])

    def on_load(self, words):
        need(words[:1] == ["TOOL"], "LOAD/TOOL, and a number")
        self.on_loadtl(words[1:])

    def on_loadtl(self, words):
        need(self.cycle is None, "CYCLE/OFF before the tool is changed", "a cycle that holds")
        said, *words = words or [""]
        number, length, statement = self.number(said), None, None
        need(number == int(number) and 0 <= number <= 99_999_999, "the number of a tool", said)
        while words:
            word, *words = words
            if word == "LENGTH":
                said, *words = words or [""]
                length = self.number(said) * self.scale
                need(length >= 0, "a tool length, not negative", f"{length:g}")
                statement = f"LOADTL/{int(number)},LENGTH,{length:g}"  # in mm, whatever the file is in
                continue
            register = not REAL.fullmatch(word) or (word.isdigit() and int(word) <= 99)
            need(register, "the word LENGTH before a length; registers are whole numbers up to 99", word)
        self.command("tool", int(number), length, statement=statement)

    def on_spindl(self, words):
        numbers = [word for word in words if REAL.fullmatch(word)]
        for word in words:
            known = word in numbers or word in ("RPM", "CLW", "CCLW", "CCW", "ON", "OFF", "STOP")
            need(known, "SPINDL/ a number, RPM, CLW or CCLW, ON or OFF", repr(word))
        need(len(numbers) < 2 and words, "SPINDL/ one number", f"{len(numbers)}")
        off = "OFF" in words or "STOP" in words
        self.turns = self.number(numbers[0]) if numbers else self.turns
        self.turning = "OFF" if off else "CCLW" if {"CCLW", "CCW"} & set(words) else "CLW"
        self.command("spindle", float(numbers[0]) if numbers else None, self.turning)

    def on_coolnt(self, words):
        kind = words[0] if words else ""
        need(kind in ("ON", "FLOOD", "MIST", "THRU", "AIR", "OFF"), "COOLNT/ON, FLOOD, MIST, THRU, AIR or OFF")
        if kind in ("THRU", "AIR"):  # every machine has its own M word for it
            self.counts[f"coolant that stays off: a comment tells which {kind}"] += 1
            self.remark()
        else:
            self.command("coolant", "FLOOD" if kind == "ON" else kind)

    def on_cutcom(self, words):
        sides = [word for word in words if word in ("LEFT", "RIGHT", "OFF")]
        need(sides or words[:1] == ["ON"], "CUTCOM/LEFT, RIGHT, ON or OFF")
        if sides:
            self.command("compensation", sides[0])
        else:  # goes on as before; the side follows
            self.remark()

    def on_stop(self, words):
        self.command("optional stop" if self.statement.upper().startswith("OP") else "stop")

    def on_delay(self, words):
        turns = words[1:] == ["REV"]
        need(len(words) == 1 + turns, "DELAY/ seconds, or DELAY/ turns,REV")
        number = self.number(words[0])
        need(self.turns or not turns, "SPINDL with turns per minute before a delay in turns", "none")
        self.command("dwell", number * 60 / self.turns if turns else number)

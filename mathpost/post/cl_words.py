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
from mathpost.post.arcs import Cycle, arc
from mathpost.post.cl_lines import REAL, UNIT_TOLERANCE, Lines, Wrong, need
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
    "ROTHED": "it turns the head itself; let the CAM system write tool axes instead (multi-axis output)",
    "ROTATE": "it turns an axis itself; let the CAM system write tool axes instead (multi-axis output)",
    "TRANS": "it shifts the coordinates; let the CAM system write them shifted",
    "TRACUT": "it transforms the coordinates; let the CAM system write them transformed",
    "COPY": "it repeats moves; let the CAM system write all of them",
    "CALSUB": "it calls moves that are not in this file; let the CAM system write them",
    "CALLSUB": "it calls moves that are not in this file; let the CAM system write them",
    "PREFUN": "it puts a G code into the program",
    "AUXFUN": "it puts an M code into the program",
    "PPWORD": "it puts words into the program",
    "RETRCT": "it moves the tool to a plane that another post-processor knows",
}
FEED_UNITS = {"MMPM": 1.0, "IPM": MM_PER_INCH, "PERMIN": None, "MMPR": 1.0, "IPR": MM_PER_INCH, "PERREV": None}
PER_TURN = ("MMPR", "IPR", "PERREV")
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

    ``"tool"`` (number, length in mm or None), ``"spindle"`` (turns per minute or None, ``"CLW"``, ``"CCLW"`` or
    ``"OFF"``), ``"coolant"`` (``"FLOOD"``, ``"MIST"`` or ``"OFF"``), ``"compensation"`` (``"LEFT"``, ``"RIGHT"`` or
    ``"OFF"``), ``"dwell"`` (seconds), ``"stop"`` or ``"optional stop"``.
    """

    kind: str
    values: tuple
    statement: str  # the words of the CL file


class Statements(Lines):
    """Takes statements: the method ``on_word`` what stands behind the slash of that word.

    `tolerance` and `ignored` are those of `cl.read`.
    """

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
            self.counts["ignored as asked", word] += 1
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
            except Wrong as wrong:
                self.problem(self.start, word, *wrong.args)
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
            raise Wrong("an arc of one GOTO (let Creo write no points on arcs, or points only)", found)
        elif self.cycle is not None:
            self.drill(np.array(point), np.array(axis))
        else:
            self.go(point, axis)

    def contact(self, axis, normal):
        """Keep the surface's normal where the tool touches it: for tools other than that of the CL data."""
        if abs(np.linalg.norm(normal) - 1) > UNIT_TOLERANCE or np.dot(normal, axis) < -UNIT_TOLERANCE:
            raise Wrong("a unit contact normal out of the part, within 90° of the tool axis", f"{normal}")
        if self.circle is not None or self.cycle is not None:
            raise Wrong("contact normals of single points only", "an arc or a cycle")
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
        values = self.numbers(words, 3)
        if not abs(math.hypot(*values) - 1) <= UNIT_TOLERANCE:
            raise Wrong(f"a unit tool axis (to {UNIT_TOLERANCE})", f"length {math.hypot(*values):.6g}")
        self.axis = (self.turned.T @ values).tolist()  # the table turns, the tool axis is said in the part
        self.unconfirmed = bool(self.table.any())

    def on_mode(self, words):
        if self.statement.upper().startswith("SET"):
            words = words[1:] if words[:1] == ["MODE"] else ["?"]
        if words == ["MILL"]:
            self.remark()
        elif words in (["INCR"], ["ABSOL"]):
            self.incremental = words == ["INCR"]
        else:
            raise Wrong("INCR, ABSOL or MILL")

    def on_rapid(self, words):
        need(not words, "RAPID, or RAPID/ and nothing")  # MODAL, or a feed that the control does not take from it
        self.rapid = True

    # Arcs

    def on_circle(self, words):
        """The tool goes to the next GOTO on this circle.

        NX writes the radius and tolerances and turns clockwise about the axis; Creo writes the radius, SolidWorks
        none, and both turn right-handed. The turns that NX counts by TIMES are those begun, the last one included:
        then the helices of published files have the ramp angles that their operations were given.
        """
        turns = 1.0
        if words[-2:-1] == ["TIMES"]:
            turns, words = self.number(words[-1]), words[:-2]
        need(turns in range(1, MOST_TURNS + 1), f"TIMES, and a whole number from 1 to {MOST_TURNS}", f"{turns:g}")
        turned = {"COUNTERCLOCKWISE": 1, "CCLW": 1, "CLOCKWISE": -1, "CLW": -1}.get(words[-1] if words else "")
        values = self.numbers(words[:-1] if turned else words, 6, 7, 11)  # centre, axis, radius …
        if self.point is None or self.incremental or self.cycle:
            raise Wrong("CIRCLE after a move, in absolute coordinates and outside a cycle")
        centre, sign = self.mm(values[:3]), turned or (-1 if len(values) == 11 else 1)
        self.circle = centre, [sign * value for value in values[3:6]], int(turns) - 1, len(values) == 7, None
        radius = math.dist(*(np.cross(values[3:6], each) for each in (self.point, centre)))
        if len(values) > 6 and abs(radius - values[6] * self.scale) > 0.02:
            raise Wrong(f"a start {values[6] * self.scale:g} mm from the centre", f"{radius:.4f}")

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
        turned = math.degrees(
            math.atan2(np.cross(start, end) @ normal, np.cross(normal, start) @ np.cross(normal, end))
        )
        for sign in (1, -1):
            if abs(wrap(sign * turned - angle)) < 0.1:
                return [sign * component for component in normal]
        raise Wrong(f"an arc of {angle:g} degrees to its end", f"{turned % 360:.3f}")

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
            raise Wrong("(CIRCLE/x,y,z,r),ON,(LINE/…) or (CYLNDR/…),ON,(PLANE/…)")
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
        self.counts["arcs as chords", f"{self.tolerance:g} mm"] += 1

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
            if word not in OF_A_CYCLE and word not in FEED_UNITS:
                raise Wrong(f"one of {', '.join([*OF_A_CYCLE, *FEED_UNITS])} in a cycle", repr(word))
            said, *words = words or [""]
            value = self.number(said)
            if word in FEED_UNITS:
                given["feed"] = self.per_minute(value, word)
            else:
                given[OF_A_CYCLE[word]] = value * (1.0 if word == "DWELL" else self.scale)
        need(given["feed"] >= LEAST_FEED, "a feed in the cycle or before it", "none")
        if "depth" not in given or not given.get("clearance", 0) > 0:
            raise Wrong("a depth (FEDTO or DEPTH) and a clearance (RAPTO or CLEAR)")
        given["depth"] = abs(given["depth"])  # NX counts upwards, SolidWorks and Creo downwards
        if kind == "BRKCHP":
            given["out"] = 0.5
        if kind == "TAP" and (self.turns is None or self.turning not in ("CLW", "CCLW")):
            raise Wrong("a turning spindle before CYCLE/TAP", "none")
        need(not self.incremental, "a cycle in absolute coordinates", "MODE/INCR")
        self.cycle = Cycle(kind, **given)

    def drill(self, point, axis):
        """Add the moves of a hole."""
        cycle, turning = self.cycle, {"CLW": "CCLW", "CCLW": "CLW"}
        if cycle.kind == "TAP" and self.turning not in turning:
            raise Wrong("a turning spindle before a hole is tapped", self.turning)
        before = float((np.array(self.point) - point) @ axis) if self.point is not None else cycle.clearance
        heights, rapid, bottom = cycle.heights(before)
        after = self.count + bottom + 1
        self.go(point + np.outer(heights, axis), axis, feed=cycle.feed, rapid=rapid)
        if cycle.dwell:
            self.command("dwell", cycle.dwell, statement=f"DELAY/{cycle.dwell:g}", record=after)
        if cycle.kind == "TAP":  # out again with the spindle turning back
            for record, sense in ((after, turning[self.turning]), (after + 1, self.turning)):
                said = f"SPINDL/{self.turns:g},RPM,{sense}"
                self.command("spindle", self.turns, sense, statement=said, record=record)
            self.counts["holes tapped as moves: a floating holder is needed", ""] += 1
        self.counts["holes of drilling cycles as moves", ""] += 1

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
        if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-4) or np.linalg.det(rotation) < 0:
            raise Wrong("right-handed axes at right angles", str(rotation.round(6).tolist()))
        if self.first_system is None:
            need(not self.count, "the first coordinate system before the first move", "moves before it")
            self.first_system = self.system = system
        if not np.allclose(system, self.system, atol=1e-9):
            self.counts["changes of the coordinate system, brought into the first", ""] += 1
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
        if len(axes) != 1 or len(numbers) != 1 or {*words} - {*axes, *numbers} - known:
            raise Wrong("ROTABL/ an angle, AAXIS, BAXIS or CAXIS, and CLW or CCLW")
        need(not self.incremental and self.cycle is None, "ROTABL in absolute coordinates and outside a cycle")
        angle = self.number(numbers[0]) * (-1 if "CLW" in words else 1)
        axis, before = "ABC".index(axes[0][0]), self.turned
        from_zero = {"TABLE", "ATANGL"} & {*words} and "INCR" not in words
        self.table[axis] = (0 if from_zero else self.table[axis]) + (
            angle if "TABLE" in words else math.radians(angle)
        )
        a, b, c = (about(direction, angle) for direction, angle in zip(np.eye(3), self.table, strict=True))
        self.turned, self.unconfirmed = np.array(a * b * c, dtype=float), True
        self.axis = (self.turned.T @ before @ self.axis).tolist()
        if self.system is None:
            self.first_system = self.system = np.eye(3, 4)
        standing, origin = np.hsplit(self.system, [3])
        self.use_system(np.hstack([standing @ before.T @ self.turned, origin / self.scale]))

    def confirm_turn(self, axis):
        """Refuse a move after ROTABL if its tool axis does not say which way the table has turned."""
        turned = ~np.isclose(self.table, 0, atol=UNIT_TOLERANCE)
        if self.unconfirmed and turned.any():
            z, said = self.turned[:, 2], self.turned @ axis
            if turned.sum() > 1:
                raise Wrong("one axis of the table turned by ROTABL: nothing says which carries which", "several")
            need(not turned[2], "ROTABL across the tool: of a turn about the tool nothing says the sense", "CAXIS")
            if not np.allclose(said, z, atol=UNIT_TOLERANCE):
                z, said = (",".join(f"{value:z.4f}" for value in each) for each in (z, said))
                raise Wrong(
                    f"TLAXIS/{z} of the part, along Z of the table that ROTABL has turned", f"TLAXIS/{said}"
                )
        self.unconfirmed = False

    def on_trntyp(self, words):
        if words[:1] != ["WORLD"] or any(self.numbers(words[1:])):
            raise Wrong("TRNTYP/WORLD,0,0,0, which changes nothing")
        self.remark()

    def on_origin(self, words):
        if any(self.numbers(words)):
            raise Wrong("ORIGIN/0,0,0, which changes nothing; let the CAM system write it shifted")
        self.remark()

    # Feeds, and what the control shall do

    def on_fedrat(self, words):
        units = [word for word in words if word in FEED_UNITS]
        if words == ["RAPID"]:
            self.rapid = True
            return
        values = [word for word in words if word not in FEED_UNITS]
        if len(values) != 1 or len(units) > 1:
            raise Wrong("FEDRAT/ a number and MMPM, IPM, MMPR or IPR", ",".join(words) or "nothing")
        value = self.number(values[0])
        feed = self.per_minute(value, units[0] if units else "PERMIN")
        need(feed >= LEAST_FEED, f"a feed above 0, at least {LEAST_FEED:g} mm/min", f"{value:g}")
        self.feed = feed

    def per_minute(self, value, unit):
        """Return a feed in mm/min."""
        if unit in ("IPM", "IPR") and not self.units_stated:
            raise Wrong("UNITS/MM or UNITS/INCH before a feed in inches: the points may be inches, too", "none")
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
            elif REAL.fullmatch(word) and (not word.isdigit() or int(word) > 99):
                raise Wrong("the word LENGTH before a length; registers are whole numbers up to 99", word)
        self.command("tool", int(number), length, statement=statement)

    def on_spindl(self, words):
        numbers = [word for word in words if REAL.fullmatch(word)]
        known = {"RPM", "CLW", "CCLW", "CCW", "ON", "OFF", "STOP"}
        if strange := [word for word in words if word not in numbers and word not in known]:
            raise Wrong("SPINDL/ a number, RPM, CLW or CCLW, ON or OFF", repr(strange[0]))
        need(len(numbers) < 2 and words, "SPINDL/ one number", f"{len(numbers)}")
        off = "OFF" in words or "STOP" in words
        self.turns = self.number(numbers[0]) if numbers else self.turns
        self.turning = "OFF" if off else "CCLW" if {"CCLW", "CCW"} & set(words) else "CLW"
        self.command("spindle", float(numbers[0]) if numbers else None, self.turning)

    def on_coolnt(self, words):
        kind = {"ON": "FLOOD", "FLOOD": "FLOOD", "MIST": "MIST", "OFF": "OFF"}.get(words[0] if words else "")
        if words[:1] in (["THRU"], ["AIR"]):  # every machine has its own M word for it
            self.counts["coolant that stays off: a comment tells which", words[0]] += 1
            self.remark()
        elif kind is None:
            raise Wrong("COOLNT/ON, FLOOD, MIST, THRU, AIR or OFF")
        else:
            self.command("coolant", kind)

    def on_cutcom(self, words):
        side = next((word for word in words if word in ("LEFT", "RIGHT", "OFF")), *words[:1] or [""])
        if side == "ON":  # goes on as before; the side follows
            self.remark()
        elif side in ("LEFT", "RIGHT", "OFF"):
            self.command("compensation", side)
        else:
            raise Wrong("CUTCOM/LEFT, RIGHT, ON or OFF")

    def on_stop(self, words):
        self.command("optional stop" if self.statement.upper().startswith("OP") else "stop")

    def on_delay(self, words):
        turns = words[1:] == ["REV"]
        need(len(words) == 1 + turns, "DELAY/ seconds, or DELAY/ turns,REV")
        seconds = self.number(words[0])
        if turns:
            need(self.turns, "SPINDL with turns per minute before a delay in turns", "none")
            seconds *= 60 / self.turns
        self.command("dwell", seconds)

"""The words of CL data that move the tool, on lines and arcs, and those that set the coordinate system."""

import math
import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError
from mathpost.path import coordinates
from mathpost.path.arcs import SAME_POINT, SAME_RADIUS, Cycle, arc
from mathpost.path.cl_lines import REAL, UNIT_TOLERANCE, known, need
from mathpost.path.orders import Orders
from mathpost.path.pieces import Arc, Hole
from mathpost.rotation import unit, wrap

MOST_TURNS = 1000  # of a helix
# The words of TLON,GOFWD/ for an arc: to a line from its centre, or to a plane through its axis and a point.
ON_AN_ARC = ("CIRCLE ON LINE", "CYLNDR ON PLANE PERPTO PLANE POINT PERPTO VECTOR POINT POINT")
FIRST_OR_SECOND = re.compile(r"[^,]*,[^/]*(?:(?!\),[-+.\d]).)*,ON,(2,INTOF,)?\(?[A-Z](?:(?!\),[-+.\d]).)*$")
LITERAL = re.compile(r"\(?\s*(CIRCLE|CYLNDR|LINE|POINT)\s*/([-+\d.eE,\s]*)")  # geometry within a statement

# Centre, axis, full turns before it, and degrees to its end or None.
Circle = tuple[list[float], list[float], int, float | None]


class Movements(Orders):
    def __init__(self, name: str, tolerance: float) -> None:
        super().__init__(name)
        self.tolerance = tolerance
        self.along_z = False  # whether there was a MULTAX/OFF or CSYS since the last move
        self.home: tuple[list[float], list[float]] | None = None
        self.tangent: list[float] | None = None
        self.cycle: Cycle | None = None
        self.circle: Circle | None = None  # the next move, if it is an arc,
        self.arc_before: tuple[list[float], list[float]] | None = None  # centre and axis of the last, if it was one
        self.unconfirmed = False  # whether the tool axis must still confirm the sense in which the table turned
        self.work_offset: int | None = None
        self.normals: dict[int, list[float]] = {}
        self.pieces: list[Arc | Hole] = []

    def pose(self, words: list[str], *counts: int) -> tuple[list[float], list[float], list[float]]:
        """Return the point (mm) or nothing, the stated or the active tool axis, and the rest of the numbers."""
        self.settle()
        values = self.numbers(words, *counts)
        return self.mm(values[:3]), values[3:6] or self.axis, values[6:]

    def mm(self, values: Sequence[float]) -> list[float]:
        return [value * self.scale for value in values]

    def settle(self) -> None:
        """Settle, before a move, the coordinates that it is in.

        After MULTAX/OFF and after every CSYS the tool points along Z, until a word says otherwise.
        """
        if self.coordinates.unsettled:
            if assumed := self.coordinates.settle():
                self.counts[assumed] += 1
            if self.along_z:
                self.axis = list(self.coordinates.z)
            self.along_z = False

    # Movements

    def on_goto(self, words: list[str]) -> None:
        point, axis, normal = self.pose(words, 3, 6, 9)
        if normal:
            self.contact(axis, normal)
        self.confirm_turn(axis)
        arc_before, self.arc_before = self.arc_before, None
        if self.circle is not None:
            centre, normal, turns, angle = self.circle
            self.circle = None
            before = known(self.point, "an arc in the coordinate system of its start", "a different one")
            if angle is not None:
                normal = self.sense(point, centre, normal, angle)
            self.sweep(before, point, axis, centre, normal, turns)
            self.arc_before = centre, normal
        elif self.cycle is not None:
            self.drill(self.cycle, np.array(point), np.array(axis))
        else:
            if arc_before is not None and self.leads_to_its_circle(point, *arc_before):
                self.counts["lines from the end of an arc to a point of its circle"] += 1
            self.go(point, axis)

    def contact(self, axis: list[float], normal: list[float]) -> None:
        """Keep the normal of the surface where the tool touches it, for tools other than that of the CL data."""
        outwards = abs(np.linalg.norm(normal) - 1) <= UNIT_TOLERANCE and np.dot(normal, axis) >= -UNIT_TOLERANCE
        need(outwards, "a unit contact normal out of the part, within 90° of the tool axis", f"{normal}")
        need(not (self.circle or self.cycle), "contact normals of single points only", "an arc or a cycle")
        placed = self.coordinates.placed(np.array([[0, 0, 0, *normal]], dtype=float).T)
        self.normals[self.start] = placed[3:, 0].tolist()

    def on_godlta(self, words: list[str]) -> None:
        self.settle()
        values = self.mm(self.numbers(words, 1, 3))
        self.go(self.shifted(values if len(values) == 3 else np.multiply(values, self.axis)), self.axis)

    def shifted(self, values: ArrayLike) -> list[float]:
        before = known(self.point, "FROM or GOTO before an incremental move", "none")
        return np.add(before, values).tolist()

    def on_from(self, words: list[str]) -> None:
        self.home = self.point, self.axis = self.pose(words, 3, 6)[:2]
        self.remark()

    def on_gohome(self, words: list[str]) -> None:
        point, axis, _ = self.pose(words, 0, 3, 6)
        if not point:
            point, axis = known(self.home, "FROM before GOHOME: nothing else says where home is", "none")
        self.go(point, axis, rapid=True)

    def on_tlaxis(self, words: list[str]) -> None:
        self.settle()
        values = self.numbers(words, 3)
        length = math.hypot(*values)
        need(abs(length - 1) <= UNIT_TOLERANCE, f"a unit tool axis (to {UNIT_TOLERANCE})", f"length {length:.6g}")
        self.axis = (self.coordinates.turned.T @ values).tolist()  # the table turns, TLAXIS is in the part
        self.unconfirmed = bool(self.coordinates.table.any())

    def on_multax(self, words: list[str]) -> None:
        need(words in ([], ["ON"], ["OFF"]), "MULTAX, MULTAX/ON or MULTAX/OFF")
        off = words == ["OFF"]
        self.along_z = self.along_z or off
        self.coordinates.say(multax=not off)
        self.remark()

    def on_mode(self, words: list[str]) -> None:
        if self.statement.upper().startswith("SET"):
            if words[:1] == ["OFSETL"]:
                need(len(words) == 2, "SET/OFSETL and the number of an offset")
                self.set_offset(words[1])
                return
            words = words[1:] if words[:1] == ["MODE"] else ["?"]
        need(words in (["INCR"], ["ABSOL"], ["MILL"]), "INCR, ABSOL or MILL")
        if words == ["INCR"]:
            self.counts["INCR, how a post-processor writes: GOTO and this program stay absolute"] += 1
        self.remark()

    # Arcs

    def on_circle(self, words: list[str]) -> None:
        """Let the tool go to the next GOTO on this circle.

        NX writes the radius and tolerances and turns clockwise about the axis; Creo writes the radius, SolidWorks
        none, and both turn right-handed. NX's TIMES counts the turns begun: with this reading, published helices
        have the ramp angles that their operations were given.
        """
        turns = 1.0
        if words[-2:-1] == ["TIMES"]:
            turns, words = self.number(words[-1]), words[:-2]
        need(turns in range(1, MOST_TURNS + 1), f"TIMES, and a whole number from 1 to {MOST_TURNS}", f"{turns:g}")
        turned = {"COUNTERCLOCKWISE": 1, "CCLW": 1, "CLOCKWISE": -1, "CLW": -1}.get(words[-1] if words else "")
        values = self.numbers(words[:-1] if turned else words, 6, 7, 11)  # centre, axis, radius …
        expected = "CIRCLE after a move, outside a cycle"
        before = known(self.point, expected)
        need(not self.cycle, expected)
        centre, sign = self.mm(values[:3]), turned or (-1 if len(values) == 11 else 1)
        self.circle = centre, [sign * value for value in values[3:6]], int(turns) - 1, None
        axis = np.array(values[3:6])
        radius = math.dist(np.cross(axis, np.array(before)), np.cross(axis, np.array(centre)))
        for stated in self.mm(values[6:7]):
            need(abs(radius - stated) <= SAME_RADIUS, f"a start {stated:g} mm from the centre", f"{radius:.4f}")

    def on_movarc(self, words: list[str]) -> None:
        """Take an arc of ISO 4343, as Autodesk writes it: centre, axis and radius, also named, and the angle."""
        names, words = words, [word for word in words if word not in ("CENTER", "AXIS", "RADIUS")]
        angle = None
        if words[7:8] == ["ANGLE"]:
            angle, words = self.number(",".join(words[8:])), words[:7]
        turns = words[7:] if words[7:8] == ["TIMES"] else []
        named = len(words) < len(names)
        complete = len(words) == 7 + len(turns) and (named or angle is not None)
        need(complete, "MOVARC/ 7 numbers and ANGLE, or CENTER, AXIS and RADIUS with theirs")
        self.numbers(words[:7], 7)
        self.on_circle([*words[:7], *turns])
        if angle is not None and self.circle is not None:
            centre, normal, *_ = self.circle
            self.circle = centre, normal, int(max(angle - 1e-3, 0) // 360), angle

    def sense(self, point: list[float], centre: list[float], normal: list[float], angle: float) -> list[float]:
        """Return the axis about which the tool turns right-handed by `angle` (degrees) on its way to a point."""
        start, end = np.array(self.point) - centre, np.array(point) - centre
        across, along = np.cross(start, end) @ normal, np.cross(normal, start) @ np.cross(normal, end)
        turned = math.degrees(math.atan2(across, along))
        for sign in (1, -1):
            if abs(wrap(sign * turned - angle)) < 0.1:
                return [sign * component for component in normal]
        raise InputError("", f"an arc of {angle:g} degrees to its end", f"{turned % 360:.3f}")

    def leads_to_its_circle(self, point: list[float], centre: list[float], normal: list[float]) -> bool:
        """Return whether a line leads from the end of an arc to a point on its circle, where the arc could go on.

        It is a line: of 44 in public files of Creo, 34 are followed by a CIRCLE about the same centre, which could
        have begun before them, and where Creo writes points on an arc they are as dense as those on any curve.
        """
        start, end = np.array(self.point) - centre, np.array(point) - centre
        radius = float(np.linalg.norm(start))
        chord = float(np.linalg.norm(end - start))
        on_it = abs(float(np.linalg.norm(end)) - radius) < 1e-3 and abs(float((end - start) @ normal)) < 1e-3
        return on_it and radius - math.sqrt(max(radius**2 - chord**2 / 4, 0)) > self.tolerance

    def on_indirv(self, words: list[str]) -> None:
        self.tangent = self.numbers(words, 3)

    def on_tlon(self, words: list[str]) -> None:
        """Take an arc of CATIA: from where the tool is, in the direction of INDIRV, to a line from the centre."""
        said = self.statement.upper()
        names = " ".join(re.findall("[A-Z]{2,}", said.partition("/")[2])).replace(" INTOF", "")
        which = FIRST_OR_SECOND.match("".join(said.split()))
        need(which and names in ON_AN_ARC, "(CIRCLE/x,y,z,r),ON,(LINE/…) or (CYLNDR/…),ON,(PLANE/…)")
        found = {name: self.numbers(values.split(",")) for name, values in LITERAL.findall(said)}
        sizes = {name: len(values) for name, values in found.items()}
        tangent, self.tangent = self.tangent, None
        before = known(self.point, "a move and INDIRV before TLON,GOFWD", "none")
        tangent = known(tangent, "a move and INDIRV before TLON,GOFWD", "none")
        if sizes == {"CIRCLE": 4, "LINE": 6}:  # a circle in a plane Z
            values, axis, towards = found["CIRCLE"], [0.0, 0.0, 1.0], found["LINE"][3:]
        elif sizes == {"CYLNDR": 7, "POINT": 3}:
            values, axis, towards = found["CYLNDR"], found["CYLNDR"][3:6], found["POINT"]
        else:
            raise InputError("", "(CIRCLE/x,y,z,r),ON,(LINE/…) or (CYLNDR/…),ON,(PLANE/…)", None)
        centre, end = (np.array(self.mm(each[:3])) for each in (values, towards))
        start, normal = np.array(before), np.array(axis)
        spoke = end - centre - (end - centre) @ normal * normal
        need(np.linalg.norm(spoke) > 0, "an end off the centre of the arc", "the centre")
        height = (start - centre) @ normal
        end = centre + spoke * values[-1] * self.scale / np.linalg.norm(spoke) + height * normal
        normal = normal if np.cross(normal, start - centre) @ tangent > 0 else -normal
        across, along = (
            np.cross(start - centre, end - centre) @ normal,
            (start - centre) @ (end - centre) - height**2,
        )
        turned = math.degrees(math.atan2(across, along)) % 360
        # 2: the line goes on behind the centre.
        beyond = 2 if turned > 180 or math.dist(start, end) < SAME_POINT else 1
        stated = 2 if which and which[1] else 1
        need(beyond == stated or abs(turned - 180) < 0.1, "2,INTOF for an arc beyond half a turn, and for no other")
        self.sweep(before, end, self.axis, centre, normal)

    def sweep(
        self, before: list[float], point: ArrayLike, axis: list[float], centre: ArrayLike, normal: ArrayLike,
        turns: int = 0,
    ) -> None:  # fmt: skip
        """Add an arc from where the tool was, as chords, and `turns` full turns before it."""
        need(not self.rapid, "an arc at a feed", "RAPID")
        need(np.allclose(axis, self.axis, atol=1e-6), "a tool axis that stands still on an arc", "one that turns")
        first = self.count - 1
        self.go(arc(before, point, centre, normal, self.tolerance, turns), axis)
        if first >= 0:  # otherwise it begins where FROM says
            line = np.concatenate([np.asarray(centre), unit(normal)])
            x, y, z, i, j, k = self.coordinates.placed(line[:, None])[:, 0].tolist()
            self.pieces.append(Arc(first, self.count - 1, (x, y, z), (i, j, k)))
        self.counts[f"arcs as chords {self.tolerance:g} mm"] += 1

    def drill(self, cycle: Cycle, point: np.ndarray, axis: np.ndarray) -> None:
        """Add the moves of a hole."""
        raise NotImplementedError

    # Coordinate systems

    def on_msys(self, words: list[str]) -> None:
        """Enter a coordinate system of NX, stated by its origin, X and Y."""
        origin, x, y = np.reshape(self.numbers(words, 9), (3, 3))
        need(self.coordinates.first is not None or not self.count, "MSYS before the first move", "moves before it")
        rotation = np.column_stack([x, y, np.cross(x, y)])
        self.enter(self.coordinates.enter(rotation, origin * self.scale, coordinates.MSYS))

    def on_mcsys(self, words: list[str]) -> None:
        """Take the number of a work offset, and origin, X and Y of a plane in its coordinates."""
        names = ",".join("#" if REAL.fullmatch(word) else word for word in words)
        plane = "NUM,#,POINT,#,#,#,VECTOR,#,#,#,VECTOR,#,#,#"
        numbers = [word for word in words if REAL.fullmatch(word)]
        whole = bool(numbers) and numbers[0].isdecimal() and int(numbers[0]) > 0
        expected = (
            "MCSYS/NUM and the number of a work offset, from 1; POINT, VECTOR and VECTOR with three numbers each"
        )
        need(names in ("NUM,#", plane) and whole, expected)
        number = int(numbers[0])
        system = np.array(self.numbers(numbers[1:]) or [0, 0, 0, 1, 0, 0, 0, 1, 0], dtype=float)
        need(self.work_offset or not self.count, "MCSYS before the first move", "moves before it")
        need(not self.cycle and not self.circle, "MCSYS outside a cycle and an arc", "within one")
        if number != self.work_offset:
            self.command("work offset", number, statement=f"MCSYS/NUM,{number}")
            self.point = None  # not stated in these coordinates
        self.work_offset = number
        origin, x, y = system.reshape(3, 3)
        self.coordinates.first = coordinates.IDENTITY
        rotation = np.column_stack([x, y, np.cross(x, y)])
        self.enter(self.coordinates.enter(rotation, origin * self.scale, coordinates.MCSYS))

    def on_csys(self, words: list[str]) -> None:
        """Take the rows of a 3×4 matrix; `mathpost.path.coordinates` explains it."""
        matrix = np.reshape(self.numbers(words, 12), (3, 4)) * [1, 1, 1, self.scale]
        coordinates.need_right_handed(matrix[:, :3])
        first = self.coordinates.csys is None and not self.coordinates.world
        need(not first or not self.count, "CSYS before the first move", "moves before it")
        self.coordinates.say(csys=matrix)
        self.along_z = True

    def on_trntyp(self, words: list[str]) -> None:
        need(words[:1] == ["WORLD"], "TRNTYP/WORLD,0,0,0")
        self.coordinates.say(world=True)
        self.on_origin(words[1:])

    def on_origin(self, words: list[str]) -> None:
        need(not any(self.numbers(words)), "zeros, which change nothing; let the CAM system write it shifted")
        self.remark()

    def enter(self, another: bool) -> None:
        if another:
            self.counts["changes of the coordinate system, brought into the first"] += 1
            self.point = None  # not stated in these coordinates

    def on_rotabl(self, words: list[str]) -> None:
        """Turn the table; the points that follow are in coordinates that do not turn with the part.

        SolidWorks writes TABLE, and radians from the table's zero. Others write degrees, with ATANGL from zero.
        """
        others = {"TABLE", "CCLW", "CLW", "ATANGL", "INCR"}
        axes = [word for word in words if word in ("AAXIS", "BAXIS", "CAXIS")]
        numbers = [word for word in words if REAL.fullmatch(word)]
        one_each = len(axes) == len(numbers) == 1 and {*words} <= {*axes, *numbers, *others}
        need(one_each, "ROTABL/ an angle, AAXIS, BAXIS or CAXIS, and CLW or CCLW")
        need(self.cycle is None, "ROTABL outside a cycle")
        angle = self.number(numbers[0]) * (-1 if "CLW" in words else 1)
        turn = angle if "TABLE" in words else math.radians(angle)
        from_zero = not {"TABLE", "ATANGL"}.isdisjoint(words) and "INCR" not in words
        turned, another = self.coordinates.turn_table("ABC".index(axes[0][0]), turn, from_zero)
        self.axis, self.unconfirmed = (turned @ self.axis).tolist(), True
        self.enter(another)

    def confirm_turn(self, axis: list[float]) -> None:
        """Check, once after ROTABL, that the tool axis confirms the sense in which the table turned."""
        if self.unconfirmed:
            self.coordinates.confirm_turn(axis)
            self.unconfirmed = False

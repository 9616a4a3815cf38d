"""Whose coordinates the points of CL data are in, and where the tool points when a GOTO does not say.

The systems use the same words for different things. Their meanings, and the evidence for them:

SolidWorks CAM, ``TRNTYP/WORLD``
    GOTO and tool axis are the part's; ``CSYS/``, rows of a matrix of 3 by 4, says only where the tool's frame
    lies. In the public files of one shop (github.com/aamorim1913/AptPostProcessor, 104 with former versions)
    the tool axis of 9,137 of the 9,185 six-number GOTOs is the third column of the matrix, the others lean a
    little from an upright one, and only so does a face mill meet its stock. The post-processor published with
    them, which made the parts, rotates each GOTO into the frame of that column. A GOTO of three numbers means that
    the tool points along that Z, anew after every CSYS. Without TRNTYP nothing says whose coordinates a GOTO is
    in: a single upright CSYS for the whole file makes no difference, any other is refused.
NX, ``MSYS/``
    Origin, X and Y of the machining coordinate system in the part; GOTO and tool axis are in it (ICAM, MSYS9:
    "convert the 9-parameter MSYS command matrix from Unigraphics format to a standard matrix format"). ``CSYS/``
    without TRNTYP as above.
Autodesk's post for DMG MORI's MfgSuite, ``MCSYS/NUM``
    The number of a work offset, and after POINT, VECTOR, VECTOR the origin, X and Y of a plane in its coordinates;
    GOTO and tool axis are in the plane (its source writes `workOffset`, `workOrigin` and `workPlane` of an
    operation). Without a plane they are in the coordinates of the work offset.
Creo, ``$$-> CSYS / …``
    "If the Machine and NC Sequence coordinate systems are different, then … all CL data will be transformed and
    output in the coordinates of the Machine coordinate system" (PTC, "Machine and NC Sequence Coordinate Systems"),
    with tool axes, so MULTAX/ON. Three-axis steps may be in the sequence's (COORDINATE_OUTPUT): if the system turns
    between them they are refused; if it moves, the report says what was assumed.
CATIA, ``$$*CATIA0``
    The three comments after it are the rows that place the machining axis system in the part. A file has one, and
    whatever it is, GOTO and tool axis are in one system; a second one that differs is refused.
``ROTABL``
    The points that follow are in coordinates that do not turn with the table and the part: see `turn_table`.
"""

from typing import Any, NoReturn

import numpy as np

from mathpost.errors import InputError
from mathpost.rotation import about

SAME = 1e-6  # of directions and mm, as files print them
Z = (0.0, 0.0, 1.0)
IDENTITY = np.eye(3, 4)

AS_WRITTEN = "GOTO as written: the CL data name no coordinate system"
WORLD = "GOTO in world coordinates (SolidWorks, TRNTYP/WORLD)"
ONE_CSYS = "GOTO in the coordinates of one CSYS (no TRNTYP)"
MSYS = "GOTO in the coordinates of MSYS (NX), brought into the first"
MCSYS = "GOTO in the coordinates of MCSYS, brought into those of its work offset"
MACHINE = "GOTO in machine coordinates (Creo, MULTAX/ON)"
THREE_AXES = "GOTO in machine coordinates (Creo, three-axis steps)"
CATIA = "GOTO in the machining axis system (CATIA)"
TABLE = "GOTO in coordinates that stand still while ROTABL turns the part, brought into the first"


def refuse(expected: str, found: str) -> NoReturn:
    raise InputError("", expected, found)


def need_right_handed(rotation: np.ndarray) -> None:
    square = np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-4) and np.linalg.det(rotation) >= 0
    if not square:
        refuse("right-handed axes at right angles", str(rotation.round(6).tolist()))


def differ(one: np.ndarray, other: np.ndarray) -> bool:
    return not np.allclose(one, other, atol=SAME)


class Coordinates:
    """The coordinate system of GOTO: a rotation and, fourth column, an origin in mm.

    Words change it; `settle` is called before a move.
    """

    def __init__(self) -> None:
        self.rule = AS_WRITTEN
        self.first: np.ndarray | None = None  # the system of the first move
        self.system: np.ndarray | None = None  # and the active one
        self.z: tuple[float, ...] = Z  # where the tool points by default, in the coordinates of GOTO
        self.unsettled = False  # whether a word has changed something since the last move
        self.world = False
        self.multax: bool | None = None
        self.csys: np.ndarray | None = None  # the last that were stated,
        self.creo: np.ndarray | None = None
        self.catia: np.ndarray | None = None
        self.settled_csys: np.ndarray | None = None  # and those that moves were in
        self.settled_creo: np.ndarray | None = None
        self.settled_catia: np.ndarray | None = None
        self.table = np.zeros(3)  # by ROTABL: A, B, C,
        self.turned = np.eye(3)  # and the axes of the coordinates

    # Words

    def say(self, **words: Any) -> None:
        """Record what a word states: `world`, `multax`, `csys`, `creo`, `catia`; the next move settles it."""
        for name, value in words.items():
            setattr(self, name, value)
        self.unsettled = True

    def enter(self, rotation: np.ndarray, origin: np.ndarray, rule: str) -> bool:
        """Enter a system (NX); return whether it differs from the last. All moves are brought into the first."""
        need_right_handed(rotation)
        system, before = np.column_stack([rotation, origin]), self.system
        if self.first is None:
            self.first = system
        if before is None:
            before = self.first
        self.rule = rule
        self.system = self.first if np.allclose(system, self.first, atol=1e-9) else system
        return not np.allclose(system, before, atol=1e-9)

    def turn_table(self, axis: int, angle: float, from_zero: bool) -> tuple[np.ndarray, bool]:
        """Turn the table by or to an angle (radians), for ROTABL; return the rotation into the new coordinates.

        With CCLW the coordinates turn right-handed in the part: in SolidWorks' files TLAXIS is their Z.
        """
        before = self.turned
        self.table[axis] = angle if from_zero else angle + self.table[axis]
        a, b, c = (about(direction, turn) for direction, turn in zip(np.eye(3), self.table, strict=True))
        self.turned = np.array(a * b * c, dtype=float)
        if self.system is None:
            self.first = self.system = IDENTITY
        standing, origin = self.system[:, :3], self.system[:, 3]
        changed = self.enter(standing @ before.T @ self.turned, origin, TABLE)
        return self.turned.T @ before, changed

    def confirm_turn(self, axis: list[float]) -> None:
        """Refuse a move after ROTABL if its tool axis does not say which way the table has turned."""
        moved = np.abs(self.table) > 1e-3
        if not moved.any():
            return
        if moved.sum() > 1:
            refuse("one axis of the table turned by ROTABL: nothing says which carries which", "several")
        if moved[2]:
            refuse("ROTABL across the tool: of a turn about the tool nothing says the sense", "CAXIS")
        wanted, found = self.turned[:, 2], self.turned @ axis
        if not np.allclose(found, wanted, atol=1e-3):
            z, said = (",".join(f"{value:z.4f}" for value in each) for each in (wanted, found))
            refuse(f"TLAXIS/{z} of the part, along Z of the table that ROTABL has turned", f"TLAXIS/{said}")

    # Moves

    def settle(self) -> str | None:
        """Settle, before a move, the frame that it is in; return a sentence on what was assumed, or None.

        Raises `InputError` if the words so far do not determine it.
        """
        self.unsettled = False
        assumed: str | None = None
        if self.world:
            self.rule = WORLD
        if self.csys is not None:
            self._settle_csys(self.csys)
        if self.creo is not None:
            assumed = self._settle_creo(self.creo)
        if self.catia is not None:
            if self.settled_catia is not None and differ(self.catia, self.settled_catia):
                refuse("one machining axis system (CATIA): GOTO of two cannot be told apart", "another $$*CATIA0")
            self.settled_catia, self.rule = self.catia, CATIA
        return assumed

    def _settle_csys(self, csys: np.ndarray) -> None:
        before = self.settled_csys
        if self.world:
            self.z = tuple(csys[:, 2].tolist())
        else:
            if before is not None and differ(csys, before):
                expected = "TRNTYP/WORLD before CSYS, or one CSYS: nothing says in whose coordinates GOTO is"
                refuse(expected, "another")
            if not np.allclose(csys[:, 2], Z, atol=SAME):
                refuse("TRNTYP/WORLD before a CSYS that leans: nothing says in whose coordinates GOTO is", "none")
            self.rule = ONE_CSYS
        self.settled_csys = csys

    def _settle_creo(self, creo: np.ndarray) -> str | None:
        before = self.settled_creo
        if self.multax:
            self.settled_creo, self.rule = IDENTITY, MACHINE
            return None
        if before is None:
            before = creo
        if differ(creo[:, :3], before[:, :3]):
            expected = "MULTAX/ON (five-axis output, in machine coordinates) where $$-> CSYS turns between steps"
            refuse(expected, "none")
        self.settled_creo = before
        self.rule = MACHINE if self.rule == MACHINE else THREE_AXES
        moves = "$$-> CSYS moves between three-axis steps: taken in machine coordinates"
        return moves if differ(creo, before) else None

    def placed(self, numbers: np.ndarray) -> np.ndarray:
        """Points and axes, shape (6, n), in the first system."""
        if self.system is None or self.first is None or self.system is self.first:
            return numbers
        rotation, origin = np.hsplit(self.system, [3])
        first, first_origin = np.hsplit(self.first, [3])
        points = first.T @ (rotation @ numbers[:3] + (origin - first_origin))
        return np.concatenate([points, first.T @ (rotation @ numbers[3:])])


class Comments:
    """The coordinate systems that Creo and CATIA write as comments."""

    def __init__(self) -> None:
        self.rows: list[list[float]] | None = None  # of a matrix after $$*CATIA0, those read so far

    def take(self, text: str) -> dict[str, np.ndarray]:
        """Return the arguments for `Coordinates.say` that a comment (all of its lines) states."""
        words = text.lstrip("$").replace(",", " ").replace("/", " ").split()
        if words[:1] == ["*CATIA0"]:
            self.rows = []
        elif words[:2] == ["->", "CSYS"]:
            values = _numbers(words[2:])
            return {"creo": np.reshape(values, (3, 4))} if len(values) == 12 else {}
        elif self.rows is not None and len(row := _numbers(words)) == 4:
            self.rows.append(row)
            if len(self.rows) == 3:
                matrix, self.rows = np.array(self.rows), None
                return {"catia": matrix}
        return {}


def _numbers(words: list[str]) -> list[float]:
    """Return words as numbers; an empty list if one of them is not a number."""
    try:
        values = [float(word) for word in words]
    except ValueError:
        return []
    return values if np.isfinite(values).all() else []

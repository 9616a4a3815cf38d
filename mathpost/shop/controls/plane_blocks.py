"""Tilted planes as NC blocks: written as a control accepts them, and read back."""

import re

import numpy as np

from mathpost.errors import InputError
from mathpost.files import NUMBER, text_of
from mathpost.path.nc_words import Words, arguments, bare, numbers, written
from mathpost.shop.controls import plane_forms
from mathpost.shop.plane.tilted_plane import NOTATIONS, Plane

VECTOR_DECIMALS = 7  # the most that the control reads
# Words of a PLANE block, or of cycle 19, that change how the axes get there and not where the plane is.
POSITIONING = re.compile(
    rf"(?<!\S)(?:TURN|MOVE|STAY|SEQ[-+]|SYM[-+]|(?:COORD|TABLE) ROT|F ?MAX|F ?AUTO"
    rf"|MB ?MAX|(?:DIST|ABST|MB|F) ?{NUMBER})(?!\S)"
)
COMMENT, BLOCK_NUMBER = re.compile(";.*"), re.compile(r"^N?\d+\s+")


def _mode(order: str) -> int:
    """_MODE of an axis-by-axis swivel: two bits for the axis of each of _A, _B and _C, X 1, Y 2, Z 3."""
    return sum(("XYZ".index(axis) + 1) << 2 * place for place, axis in enumerate(order))


MODES = {_mode(name[-3:]): name for name in NOTATIONS if re.fullmatch("CYCLE800 [XYZ]{3}", name)}
WRITTEN_AS = {"p1": "G68.2 P1", "p3": "G68.2 P3", "g268": "G268"}  # notations of forms; of the others G68.2
MODE_SOLID = 64  # bits 7-6 of _MODE are 01; axis by axis they are 00


def to_text(
    plane: Plane, *, decimals: int = 4, positioning: str = "STAY", swivel_data: str = "TC1", direction: int = -1
) -> str:
    """Return the NC block or blocks of one `Plane`, lines without block numbers.

    The plane's origin is part of G68.2 and CYCLE800; elsewhere a datum shift goes before, if it is not zero. Angles
    and lengths have so many `decimals`. A PLANE block ends with `positioning`, such as ``"MOVE DIST50 F1000
    SEQ-"``. CYCLE800 holds `swivel_data`, the name of the machine's record, and `direction`, −1 or +1: the lower or
    the higher value of the reference rotary axis.

    Examples
    --------
    >>> print(to_text(Plane("G68.2", [135, 54.7356, -90])))
    G68.2 X0. Y0. Z0. I135. J54.7356 K-90.
    >>> print(to_text(Plane("PLANE SPATIAL", [0, 54.7356, 45], [10, 0, -2.5]), positioning="MOVE DIST50 FMAX"))
    TRANS DATUM AXIS X+10 Y+0 Z-2.5
    PLANE SPATIAL SPA+0 SPB+54.7356 SPC+45 MOVE DIST50 FMAX
    >>> print(to_text(Plane("CYCLE800 ZYX", [45, 54.7356, 0])))
    CYCLE800(0,"TC1",0,27,0,0,0,45,54.7356,0,0,0,0,-1,0,1)
    """
    if plane.values.ndim != 1 or plane.origin.ndim != 1:
        raise InputError("plane", "one plane", f"planes of shape {plane.values.shape[:-1]}")
    if direction not in (-1, 1):
        raise InputError("direction", "-1 or +1", repr(direction))
    kind, _, variant = plane.notation.partition(" ")
    origin = dict(zip("XYZ", plane.origin, strict=True))
    values = dict(zip(plane.words, plane.values, strict=True))
    if kind in ("G68.2", "G268"):  # every number with its decimal point, or it counts increments
        if variant != "P3":
            order = {"P1": "P1 Q123 ", "": ""}[variant] if kind == "G68.2" else "Q123 "
            return f"{kind} {order}{written(origin | values, decimals, point='.')}"
        x, z = (dict(zip("IJK", vector, strict=True)) for vector in (plane.values[:3], plane.values[3:]))
        first = f"{written(origin, decimals, point='.')} {written(x, VECTOR_DECIMALS, point='.')}"
        return f"G68.2 P3 Q1 {first}\nG68.2 P3 Q2 {written(z, VECTOR_DECIMALS, point='.')}"
    if kind == "CYCLE800":
        solid = variant == "solid"
        angles = [*plane.values[:2], 0.0] if solid else plane.values
        mode = MODE_SOLID if solid else _mode(variant)
        numbers = ",".join(text_of(value, decimals) for value in (*plane.origin, *angles, 0, 0, 0))
        rest = text_of(plane.values[2], decimals) if solid else "0"
        turned = "" if rest == "0" else f"\nAROT Z{rest}"
        return f'CYCLE800(0,"{swivel_data}",0,{mode},{numbers},{direction},0,1){turned}'
    plus, shifted = ("+", "TRANS DATUM AXIS") if kind == "PLANE" else ("", "TRANS")
    shift = f"{shifted} {written(origin, decimals, plus)}\n" if plane.origin.any() else ""
    words = written(values, VECTOR_DECIMALS if variant == "VECTOR" else decimals, plus)
    return f"{shift}{plane.notation} {words} {positioning}" if kind == "PLANE" else f"{shift}AROT {words}"


def from_text(text: str) -> Plane:
    """Read one `Plane` from the blocks that `to_text` returns, or from the like in a program, as `read`.

    Examples
    --------
    >>> from_text("N20 PLANE EULER EULPR+135 EULNU+54.7356 EULROT+270 TURN FMAX SEQ+").to("G68.2").values.round(4)
    array([135.    ,  54.7356, -90.    ])
    >>> three = "G68.2 P2 Q1 X0 Y0 Z9\\nG68.2 P2 Q2 X0 Y5 Z9\\nG68.2 P2 Q3 X-5 Y0 Z4"
    >>> from_text(three).frame.z.round(3) + 0.0
    array([-0.707,  0.   ,  0.707])
    """
    return read(text)[0]


def read(
    text: str, *, keep: str = "", before: Plane | None = None, tool: np.ndarray | None = None
) -> tuple[Plane, str]:
    """Read one `Plane`, and the key of its words in `plane_forms.FORMS`, "" without one; `keep` as in `Plane`.

    Of the forms of G68.2 and its kin (`mathpost.shop.controls.plane_forms`) some take several blocks. G68.4 counts
    from the plane `before`, G68.3 takes its Z from the `tool` axis, (3,). How the axes get there (STAY, MOVE, SEQ,
    F … of a PLANE block) is passed over. `InputError` names the line where a word is missing, doubled, not a number
    or not one of the block, or where a second plane begins.
    """
    plane, form, origin = before, "", np.zeros(3)
    group: list[Words] = []
    for number, line in enumerate(text.splitlines(), 1):
        where, block = f"line {number}", bare(line, COMMENT, BLOCK_NUMBER).strip()
        words = Words(block, where)
        if not block:
            continue
        if group or re.match(rf"(?:{'|'.join(map(re.escape, plane_forms.HEADS))})(?![\d.])", block):
            group.append(words)
            if plane_forms.lacking([each.block for each in group]):
                continue
            adds = block.startswith(("G68.4", "G68 ", "G68.5"))
            if plane is not before and not adds:
                raise InputError(where, "one plane only", repr(block))
            held = plane.frame if plane and adds else None
            frame, form = plane_forms.read(group, held, tool, keep)
            plane, group = Plane.from_frame(frame, WRITTEN_AS.get(form, "G68.2")), []
            continue
        if words.begin("TRANS DATUM AXIS", "TRANS"):
            origin = words.take("XYZ", optional=True)
        elif plane and plane.notation == "CYCLE800 solid" and words.begin("AROT"):
            plane = Plane(plane.notation, np.add(plane.values, [0, 0, *words.take("Z")]), plane.origin)
        elif plane is not before:
            raise InputError(where, "one plane only", repr(block))
        else:
            plane = _read_plane(words, origin, keep)
        words.done()
    if group:
        raise InputError(group[-1].where, " and ".join(plane_forms.lacking([each.block for each in group])), "none")
    if plane is None or plane is before:
        raise InputError("text", "a block with G68.2, PLANE, CYCLE800 or AROT", repr(text))
    return plane, form


def swivel(text: str) -> tuple[bool, int]:
    """Whether a CYCLE800 leaves the slides where they are, and its direction: −1, +1, or 0 where nothing turns.

    Examples
    --------
    >>> swivel('CYCLE800(2,"TC1",0,57,0,0,0,0,45,0,0,0,0,-1,0,1)')
    (False, -1)
    """
    given = _cycle800(text, "CYCLE800")
    whole = []
    for place in (0, 2, 13):
        argument = given[place] if place < len(given) else ""
        if not re.fullmatch(r"(?:[-+]?\d+)?", argument):
            raise InputError("CYCLE800", f"a whole number as argument {place + 1}", repr(argument))
        whole.append(int(argument or 0))
    retract, added, direction = whole
    if added % 10:
        raise InputError("CYCLE800", "a new plane, _ST 0", f"one on top of the last, _ST {added}")
    return retract == 0, direction


def _read_plane(words: Words, origin: np.ndarray, keep: str) -> Plane:
    if words.rest.startswith("CYCLE800"):
        return _read_cycle800(words)
    if words.begin("CYCL DEF 19.1"):
        words.drop(POSITIONING)
        return Plane("PLANE SPATIAL", words.take("ABC", optional=True), origin, keep)
    if words.begin("AROT"):
        return Plane("AROT RPY", words.take(NOTATIONS["AROT RPY"].words, optional=True), origin, keep)
    notation = words.begin("PLANE SPATIAL", "PLANE EULER", "PLANE VECTOR")
    if not notation:
        expected = "G68.2, PLANE SPATIAL, EULER or VECTOR, CYCLE800 or AROT"
        raise InputError(words.where, expected, repr(words.block))
    words.drop(POSITIONING)
    return Plane(notation, words.take(NOTATIONS[notation].words), origin, keep)


def _cycle800(text: str, where: str) -> list[str]:
    """The arguments of a CYCLE800 that defines a plane."""
    name, given = arguments(text)
    if name != "CYCLE800" or not 10 <= len(given) <= 17:
        raise InputError(where, "CYCLE800 with at least ten arguments, at most seventeen", repr(text))
    return given


def _read_cycle800(words: Words) -> Plane:
    given = _cycle800(words.rest, words.where)
    words.rest = words.rest.partition(")")[2]
    try:
        said = numbers(given[3:13])
    except ValueError:
        raise InputError(words.where, "numbers after the swivel data record's name", repr(words.block)) from None
    mode, origin, angles, shift = int(said[0]), said[1:4], said[4:7], [*said[7:], 0, 0, 0][:3]
    if mode >> 6 != 1 and mode not in MODES:
        raise InputError(words.where, f"_MODE {', '.join(map(str, MODES))} or {MODE_SOLID}", str(mode))
    values = angles if mode in MODES else [*angles[:2], 0.0]
    plane = Plane(MODES.get(mode, "CYCLE800 solid"), np.array(values), np.array(origin))
    # _X1 _Y1 _Z1 move the origin once more, along the axes as turned.
    return Plane(plane.notation, plane.values, plane.frame.point(np.array(shift)))

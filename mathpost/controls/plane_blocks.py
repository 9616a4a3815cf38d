"""Tilted planes as NC blocks: written as a control accepts them, and read back."""

import re
from collections.abc import Iterable

import numpy as np

from mathpost.errors import NUMBER, InputError
from mathpost.plane.tilted_plane import NOTATIONS, Plane

VECTOR_DECIMALS = 7  # the most that the control reads


def _mode(order: str) -> int:
    """_MODE of an axis-by-axis swivel: two bits for the axis of each of _A, _B and _C, X 1, Y 2, Z 3."""
    return sum(("XYZ".index(axis) + 1) << 2 * place for place, axis in enumerate(order))


MODES = {_mode(name[-3:]): name for name in NOTATIONS if re.fullmatch("CYCLE800 [XYZ]{3}", name)}
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
    if kind == "G68.2":  # every number with its decimal point, or it counts increments
        return f"G68.2 {_written(origin | values, decimals, point='.')}"
    if kind == "CYCLE800":
        solid = variant == "solid"
        angles = [*plane.values[:2], 0.0] if solid else plane.values
        mode = MODE_SOLID if solid else _mode(variant)
        numbers = ",".join(_number(value, decimals) for value in (*plane.origin, *angles, 0, 0, 0))
        rest = _number(plane.values[2], decimals) if solid else "0"
        turned = "" if rest == "0" else f"\nAROT Z{rest}"
        return f'CYCLE800(0,"{swivel_data}",0,{mode},{numbers},{direction},0,1){turned}'
    plus, shifted = ("+", "TRANS DATUM AXIS") if kind == "PLANE" else ("", "TRANS")
    shift = f"{shifted} {_written(origin, decimals, plus)}\n" if plane.origin.any() else ""
    words = _written(values, VECTOR_DECIMALS if variant == "VECTOR" else decimals, plus)
    return f"{shift}{plane.notation} {words} {positioning}" if kind == "PLANE" else f"{shift}AROT {words}"


def from_text(text: str, *, keep: str = "") -> Plane:
    """Read one `Plane` from the blocks that `to_text` returns, or from the like in a program; `keep` as in `Plane`.

    Words that do not change the plane (STAY, MOVE, SEQ, F …) are passed over. `InputError` names the line where a
    word is missing, doubled or not a number, or where a second plane begins.

    Examples
    --------
    >>> from_text("N20 PLANE EULER EULPR+135 EULNU+54.7356 EULROT+270 TURN FMAX SEQ+").to("G68.2").values.round(4)
    array([135.    ,  54.7356, -90.    ])
    """
    plane, origin = None, np.zeros(3)
    for number, line in enumerate(text.splitlines(), 1):
        where, block = f"line {number}", re.sub(r"^\s*(?:N?\d+\s+)?", "", line.split(";")[0]).strip()
        if not block:
            continue
        if block.startswith("TRANS"):
            origin = _words(block, "XYZ", where, optional=True)
        elif plane and plane.notation == "CYCLE800 solid" and re.fullmatch(rf"AROT\s+Z\s*=?\s*{NUMBER}", block):
            rest = _words(block, "Z", where)
            plane = Plane(plane.notation, np.add(plane.values, [0, 0, rest[0]]), plane.origin)
        elif plane:
            raise InputError(where, "one plane only", repr(block))
        else:
            plane = _read_plane(block, where, origin, keep)
    if plane is None:
        raise InputError("text", "a block with G68.2, PLANE, CYCLE800 or AROT", repr(text))
    return plane


def swivel(text: str) -> tuple[bool, int]:
    """Whether a CYCLE800 leaves the slides where they are, and its direction: −1, +1, or 0 where nothing turns.

    Examples
    --------
    >>> swivel('CYCLE800(2,"TC1",0,57,0,0,0,0,45,0,0,0,0,-1,0,1)')
    (False, -1)
    """
    arguments = [argument.strip() for argument in text[text.index("(") + 1 : text.rindex(")")].split(",")]
    numbers = []
    for place in (0, 2, 13):
        given = arguments[place] if place < len(arguments) else ""
        if not re.fullmatch(r"[-+]?\d*", given):
            raise InputError("CYCLE800", f"a whole number as argument {place + 1}", repr(given))
        numbers.append(int(given or 0))
    retract, added, direction = numbers
    if added % 10:
        raise InputError("CYCLE800", "a new plane, _ST 0", f"one on top of the last, _ST {added}")
    return retract == 0, direction


def _read_plane(block: str, where: str, origin: np.ndarray, keep: str) -> Plane:
    if block.startswith("CYCLE800"):
        return _read_cycle800(block, where)
    if block.startswith("CYCL DEF 19.1"):
        return Plane("PLANE SPATIAL", _words(block, "ABC", where, optional=True), origin, keep)
    notations = ("G68.2", "PLANE SPATIAL", "PLANE EULER", "PLANE VECTOR", "AROT RPY")
    notation = next((each for each in notations if block.startswith(each.removesuffix(" RPY"))), "")
    if not notation:
        raise InputError(where, "G68.2, PLANE SPATIAL, EULER or VECTOR, CYCLE800 or AROT", repr(block))
    if notation == "G68.2":
        if re.search(r"P\s*\d", block):
            raise InputError(where, "G68.2 with I J K, without P", repr(block))
        origin = _words(block, "XYZ", where, optional=True)
    values = _words(block, NOTATIONS[notation].words, where, optional=notation == "AROT RPY")
    return Plane(notation, values, origin, keep)


def _read_cycle800(block: str, where: str) -> Plane:
    call = re.fullmatch(r"CYCLE800\s*\((.*)\)", block)
    arguments = [argument.strip() for argument in call.group(1).split(",")] if call else []
    if len(arguments) < 10:
        raise InputError(where, "CYCLE800 with at least ten arguments", repr(block))
    try:
        numbers = [float(argument or 0) for argument in arguments[3:13]]
    except ValueError:
        raise InputError(where, "numbers after the swivel data record's name", repr(block)) from None
    mode, origin, angles, shift = int(numbers[0]), numbers[1:4], numbers[4:7], [*numbers[7:], 0, 0, 0][:3]
    if mode >> 6 != 1 and mode not in MODES:
        raise InputError(where, f"_MODE {', '.join(map(str, MODES))} or {MODE_SOLID}", str(mode))
    values = angles if mode in MODES else [*angles[:2], 0.0]
    plane = Plane(MODES.get(mode, "CYCLE800 solid"), np.array(values), np.array(origin))
    # _X1 _Y1 _Z1 move the origin once more, along the axes as turned.
    return Plane(plane.notation, plane.values, plane.frame.point(np.array(shift)))


def _words(block: str, words: Iterable[str], where: str, optional: bool = False) -> np.ndarray:
    """The values of `words` in a block; a missing one is 0 if `optional`."""
    values = []
    for word in words:
        found = re.findall(rf"(?<![A-Z]){word}\s*=?\s*({NUMBER})(?![\d.])", block)
        if len(found) > 1 or not (found or optional):
            raise InputError(where, f"one word {word} with a number", f"{len(found)} in {block!r}")
        values.append(float(found[0]) if found else 0.0)
    return np.array(values)


def _number(value: float, decimals: int) -> str:
    text = f"{value:z.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def _written(values: dict[str, float], decimals: int, plus: str = "", point: str = "") -> str:
    """Words with their values; `plus` before a number without a sign, `point` behind one without a point."""
    texts = [(word, _number(value, decimals)) for word, value in values.items()]
    return " ".join(f"{word}{plus * (text[0] != '-')}{text}{point * ('.' not in text)}" for word, text in texts)

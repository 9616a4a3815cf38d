"""The forms of G68.2 and its kin: words to frames. What each rests on is in `forms.toml`, beside this file.

A form of several blocks, three points or two vectors, is read when all of them are there: `lacking` says which are
not. A frame has the feature in the workpiece; `G68.4` and a second `G68` count from the frame before.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from mathpost import euler
from mathpost.errors import InputError
from mathpost.files import read_toml
from mathpost.frame import Frame
from mathpost.path.nc_words import Words
from mathpost.rotation import unit

FORMS = read_toml(Path(__file__).with_name("forms.toml"))
HEADS = ("G68.2", "G68.3", "G68.4", "G68.5", "G68", "G268")
SEVERAL = {2: (1, 2, 3), 3: (1, 2)}  # the blocks that P2 and P3 need, by Q
ORDERS = (123, 132, 213, 231, 312, 321)  # of three turns: 1 is X
X, Y, Z = np.eye(3)


def lacking(texts: Sequence[str]) -> list[str]:
    """Say which blocks a form of several blocks still needs; none if `texts` are whole, or no such form.

    Examples
    --------
    >>> lacking(["G68.2 P2 Q1 X0 Y0 Z0", "G68.2 P2 Q3 X0 Y1 Z0"])
    ['G68.2 P2 Q2']
    """
    kind = re.match(r"(G68\.[24])(?!\d).*?(?<![A-Z])P([23])(?![\d.])", texts[0])
    if kind is None:
        return []
    there = re.findall(r"(?<![A-Z])Q(\d+)(?![\d.])", " ".join(texts))
    return [f"{kind[1]} P{kind[2]} Q{q}" for q in SEVERAL[int(kind[2])] if str(q) not in there]


def read(blocks: Sequence[Words], before: Frame | None, tool: np.ndarray | None, keep: str) -> tuple[Frame, str]:
    """Read the frame of a form, and its key in `FORMS`; `blocks` are more than one of three points or two vectors.

    `before` is the frame that holds, `tool` the tool axis, (3,), NaN where it is not known: G68.3 needs it. `keep`
    says which of two vectors that are not square is kept, "B" the first or "N" the second.
    """
    first = blocks[0]
    head = first.begin(*HEADS)
    if not head:
        raise InputError(first.where, f"one of {', '.join(HEADS)}, then a blank", repr(first.block))
    if head in ("G68.2", "G68.4"):
        way = first.whole("P", (0, 1, 2, 3, 4), 0)
        frame, form = _WAYS[way](blocks, keep), f"p{way}"
    else:
        frame, form = _ONE[head](first, tool), head.lower().replace(".", "_")
    for block in blocks:
        block.done()
    if head == "G68.4" and before is None:
        raise InputError(first.where, "a plane before G68.4, which counts from it", "none")
    if head in ("G68.4", "G68", "G68.5") and before is not None:
        frame = before @ Frame(frame.rotation, frame.origin, "feature", "feature")
    return frame, "g68_4" if head == "G68.4" else form


def _feature(rotation: np.ndarray, origin: np.ndarray) -> Frame:
    return Frame(rotation, origin, "WCS", "feature")


def _turned(angle: float, origin: Iterable[float] = (0.0, 0.0, 0.0)) -> Frame:
    """A turn about the feature's Z, and a shift along its axes."""
    return Frame(euler.from_axis_angle(Z, angle, degrees=True), np.array(origin), "feature", "feature")


def _euler(blocks: Sequence[Words], keep: str) -> Frame:
    return _feature(euler.matrix("ZXZ", blocks[0].take("IJK"), degrees=True), blocks[0].take("XYZ", optional=True))


def _about_fixed(words: Words, order: str) -> np.ndarray:
    """I, J and K about the fixed X, Y and Z, in an order of axes such as 321: Z first."""
    angles = words.take("IJK", optional=True)
    places = [int(digit) - 1 for digit in order]
    return euler.matrix("".join("xyz"[place] for place in places), angles[places], degrees=True)


def _roll_pitch_yaw(blocks: Sequence[Words], keep: str) -> Frame:
    words = blocks[0]
    order = str(words.whole("Q", ORDERS, 123))
    return _feature(_about_fixed(words, order), words.take("XYZ", optional=True))


def _by_q(blocks: Sequence[Words], way: int) -> dict[int, Words]:
    found: dict[int, Words] = {}
    for n, words in enumerate(blocks):
        if n and (words.begin("G68.2", "G68.4") != blocks[0].block[:5] or words.whole("P", (way,), 0) != way):
            raise InputError(words.where, f"the next block of {blocks[0].block[:5]} P{way}", repr(words.block))
        q = words.whole("Q", (0, *SEVERAL[way]) if way == 2 else SEVERAL[way], -1)
        if q < 0 or q in found:
            raise InputError(words.where, "a Q that is not there yet", repr(words.block))
        found[q] = words
    return found


def _three_points(blocks: Sequence[Words], keep: str) -> Frame:
    """From Q1 to Q2 is X, Q3 on the side of Y. Q0 shifts the origin along the feature's axes, R turns it."""
    parts = _by_q(blocks, 2)
    first, second, third = (parts[q].take("XYZ") for q in SEVERAL[2])
    normal = np.cross(second - first, third - first)
    longest = max(np.linalg.norm(second - first), np.linalg.norm(third - first))
    if np.linalg.norm(normal) < 1e-9 * longest**2 or not longest:
        raise InputError(parts[3].where, "three points that are not on one line", repr(parts[3].block))
    frame = Frame.from_axes(normal, second - first, first, "WCS", "feature")
    shift = parts[0].take("XYZ", optional=True) if 0 in parts else np.zeros(3)
    turn = parts[0].take("R", optional=True)[0] if 0 in parts else 0.0
    return frame @ _turned(turn, shift)


def _two_vectors(blocks: Sequence[Words], keep: str) -> Frame:
    """Q1 has X and the origin, Q2 has Z; they are square as far as their digits say, or `keep` says which holds."""
    parts = _by_q(blocks, 3)
    x, z = parts[1].take("IJK"), parts[2].take("IJK")
    allowed = 1e-6 + sum(2 * part.half / np.linalg.norm(vector) for part, vector in ((parts[1], x), (parts[2], z)))
    x, z = unit(x, "G68.2 P3 Q1"), unit(z, "G68.2 P3 Q2")
    if not keep and abs(x @ z) > allowed:
        found = f"{np.degrees(np.arccos(x @ z)):.4f} degrees; keep N or keep B says which of them holds"
        raise InputError(parts[2].where, "90 degrees between both vectors", found)
    if keep == "B":
        z = z - (z @ x) * x
    return Frame.from_axes(z, x, parts[1].take("XYZ", optional=True), "WCS", "feature")


def _projected(blocks: Sequence[Words], keep: str) -> Frame:
    """X turned by I about Y, and Y turned by J about X, span the plane; K turns X from the first, about Z."""
    alpha, beta, gamma = blocks[0].take("IJK")
    first = euler.from_axis_angle(Y, alpha, degrees=True) @ X
    second = euler.from_axis_angle(X, beta, degrees=True) @ Y
    normal = np.cross(first, second)
    if np.linalg.norm(normal) < 1e-9:
        raise InputError(blocks[0].where, "projected angles that span a plane", f"I{alpha:g} J{beta:g}")
    level = Frame.from_axes(normal, first, blocks[0].take("XYZ", optional=True), "WCS", "feature")
    return level @ _turned(gamma)


def _along_tool(words: Words, tool: np.ndarray | None) -> Frame:
    """G68.3: Z is the tool axis, X square to it and to the vertical, turned by R about Z."""
    origin, turn = words.take("XYZ"), words.take("R", optional=True)[0]
    if tool is None or np.isnan(tool).any():
        raise InputError(words.where, "rotary axes whose position is known, for G68.3", "none")
    level = np.cross(Z, tool)
    if np.linalg.norm(level) < 1e-9:
        raise InputError(words.where, "a tool axis off the vertical: else X of G68.3 is not known", "the vertical")
    frame = Frame.from_axes(tool, level, origin, "WCS", "feature")
    return frame @ _turned(turn)


def _about_line(words: Words, tool: np.ndarray | None) -> Frame:
    """G68 X Y Z I J K R: a turn by R about the direction I J K, and X Y Z is the new origin."""
    origin, axis, angle = words.take("XYZ", optional=True), words.take("IJK"), words.take("R")[0]
    return _feature(euler.from_axis_angle(unit(axis, f"{words.where}, I J K"), angle, degrees=True), origin)


def _haas(words: Words, tool: np.ndarray | None) -> Frame:
    order = words.whole("Q", ORDERS, 0)
    if not order:
        raise InputError(words.where, "G268 with Q, the order of I J K, such as Q123", "none")
    return _feature(_about_fixed(words, str(order)), words.take("XYZ", optional=True))


_WAYS: tuple[Callable[[Sequence[Words], str], Frame], ...] = (
    _euler, _roll_pitch_yaw, _three_points, _two_vectors, _projected,
)  # fmt: skip
_ONE = {"G68.3": _along_tool, "G68": _about_line, "G68.5": _about_line, "G268": _haas}

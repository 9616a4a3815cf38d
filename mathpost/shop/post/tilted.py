"""Operations whose rotary axes rest at a position that is not 0, in the coordinates of a tilted plane.

Earlier moves have turned the rotary axes. The plane is written only if the control, from their present position,
takes this very position for it: then nothing turns, and the moves that follow are in the coordinates of the plane.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import MathpostError
from mathpost.frame import Frame
from mathpost.path.cl import commands
from mathpost.path.modal import Command
from mathpost.path.motion import SAFE
from mathpost.path.pieces import Hole
from mathpost.shop.controls import plane_blocks
from mathpost.shop.controls.blocks import printed
from mathpost.shop.plane import positioning
from mathpost.shop.plane.tilted_plane import Plane
from mathpost.shop.post.draft import Draft

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.shop.controls.phrases import Tilted
    from mathpost.shop.post.steps import Moves
    from mathpost.shop.post.tool_path import ToolPath

FEWEST = 8  # moves that are worth a plane, or a hole
SAME = 1e-3  # degrees, by which printed angles may turn the axes


def tilted(draft: Draft) -> None:
    """Put the operations of a draft into planes.

    In a plane X Y Z name the tip: the control must know the length of the tool, which it does only where X Y Z name
    the tip without a plane, too.
    """
    control, named = draft.options.control, draft.path.kin.machine.programmed_point
    if control.tilted is None or not control.positioning or named != "tip":
        return
    blocks = draft.moves.blocks
    for first, stop, drilled in standing(draft.path, draft.moves):
        tcp = blocks.tcp[first + 1 : stop].any()
        if not tcp and (drilled or stop - first > FEWEST) and blocks.words[first, 3:].any():
            _tilt(draft, control.tilted, first, stop)


def standing(path: ToolPath, moves: Moves) -> Iterator[tuple[int, int, bool]]:
    """Yield operations whose rotary axes stand still: first row, the row behind the last, whether it has holes."""
    blocks, motion = moves.blocks, moves.motion
    turned = (blocks.words[1:, 3:] != blocks.words[:-1, 3:]).any(axis=1)
    fixed = [row for kind in ("offset", "tool", "approach") for row, _ in commands(blocks.remarks, kind)]
    edges, safe = np.r_[True, turned, True], np.flatnonzero(motion.kind == SAFE)
    edges[[*safe, *(safe + 1), *(row for row in fixed if row <= len(turned))]] = True
    drilled = np.searchsorted(motion.place, [each.first for each in path.cl.pieces if isinstance(each, Hole)])
    at = np.flatnonzero(edges)
    for run in np.flatnonzero(np.diff(at) > 1).tolist():  # of a path in five axes there are few
        first, stop = at[run : run + 2].tolist()
        if motion.kind[first] != SAFE:
            yield first, stop, bool(((drilled >= first) & (drilled < stop)).any())


def _tilt(draft: Draft, known: Tilted, first: int, stop: int) -> None:
    """Write the moves after row `first` in a plane, if the control takes the position of the rotary axes for it."""
    kin, control = draft.path.kin, draft.options.control
    joints = draft.moves.motion.joints[first:stop]
    tips, axes = kin.forward(joints)
    frame = Frame.from_axes(axes[0], _along_x(kin, joints[0], axes[0]), (0.0, 0.0, 0.0), "WCS", "feature")
    plane = Plane.from_frame(frame, known.notation)
    plane = Plane(plane.notation, np.round(plane.values, control.decimals))
    direction = _direction(draft, plane, first)
    if direction is None:
        return
    words = printed(plane.frame.inverse().point(tips), control.decimals)
    if not (np.diff(words, axis=0) != 0).any(axis=1).all():
        return
    text = plane_blocks.to_text(
        plane,
        decimals=control.decimals,
        positioning=known.positioning,
        swivel_data=known.swivel_data,
        direction=direction,
    )
    draft.words[first + 1 : stop, :3] = words[1:]
    draft.starts[first:stop] = words
    draft.frames[first + 1 : stop] = [plane.frame] * (stop - first - 1)
    draft.say(first + 1, Command("plane", (text.splitlines() + list(known.on),), ""))
    draft.say(stop, Command("plane off", (known.off,), ""), first=True)


def _along_x(kin: Kinematics, joints: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """A direction of the workpiece for X of the plane: that of the slide X, or of Y where the tool lies along X."""
    moved = kin.forward(joints + np.eye(3, len(joints))[:2])[0] - kin.forward(joints)[0]
    x, y = moved
    base = x if abs(x @ axis) < 0.9 else y
    base = base - (base @ axis) * axis
    return base / np.linalg.norm(base)


def _direction(draft: Draft, plane: Plane, row: int) -> int | None:
    """The direction with which the control takes the present position for a plane; None if it takes another one."""
    control, standing = draft.options.control, draft.moves.blocks.words[row, 3:]
    rule = getattr(positioning, control.positioning)
    try:
        alignment = positioning.align(plane.frame, draft.path.kin)
    except MathpostError:
        return None
    directed = control.positioning == "siemens"
    for direction in (-1, 1):
        try:
            found = rule(alignment, standing, *([direction] if directed else []))
        except MathpostError:
            continue
        if np.abs(found.angles - standing).max() < SAME:
            return direction
    return None

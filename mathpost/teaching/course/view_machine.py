"""Views of a moving machine: its joints, both solutions for one tool axis, a walk along a program."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.path import selection
from mathpost.path.cl import from_arrays
from mathpost.path.singular import CONE, distance, from_pole, regions
from mathpost.shop import codegen
from mathpost.teaching.draw import scene
from mathpost.teaching.draw.arrangement import Arrangement, placing
from mathpost.teaching.draw.colours import COLOUR
from mathpost.teaching.draw.live import Live, Slider, slider
from mathpost.teaching.draw.scene import Line, Scene
from mathpost.teaching.draw.solid import Turned, across, put, ring

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.path.cl import CLData
    from mathpost.teaching.draw.part import Part

MOST_WALKED = 4000  # records of a walk; of more, only every second, third … is shown
SAMPLES = 48  # of the tool in a part, between two blocks
TOUCH = 0.01  # mm; less is the error of triangles for a round face, here and in paths.js
IN_THE_PART = "#c0002a"
BRANCHES = ("first branch", "second branch")


def machine(kin: Kinematics, *, cameras: Sequence[tuple[float, float]] = scene.CAMERAS) -> Live:
    """A machine with a slider for each joint, mm and degrees; leaving travel is reported, not prevented.

    Buttons, with the tip kept in place: the pole, the limits of the tilting axis, the other solution. `cameras` are
    azimuth and elevation, degrees, of which the clearest is taken.
    """
    drawn, made = scene.machine(kin)
    start, drawn = scene.best(kin, drawn, scene.turned(kin, made), cameras=cameras)
    sliders = _joint_sliders(kin, made, start)
    state = {"kind": "machine", "about": _about(kin), "home": made.home.tolist(), "sliders": sliders}
    return Live(state, [codegen.body(kin, jacobian=False)], pose_text(kin, start), [drawn])


def tool_axis(kin: Kinematics) -> Live:
    """Both solutions for one tool axis: sliders tilt, the angle from the pole, and direction about it.

    The singular cone on the sphere has a half angle of 5 degrees; the edge of reach is dashed.
    """
    about, (near, far) = _about(kin), np.degrees(kin.reach)
    drawn, made = scene.machine(kin)
    _, framed = scene.best(kin, drawn, scene.turned(kin, made), aspect=0.75)
    tilt, direction, most = float(min(max(30.0, near), far)), -30.0, float(min(180.0, far + 10.0))
    pole, (angle, turn) = np.array(about["pole"]), np.radians([tilt, direction])
    zero, quarter = across(pole)  # as the browser takes them
    axis = np.cos(angle) * pole + np.sin(angle) * (np.cos(turn) * zero + np.sin(turn) * quarter)
    tip = kin.forward(made.home)[0]
    both = kin.inverse(tip, axis)
    named = zip(BRANCHES, map(placing(kin.machine), both), strict=True)
    pair = [replace(framed, title=name, colour=COLOUR[name], places=at) for name, at in named]
    joint = about["names"][about["tool_side"]]
    limits: dict[float, list[str]] = {}
    for limit in about["limits"][about["tool_side"]]:
        if limit is not None:
            leaning = kin.forward(np.radians(limit) * np.eye(5)[about["tool_side"]])[1]
            lean = round(float(np.degrees(from_pole(kin, leaning, (0, np.inf)))), 9)
            limits.setdefault(lean, []).append(f"{limit:.0f}°")  # the same tilt on both branches is one place
    places = [["pole", [near, None]], ["beside the pole", [near + 0.5, None]]]
    places += [[f"{joint} limit {' and '.join(at)}", [lean, None]] for lean, at in limits.items()]
    places.append(["edge of reach", [far, None]])
    sliders = [slider("tilt", 0.0, most, tilt, step=0.5), slider("direction", -180.0, 180.0, direction)]
    state = {"kind": "both", "about": about, "tip": tip.tolist(), "sliders": sliders, "places": places}
    text = "; ".join(f"{name}: {_words(kin, joints)}" for name, joints in zip(BRANCHES, both, strict=True))
    text, scenes = f"tool axis {_list(axis, 4)}; {text}", [_sphere(kin, axis), *pair]
    return Live(state, [codegen.body(kin, jacobian=False)], text, scenes, height=470, layout="column")


def walk(
    kin: Kinematics,
    cl: CLData,
    joints: ArrayLike | None = None,
    *,
    place: ArrayLike | None = None,
    start: float = 1.0,
    part: Part | None = None,
) -> Live:
    """Walk along a program by a slider: the machine, and both branches of both rotary axes with a cursor.

    Between blocks all joints move linearly, and the true path of the tip is drawn. `joints`, shape (m, 5), mm and
    radians, are the blocks, by default one per record, as chosen by `mathpost.path.selection.choose`; `place`,
    shape (m,), is where each ends on the CL path, as in the `Result` of `mathpost.postprocess`. The slider begins
    at the record `start`.

    A `draw.part.Part` is drawn on the machine, and the view says how deep the tool is in it. Then the path of the
    tip is drawn up to the present record, red where the tool is in the part.
    """
    blocks = selection.choose(kin, cl).joints if joints is None else np.asarray(joints, dtype=float)
    ends = np.arange(len(blocks)) if place is None else np.asarray(place)
    drawn, _ = scene.machine(kin, cl, part=part)
    here = np.array([np.interp(start - 1, ends, column) for column in blocks.T])
    if part is not None:  # as close as keeps its whole way in sight
        rings = np.concatenate(part.rings)
        drawn.extent = np.concatenate([put(placing(kin.machine)(q)["workpiece"], rings) for q in blocks])
    _, drawn = scene.best(kin, drawn, here[None], aspect=0.9)
    drawn.lines.append(Line("workpiece", [], COLOUR["tool"], 1.8, name="true tip"))
    at_records = np.stack([np.interp(np.arange(len(cl)), ends, column) for column in blocks.T], axis=-1)
    near = [[first + 1, last + 1] for first, last in regions(kin, cl, at_records, cone=CONE)]
    places = _sights(kin, cl, at_records)
    poses = np.concatenate([cl.points, cl.axes], axis=1).round(9).tolist()
    step = 1.0 if len(cl) > 30 else 0.05
    state = {
        "kind": "walk", "cl": poses, "about": _about(kin), "joints": blocks.tolist(), "place": ends.tolist(),
        "singular": near, "places": places,
        "sliders": [slider("record", 1.0, float(len(cl)), start, step=step, unit="")],
    }  # fmt: skip
    if part is not None:
        drawn.lines.append(Line("workpiece", [], IN_THE_PART, 4.0, name="in the part", over=True))
        number, at = np.arange(len(blocks)), np.arange(SAMPLES * (len(blocks) - 1) + 1) / SAMPLES
        sampled = np.stack([np.interp(at, number, column) for column in blocks.T], axis=-1)
        depth = part.depth(*kin.forward(sampled))
        state["depth"] = depth.round(4).tolist()
        if depth.max() > TOUCH:
            places.append(["in the part", float(np.interp(at[depth.argmax()], number, ends)) + 1])
    said = f"record {start:g}: {pose_text(kin, here)}"
    return Live(state, [codegen.body(kin, jacobian=False)], said, [drawn], height=520, layout="column")


def short_walk(kin: Kinematics, cl: CLData, joints: np.ndarray) -> tuple[Live, int]:
    """Return a `walk` of at most `MOST_WALKED` records, with their joints, and that every n-th is shown."""
    every = -(-len(joints) // MOST_WALKED)
    shown = slice(0, len(joints), every)
    return walk(kin, from_arrays(cl.points[shown], cl.axes[shown]), joints[shown]), every


def _about(kin: Kinematics) -> dict[str, Any]:
    """Return the data of a machine that the browser needs besides its printed functions."""
    derived, limits = kin.inverse_symbolic, (kin.machine.limits * kin.machine.units[:, None]).round(9).tolist()
    return {
        "names": list(kin.machine.joint_names),
        "limits": [[x if np.isfinite(x) else None for x in pair] for pair in limits],
        "tool_side": kin.tool_side,  # None with one rotary axis
        "middle": float(sum(derived.solutions) / 2),
        "pole": [float(x) for x in derived.pole],
        "reach": list(kin.reach),
    }


def _joint_sliders(kin: Kinematics, made: Arrangement, start: np.ndarray) -> list[Slider]:
    """Return sliders wide enough for every pose with the tip over the workpiece; rotary joints in degrees."""
    limits = np.degrees(kin.machine.limits[3:])
    limits = np.where(np.isfinite(limits), limits, 0.0).clip(-360, 360)
    low, high = np.minimum(limits[:, 0], -180), np.maximum(limits[:, 1], 180)
    grid = np.radians(np.stack(np.meshgrid(*np.linspace(low, high, 13).T), axis=-1).reshape(-1, len(limits)))
    linear = kin.close(kin.forward(made.home)[0], grid)[:, :3]
    low = np.r_[np.floor(linear.min(axis=0) - 0.5 * made.size), low]
    high = np.r_[np.ceil(linear.max(axis=0) + 0.5 * made.size), high]
    rows = np.stack([low, high, start * kin.machine.units], axis=1).tolist()
    pairs = zip(kin.machine.joint_names, rows, strict=True)
    return [slider(name, *row, unit="mm" if name in "XYZ" else "°") for name, row in pairs]


def _sphere(kin: Kinematics, axis: np.ndarray) -> Scene:
    """Return the scene of the tool axis on the unit sphere, the singular cones and the edge of reach."""
    turn = np.linspace(-np.pi / 2, np.pi / 2, 19)
    ball = Turned("bed", "#eef1f4", list(zip(np.cos(turn), np.sin(turn), strict=True)), np.zeros(3), np.eye(3)[2])
    drawn = Scene([ball], extent=1.25 * np.concatenate([np.eye(3), -np.eye(3)]))
    drawn.triad("bed", "xyz", length=1.25, colour=COLOUR["workpiece"])
    pole, (near, far) = np.array(kin.inverse_symbolic.pole, dtype=float), kin.reach
    for end, inwards in ((near, 1), (far, -1)):
        drawn.lines.append(Line("bed", [1.004 * _circle(pole, end + inwards * np.radians(5))], "#b59a00", 1.6))
        if 1e-9 < end < np.pi - 1e-9:
            drawn.lines.append(Line("bed", [1.004 * _circle(pole, end)], "#000000", 1.4, dash=True))
    drawn.lines.append(Line("bed", [[np.zeros(3), axis]], COLOUR["tool"], 3.0, name="tool", dot=True))
    return drawn.frame(*scene.CAMERAS[0], aspect=0.8)


def _circle(pole: np.ndarray, angle: float) -> np.ndarray:
    """Points of the circle on the unit sphere at `angle` (radians) from the unit vector `pole`."""
    return ring(np.cos(angle) * pole, pole, np.sin(angle), 60)[[*range(60), 0]]


def _sights(kin: Kinematics, cl: CLData, joints: np.ndarray) -> list[list]:
    """Buttons of a walk: nearest to the pole or to a limit, a change of branch, the largest swing."""
    places = {"pole": int(np.nanargmin(distance(kin, cl.axes))) + 1.0}
    room = np.abs(joints[:, 3:, None] - kin.machine.limits[3:]).min(axis=(1, 2))
    if np.isfinite(room).any():
        places["limit"] = int(np.nanargmin(room)) + 1.0
    if len(cl) > 1:
        both = kin.inverse(cl.points, cl.axes)
        branch = np.abs(np.exp(1j * both[:, :, 3:]) - np.exp(1j * joints[:, None, 3:])).sum(axis=2).argmin(axis=1)
        swing = np.abs(np.diff(joints[:, 3:], axis=0)).max(axis=1)
        if (changes := np.flatnonzero(np.diff(branch))).size:
            places["branch change"] = changes[swing[changes].argmax()] + 1.5
        places["largest swing"] = int(swing.argmax()) + 1.5
    return list(map(list, places.items()))


def _list(values: Iterable[float], digits: int) -> str:
    return " ".join(f"{value:z.{digits}f}" for value in values)


def _words(kin: Kinematics, joints: np.ndarray) -> str:
    """Return joints as NC words, and a sentence for each that is out of travel."""
    pairs = zip(kin.machine.joint_names, joints * kin.machine.units, strict=True)
    words = " ".join(f"{name}{value:z.3f}" for name, value in pairs)
    return "; ".join([words, *kin.machine.out_of_travel(joints)])


def pose_text(kin: Kinematics, joints: np.ndarray) -> str:
    """Return a pose as a view reports it: NC words, tip, tool axis, distance from singular."""
    tip, axis = kin.forward(joints)
    said = f"{_words(kin, joints)}; tip {_list(tip, 3)}, tool axis {_list(axis, 4)}"
    return said if kin.tool_side is None else f"{said}, {np.degrees(distance(kin, axis)):.2f}° from singular"

"""Machines that no file describes: random axes, offsets and arrangements."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from mathpost import machine_file
from mathpost.errors import InputError

SIDES = [("workpiece", "workpiece"), ("workpiece", "tool"), ("tool", "tool")]


def content(
    first, second, sides=SIDES[0], *, point=((0, 0, 0), (0, 0, 0)), origin=(0, 0, 0), tool=(0, 0, 1), **more
):
    """The content of a machine file with two rotary axes in the directions `first` and `second`."""
    rotary = [
        {"name": name, "carries": side, "axis": list(axis), "point": list(at)}
        for name, side, axis, at in zip("AC", sides, (first, second), point, strict=True)
    ]
    tool = {"axis": list(tool), "length": more.get("length", 0), "programmed_point": more.get("programmed", "tip")}
    return {"name": "m", "source": "test", "rotary": rotary, "workpiece": {"origin": list(origin)}, "tool": tool}


_component = st.integers(-9, 9)
_direction = st.tuples(_component, _component, _component).filter(any)
_offset = st.tuples(*[st.floats(-300, 300).map(lambda value: round(value, 3))] * 3)


@st.composite
def machines(draw):
    """Any machine that `mathpost.machine` accepts."""
    programmed = draw(st.one_of(st.just("tip"), st.just("nose"), _offset.map(list)))
    while True:
        data = content(
            draw(_direction),
            draw(_direction),
            draw(st.sampled_from(SIDES)),
            point=(draw(_offset), draw(_offset)),
            origin=draw(_offset),
            tool=draw(_direction),
            length=draw(st.integers(0, 300)),
            programmed=programmed,
        )
        try:
            return machine_file.from_dict(data)
        except InputError:  # parallel axes
            continue


def with_slides(given, workpiece="", tool="XYZ"):
    """The machine with these slides on either side, each from the bed outwards."""
    linear = [replace(each, carries="workpiece" if each.name in workpiece else "tool") for each in given.linear]
    return replace(given, linear=tuple(linear), slide_order=(*workpiece, *tool))


def random_joints(kin, count, seed):
    """Joints spread over all angles, a quarter of them within 1e-3 … 1e-17 rad of the singular tool-side angles."""
    rng = np.random.default_rng(seed)
    turns = rng.uniform(-np.pi, np.pi, (count, len(kin.symbols) - 3))
    joints = np.concatenate([rng.uniform(-500, 500, (count, 3)), turns], axis=1)
    if kin.tool_side is None:
        return joints
    tool_side = kin.symbols.index(kin.inverse_symbolic.tool_side)
    middle = float(sum(kin.inverse_symbolic.solutions) / 2)
    near = count // 4
    ends = middle + rng.choice([0, np.pi], near)
    joints[:near, tool_side] = ends + rng.choice([-1, 1], near) * 10.0 ** rng.uniform(-17, -3, near)
    joints[: near // 8, tool_side] = ends[: near // 8]
    return joints

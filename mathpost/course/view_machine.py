"""Views of a moving machine: five joints by hand, one tool axis with both solutions, a walk along a program."""

import numpy as np

from mathpost.draw import plot
from mathpost.draw.arrangement import arrange
from mathpost.draw.scene import Scene
from mathpost.draw.traces import CONE, ROLES, Curves, Sphere, nearest_to_singular, small_circle
from mathpost.draw.widget import View
from mathpost.post import selection, travel
from mathpost.post.singular import distance

TRACED = 200  # rows of a program up to which the true way of the tip is drawn


def machine(kin):
    """A machine with a slider for each joint, mm and degrees; out of travel is said, not forbidden.

    The buttons keep the tip where it is: to the pole, to the limits of the tilting axis, to the other solution of
    the same pose.
    """
    names, laid_out = kin.machine.joint_names, arrange(kin)
    inner = kin.symbols.index(kin.inverse_symbolic.inner)
    middle = float(sum(kin.inverse_symbolic.solutions) / 2)

    def build(figure):
        scene = Scene(figure.subplots(), kin)

        def update(**values):
            joints = _meant(values)
            scene.move(joints)
            return _pose(kin, joints)

        return update

    def named(joints):
        return dict(zip(names, _shown(joints), strict=True))

    def with_tilt(angle):
        def place(values):
            joints = _meant(values)
            rotary = joints[3:].copy()
            rotary[inner - 3] = angle
            return named(kin.close(kin.forward(joints)[0], rotary))

        return place

    def other_solution(values):
        joints = _meant(values)
        both = kin.inverse(*kin.forward(joints))
        apart = np.abs(np.exp(1j * both[:, 3:]) - np.exp(1j * joints[3:])).sum(axis=1)
        return named(both[apart.argmax()])

    places = {"home": named(laid_out.home), "pole": with_tilt(middle)}
    places |= {
        f"{names[inner]} limit {np.degrees(limit):.0f}°": with_tilt(limit)
        for limit in kin.machine.limits[inner]
        if np.isfinite(limit)
    }
    places["other solution"] = other_solution
    return View(build, _joint_sliders(kin, laid_out), size=(6.0, 4.4), places=places)


def tool_axis(kin, *, tilt=30.0, direction=-30.0):
    """One tool axis and both solutions of it: sliders tilt, the angle from the pole, and direction about it.

    The singular cone on the sphere has a half angle of 5 degrees; dashed is the edge of reach.
    """
    pole = np.array(kin.inverse_symbolic.pole, dtype=float)
    inner = kin.symbols.index(kin.inverse_symbolic.inner)
    near, far = np.degrees(kin.reach)

    def axis_at(tilt, direction):
        return _on_circle(pole, np.radians(tilt), np.radians(direction))

    def build(figure):
        panels = figure.subplots(1, 3, width_ratios=[0.8, 1, 1])
        sphere = Sphere(panels[0], kin)
        scenes = [Scene(panel, kin) for panel in panels[1:]]
        tip = kin.forward(scenes[0].home)[0]
        for panel, role in zip(panels[1:], ROLES, strict=True):
            panel.set_title(role, color=plot.COLOUR[role], fontsize=12)

        def update(tilt, direction):
            axis = axis_at(tilt, direction)
            sphere.move(axis)
            both, lines = kin.inverse(tip, axis), []
            for scene, role, joints in zip(scenes, ROLES, both, strict=True):
                reached = not np.isnan(joints).any()
                scene.show(reached)
                if reached:
                    scene.move(joints)
                lines.append(f"{role}: {_joints(kin, joints) if reached else 'the tool axis is out of reach'}")
            vector = " ".join(f"{value:z.4f}" for value in axis)
            return "<br>".join([f"tool axis i j k = {vector}", *lines])

        return update

    def tilt_of(angle):
        rotary = np.zeros(5)
        rotary[inner] = angle
        axis = kin.forward(rotary)[1]
        return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(pole, axis)), pole @ axis)))

    most = min(180.0, far + 10.0)
    places = {"pole": {"tilt": near}, "beside the pole": {"tilt": near + 0.5}}
    for limit in kin.machine.limits[inner]:
        if np.isfinite(limit):
            name = f"{kin.machine.joint_names[inner]} limit {np.degrees(limit):.0f}°"
            places[name] = {"tilt": tilt_of(limit)}
    places["edge of reach"] = {"tilt": far}
    places["turn by 180°"] = lambda values: {"direction": (values["direction"] + 360) % 360 - 180}
    sliders = {"tilt": (0.0, most, min(max(tilt, near), most), 0.5), "direction": (-180.0, 180.0, direction, 1.0)}
    return View(build, sliders, size=(9.0, 3.9), places=places, play="direction")


def walk(kin, cl, joints=None, *, place=None, cone=CONE):
    """Walk along a program: the machine, and both branches of both rotary axes with a cursor.

    Parameters
    ----------
    kin : Kinematics
    cl : CLData
    joints : array_like, shape (m, 5), optional
        The blocks, mm and radians; by default one for each record, as `mathpost.post.selection.choose` finds them.
    place : array_like, shape (m,), optional
        Where each block ends on the CL path, as in `mathpost.post.Result`; needed if there are more
        blocks than records.
    cone : float
        Radians about the singular tool axes.

    Returns
    -------
    View
        With the slider record. Between two blocks all joints move linearly; dotted is the CL segment, and where it
        differs the true way of the tip is drawn.
    """
    chosen = selection.choose(kin, cl).joints if joints is None else np.asarray(joints, dtype=float)
    place = np.arange(len(chosen), dtype=float) if place is None else np.asarray(place, dtype=float)
    at_records = _between(place, chosen, np.arange(len(cl), dtype=float))

    def build(figure):
        panels = figure.subplot_mosaic([["machine", "first"], ["machine", "second"]], width_ratios=[1.25, 1])
        scene = Scene(panels["machine"], kin, cl)
        way = [scene.trace(kin, chosen)] if len(chosen) <= TRACED else []
        curves = Curves([panels["first"], panels["second"]], kin, cl, at_records, cone=cone)
        panels["first"].tick_params(labelbottom=False)
        figure.legend(handles=way + curves.legend, loc="outside upper center", ncols=6, fontsize=9, frameon=False)

        def update(record):
            joints = _between(place, chosen, np.array([record - 1]))[0]
            scene.move(joints)
            curves.move(record)
            tip, axis = kin.forward(joints)
            wanted = cl.at(record - 1)
            off = np.linalg.norm(tip - wanted[0])
            turned = np.degrees(2 * np.arcsin(min(1.0, np.linalg.norm(axis - wanted[1]) / 2)))
            pole = np.degrees(distance(kin, axis))
            return (
                f"record {record:.2f}: {_joints(kin, joints)}<br>"
                f"tip {off:.4f} mm and axis {turned:.3f}° off the CL data, {pole:.2f}° from singular"
            )

        return update

    last = float(max(len(cl), 2))
    step = 0.05 if len(cl) <= 30 else 1.0
    return View(
        build,
        {"record": (1.0, last, 1.0, step)},
        size=(8.6, 4.4),
        places=_sights(kin, cl, at_records),
        play="record",
    )


def _sights(kin, cl, joints):
    """Buttons of a walk: nearest to the pole, nearest to a limit, where the branch changes or an axis swings."""
    places = {"pole": nearest_to_singular(kin, cl) + 1.0}
    room = np.abs(joints[:, 3:, None] - kin.machine.limits[3:]).min(axis=(1, 2))
    if np.isfinite(room).any():
        places["limit"] = int(np.nanargmin(room)) + 1.0
    if len(cl) > 1:
        both = kin.inverse(cl.points, cl.axes)
        branch = np.abs(np.exp(1j * both[:, :, 3:]) - np.exp(1j * joints[:, None, 3:])).sum(axis=2).argmin(axis=1)
        swing = np.abs(np.diff(joints[:, 3:], axis=0)).max(axis=1)
        changes = np.flatnonzero(np.diff(branch))
        if changes.size:
            places["branch change"] = changes[swing[changes].argmax()] + 1.5
        places["largest swing"] = int(swing.argmax()) + 1.5
    return {label: {"record": record} for label, record in places.items()}


def _joint_sliders(kin, laid_out):
    """Ranges that hold every pose with the tip over the workpiece; degrees for the rotary joints."""
    limits = np.degrees(kin.machine.limits[3:])
    limits = np.where(np.isfinite(limits), limits, 0.0).clip(-360, 360)
    low, high = np.minimum(limits[:, 0], -180), np.maximum(limits[:, 1], 180)
    tip = kin.forward(laid_out.home)[0]
    grid = np.radians(np.stack(np.meshgrid(*np.linspace(low, high, 13).T), axis=-1).reshape(-1, 2))
    linear = kin.close(tip, grid)[:, :3]
    low = np.r_[np.floor(linear.min(axis=0) - 0.5 * laid_out.size), low]
    high = np.r_[np.ceil(linear.max(axis=0) + 0.5 * laid_out.size), high]
    start = _shown(kin.close(tip, np.radians([30.0, 30.0])))
    rows = zip(low.tolist(), high.tolist(), start.round(3).tolist(), strict=True)
    return {name: (*row, 1.0) for name, row in zip(kin.machine.joint_names, rows, strict=True)}


def _between(place, joints, wanted):
    """Joints at places on the path, moving linearly from block to block."""
    return np.stack([np.interp(wanted, place, column) for column in joints.T], axis=-1)


def _meant(values):
    """Joints, mm and radians, that the sliders' values mean."""
    joints = np.array([*values.values()], dtype=float)
    joints[3:] = np.radians(joints[3:])
    return joints


def _shown(joints):
    """Joints as the sliders have them: mm and degrees."""
    return np.r_[joints[:3], np.degrees(joints[3:])]


def _joints(kin, joints):
    """Joints as NC words, and what is out of travel."""
    words = " ".join(
        f"{name}{value:z.3f}" for name, value in zip(kin.machine.joint_names, _shown(joints), strict=True)
    )
    out = travel.out_of_travel(kin.machine, joints)
    return words + (f" <b>{'; '.join(out)}</b>" if out else "")


def _pose(kin, joints):
    tip, axis = kin.forward(joints)
    place = " ".join(f"{value:z.3f}" for value in tip)
    vector = " ".join(f"{value:z.4f}" for value in axis)
    pole = np.degrees(distance(kin, axis))
    return f"{_joints(kin, joints)}<br>tip {place}, tool axis {vector}, {pole:.2f}° from singular"


def _on_circle(pole, angle, direction):
    """The unit vector at `angle` from `pole`, in the given direction about it; radians."""
    zero, _, quarter = small_circle(pole, np.pi / 2, count=9)[:3]
    return np.cos(angle) * pole + np.sin(angle) * (np.cos(direction) * zero + np.sin(direction) * quarter)

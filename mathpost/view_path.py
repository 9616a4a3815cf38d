"""Views with sliders for lessons 00 and 05 to 07: the tool in the workpiece, and paths past the pole."""

import numpy as np

from mathpost import plot
from mathpost.widget import View


def tool_in_workpiece(kin):
    """Two sliders for the rotary axes of a machine, and the tool axis as the workpiece sees it."""
    names = kin.machine.joint_names[3:]
    limits = np.degrees(kin.machine.limits[3:].clip(-np.pi, np.pi))

    def build(figure):
        axes = figure.add_subplot(projection="3d")
        plot.frame(axes, np.eye(3), np.zeros(3), colour=plot.COLOUR["workpiece"], length=0.8)
        (tool,) = axes.plot([0, 0], [0, 0], [0, 1], color=plot.COLOUR["tool"], linewidth=4)
        (trace,) = axes.plot([], [], [], color=plot.COLOUR["machine"], linewidth=1)
        axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-0.2, 1.2), xticks=[], yticks=[], zticks=[])
        axes.set_box_aspect((2, 2, 1.4))

        def update(**angles):
            joints = np.zeros((91, 5))
            joints[:, 3:] = list(angles.values())
            inner = names.index(str(kin.inverse_symbolic.inner))
            joints[:-1, 3 + inner] = np.linspace(*limits[inner], 90)
            _, axis = kin.forward(joints, degrees=True)
            trace.set_data_3d(*axis[:-1].T)
            tool.set_data_3d(*np.stack([np.zeros(3), axis[-1]], axis=1))
            return f"tool axis i j k = {axis[-1, 0]:z.4f} {axis[-1, 1]:z.4f} {axis[-1, 2]:z.4f}"

        return update

    sliders = {name: (*travel, 30.0, 1.0) for name, travel in zip(names, limits, strict=True)}
    return View(build, sliders, size=(6.0, 4.2))


def past_the_pole(kin):
    """A tool that tilts over in a plane at a distance from the pole: both branches of both rotary axes."""
    tilt = np.radians(np.linspace(-20, 20, 201))
    pole = np.array(kin.inverse_symbolic.pole, dtype=float)
    side = np.eye(3)[np.abs(pole).argmin()]
    across = np.cross(pole, side)
    names = kin.machine.joint_names[3:]

    def build(figure):
        panels = figure.subplots(2, 1, sharex=True)
        lines = {}
        for axis, panel in enumerate(panels):
            for branch, role in enumerate(("first branch", "second branch")):
                (lines[axis, branch],) = panel.plot(
                    np.degrees(tilt), tilt, color=plot.COLOUR[role], linestyle=plot.STYLE[role], label=role
                )
            panel.set(ylabel=f"{names[axis]}, degrees", ylim=(-200, 200) if axis else (-60, 60))
        inner = names.index(str(kin.inverse_symbolic.inner))
        panels[inner].set_ylim(-60, 60)
        panels[1 - inner].set_ylim(-400, 400)
        panels[0].legend(loc="upper right")
        panels[1].set_xlabel("tilt of the tool in its plane, degrees")

        def update(distance):
            plane = np.cos(np.radians(distance)) * pole + np.sin(np.radians(distance)) * across
            axes = np.cos(tilt)[:, None] * plane + np.sin(tilt)[:, None] * side
            angles = np.unwrap(kin.inverse([0, 0, 0], axes)[..., 3:], axis=0)
            for (axis, branch), line in lines.items():
                line.set_ydata(np.degrees(angles[:, branch, axis]))
            fastest = np.abs(np.diff(angles[:, 0, 1 - inner])).max() / (tilt[1] - tilt[0])
            return f"at {distance:.2f}° from the pole the outer axis turns up to {fastest:.1f}° per degree of tilt"

        return update

    return View(build, {"distance": (0.05, 10.0, 3.0, 0.05)}, size=(7.0, 4.6))


def moved_aside(crossing, *, most=5.0):
    """The outer axis through a singular region, with the tool axis moved aside by up to a slider's degrees."""
    direct = crossing.way("direct")

    def build(figure):
        panel = figure.subplots()
        plot.along(panel, direct.place + 1, np.degrees(direct.joints[:, crossing.outer]), "published", "as chosen")
        (line,) = panel.plot([], [], color=plot.COLOUR["first branch"], label="tool axis moved aside")
        panel.set(xlabel="record", ylabel=f"{crossing.kin.machine.joint_names[crossing.outer]}, degrees")
        panel.legend()

        def update(degrees):
            way = crossing.way("aside", lean=np.radians(degrees))
            if way.reason:
                line.set_data([], [])
                return way.reason
            line.set_data(way.place + 1, np.degrees(way.joints[:, crossing.outer]))
            return (
                f"peak {np.degrees(way.peak_rate):.0f}° per {'record' if way.per_record else 's'}, "
                f"tool axis off by {np.degrees(way.axis_error):.2f}°, {way.blocks} blocks"
            )

        return update

    return View(build, {"degrees": (0.1, most, 1.0, 0.1)})

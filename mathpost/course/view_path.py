"""Views with sliders for lessons 05 to 07: paths past the pole."""

import numpy as np

from mathpost.draw import plot
from mathpost.draw.chart import recorded
from mathpost.draw.formula import slider


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
                    np.degrees(tilt[::2]),
                    tilt[::2],
                    color=plot.COLOUR[role],
                    linestyle=plot.STYLE[role],
                    label=role,
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
                line.set_ydata(np.degrees(angles[::2, branch, axis]))
            fastest = np.abs(np.diff(angles[:, 0, 1 - inner])).max() / (tilt[1] - tilt[0])
            return [
                f"at {distance:.2f}° from the pole the outer axis turns up to {fastest:.1f}° per degree of tilt"
            ]

        return update

    return recorded(build, slider("distance", 0.1, 10.0, 3.0, step=0.1), size=(7.0, 4.6), height=520)


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
                return [way.reason]
            line.set_data(way.place + 1, np.degrees(way.joints[:, crossing.outer]))
            return [
                f"{way.time:.2f} s, peak {np.degrees(way.peak_speed):.0f}°/s, "
                f"tool axis off by {np.degrees(way.axis_error):.2f}°, {way.blocks} blocks"
            ]

        return update

    return recorded(build, slider("moved by", 0.1, most, 1.0, step=0.1))

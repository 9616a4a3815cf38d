"""Curves along a path with travel and singular regions shaded, and the tool axis on the unit sphere."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch

from mathpost.draw import plot
from mathpost.draw.solid import Camera
from mathpost.post.singular import distance, regions
from mathpost.rotation import unit

CONE = np.radians(1.0)
SHOWN_CONE = np.radians(5.0)  # of the sphere: one degree would be hardly seen
DRAWN = 1200  # records that a curve is drawn through at most
ROLES = ("first branch", "second branch")


class Curves:
    """Both branches of both rotary axes along a path, what was chosen, travel, singular regions, and a cursor.

    Parameters
    ----------
    panels : sequence of 2 matplotlib axes
        For the two rotary joints in the order of the machine file.
    kin : Kinematics
    cl : CLData
    joints : array_like, shape (n, 5)
        The joints chosen for the records, mm and radians; grey and wide.
    cone : float
        Half angle (radians) about the singular tool axes; regions inside are hatched.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.post import cl as cldata, selection
    >>> from mathpost.kinematics import Kinematics
    >>> kin = Kinematics(machine.load("data/machines/dmu50v.toml"))
    >>> blade = cldata.read("data/cl/blade.cl")
    >>> _, panels = plot.figure(2, 1)
    >>> Curves(panels, kin, blade, selection.choose(kin, blade).joints).singular
    [(1, 2)]
    """

    def __init__(self, panels, kin, cl, joints, *, cone=CONE):
        joints = np.asarray(joints, dtype=float)
        self.singular = regions(kin, cl, joints, cone=cone)
        some = np.unique(np.linspace(0, len(cl) - 1, min(len(cl), DRAWN)).astype(int))
        found = kin.inverse(cl.points[some], cl.axes[some])
        dots = "." if len(cl) <= 30 else None
        self.cursors = []
        for axis, panel in zip((3, 4), panels, strict=True):
            chosen = np.degrees(joints[some, axis])
            panel.plot(some + 1, chosen, color=plot.COLOUR["machine"], alpha=0.5, linewidth=6, label="chosen")
            for branch, role in enumerate(ROLES):
                angle = np.unwrap(found[:, branch, axis])
                turns = np.round((np.nanmedian(chosen) - np.degrees(np.nanmedian(angle))) / 360)
                plot.along(panel, some + 1, np.degrees(angle) + 360 * turns, role, points=dots is not None)
            low, high = np.degrees(kin.machine.limits[axis])
            _margin(panel)
            plot.travel(panel, low, high)
            for limit in (low, high):
                if panel.get_ylim()[0] < limit < panel.get_ylim()[1]:
                    panel.axhline(limit, color=plot.COLOUR["published"], linewidth=0.8, linestyle=(0, (1, 1)))
            for first, last in self.singular:
                panel.axvspan(first + 1, last + 1, facecolor="none", edgecolor="#999999", hatch="///", zorder=0)
            panel.set(ylabel=f"{kin.machine.joint_names[axis]}, degrees", xlim=(1, max(len(cl), 2)))
            self.cursors.append(panel.axvline(1, color=plot.COLOUR["tool"], linewidth=1.6))
        panels[-1].set_xlabel("record")

    @property
    def legend(self):
        """Handles for a legend: the curves, and what is shaded and hatched."""
        outside = Patch(facecolor=plot.COLOUR["forbidden"], alpha=0.4, label="out of travel")
        singular = Patch(facecolor="none", edgecolor="#999999", hatch="///", label="singular region")
        return [*self.cursors[0].axes.get_legend_handles_labels()[0], outside, singular]

    def move(self, record):
        """Put the cursor at `record`, counted from 1; 2.25 is a quarter of the way to the third."""
        for cursor in self.cursors:
            cursor.set_xdata([record, record])


class Sphere:
    """The tool axis in the workpiece as a point of the unit sphere, with the singular cone and the edge of reach.

    Parameters
    ----------
    axes : matplotlib axes
        Ordinary ones.
    kin : Kinematics
    tool_axes : array_like, shape (n, 3), optional
        The tool axes of a path, of unit length.
    cone : float
        Half angle (radians) of the singular cone.
    """

    def __init__(self, axes, kin, tool_axes=None, *, cone=SHOWN_CONE, camera=None):
        self.camera = camera or Camera()
        self.axes, self.kin = axes, kin
        pole = np.array(kin.inverse_symbolic.pole, dtype=float)
        axes.add_patch(plt.Circle((0, 0), 1, facecolor="#f2f2f2", edgecolor=plot.COLOUR["machine"], zorder=0))
        for angle in np.radians([30, 60, 90, 120, 150]):
            self._curve(small_circle([0, 0, 1], angle), color=plot.COLOUR["machine"], linewidth=0.4)
        near, far = kin.reach
        for end, inwards in ((near, 1), (far, -1)):
            self._cone(pole, end, end + inwards * cone)
            if 1e-9 < end < np.pi - 1e-9:
                self._curve(small_circle(pole, end), color=plot.COLOUR["published"], linestyle="--", linewidth=1)
        for direction, letter in zip(np.eye(3), "xyz", strict=True):
            colour = plot.COLOUR["workpiece"]
            axes.plot(*self.camera.project([0 * direction, 1.25 * direction]).T, color=colour, linewidth=1.2)
            axes.text(*self.camera.project(1.38 * direction), letter, color=colour, ha="center", va="center")
        if tool_axes is not None:
            self._curve(np.asarray(tool_axes), color=plot.COLOUR["tool"], linewidth=1.4)
        (self.arrow,) = axes.plot([], [], color=plot.COLOUR["tool"], linewidth=2.4)
        (self.dot,) = axes.plot([], [], "o", color=plot.COLOUR["tool"], markersize=8)
        axes.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5), aspect="equal")
        axes.set_axis_off()

    def move(self, tool_axis):
        """Show a tool axis, shape (3,); the dot is hollow on the far side of the sphere."""
        tool_axis = unit(np.asarray(tool_axis, dtype=float))
        end = self.camera.project(tool_axis)
        self.arrow.set_data([0, end[0]], [0, end[1]])
        self.dot.set_data(end[:1], end[1:])
        self.dot.set_markerfacecolor(plot.COLOUR["tool"] if tool_axis @ self.camera.towards >= 0 else "white")

    def _curve(self, points, **style):
        """A curve on the sphere: faint where it is on the far side."""
        flat, front = self.camera.project(points), (points @ self.camera.towards >= 0)[:, None]
        self.axes.plot(*np.where(front, flat, np.nan).T, **style)
        self.axes.plot(*np.where(front, np.nan, flat).T, alpha=0.35, **style)

    def _cone(self, pole, start, end):
        """Shade between two circles about the pole, radians."""
        inner, outer = (self.camera.project(small_circle(pole, angle)) for angle in (start, end))
        band = np.concatenate([outer, inner[::-1]])
        seen = pole @ self.camera.towards * np.cos(end) > -0.1
        self.axes.fill(*band.T, color=plot.COLOUR["forbidden"], alpha=0.9 if seen else 0.3, linewidth=0)
        self._curve(small_circle(pole, end), color=plot.COLOUR["published"], linewidth=0.8)


def small_circle(pole, angle, count=73):
    """Points of the circle on the unit sphere at `angle` (radians) from `pole`, shape (count, 3)."""
    pole = unit(np.asarray(pole, dtype=float))
    side = unit(np.cross(pole, np.eye(3)[np.abs(pole).argmin()]))
    turn = np.linspace(0, 2 * np.pi, count)[:, None]
    around = np.cos(turn) * side + np.sin(turn) * np.cross(pole, side)
    return np.cos(angle) * pole + np.sin(angle) * around


def nearest_to_singular(kin, cl):
    """The record (from 0) whose tool axis is nearest to a singular one."""
    return int(np.nanargmin(distance(kin, cl.axes)))


def _margin(panel):
    """Room above and below the curves, and for the shading of what is out of travel."""
    low, high = panel.get_ylim()
    panel.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))

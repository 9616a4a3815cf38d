"""The picture of a machine of any arrangement, moved by its own chain: bodies, frames, path and tip.

Bodies stand where `mathpost.chain.bodies` puts them; frames, the tool path and the true way of the tip between
blocks are drawn over them in the colour of their role.
"""

import matplotlib.patheffects as effects
import numpy as np

from mathpost.draw import plot
from mathpost.draw.arrangement import arrange, placing
from mathpost.draw.solid import Camera, Solids
from mathpost.post.between_blocks import true_tip

ON_ANYTHING = [effects.withStroke(linewidth=3, foreground="white")]


class Scene:
    """A machine drawn into ordinary `axes`; `move` takes it to other joints.

    Parameters
    ----------
    axes : matplotlib axes
    kin : Kinematics
    cl : CLData, optional
        A tool path: the workpiece is fitted to it, and tip points and tool axes are drawn.
    camera : Camera, optional
    labels : bool
        Whether frames and rotary axes are named.

    Attributes
    ----------
    home : ndarray, shape (5,)
        Joints at rotary zero with the tool over the workpiece, mm and radians.
    size : float
        The length that the bodies are measured by, mm.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.kinematics import Kinematics
    >>> _, axes = plot.figure()
    >>> scene = Scene(axes, Kinematics(machine.load("data/machines/ac_table.toml")))
    >>> scene.move(scene.home + [0, 0, 20, 0.5, 0])
    """

    def __init__(self, axes, kin, cl=None, *, camera=None, labels=True):
        self.axes, self.camera, self.names = axes, camera or Camera(), labels
        made = arrange(kin, cl)
        self.home, self.size = made.home, made.size
        self._places = placing(kin.machine)
        self._solids = Solids(axes, made.solids, self.camera)
        self._lines, self._labels, self._gap = [], [], 0.0
        for name, ends in made.lines.items():
            self._line(name, ends, color="black", linewidth=0.9, linestyle="-.", path_effects=[])
            self._label(name, ends[1], "black")
        arm = 0.42 * self.size
        self._triad("bed", made.corner, 0.8 * arm, "XYZ", plot.COLOUR["machine"])
        self._triad("workpiece", np.zeros(3), arm, "xyz", plot.COLOUR["workpiece"])
        self._label("tool", [-0.17 * self.size, 0, 0.25 * self.size], plot.COLOUR["tool"], "n")
        if cl is not None:
            self._path(cl)
        axes.set_axis_off()
        axes.set_aspect("equal", adjustable="box")
        self._frame_the_view(kin, made)
        self.move(self.home)

    def trace(self, kin, joints, *, magnify=1.0, samples=24):
        """Draw where the tip really goes between rows of `joints`, shape (n, 5), against the straight CL segments.

        With `magnify` the departure from the segments is drawn that many times too large. Returns the line of the
        tip, for a legend.
        """
        tip, chord = true_tip(kin, joints, samples=samples)
        true = chord + magnify * (tip - chord)
        self._line("workpiece", chord, color=plot.COLOUR["published"], linestyle=":", linewidth=1.2)
        return self._line("workpiece", true, color=plot.COLOUR["tool"], linewidth=1.4, label="true tip")

    def move(self, joints):
        """Redraw with the machine at `joints`, shape (5,), mm and radians."""
        places = self._places(joints)
        self._solids.move(places)
        for line, body, points in self._lines:
            line.set_data(*self.camera.project(_at(places[body], points)).T)
        if self._labels:
            wanted = np.array([self.camera.project(_at(places[body], point)) for _, body, point in self._labels])
            for (text, _, _), at in zip(self._labels, spread(wanted, self._gap), strict=True):
                text.set_position(at)

    def show(self, visible):
        """Show or hide the machine."""
        for artist in (self._solids.artist, *(entry[0] for entry in self._lines + self._labels)):
            artist.set_visible(visible)

    def _line(self, body, points, **style):
        (line,) = self.axes.plot([], [], zorder=2, **{"path_effects": ON_ANYTHING} | style)
        self._lines.append((line, body, np.asarray(points, dtype=float)))
        return line

    def _label(self, body, point, colour, text=None):
        if self.names:
            options = {
                "ha": "center",
                "va": "center",
                "fontsize": 11,
                "path_effects": ON_ANYTHING,
                "zorder": 4,
            }
            written = self.axes.text(0, 0, text or body, color=colour, clip_on=True, **options)
            self._labels.append((written, body, np.asarray(point, dtype=float)))

    def _triad(self, body, origin, length, letters, colour):
        arms = [np.stack([origin, origin + length * e, np.full(3, np.nan)]) for e in np.eye(3)]
        self._line(body, np.concatenate(arms), color=colour, linewidth=2.2)
        for e, letter in zip(np.eye(3), letters, strict=True):
            self._label(body, origin + 1.18 * length * e, colour, letter)

    def _path(self, cl, shown=60, drawn=1000):
        """The tip's path through up to `drawn` records, and the tool axis at up to `shown`."""
        points = cl.points[_some(len(cl), drawn)]
        some = _some(len(cl), shown)
        ends = cl.points[some] + 0.16 * self.size * cl.axes[some]
        arms = np.stack([cl.points[some], ends, np.full_like(ends, np.nan)], axis=1).reshape(-1, 3)
        self._line("workpiece", arms, color=plot.COLOUR["tool"], linewidth=0.8, path_effects=[])
        self._line("workpiece", points, color=plot.COLOUR["published"], linewidth=0.8, path_effects=[])

    def _frame_the_view(self, kin, made):
        """Limits that hold the machine at home, and table and head when they turn by 45 and 90 degrees."""
        still = ("bed", *kin.machine.joint_names[:3])
        inner = kin.symbols.index(kin.inverse_symbolic.inner) - 3
        turns = np.radians([[0, 0], [45, 0], [-45, 0], [45, 90], [45, -90]])
        limits = kin.machine.limits[3:]
        poses = kin.close(kin.forward(self.home)[0], np.clip(turns if inner == 0 else turns[:, ::-1], *limits.T))
        points = []
        for number, joints in enumerate(poses):
            places = self._places(joints)
            shown = [s for s in made.solids if s.body not in still or (s.layer == 0 and number == 0)]
            points += [_at(places[solid.body], solid.vertices) for solid in shown]
        flat = self.camera.project(np.concatenate(points))
        low, high = flat.min(axis=0) - 0.2 * self.size, flat.max(axis=0) + 0.3 * self.size
        self.axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        self._gap = 0.055 * (high - low).max()


def spread(positions, gap, rounds=12):
    """Return positions, shape (n, 2), moved apart until no two are nearer than `gap`, each as little as can be.

    Examples
    --------
    >>> spread([[0.0, 0.0], [0.2, 0.0], [5.0, 5.0]], 1.0).round(2) + 0.0
    array([[-0.4,  0. ],
           [ 0.6,  0. ],
           [ 5. ,  5. ]])
    """
    positions = np.array(positions, dtype=float)
    first, second = np.triu_indices(len(positions), 1)
    for _ in range(rounds):
        apart = positions[second] - positions[first]
        distance = np.linalg.norm(apart, axis=1)
        near = distance < gap * (1 - 1e-9)
        if not near.any():
            break
        # Two in the same place part sideways.
        towards = np.where(distance[:, None] > 1e-9, apart / np.maximum(distance, 1e-9)[:, None], [1.0, 0.0])
        push = (0.5 * np.where(near, gap - distance, 0.0))[:, None] * towards
        np.add.at(positions, first, -push)
        np.add.at(positions, second, push)
    return positions


def _at(matrix, points):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _some(count, most):
    """Up to `most` of the numbers 0 … count − 1, evenly spread, both ends among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))

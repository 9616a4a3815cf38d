"""Readings of machines that are not as anybody believes: turns by Rodrigues' formula in plain NumPy, nothing else.

The control believes the axes of `MACHINES`; the machine has others, slides out of square, positioning errors, a
spindle that leans. `ball`, `probe` and `laser` write what a ball under RTCP, a nest on the table, a probe or a
laser would show, with noise and with what people and machines do wrong. Nothing is shared with the package.
"""

import numpy as np

TABLE, HEAD = "workpiece", "tool"
MACHINES = {  # name, what it carries, direction, point; the workpiece side first
    "table": [("A", TABLE, (-1, 0, 0), (20, 0, -50)), ("C", TABLE, (0, 0, -1), (10, -30, 0))],
    "mixed": [("C", TABLE, (0, 0, 1), (10, -30, 0)), ("B", HEAD, (0, 1, 0), (0, 0, 180))],
    "head": [("C", HEAD, (0, 0, 1), (0, 0, 60)), ("A", HEAD, (1, 0, 0), (0, 5, 200))],
}
LENGTH = 120.0
SQUARE = (24e-6, -17e-6, 20e-6)  # EC0Y, EB0Z, EA0Z
ARCSEC = np.pi / 180 / 3600


def toml(kind):
    """The machine file that the control believes."""
    rows = "".join(
        f'[[rotary]]\nname = "{name}"\ncarries = "{side}"\naxis = {list(axis)}\npoint = {list(point)}\n'
        for name, side, axis, point in MACHINES[kind]
    )
    tool = f"[tool]\naxis = [0, 0, 1]\nlength = {LENGTH}\n"
    return f'name = "{kind}"\nsource = "test"\n{rows}[workpiece]\norigin = [0, 0, 0]\n{tool}'


def turned(points, angle, axis, at):
    """Points, (n, 3), turned by angles, (n,), about a line."""
    k = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    v = points - at
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return at + v * cos + np.cross(k, v) * sin + k * (v @ k)[:, None] * (1 - cos)


class Simulated:
    """A machine: what its file says, and what it has beyond that."""

    def __init__(self, kind, rng, square=(0, 0, 0), size=(0.03, 1e-4)):
        self.kind, self.square, self.positioning, self.scale = kind, square, {}, np.zeros(3)
        self.axes, self.true, self.lean = [], {}, np.zeros(3)
        for name, side, axis, point in MACHINES[kind]:
            across = 1 - np.abs(axis)
            shift, tilt = rng.normal(0, size[0], 3) * across, rng.normal(0, size[1], 3) * across
            self.axes.append((name, side, np.add(axis, np.cross(tilt, axis)), np.add(point, shift)))
            for n in np.flatnonzero(across):
                self.true |= {f"E{'XYZ'[n]}0{name}": shift[n], f"E{'ABC'[n]}0{name}": tilt[n]}
        if kind != "table":
            self.lean = np.append(rng.normal(0, size[1], 2), 0)
            self.true |= {"EA0S": self.lean[0], "EB0S": self.lean[1]}

    def gap(self, place, angles, length, aside=0.0):
        """Ball minus tip, (n, 3), while the control keeps the tip on the ball that it believes at `place`."""
        slides = self.slides(place, angles, length)
        right = {name: angle + self.positioning.get(name, np.zeros_like)(angle) for name, angle in angles.items()}
        stands = slides + self.off(encoders(slides, length))
        return _ball(self.axes, place + aside, right) - stands - _tip(self.axes, self.lean, right, length)

    def off(self, encoders):
        """By how much slides, out of square and with scales of their own, stand off, (n, 3)."""
        c, b, a = self.square
        x, y, z = np.transpose(encoders)
        return np.stack([self.scale[0] * x - c * y + b * z, self.scale[1] * y - a * z, self.scale[2] * z], axis=1)

    def slides(self, place, angles, length):
        """Where the control, which believes its machine file, has the slides: (n, 3)."""
        believed = [
            (name, side, np.array(axis), np.array(point)) for name, side, axis, point in MACHINES[self.kind]
        ]
        return _ball(believed, place, angles) - _tip(believed, np.zeros(3), angles, length)

    def display(self, place, angles, length):
        """What the control shows when the tip has found the ball: (n, 3)."""
        return self.slides(place, angles, length) + self.gap(place, angles, length)


def encoders(slides, length):
    """What the slides' encoders count, which do not know the tool: where the spindle nose is."""
    return slides + np.outer(length, (0, 0, 1))


def _ball(axes, place, angles):
    for name, side, axis, point in axes[::-1]:
        if side == TABLE:
            place = turned(place, angles[name], axis, point)
    return place


def _tip(axes, lean, angles, length):
    """The tip from where it stands at rotary zero with an ideal spindle, (n, 3)."""
    spindle = np.array([0, 0, 1.0]) + np.cross(lean, (0, 0, 1.0))
    tip = -np.outer(length, spindle / np.linalg.norm(spindle))
    for name, side, axis, point in axes[::-1]:
        if side == HEAD:
            tip = turned(tip, angles[name], axis, point)
    return tip + np.outer(length, (0, 0, 1.0))


def poses(kind, names):
    """Angles, radians by name, places and lengths of two balls."""
    tilts = np.repeat([0.0, 25, 50, -40], 4)
    turns = np.tile([0.0, 90, 180, 270], 4) + np.repeat([0, 20, 40, 60], 4)
    tilt = next(name for name in names if name != "C")
    angles = {tilt: np.tile(np.deg2rad(tilts), 2), "C": np.tile(np.deg2rad(turns), 2)}
    place = np.repeat([(150.0, 20, 40), (-60.0, 130, 90)], 16, axis=0)
    length = np.repeat([LENGTH, LENGTH + 100 * (kind != "table")], 16)
    return angles, place, length


def ball(machine, rng, noise=5e-4, sensor=False, drift=0.0, change=None):
    """A file of a ball under RTCP, or of a nest on the table, as text; `change` alters its columns."""
    names = [name for name, *_ in MACHINES[machine.kind]]
    angles, place, length = poses(machine.kind, names)
    aside = np.repeat(rng.normal(0, 0.02, (2, 3)), 16, axis=0)
    gap = machine.gap(place, angles, length, aside)
    if sensor:  # the tool minus the nest, along axes that turn with the table
        believed = [(name, side, np.array(axis), np.zeros(3)) for name, side, axis, _ in MACHINES[machine.kind]]
        back = [(name, side, -axis, point) for name, side, axis, point in believed][::-1]
        gap = -_ball(back, gap, angles)
    gap = gap + np.outer(np.linspace(0, 1, len(gap)), (0, 0, drift)) + noise * rng.standard_normal(gap.shape)
    columns = {name: np.rad2deg(angles[name]) for name in names} | {"length": length}
    columns |= dict(zip("xyz", place.T, strict=True)) | dict(zip(("ex", "ey", "ez"), gap.T, strict=True))
    return text({"method": "sensor" if sensor else "ball", "unit": "mm"}, change(columns) if change else columns)


def probe(machine, rng, noise=1e-3, change=None, setup=True):
    """A file of two balls probed at all angles."""
    names = [name for name, *_ in MACHINES[machine.kind]]
    angles, place, length = poses(machine.kind, names)
    shown = machine.display(place, angles, length) + noise * rng.standard_normal(place.shape)
    columns = {name: np.rad2deg(angles[name]) for name in names} | {"length": length}
    columns |= dict(zip("xyz", shown.T, strict=True))
    if setup:
        columns["setup"] = np.repeat([1.0, 2.0], 16)
    return text({"method": "probe", "unit": "mm"}, change(columns) if change else columns)


def laser(machine, name, rng, noise=0.2):
    """A file of three runs forth and back of a rotary axis' positioning."""
    at = np.arange(0, 360, 30.0) if name == "C" else np.linspace(-60, 60, 13)
    true = machine.positioning.get(name, np.zeros_like)(np.deg2rad(at)) / ARCSEC
    columns = {"position": at}
    for run in (1, 2, 3):
        for side in ("up", "down"):
            columns[f"{side}{run}"] = true + 0.3 * (side == "up") - 0.15 + noise * rng.standard_normal(len(at))
    return text({"method": "laser", "axis": name, "unit": "arcsec"}, columns)


def text(settings, columns):
    """A file of readings."""
    head = "".join(f"# {key} = {value}\n" for key, value in settings.items())
    rows = np.column_stack(list(columns.values()))
    return head + ",".join(columns) + "\n" + "".join(",".join(f"{x:.9g}" for x in row) + "\n" for row in rows)

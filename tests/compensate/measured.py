"""Machines with known errors and what every method would read on them, with SciPy's rotations only.

Nothing here shares a formula with `mathpost`: bodies are turned about lines one after the other.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from mathpost import machine_file as machines

ISO, AGAINST = (-1, 1)
TURNS = np.arange(0, 360, 30.0)


def nominal(arrangement, sign=ISO):
    """A machine of an arrangement, table, head or mixed, whose tables turn about `sign` times Z and X."""
    table = [("A", "workpiece", (sign, 0, 0), (20, 0, -50)), ("C", "workpiece", (0, 0, sign), (10, -30, 0))]
    head = [("C", "tool", (0, 0, 1), (0, 0, 60)), ("A", "tool", (1, 0, 0), (0, 5, 200))]
    mixed = [table[1], ("B", "tool", (0, 1, 0), (0, 0, 180))]
    rotary = {"table": table, "head": head, "mixed": mixed}[arrangement]
    keys = ("name", "carries", "axis", "point")
    rotary = [
        {key: list(v) if isinstance(v, tuple) else v for key, v in zip(keys, row, strict=True)} for row in rotary
    ]
    content = {"name": arrangement, "source": "test", "rotary": rotary, "workpiece": {"origin": [5, 8, -20]}}
    return machines.from_dict(content | {"tool": {"axis": [0, 0, 1], "length": 120}})


@dataclass
class Real:
    """A machine as it is: true lines, spindle, squareness and positioning errors beside what the control believes.

    `shifts` and `tilts` are vectors by axis name, square to the axis; `spindle` is a rotation vector; `square` has
    EC0Y, EB0Z, EA0Z, which count from the slides at `about`; `positioning` maps a joint's name to a function of its
    position, in mm or radians. A slide's position is that of the spindle nose: it does not know the tool.
    """

    machine: object
    shifts: dict = field(default_factory=dict)
    tilts: dict = field(default_factory=dict)
    spindle: np.ndarray = field(default_factory=lambda: np.zeros(3))
    square: np.ndarray = field(default_factory=lambda: np.zeros(3))
    positioning: dict = field(default_factory=dict)
    about: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @classmethod
    def random(cls, machine, rng, positioning=True):
        def across(rotary, size):
            axis = np.array(rotary.axis)
            vector = rng.normal(0, size, 3)
            return vector - axis * (axis @ vector)

        real = cls(machine)
        for each in machine.rotary:
            real.shifts[each.name], real.tilts[each.name] = across(each, 0.03), across(each, 1e-4)
        if any(each.carries == "tool" for each in machine.rotary):
            real.spindle = np.append(rng.normal(0, 1e-4, 2), 0)
        real.square = rng.normal(0, 4e-5, 3)
        if positioning:
            for each in machine.rotary:
                a, b, c = rng.normal(0, 4e-5, 3)
                real.positioning[each.name] = lambda q, a=a, b=b, c=c: a + b * np.sin(q) + c * np.cos(2 * q)
        return real

    def ball(self, place, angles):
        """Where a ball that stands at `place` (n, 3) at rotary zero, machine coordinates, is at `angles` (n, 2)."""
        for index in (1, 0):
            if self.machine.rotary[index].carries == "workpiece":
                place = self._turned(place, index, angles)
        return place

    def tip(self, slides, angles, length):
        """Where the tip is with the slides at `slides` (n, 3): machine coordinates of an ideal tip at head zero."""
        nose = slides + np.outer(length, (0, 0, 1))
        nose = nose + self._off(nose)
        tip = np.outer(-np.asarray(length), Rotation.from_rotvec(self.spindle).apply((0, 0, 1)))
        for index in (1, 0):
            if self.machine.rotary[index].carries == "tool":
                tip = self._turned(tip, index, angles)
        return nose + tip

    def slides(self, place, angles, length):
        """The slides that bring the tip to the ball."""
        slides = np.zeros_like(place)
        for _ in range(3):
            slides = slides + self.ball(place, angles) - self.tip(slides, angles, length)
        return slides

    def _turned(self, points, index, angles):
        rotary, angle = self.machine.rotary[index], angles[:, index]
        if rotary.name in self.positioning:
            angle = angle + self.positioning[rotary.name](angle)
        axis, at = np.array(rotary.axis, dtype=float), np.array(rotary.point, dtype=float)
        if rotary.name in self.tilts:
            axis = axis + np.cross(self.tilts[rotary.name], axis)
            axis, at = axis / np.linalg.norm(axis), at + self.shifts[rotary.name]
        return at + Rotation.from_rotvec(np.outer(angle, axis)).apply(points - at)

    def aside(self, slides):
        """By how much the slides, out of square, stand off."""
        c, b, a = self.square
        x, y, z = (slides - self.about).T
        return np.stack([-c * y + b * z, -a * z, 0 * x], axis=1)

    def _off(self, slides):
        """The same, with scales of their own."""
        off = self.aside(slides)
        for index, name in enumerate("XYZ"):
            off[:, index] += self.positioning.get(name, np.zeros_like)(slides[:, index])
        return off


def gaps(real, place, angles, length, aside=0.0):
    """Ball minus tip, along the machine's axes, while the control believes the machine to be as its file says."""
    believed = Real(real.machine)
    slides = believed.slides(place, angles, length)
    return real.ball(place + aside, angles) - real.tip(slides, angles, length)


def files(real, folder, rng, noise=5e-4, only=None):
    """Write a file of readings for each method that suits the machine; return their paths."""
    machine, names = real.machine, [each.name for each in real.machine.rotary]
    tables = [n for n, each in enumerate(machine.rotary) if each.carries == "workpiece"]
    heads = [n for n, each in enumerate(machine.rotary) if each.carries == "tool"]
    paths = []

    def write(name, settings, columns):
        if only is not None and name.partition("_")[0] not in only:
            return
        path = folder / f"{name}.csv"
        head = "".join(f"# {key} = {value}\n" for key, value in settings.items())
        rows = np.column_stack(list(columns.values()))
        lines = [",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in rows)]
        path.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
        paths.append(path)

    def noisy(values, size=noise):
        return values + size * rng.standard_normal(np.shape(values))

    tilt = [0.0, 25.0, 50.0, -40.0]
    pairs = np.array([(a, c) if names[0] == "A" else (c, a) for a in tilt for c in TURNS[::3]])
    angles = np.deg2rad(pairs)
    place, columns = [], {name: [] for name in (*names, "length", "x", "y", "z", "ex", "ey", "ez")}
    for at, length in (((150, 20, 40), 120.0), ((-60, 130, 90), 220.0)):
        place = np.tile(np.array(at, dtype=float), (len(angles), 1))
        lengths = np.full(len(angles), length if heads else 120.0)
        gap = noisy(gaps(real, place, angles, lengths, aside=rng.normal(0, 0.02, 3)))
        parts = [*pairs.T, lengths, *place.T, *(1e3 * gap).T]
        for column, part in zip(columns.values(), parts, strict=True):
            column.append(part)
    write("ball", {"method": "ball", "unit": "µm"}, {key: np.concatenate(each) for key, each in columns.items()})

    if tables:
        place = np.tile((80.0, -90.0, 30.0), (len(angles), 1))
        found = noisy(real.slides(place, angles, np.full(len(angles), 120.0)), 2 * noise)
        write(
            "probe",
            {"method": "probe", "unit": "mm"},
            dict(zip((*names, "x", "y", "z"), [*pairs.T, *found.T], strict=True)),
        )
        turning = tables[-1]
        rotary = machine.rotary[turning]
        angles_c = np.zeros((len(TURNS), 2))
        angles_c[:, turning] = np.sign(rotary.axis[2]) * np.deg2rad(
            TURNS
        )  # the table turns by `TURNS`, whatever its word
        place = np.tile(np.add(rotary.point, (100, 0, 0)), (len(TURNS), 1))
        gap = gaps(real, place, angles_c, np.full(len(TURNS), 120.0), aside=rng.normal(0, 0.02, 3))
        out = np.column_stack([np.cos(np.deg2rad(TURNS)), np.sin(np.deg2rad(TURNS)), 0 * TURNS])
        dial = noisy(-(gap * out).sum(axis=1) + 0.1, 2 * noise)
        settings = {"method": "dial", "unit": "mm", "axis": rotary.name, "positive": "in"}
        write(
            "dial", settings, {"角度": TURNS, "R": 0 * TURNS + 100, "z": 0 * TURNS + rotary.point[2], "dial": -dial}
        )

    if heads:
        index = heads[-1]
        rotary = machine.rotary[index]
        swing = np.tile([-50.0, -25, 25, 50], 2)
        lengths = np.repeat([120.0, 320.0], 4)
        angles_h = np.zeros((8, 2))
        angles_h[:, index] = np.deg2rad(swing)
        place = np.tile((30.0, 40.0, 50.0), (8, 1))
        moved = -(gaps(real, place, angles_h, lengths) - gaps(real, place, 0 * angles_h, lengths))
        pivot = np.array(rotary.point)[2] + lengths
        lateral = moved @ np.cross((0, 0, 1), rotary.axis)
        write(
            "tip",
            {"method": "tip", "unit": "mm", "axis": rotary.name, "positive": "tip"},
            {"angle": swing, "L": pivot, "axial": noisy(moved[:, 2]), "lateral": noisy(lateral)},
        )

    centre, circle = np.array([20.0, 10.0, 30.0]), np.deg2rad(TURNS)
    flat = [np.stack([np.cos(circle), np.sin(circle), 0 * circle], axis=1)]
    place = np.concatenate([centre + 150 * np.roll(each, n, axis=1) for each in flat for n in range(3)])
    still = np.zeros((len(place), 2))
    tip = real.tip(
        Real(machine).slides(place, still, np.full(len(place), 120.0)), still, np.full(len(place), 120.0)
    )
    bar = np.linalg.norm(tip - centre - rng.normal(0, 0.005, 3), axis=1) - 150 + 0.02
    settings = {"method": "ballbar", "unit": "mm", "centre": "20 10 30"}
    write(
        "ballbar",
        settings,
        dict(zip((*names, "x", "y", "z", "bar"), [*still.T, *place.T, noisy(bar)], strict=True)),
    )

    for name, error in real.positioning.items():
        rotary = machine.rotary[names.index(name)] if name in names else None
        at = TURNS if name == "C" else np.linspace(-60, 60, 13) if rotary else np.linspace(-500, 500, 11)
        true = error(np.deg2rad(at)) * 3600 * 180 / np.pi if rotary else 1e3 * error(at)
        runs = {
            f"{side}{run}": noisy(true + 0.3 * (side == "up") - 0.15, 0.2)
            for run in (1, 2, 3)
            for side in ("up", "down")
        }
        settings = {"method": "laser", "axis": name, "unit": "arcsec" if rotary else "µm"}
        write(f"laser_{name}", settings, {"position": at} | runs)
    return paths


def believed(calibration, values=None, tables=None):
    """The machine as a calibration says that it is, as a `Real`; other values and table entries if given."""
    machine, values = calibration.nominal, calibration.values if values is None else values
    real = Real(machine)
    for each in machine.rotary:
        real.shifts[each.name] = np.array([values.get(f"E{d}0{each.name}", 0.0) for d in "XYZ"])
        real.tilts[each.name] = np.array([values.get(f"E{d}0{each.name}", 0.0) for d in "ABC"])
    real.spindle = np.array([values.get("EA0S", 0.0), values.get("EB0S", 0.0), 0.0])
    real.square = np.array([values.get(name, 0.0) for name in ("EC0Y", "EB0Z", "EA0Z")])
    real.about = calibration.about
    for n, each in enumerate(calibration.positioning):
        entries = each.value if tables is None else tables[n]
        at, wrap = (np.append(each.at, 360), "periodic") if each.endless else (each.at, "not-a-knot")
        entries = np.append(entries, entries[0]) if each.endless else entries
        curve = CubicSpline(np.deg2rad(at), entries, bc_type=wrap)
        real.positioning[machine.joint_names[each.joint]] = curve
    return real


def left(real, control, place, angles, length):
    """What the tip misses, (n, 3), if a program is made for `control`; the datum is at rotary zero."""

    def miss(angles, aside=0.0):
        commanded = angles.copy()
        for index, each in enumerate(real.machine.rotary):
            if each.name in control.positioning:
                commanded[:, index] -= control.positioning[each.name](angles[:, index])
        plain = Real(
            control.machine, control.shifts, control.tilts, control.spindle, control.square, about=control.about
        )
        slides = plain.slides(place, angles, length)
        return real.tip(slides, commanded, length) - real.ball(place + aside, commanded)

    return miss(angles, aside=miss(0 * angles))

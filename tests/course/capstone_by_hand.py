"""A learner's way from a machine file and CL data to a program: plain NumPy, nothing of the package.

`program` may be told to go wrong in one place, as learners do.
"""

import re
import tomllib
from itertools import pairwise

import numpy as np

TIP, AXIS = 0.008, 0.05  # mm and degrees to plan by; 0.01 and 0.1 are granted
HALF_TURN = np.pi


def turn(axis, angle):
    """Rodrigues' formula: the matrix that turns about an axis."""
    x, y, z = np.array(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


class Machine:
    """A table C with a tilting table below it, or a tilting head above it."""

    def __init__(self, text):
        file = tomllib.loads(text)
        self.rotary, tool = file["rotary"], file["tool"]
        self.inner = next(n for n, joint in enumerate(self.rotary) if joint["name"] != "C")
        self.head = self.rotary[self.inner]["carries"] == "tool"
        self.lever = np.add(self.rotary[self.inner]["point"], [0, 0, tool["length"]])
        self.low, self.high = np.radians(self.rotary[self.inner]["limits"])
        linear = [file["linear"][name]["max_rate"] for name in "XYZ"]
        self.rates = np.array(linear + [np.radians(joint["max_rate"]) for joint in self.rotary])
        self.names = "XYZ" + "".join(joint["name"] for joint in self.rotary)

    def forward(self, joints):
        tip, axis = np.array(joints[:3]), np.array([0, 0, 1.0])
        for joint, angle in zip(self.rotary, joints[3:], strict=True):
            if joint["carries"] == "tool":
                continue
            if self.head:  # the head comes first
                swung = turn(self.rotary[self.inner]["axis"], joints[3 + self.inner])
                tip, axis = tip + self.lever - swung @ self.lever, swung @ axis
            back, point = turn(joint["axis"], angle).T, np.array(joint["point"], float)
            tip, axis = back @ (tip - point) + point, back @ axis
        return tip, axis

    def close(self, tip, angles):
        """X Y Z that bring the tip there at given angles."""
        for joint, angle in reversed(list(zip(self.rotary, angles, strict=True))):
            if joint["carries"] == "workpiece":
                point = np.array(joint["point"], float)
                tip = turn(joint["axis"], angle) @ (tip - point) + point
        if self.head:
            tip = tip - self.lever + turn(self.rotary[self.inner]["axis"], angles[self.inner]) @ self.lever
        return np.array([*tip, *angles])

    def leaning(self, tilt):
        """The tool axis while C is 0."""
        return self.forward([0, 0, 0, *self.angles(tilt, 0.0)])[1]

    def angles(self, tilt, c):
        return (tilt, c) if self.inner == 0 else (c, tilt)

    def inverse(self, tip, axis):
        level, quarter, half = (self.leaning(angle)[2] for angle in (0, np.pi / 2, np.pi))
        middle = (level + half) / 2
        a, b = (level - half) / 2, quarter - middle
        spread = np.arccos(np.clip((axis[2] - middle) / np.hypot(a, b), -1, 1))
        sense = -np.sign(self.rotary[1 - self.inner]["axis"][2])
        rows = []
        for tilt in (np.arctan2(b, a) + spread, np.arctan2(b, a) - spread):
            w = self.leaning(tilt)
            c = sense * np.arctan2(w[0] * axis[1] - w[1] * axis[0], w[0] * axis[0] + w[1] * axis[1])
            rows.append(self.close(tip, self.angles(tilt, c)))
        return np.array(rows)

    def beside(self, rows, joints):
        """The row nearest to joints, its C in their winding."""
        c = 4 - self.inner
        rows = np.array(rows)
        rows[:, c] += 2 * np.pi * np.round((joints[c] - rows[:, c]) / (2 * np.pi))
        return rows[np.abs(rows - joints)[:, 3:].sum(axis=1).argmin()]


def records(text):
    """Tips, tool axes and feeds of the CL data."""
    feed, found = np.nan, []
    for line in text.splitlines():
        if line.startswith("FEDRAT"):
            feed = float(re.search(r"[\d.]+", line).group())
        if line.startswith("GOTO/"):
            found.append([*map(float, line[5:].split(",")), feed])
    table = np.array(found)
    return table[:, :3], table[:, 3:6] / np.linalg.norm(table[:, 3:6], axis=1)[:, None], table[:, 6]


def slerp(first, last, t):
    angle = np.arccos(np.clip(first @ last, -1, 1))
    t = np.asarray(t)[..., None]
    return (np.sin((1 - t) * angle) * first + np.sin(t * angle) * last) / np.sin(angle)


def from_pole(axis):
    return np.hypot(axis[..., 0], axis[..., 1])


def candidates(machine, tips, axes, free):
    """Joints inside travel for each record; at the pole, with the C of its neighbours."""
    found = [machine.inverse(tip, axis) for tip, axis in zip(tips, axes, strict=True)]
    for n in np.flatnonzero([free and from_pole(axis) < 1e-7 for axis in axes]):
        tilt = found[n][0][3 + machine.inner]
        near = [row[4 - machine.inner] for m in (n - 1, n + 1) for row in found[m]]
        found[n] = np.array([machine.close(tips[n], machine.angles(tilt, c)) for c in near])
    tilting = 3 + machine.inner
    return [
        rows[(rows[:, tilting] > machine.low - 1e-9) & (rows[:, tilting] < machine.high + 1e-9)] for rows in found
    ]


def choose(machine, nodes, axes):
    """Bellman: the quickest choice that changes its branch at the pole only."""
    c, tilting = 4 - machine.inner, 3 + machine.inner
    best = [(0.0, [node]) for node in nodes[0]]
    for n, rows in enumerate(nodes[1:]):
        near = from_pole(slerp(axes[n], axes[n + 1], np.linspace(0, 1, 3001))).min()
        reached = []
        for row in rows:
            options = []
            for cost, way in best:
                after = row.copy()
                after[c] += 2 * np.pi * np.round((way[-1][c] - row[c]) / (2 * np.pi))
                other = after[tilting] * way[-1][tilting] < -1e-12 and near > 1e-4
                step = np.abs(after - way[-1]) / machine.rates
                options.append((cost + step.max() + 1e6 * other, [*way, after]))
            reached.append(min(options, key=lambda option: option[0]))
        best = reached
    return np.array(min(best, key=lambda option: option[0])[1])


def strays(machine, start, end, tips, axes):
    """How far tip (mm) and tool axis (degrees) leave segment and arc when all joints move linearly."""
    step = tips[1] - tips[0]
    arc = slerp(*axes, np.linspace(0, 1, 401))
    far = lean = 0.0
    for u in np.linspace(0, 1, 25):
        tip, axis = machine.forward(start + u * (end - start))
        along = np.clip((tip - tips[0]) @ step / (step @ step), 0, 1)
        far = max(far, np.linalg.norm(tip - tips[0] - along * step))
        lean = max(lean, np.degrees(2 * np.arcsin(np.linalg.norm(arc - axis, axis=1).min() / 2)))
    return far, lean


def divided(machine, at, one, two, tips, axes):
    """Poses up to `two`, halved on the path until both tolerances are kept."""
    far, lean = strays(machine, one, two, tips, axes)
    if far <= TIP and lean <= AXIS:
        return [two]
    a, b = at
    middle = (a + b) / 2
    tip, between = tips[0] + middle * (tips[1] - tips[0]), (one + two) / 2
    if a == b:  # C turns in place
        half = machine.close(tip, between[3:])
    else:
        half = machine.beside(machine.inverse(tip, slerp(*axes, middle)), between)
    before = divided(machine, (a, middle), one, half, tips, axes)
    return before + divided(machine, (middle, b), half, two, tips, axes)


def stations(machine, one, two, tips, axes):
    """Where a move begins, turns in place at the pole if it meets it and C has to turn, and ends."""
    c = 4 - machine.inner
    t = np.linspace(0, 1, 20001)
    away = from_pole(slerp(*axes, t))
    pole = t[away.argmin()]
    if abs(two[c] - one[c]) < np.radians(1) or away.min() > 1e-4:
        return [(0.0, one), (1.0, two)]
    tilt = machine.inverse(tips[0], np.array([0, 0, 1.0]))[0][3 + machine.inner]
    tip = tips[0] + pole * (tips[1] - tips[0])
    still = [(pole, machine.close(tip, machine.angles(tilt, row[c]))) for row in (one, two)]
    return [(0.0, one), *still, (1.0, two)]


def program(machine_text, cl_text, *, free=True, divide=True, shift=(0, 0, 0), mirrored=1, evenly=False, skip=()):
    """The text of a Heidenhain program. The keywords are slips: see the tests."""
    machine = Machine(machine_text)
    tips, axes, feeds = (np.delete(each, skip, axis=0) for each in records(cl_text))
    chosen = choose(machine, candidates(machine, tips, axes, free), axes)
    poses, feed_of = [chosen[0]], [feeds[0]]
    for n, (one, two) in enumerate(pairwise(chosen)):
        ends = tips[n : n + 2], axes[n : n + 2]
        found = [two]
        if evenly:  # equation (8): all five joints in proportion
            found = list(np.linspace(one, two, 33)[1:])
        elif divide:
            found = []
            for (a, start), (b, end) in pairwise(stations(machine, one, two, *ends)):
                found += divided(machine, (a, b), start, end, *ends)
        poses += found
        feed_of += [feeds[n + 1]] * len(found)
    poses = np.array(poses)
    poses[:, 3 + 1 - machine.inner] *= mirrored
    poses[:, :3] += shift
    return written(machine, poses, feed_of)


def written(machine, poses, feeds):
    words = np.degrees(poses)
    words[:, :3] = poses[:, :3]
    lines, before = ["BEGIN PGM PART MM"], None
    for row, pose, feed in zip(words, poses, feeds, strict=True):
        rate = f"F{feed:g}"
        if before is not None:
            way = np.linalg.norm(np.subtract(*(machine.forward(each)[0] for each in (pose, before))))
            needed = (np.abs(pose - before) / machine.rates).max()
            if needed > way / feed * 60:
                rate = f"FT{np.ceil(1000 * needed) / 1000:.3f}"
        before = pose
        axes = (f"{name}{value:+.4f}" for name, value in zip(machine.names, row, strict=True))
        lines.append(" ".join(["L", *axes, rate]))
    return "\n".join(f"{n} {line}" for n, line in enumerate([*lines, "END PGM PART MM"])) + "\n"

"""Jobs drawn at random, whole as a shop has them, and what the tool's body meets while their programs run.

A job is a machine with a head and a foot of its own, stock and a fixture, and CL data of several tools: passes,
passes that swing, holes in leaned planes. What is cut, the stock and the fixture are points; those that the tool
has been in are gone.
"""

import re
import tomllib
from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np

from tests.conftest import DATA

from .machine_model import Model
from .reader import Setup, read

MACHINES = tuple(sorted(path.stem for path in (DATA / "machines").glob("*.toml")))
CONTROLS = ("heidenhain", "fanuc", "siemens", "linuxcnc", "linuxcnc_g64", "haas", "mazak")
OWN_RATE = ("fanuc", "haas", "mazak")  # G0 is no straight line: parameter 1401, setting 335
LENGTHS = {3: 80.0, 8: 116.5, 12: 60.0}
RADIUS = 4.9  # mm, of the body; what it cuts away is a little more
NEAR = 0.05  # mm above the tip: what it slides over does not count
ON_IT = 0.05  # mm beside a line that is cut
GRID = 2.5  # mm, between the points of solids
KINDS = {"cut": 0.1, "stock": 1.5, "fixture": 0.3}  # what may be met, and mm by which that does not count
CYCLES = ("DRILL", "DEEP", "BRKCHP", "BORE")


@dataclass
class Job:
    """CL data for a machine, and what is around the tool, by kind: points of the workpiece, (n, 3)."""

    name: str  # of the machine
    content: dict  # of its file
    control: str
    tcp: bool
    text: str
    points: dict
    lines: np.ndarray  # shape (k, 2, 3), that are cut


def drawn(seed):
    """A job of this number."""
    rng = np.random.default_rng([seed, 55])
    name, control, tcp = MACHINES[seed % 8], CONTROLS[(seed // 8) % 7], bool(rng.integers(2))
    content = tomllib.loads((DATA / "machines" / f"{name}.toml").read_text(encoding="utf-8"))
    model = Model(content)
    if control in ("haas", "mazak") and len(model.letters) == 1:
        tcp = False
    lines, cuts = ["UNITS/MM"], []
    for tool in rng.permutation(list(LENGTHS))[: rng.integers(1, 4)].tolist():
        lines += [f"LOAD/TOOL,{tool},LENGTH,{LENGTHS[tool]:g}", "SPINDL/RPM,4000,CLW", "COOLNT/FLOOD"]
        for _ in range(rng.integers(1, 4)):
            said, cut = operation(rng, model)
            lines, cuts = lines + said, cuts + cut
    lines.append("FINI")
    cuts = np.array(cuts)
    stock, fixture = around(rng, cuts)
    content["workpiece"] |= {"stock": stock, "fixture": fixture}
    content["program"] = own_lines(rng, control, content["linear"]["safe"]["Z"])
    t = np.linspace(0, 1, 60)[:, None, None]
    swept = (cuts[:, 0] + t * (cuts[:, 1] - cuts[:, 0])).reshape(-1, 3)
    points = {"stock": lattice(stock), "fixture": lattice(fixture)}
    if not stock:  # nobody knows more than what is cut
        points["cut"] = swept
    return Job(name, content, control, tcp, "\n".join(lines) + "\n", points, cuts)


def operation(rng, model):
    """Lines of CL data, and what they cut: passes in a plane, a pass that swings, or holes."""
    angles = np.array([rng.uniform(*reach(model, n)) for n in range(len(model.letters))])
    if rng.random() < 0.25:
        angles[:] = 0  # straight from above
    axis = model.place(np.zeros(3), angles)[1]
    u = np.cross(axis, np.eye(3)[rng.integers(3)] + [0.1, 0.2, 0.3])
    u /= np.linalg.norm(u)
    v, centre = np.cross(axis, u), rng.uniform([-30, -30, 10], [30, 30, 40])
    low, high = model.travel["Z"]
    away = rng.choice([8.0, 40.0, min(150.0, (high - low) / 8)], p=[0.05, 0.1, 0.85])
    kind = rng.integers(3)
    if kind == 2:
        places = centre + rng.uniform(-25, 25, (rng.integers(2, 5), 2)) @ [u, v]
        depth, clearance = rng.uniform(4, 15), rng.uniform(1, 4)
        step = f",STEP,{depth / 3 + 0.01:.3f}" if (word := rng.choice(CYCLES)) in ("DEEP", "BRKCHP") else ""
        cycle = f"CYCLE/{word},FEDTO,{-depth:.3f},RAPTO,{clearance:.3f},MMPM,200{step}"
        lines = ["RAPID", goto(places[0] + away * axis, axis), cycle, *(goto(place, axis) for place in places)]
        lines += ["CYCLE/OFF", "RAPID", goto(places[-1] + away * axis, axis)]
        return lines, [(place + clearance * axis, place - depth * axis) for place in places]
    if kind == 1:
        count, swing = int(rng.integers(3, 8)), rng.uniform(-8, 8, len(model.letters))
        t = np.linspace(-1, 1, count)
        points = centre + 25 * t[:, None] * u + rng.uniform(-4, 4) * (t**2)[:, None] * axis
        axes = [model.place(np.zeros(3), angles + swing * (1 + each) / 2)[1] for each in t]
    else:
        rows = [[s * 30 * u + k * rng.uniform(4, 12) * v for s in (-1, 1)][:: 1 - 2 * (k % 2)] for k in range(3)]
        points = centre + np.concatenate(rows)
        axes = [axis] * len(points)
    above = points[0] + away * axes[0]
    lines = ["RAPID", goto(above, axes[0]), "FEDRAT/700,MMPM"]
    lines += [goto(*pose) for pose in zip(points, axes, strict=True)]
    lines += ["RAPID", goto(points[-1] + away * axes[-1], axes[-1])]
    return lines, list(pairwise([above, *points]))


def reach(model, n):
    """From where to where a rotary axis is drawn, degrees."""
    low, high = np.clip(model.travel[model.letters[n]], -180, 180)
    middle = 0.0 if low < 0 else (low + high) / 2
    return max(low, middle - 60), min(high - 9, middle + 60)


def goto(point, axis):
    return "GOTO/" + ",".join(f"{value:.9f}" for value in [*point, *axis])


def around(rng, cuts):
    """Stock about what is cut, a box or a cylinder, and as a fixture a plate below it and a jaw beside it."""
    ends = cuts[:, 1]
    low, high = ends.min(axis=0) - rng.uniform(3, 15, 3), ends.max(axis=0) + rng.uniform(0, 4, 3)
    low, high = low.round(2), high.round(2)
    if rng.random() < 0.3:
        middle = ((low + high) / 2).round(2)
        start, end = [*middle[:2].tolist(), low[2]], [*middle[:2].tolist(), high[2]]
        radius = round(float(np.linalg.norm(high[:2] - low[:2]) / 2), 2)
        stock = [{"from": start, "to": end, "radius": radius}]
        low[:2], high[:2] = middle[:2] - radius, middle[:2] + radius
    else:
        stock = [{"from": low.tolist(), "to": high.tolist()}]
    stock = stock * bool(rng.random() < 0.7)
    if rng.random() < 0.2:
        return stock, []
    deep = low[2] - 2
    plate = {"from": [low[0] - 20, low[1] - 20, deep - 20], "to": [high[0] + 20, high[1] + 20, deep]}
    top = deep + rng.uniform(0.2, 0.7) * (high[2] - deep)
    jaw = {"from": [high[0] + 8, low[1], deep], "to": [high[0] + 25, high[1], top]}
    if rng.random() < 0.5:
        at = [high[0] + 20, float(rng.uniform(low[1], high[1]))]
        jaw = {"from": [*at, deep], "to": [*at, top], "radius": 10.0}
    rounded = [{key: np.round(value, 2).tolist() for key, value in each.items()} for each in (plate, jaw)]
    return stock, rounded[: rng.integers(1, 3)]


def lattice(solids):
    """Points of boxes and cylinders, (n, 3)."""
    found = [np.empty((0, 3))]
    for solid in solids:
        start, end = np.array(solid["from"]), np.array(solid["to"])
        grow = np.array([solid["radius"]] * 2 + [0]) if "radius" in solid else 0
        sides = [np.linspace(a, b, 2 + int((b - a) / GRID)) for a, b in zip(start - grow, end + grow, strict=True)]
        points = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
        if "radius" in solid:
            points = points[np.linalg.norm((points - start)[:, :2], axis=1) <= solid["radius"]]
        found.append(points)
    return np.concatenate(found)


def own_lines(rng, control, safe):
    """Head, foot and tool change of the shop's own, as the machine's maker has them, or some of them."""
    up = {"heidenhain": f"L Z{safe:+g} R0 FMAX M91", "siemens": f"SUPA G0 Z{safe:g} D0"}
    rise = up.get(control, f"G53 G0 Z{safe:.1f}")
    home = {"heidenhain": "L X+0 Y+0 R0 FMAX M91", "siemens": "SUPA G0 X0 Y0"}.get(control, "G53 G0 X0. Y0.")
    change = {
        "heidenhain": [rise, "TOOL CALL {tool} Z"],
        "siemens": [rise, "T{tool}", "M6", "D1"],
    }.get(control, [rise, "T{tool} M6", "G43 H{tool}"])
    found = {"head": [rise], "foot": [rise, home]}
    if rng.random() < 0.4:
        found["tool_change"] = change
    if rng.random() < 0.25:
        found["head"].append(home)
    if rng.random() < 0.2:  # a line that may go too low
        low = safe - rng.uniform(20, 400)
        found["foot"].insert(0, re.sub(r"Z\+?[\d.]+", f"Z{low:+.1f}", rise))
    return found


# What a program meets.


def hits(job, program, rng):
    """How deep a rapid or a user's move has each kind in the tool's body, mm: (line, text, kind, depth) of each.

    And of moves in cut the fixture. What the tool is in where the cut goes on behind a rapid move is that cut's.
    """
    model = Model(job.content)
    highest = model.nose_of_slides([0, 0, job.content["linear"]["safe"]["Z"]])
    start = np.add(highest, [*rng.uniform(-100, 100, 2), 0]), np.zeros(len(model.letters))
    dialect = job.control.removesuffix("_g64")
    moves = [
        move
        for move in read(program, dialect, Setup(model, lengths=LENGTHS, start=start))
        if move.kind != "dwell" and not np.isnan(np.r_[move.nose(model, 0.0), move.nose(model, 1.0)]).any()
    ]
    left = {kind: points.copy() for kind, points in job.points.items()}
    found = []
    for at, move in enumerate(moves):
        cutting = cuts_now(job, model, move)
        poses = np.concatenate(list(ways(rng, model, move, job.control)))
        for kind, points in left.items():
            least = KINDS[kind]
            if kind == "fixture" or not cutting:
                if kind != "fixture" and (after := next_cut(job, moves, at)) is not None:
                    points = points[~in_column(points, *after, RADIUS + 0.3)]
                deep = depth(points, poses, max(move.tool_length, 50.0))
                if deep > least:
                    found.append((move.line, move.text, kind, deep))
        if cutting:
            for kind in left:
                if kind != "fixture":
                    left[kind] = left[kind][~swept(left[kind], poses)]
    return found


def cuts_now(job, model, move):
    """Whether a move at feed goes along what is cut; others stand for rapid ones."""
    if move.kind != "feed":
        return False
    tips = np.array([pose_of(model, move, t)[0] for t in (0.0, 0.5, 1.0)])
    start, way = job.lines[:, 0], job.lines[:, 1] - job.lines[:, 0]
    off = tips[:, None] - start
    share = np.clip((off * way).sum(axis=2) / (way**2).sum(axis=1), 0, 1)
    return bool((np.linalg.norm(off - share[..., None] * way, axis=2).min(axis=1) < ON_IT).all())


def next_cut(job, moves, at):
    """Tip and axis at the beginning of the next move in cut, if the one behind this is one."""
    model = Model(job.content)
    if at + 1 < len(moves) and cuts_now(job, model, moves[at + 1]):
        return pose_of(model, moves[at + 1], 0.0)
    return None


def pose_of(model, move, t):
    return model.place(move.nose(model, t), move.angles(t), move.tool_length)


def ways(rng, model, move, control):
    """The poses, (m, 6) tip and axis, on each way that a move may take."""
    ends = [np.r_[move.nose(model, t), move.angles(t)] for t in (0.0, 1.0)]
    moving = np.flatnonzero(np.abs(ends[1] - ends[0]) > 2e-3)
    tips = [pose_of(model, move, t)[0] for t in (0.0, 1.0)]
    long = np.linalg.norm(tips[1] - tips[0]) + 2 * np.abs(ends[1] - ends[0])[3:].sum()
    count = int(np.clip(long, 2, 150))
    if move.kind == "rapid" and control in OWN_RATE and len(moving) > 1 and not move.cycle:
        orders = list(permutations(moving))
        for order in [orders[n] for n in rng.choice(len(orders), min(len(orders), 6), replace=False)]:
            corners = [ends[0]]
            for axis in order:
                corners.append(np.where(np.arange(len(ends[0])) == axis, ends[1], corners[-1]))
            for a, b in pairwise(corners):
                axes = np.linspace(a, b, 2 + count // 2)
                yield np.array([np.concatenate(model.place(e[:3], e[3:], move.tool_length)) for e in axes])
        return
    yield np.array([np.concatenate(pose_of(model, move, t)) for t in np.linspace(0, 1, count + 1)])


def candidates(points, poses, length):
    """Which points are in the box around the body on its way."""
    ends = np.concatenate([poses[:, :3], poses[:, :3] + length * poses[:, 3:]])
    low, high = ends.min(axis=0) - RADIUS - 1, ends.max(axis=0) + RADIUS + 1
    return np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))


def depth(points, poses, length):
    """How deep the deepest point is in a cylinder above the tip at any of some poses, mm."""
    points = points[candidates(points, poses, length)]
    worst = 0.0
    for pose in poses if len(points) else ():
        off = points - pose[:3]
        along = off @ pose[3:]
        beside = np.linalg.norm(off - along[:, None] * pose[3:], axis=1)
        inside = np.minimum(np.minimum(along - NEAR, length - along), RADIUS - beside)
        worst = max(worst, float(inside.max()))
    return worst


def in_column(points, tip, axis, radius):
    """Whether points are above the tip and no further than a radius from the tool axis."""
    off = points - tip
    along = off @ axis
    return (along > -NEAR) & (np.linalg.norm(off - along[:, None] * axis, axis=1) < radius)


def swept(points, poses):
    """Which points the tool takes away on its way."""
    gone = np.zeros(len(points), bool)
    some = candidates(points, poses, 1000.0)
    for pose in poses:
        gone[some] |= in_column(points[some], pose[:3], pose[3:], RADIUS + 0.2)
    return gone

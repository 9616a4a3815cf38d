"""Right sheets of five-axis machines: tables of NC words, and the angles of a tilted plane.

The formulas are written by hand for each machine; the truth is the machine's pose, from SciPy's rotations about the
axes of its file: the words must put the tool where the row says.
"""

import tomllib
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.workbook.layouts import Pen, draw_style, label_list, lengths, unit_vectors

MACHINES = Path(__file__).parents[2] / "data/machines"
CL_HEADINGS = ("X Y Z I J K", "X_CL Y_CL Z_CL I J K", "x y z nx ny nz", "Px Py Pz u v w", "x y z i j k")
NC_HEADINGS = {"": "{}", "nc": "{}_NC", "m": "{}m"}
# The formulas of each machine, {I} {J} {K} {X} {Y} {Z} from the row, and {name} of what stands to the left of it;
# constants of the machine as {:name}. Rotary words in degrees.
ROTATED = {
    "x1": "={x}*COS(RADIANS({C}))+{y}*SIN(RADIANS({C}))",
    "y1": "=-{x}*SIN(RADIANS({C}))+{y}*COS(RADIANS({C}))",
}
TABLES = {
    "ac_table": (
        {"pivot": 50},
        {"A": "=DEGREES(ACOS({k}))", "C": "=DEGREES(ATAN2(-{j},{i}))"},
        ROTATED,
        {
            "X": "={x1}",
            "Y": "={y1}*COS(RADIANS({A}))+({z}+{pivot})*SIN(RADIANS({A}))",
            "Z": "=-{y1}*SIN(RADIANS({A}))+({z}+{pivot})*COS(RADIANS({A}))-{pivot}",
        },
    ),
    "bc_table": (
        {"pivot": 120},
        {"B": "=ACOS({k})*180/PI()", "C": "=ATAN2({i},{j})*180/PI()"},
        ROTATED,
        {
            "X": "={x1}*COS(RADIANS({B}))-({z}+{pivot})*SIN(RADIANS({B}))",
            "Y": "={y1}",
            "Z": "={x1}*SIN(RADIANS({B}))+({z}+{pivot})*COS(RADIANS({B}))-{pivot}",
        },
    ),
    "head_b_table_c": (
        {"length": 300},
        {"B": "=DEGREES(ATAN2({k},SQRT({i}^2+{j}^2)))", "C": "=DEGREES(ATAN2({i},{j}))"},
        ROTATED,
        {
            "X": "={x1}+{length}*SIN(RADIANS({B}))",
            "Y": "={y1}",
            "Z": "={z}+{length}*COS(RADIANS({B}))-{length}",
        },
    ),
    "ac_head": (
        {"length": 350},
        {"A": "=DEGREES(ACOS({k}))", "C": "=DEGREES(ATAN2(-{j},{i}))"},
        {},
        {"X": "={x}+{length}*{i}", "Y": "={y}+{length}*{j}", "Z": "={z}+{length}*{k}"},
    ),
    "dmu50v": (
        {"pivot": 50},
        {
            "B": "=DEGREES(ACOS(2*{k}-1))",
            "C": "=DEGREES(ATAN2(-{i}*SIN(RADIANS({B}))/SQRT(2)+{j}*(1-COS(RADIANS({B})))/2,"
            "{i}*(1-COS(RADIANS({B})))/2+{j}*SIN(RADIANS({B}))/SQRT(2)))",
        },
        {
            "x1": "={x}*COS(RADIANS({C}))-{y}*SIN(RADIANS({C}))-{pivot}",
            "y1": "={x}*SIN(RADIANS({C}))+{y}*COS(RADIANS({C}))",
        },
        {
            "X": "=COS(RADIANS({B}))*{x1}+SIN(RADIANS({B}))/SQRT(2)*({z}-{y1})+{pivot}",
            "Y": "=SIN(RADIANS({B}))/SQRT(2)*{x1}+(1+COS(RADIANS({B})))/2*{y1}+(1-COS(RADIANS({B})))/2*{z}",
            "Z": "=-SIN(RADIANS({B}))/SQRT(2)*{x1}+(1-COS(RADIANS({B})))/2*{y1}+(1+COS(RADIANS({B})))/2*{z}",
        },
    ),
}


def forward(name, linear, rotary):
    """Tip and tool axis in the workpiece, shape (6, n), of linear (3, n) and rotary words (2, n) in degrees."""
    with open(MACHINES / f"{name}.toml", "rb") as file:
        data = tomllib.load(file)
    joints = []
    for joint, words in zip(data["rotary"], rotary, strict=True):
        axis = np.array(joint["axis"], dtype=float)
        turns = Rotation.from_rotvec(np.outer(np.radians(words), axis / np.linalg.norm(axis)))
        joints.append((joint["carries"], turns, np.array(joint["point"], dtype=float)))
    origin, length = np.array(data["workpiece"]["origin"], dtype=float), data["tool"]["length"]
    tip = np.array([0.0, 0, -length])
    programmed = data["tool"]["programmed_point"]
    programmed = tip if programmed == "tip" else np.array(programmed, dtype=float)
    nose = linear.T + origin - programmed
    tip, axis = nose + tip, np.tile([0.0, 0, 1], (linear.shape[1], 1))
    for carries, turns, point in reversed(joints):
        if carries == "tool":
            tip, axis = turns.apply(tip - nose - point) + nose + point, turns.apply(axis)
    for carries, turns, point in joints:
        if carries == "workpiece":
            tip, axis = turns.inv().apply(tip - point) + point, turns.inv().apply(axis)
    return np.vstack([(tip - origin).T, axis.T])


def nc_values(rng):
    """A table of NC words without formulas."""
    book = nc_table(rng)
    book.family, book.as_values = "NC table of values", True
    return book


def nc_table(rng):
    """A table of tip and tool axis, and the words of a machine from them by formulas."""
    pen = Pen(rng, draw_style(rng, sheets=1, names=False))
    book = pen.book
    name = str(rng.choice(list(TABLES)))
    book.family = f"NC table {name}"
    book.task = {"kind": "nc", "machine": str(MACHINES / f"{name}.toml")}
    constants, angles, helpers, words = TABLES[name]
    rows = int(rng.integers(5, 15))
    if pen.style.language and rng.integers(2):
        pen.line(pen.word("title"))
    fragments = {key: str(value) for key, value in constants.items()}
    if rng.integers(2):
        for key, value in constants.items():
            area = pen.labelled([value], label_list(key), upright=False)
            fragments[key] = pen.ref(area, fixed=True)
    inputs = str(rng.choice(CL_HEADINGS)).split()
    form = NC_HEADINGS[str(rng.choice(list(NC_HEADINGS)))]
    headings = [*inputs, *angles, *helpers, *(form.format(word) for word in words)]
    units = ["mm"] * 3 + [""] * 3 + ["°", "°"] + ["mm"] * (len(helpers) + 3)
    with_units = int(rng.integers(3) == 0)
    pen.new_band()
    table = pen.block(rows + 1 + with_units, len(headings))
    pen.put(table.part(0, 0, 1, len(headings)), headings)
    if with_units:
        pen.put(table.part(1, 0, 1, len(headings)), [unit or None for unit in units])
    tilts, turns = (
        np.linspace(*rng.uniform([10, 25], [20, 55]), rows),
        np.linspace(*rng.uniform([-70, 20], [0, 70]), rows),
    )
    cl = forward(name, rng.uniform(-40, 40, (3, rows)), order_of(name, angles, tilts, turns))
    for n in range(rows):
        r = n + 1 + with_units
        points, axes = table.part(r, 0, 1, 3), table.part(r, 3, 1, 3)
        pen.put(points, np.round(cl[:3, n], 3))
        pen.put(axes, np.round(cl[3:, n] / np.linalg.norm(cl[3:, n]), 12))
        book.inputs += [(points.each(), lengths), (axes.each(), reachable(name))]
        row = {letter: table.part(r, k).text() for k, letter in enumerate("xyzijk")}
        for k, (word, formula) in enumerate((*angles.items(), *helpers.items(), *words.items())):
            cell = table.part(r, 6 + k)
            pen.put(cell, [formula.format(**row, **fragments)])
            row[word] = cell.text()
        cells = {word: table.key(r, 6 + k) for k, word in enumerate((*angles, *helpers, *words))}
        book.rows.append({word: cells[word] for word in (*angles, *words)})

        def truth(values, cells=cells):
            rotary = np.array([values[cells[word]] for word in angles])
            linear = np.array([values[cells[word]] for word in words])
            return forward(name, linear, rotary if first_in_file(name) == next(iter(angles)) else rotary[::-1])

        book.truths.append((points.each() + axes.each(), truth))
    for k in range(6, len(headings)):
        book.columns.append([table.key(n + 1 + with_units, k) for n in range(rows)])
    return book


def first_in_file(name):
    with open(MACHINES / f"{name}.toml", "rb") as file:
        return tomllib.load(file)["rotary"][0]["name"]


def order_of(name, angles, tilts, turns):
    """The rotary words in the order of the machine's file."""
    return np.array([tilts, turns] if first_in_file(name) == next(iter(angles)) else [turns, tilts])


def reachable(name):
    """Unit vectors that the machine reaches, away from its pole."""
    lowest = 0.05 if name == "dmu50v" else -0.98  # the axis at 45 degrees reaches the upper half only

    def sample(rng, samples):
        vectors = unit_vectors(rng, 20 * samples)
        return vectors[:, (vectors[2] > lowest) & (vectors[2] < 0.98)][:, :samples]

    return sample


PLANES = {
    "G68.2 I J K": (
        ("I", "J", "K"),
        "ZXZ",
        ("ATAN2(-{z1},{z0})", "ACOS({z2})", "ATAN2({z0}*{x1}-{z1}*{x0},{x2})"),
    ),
    "PLANE EULER EULPR EULNU EULROT": (
        ("EULPR", "EULNU", "EULROT"),
        "ZXZ",
        ("ATAN2(-{z1},{z0})", "ATAN2({z2},SQRT({z0}^2+{z1}^2))", "ATAN2({z0}*{x1}-{z1}*{x0},{x2})"),
    ),
    "PLANE SPATIAL SPA SPB SPC": (
        ("SPA", "SPB", "SPC"),
        "ZYX",
        ("ATAN2({z2},{z0}*{x1}-{z1}*{x0})", "ASIN(-{x2})", "ATAN2({x0},{x1})"),
    ),
}


def tilted_plane(rng):
    """The angles of a tilted plane from the directions of its X and Z."""
    pen = Pen(rng, draw_style(rng, sheets=1, names=False))
    book = pen.book
    title = str(rng.choice(list(PLANES)))
    labels, sequence, formulas = PLANES[title]
    book.family = "tilted plane"
    pen.line(title)
    frame = Rotation.from_euler("ZXZ", np.round(rng.uniform([-80, 20, -80], [80, 70, 80]), 1), degrees=True)
    x = pen.labelled(np.round(frame.as_matrix()[:, 0], 12), ["Xx", "Xy", "Xz"], upright=pen.style.upright)
    z = pen.labelled(np.round(frame.as_matrix()[:, 2], 12), ["Zx", "Zy", "Zz"], upright=pen.style.upright)
    book.inputs.append((x.each() + z.each(), frames))
    fragments = {f"{name}{n}": pen.entry(area, n) for name, area in (("x", x), ("z", z)) for n in range(3)}
    wrapped = "=DEGREES({})" if rng.integers(2) else "={}*180/PI()"
    contents = [wrapped.format(formula.format(**fragments)) for formula in formulas]
    result = pen.labelled(contents, list(labels), upright=pen.style.upright)

    def truth(values):
        x_axis, z_axis = (np.array([values[key] for key in area.each()]) for area in (x, z))
        matrices = np.stack([x_axis, np.cross(z_axis, x_axis, axis=0), z_axis]).transpose(2, 1, 0)
        angles = Rotation.from_matrix(matrices).as_euler(sequence, degrees=True).T
        return angles if sequence == "ZXZ" else angles[::-1]

    book.truths.append((result.each(), truth))
    return book


def frames(rng, samples):
    matrices = Rotation.random(samples, random_state=int(rng.integers(1_000_000))).as_matrix()
    return np.vstack([matrices[:, :, 0].T, matrices[:, :, 2].T])

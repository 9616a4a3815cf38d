"""Views with sliders for lessons 01 to 04: rotations, frames, the tilted plane, the chain."""

import numpy as np
import sympy as sp

from mathpost import angles as euler
from mathpost import chain
from mathpost.draw import plot
from mathpost.draw.arrangement import tool_solids
from mathpost.draw.chart import recorded
from mathpost.draw.formula import formula, slider
from mathpost.draw.scene import Label, Line, Scene, clearest
from mathpost.draw.solid import Hull, block, ring
from mathpost.plane import positioning
from mathpost.plane.alignment import align
from mathpost.plane.tilted_plane import NOTATIONS, Plane
from mathpost.rotation import ACTIVE, zxz_right, zxz_steps

_MACHINE, _WORKPIECE, _TOOL = (plot.COLOUR[role] for role in ("machine", "workpiece", "tool"))
_AXIS, _NODES = plot.COLOUR["first branch"], plot.COLOUR["second branch"]  # of a turn; where two planes meet
_UNIT = dict(zip("XYZ", ((1, 0, 0), (0, 1, 0), (0, 0, 1)), strict=True))
_DEGREES = 180 / sp.pi


def turned_point(point):
    """A point in the initial frame and in the one that ZXZ angles turn: sliders alpha, beta, gamma in degrees."""
    symbols, size = sp.symbols("alpha beta gamma", real=True), 0.75 * float(np.linalg.norm(point))
    turned = zxz_right(*symbols)
    x, y, z = new = turned * sp.Matrix(point)
    wrong = zxz_steps("right", symbols, point, elementary=ACTIVE)[-1].value
    angles = {"alpha": (-180, 135.0), "beta": (0, 54.7356), "gamma": (-180, -90.0)}
    frame = zxz_right(*(start for _, start in angles.values()), degrees=True)
    axes = np.concatenate([np.eye(3), frame])
    scene = Scene(["turned"], extent=np.concatenate([1.35 * size * axes, 1.25 * np.array([point, np.zeros(3)])]))
    scene.triad("bed", "XYZ", length=size, colour=_MACHINE)
    scene.triad("turned", ("X'", "Y'", "Z'"), length=size, colour=_WORKPIECE, width=3)
    scene.lines.append(Line("bed", [[np.zeros(3), np.array(point)]], _TOOL, 1.2, dash=True, over=True, dot=True))
    scene.lines.append(Line("turned", [], _TOOL, 2.4, name="coordinates", span=(0, 4), over=True))
    scene.labels.append(Label("bed", 1.1 * np.array(point), "P", _TOOL))
    return formula(
        scene.frame(*clearest(dict(zip(("X", "Y", "Z", "X'", "Y'", "Z'"), axes, strict=True)))),
        symbols,
        [slider(name, low, 180, start) for name, (low, start) in angles.items()],
        {"turned": turned.T},
        ["in the turned frame: x' = {0:6}, y' = {1:6}, z' = {2:6}", "with active elements: {3:6}, {4:6}, {5:6}"],
        numbers=[*new, *wrong],
        points=[sp.zeros(3, 1), sp.Matrix([x, 0, 0]), sp.Matrix([x, y, 0]), sp.Matrix([x, y, z])],
    )


def turns(point, angles):
    """A point that stays and a frame that makes three turns, one after the other: a slider from 0 to 3 that plays.

    The angles are those of ZXZ in degrees; dashed is the axis of the present turn.
    """
    s, size = sp.Symbol("s", real=True), 0.75 * float(np.linalg.norm(point))
    done = [sp.Rational(round(1e9 * t), 10**9) * sp.Min(1, sp.Max(0, s - n)) for n, t in enumerate(angles)]
    F = euler.matrix("ZXZ", [t * sp.pi / 180 for t in done])
    v = (
        size * sp.Piecewise((1, sp.Or(s <= 1, s > 2)), (0, True)) * F[:, 2]
        + size * sp.Piecewise((1, sp.And(s > 1, s <= 2)), (0, True)) * F[:, 0]
    )
    start = np.array(F.subs(s, 1.5).evalf(), dtype=float)
    axes = np.concatenate([np.eye(3), start.T])
    scene = Scene(["turned"], extent=1.3 * size * np.concatenate([np.eye(3), -np.eye(3)]))
    scene.triad("bed", "XYZ", length=size, colour=_MACHINE)
    scene.triad("turned", ("X'", "Y'", "Z'"), length=size, colour=_WORKPIECE, width=3)
    scene.lines.append(Line("bed", [[np.zeros(3), np.array(point)]], _TOOL, 1.2, dash=True, over=True, dot=True))
    scene.lines.append(Line("bed", [], _AXIS, 2.4, name="axis", span=(0, 2), dash=True, over=True))
    scene.labels.append(Label("bed", 1.1 * np.array(point), "P", _TOOL))
    words = ("about Z", "about the new X", "about the newest Z")
    now = [sp.Piecewise((1, condition), (0, True)) for condition in (s <= 1, sp.And(s > 1, s <= 2), s > 2)]
    said = "".join(f"{{{3 + n}?{word}}}" for n, word in enumerate(words))
    return formula(
        scene.frame(*clearest(dict(zip(("X", "Y", "Z", "X'", "Y'", "Z'"), axes, strict=True)))),
        [s],
        [slider("turn", 0, 3, 1.5, step=0.05, unit="")],
        {"turned": F},
        ["α {0:4}°, β {1:4}°, γ {2:4}°; now it turns " + said],
        numbers=[*done, *now],
        points=[-1.2 * v, 1.2 * v],
        play=0,
        height=420,
    )


def notations(angles=(135.0, 54.7356, -90.0)):
    """One frame in many notations: sliders I, J, K, the ZXZ angles in degrees.

    Dashed is the axis of the single turn that makes the frame; pink is the line of nodes, where XY and xy meet.
    """
    symbols = sp.symbols("I J K", real=True)
    F, node = euler.matrix("ZXZ", symbols), sp.Matrix([sp.cos(symbols[0]), sp.sin(symbols[0]), 0])
    turns = (sp.Quaternion.from_axis_angle(_UNIT[letter], t) for letter, t in zip("ZXZ", symbols, strict=True))
    w, x, y, z = sp.prod(turns).args
    sign, sine = sp.Piecewise((-1, w < 0), (1, True)), sp.sqrt(x**2 + y**2 + z**2)
    still = sine < 1e-12  # no turn at all has the axis Z
    v = sp.Matrix(
        [
            sp.Piecewise((end, still), (sign * x / sp.Max(sine, 1e-12), True))
            for end, x in zip((0, 0, 1), (x, y, z), strict=True)
        ]
    )
    numbers = [*v, 2 * sp.atan2(sine, sign * w) * _DEGREES, *(sign * x for x in (w, x, y, z))]
    text = ["axis ({0:4}, {1:4}, {2:4}), angle {3:3}° (dashed)", "quaternion ({4:4}, {5:4}, {6:4}, {7:4})"]
    for name in ("G68.2", "PLANE SPATIAL", "AROT RPY"):
        about, n = NOTATIONS[name], len(numbers)
        *found, locked = _read_back(about, F)
        numbers += [*(angle * _DEGREES for angle in found), locked]
        words = ", ".join(f"{word} {{{n + i}:3}}" for i, word in enumerate(about.words))
        text.append(f"{name}: {words}{{{n + 3}? (locked)}}")
    frame = euler.matrix("ZXZ", angles, degrees=True)
    axes = np.concatenate([np.eye(3), frame.T])
    scene = Scene(["turned"], extent=1.35 * np.concatenate([axes, -axes[:3] / 2]))
    scene.triad("bed", "XYZ", length=1.0, colour=_MACHINE)
    scene.triad("turned", "xyz", length=1.0, colour=_WORKPIECE, width=3)
    scene.lines.append(Line("bed", [], _AXIS, 2.4, name="axis", span=(0, 2), dash=True, over=True))
    scene.lines.append(Line("bed", [], _NODES, 1.6, name="nodes", span=(2, 4), over=True))
    return formula(
        scene.frame(*clearest(dict(zip("XYZxyz", axes, strict=True)))),
        symbols,
        [slider(name, low, 180, value) for name, low, value in zip("IJK", (-180, 0, -180), angles, strict=True)],
        {"turned": F},
        text,
        numbers=numbers,
        points=[-v, v, -1.25 * node, 1.25 * node],
        height=460,
    )


def _read_back(about, matrix):
    """The three angles of a `Notation` as expressions, its rule at the lock included, and 1 where it locks."""
    sequence, step = (about.sequence, 1) if about.sequence.isupper() else (about.sequence[::-1].upper(), -1)
    first, *_ = euler.arguments(sequence, matrix, 0)
    locked = sp.sqrt(first[0] ** 2 + first[1] ** 2) < euler.LOCK
    together = sp.atan2(*euler.arguments(sequence, matrix, 0)[2])
    if (about.lock == "third") == (step > 0):  # the last turn about a moving axis is to be 0
        i, k = ("XYZ".index(letter) for letter in (sequence[0], sequence[2]))
        at_lock = (together * sp.sign(matrix[i, k]), 0)
    else:
        at_lock = (0, together)
    a = sp.Piecewise((at_lock[0], locked), (sp.atan2(*first), True))
    _, middle, third = euler.arguments(sequence, matrix, a)
    angles = [a, sp.atan2(*middle), sp.Piecewise((at_lock[1], locked), (sp.atan2(*third), True))]
    return [*angles[::step], sp.Piecewise((1, locked), (0, True))]


def third_angle(machine, i, j, *, radius=10.0, retract=1.0, run_out=0.02):
    """Looking along Z onto a tilted plane: what the third angle, slider K, does to a boring bar and to a probe.

    The spindle stops with the bar's tip along its own X, and the control retracts by `retract` against the
    feature's X; a stylus runs out by `run_out` along the spindle's X, and the control corrects along the
    feature's. Both are right only if the spindle's X is the feature's. The rotary axes go where SEQ+ sends them.
    Lengths in mm, angles in degrees.
    """
    turn = np.linspace(0, 2 * np.pi, 61)
    circle = np.stack([np.cos(turn), np.sin(turn)])

    def build(figure):
        bore, probe = figure.subplots(1, 2)
        for axes, title in (
            (bore, "boring bar, retracted along −X"),
            (probe, "stylus ball, believed (dotted) and true"),
        ):
            axes.set(title=title, aspect="equal", xlim=(-1.55, 1.55), ylim=(-1.55, 1.55))
            axes.set_axis_off()
            for direction, label in zip(np.eye(2), "XY", strict=True):
                axes.plot(*np.array([(0, 0), 1.3 * direction]).T, color=_WORKPIECE)
                axes.text(*(1.42 * direction), label, color=_WORKPIECE, ha="center", va="center")
        bore.plot(*circle, color=_WORKPIECE)
        (bar,) = bore.fill([], [], color=_TOOL, alpha=0.35)
        (tip,) = bore.plot([], [], color=_TOOL, lw=5)
        (seen,) = probe.plot([], [], color=_WORKPIECE, ls=":")
        (ball,) = probe.plot([], [], color=_TOOL)
        arrows = [
            (
                axes.plot([], [], color=_MACHINE, lw=2)[0],
                axes.text(0, 0, "", color=_MACHINE, ha="center", va="center"),
            )
            for axes in (bore, probe)
        ]

        def update(K):
            plane = Plane("G68.2", [i, j, K])
            choice = positioning.heidenhain(align(plane.frame, machine), (0, 0), seq="+")
            angle = -np.deg2rad(choice.rho)  # from the feature's X to the spindle's
            spindle = np.array([np.cos(angle), np.sin(angle)])
            for line, text in arrows:
                line.set_data(*np.stack([0.4 * spindle, 1.15 * spindle], axis=-1))
                text.set(position=1.05 * spindle + 0.2 * spindle[::-1] * [1, -1], text="Xₛ")
            shift = np.array([-0.25, 0])  # not to scale
            bar.set_xy((0.6 * circle + shift[:, None]).T)
            tip.set_data(*np.stack([0.6 * spindle + shift, spindle + shift], axis=-1))
            clearance = radius - np.hypot(*(radius * spindle - [retract, 0]))
            ball.set_data(*(0.3 * circle + 0.35 * spindle[:, None]))
            seen.set_data(*(0.3 * circle + [[0.35], [0]]))
            error = run_out * np.hypot(*(spindle - [1, 0]))
            state = "clear of the wall" if clearance > 0 else "IN THE WALL"
            angles = ", ".join(f"{r.name} {a:z.3f}" for r, a in zip(machine.rotary, choice.angles, strict=True))
            return [
                f"{angles}, ρ = {choice.rho:z.3f}",
                f"tip after the retract: {clearance:z.3f} mm {state}",
                f"centre measured by the probe: wrong by {1000 * error:.1f} µm",
            ]

        return update

    return recorded(build, slider("K", -180, 180, -90, step=5.0), size=(7.0, 4.0), height=520)


def carried(machine):
    """What each rotary axis of a machine carries: sliders named after the two axes, buttons for the sense.

    With sense −1 both axes turn against their programmed angle: a table taken for a head, or a head for a table.
    Workpiece and tool are seen with their pivots together: what turns is in question here, not where.
    """
    names, sense = [rotary.name for rotary in machine.rotary], sp.Symbol("sense", real=True)
    angles = chain.joint_symbols(machine)[3:]
    signed = {angle: sense * angle for angle in angles}
    bodies = dict(chain.bodies(machine))
    workpiece, tool = (bodies[name][:3, :3].subs(signed, simultaneous=True) for name in ("workpiece", "tool"))
    part = Hull("workpiece", _WORKPIECE, block([-50.0, -35, -40], [50, 35, 0]))
    shapes = [part, *tool_solids(np.zeros(3), np.array([0.0, 0, 1]), 100.0, 90.0)]
    around = np.concatenate([ring([0, 0, 10], normal, 85.0) for normal in np.eye(3)])
    scene = Scene(["workpiece", "tool"], shapes, extent=around)
    scene.triad("bed", "XYZ", length=80, colour=_MACHINE)
    scene.triad("workpiece", "xyz", length=62, colour=_WORKPIECE, width=3)
    outer = names[1 if machine.arrangement == "table-table" else 0]
    sliders = [slider(name, -180, 180, 130 if name == outer else 30) for name in names]
    start = dict(zip((*angles, sense), [*(np.radians(each["value"]) for each in sliders), 1], strict=True))
    at_start = [np.array(matrix.subs(start).evalf(), dtype=float) for matrix in (workpiece, tool)]
    axes = dict(zip("xyzn", [*at_start[0].T, at_start[1][:, 2]], strict=True)) | {
        "X": np.eye(3)[0],
        "Y": np.eye(3)[1],
    }
    return formula(
        scene.frame(*clearest(axes)),
        (*angles, sense),
        [*sliders, slider("sense", -1, 1, 1, unit="", hidden=True)],
        {"workpiece": workpiece, "tool": tool},
        ["sense {3:0}: tool axis in the workpiece ({0:4}, {1:4}, {2:4})"],
        numbers=[*(workpiece.T * tool)[:, 2], sense],
        buttons=[("sense 1", [None, None, 1]), ("sense −1", [None, None, -1])],
        height=400,
    )

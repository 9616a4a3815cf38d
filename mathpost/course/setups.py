"""The set-ups of lessons 08 to 13: how things stand, what turns, which way a reading counts. Not to scale."""

import numpy as np

from mathpost.draw import plot
from mathpost.draw.sketch import sketch


def show(*names):
    """Draw set-ups beside each other, by the names of this module's functions.

    Examples
    --------
    >>> show("dial")
    {'image/png': ..., 'text/plain': 'picture with "dial and ring, ...
    """
    _, panels = plot.figure(1, len(names), size=(4.4 * len(names), 3.9))
    for axes, name in zip(np.atleast_1d(panels), names, strict=True):
        title, parts = globals()[name]()
        sketch(axes, parts, title=title)
    plot.show()


def datum():
    """Lesson 08: a table B seen along Y, the datum before and after a turn."""
    centre, w = np.zeros(2), np.array([0.35, 2.1])
    moved = np.array([-w[1], w[0]])  # the table obeys ISO 841: at B+90 what looked along +X looks at the spindle
    return "table B, along Y: the spindle stands at +Z", [
        ("ring", (centre, 2.6), "machine", ""),
        ("body", _box(0, 1.1, 0.7, 1.0), "workpiece", "part, B0"),
        ("line", [centre, w], "machine", ""),
        ("line", [centre, moved], "machine", ""),
        ("turn", (centre, 2.12, 81, 170), "tool", "table: B+", (-3.0, 1.6)),
        ("point", centre, "machine", "c", (-1.8, -1.2)),
        ("point", w, "workpiece", "w (G54)", (0.6, 0.6)),
        ("point", moved, "workpiece", "w′ = ?", (-2.0, -1.6)),
        ("body", _box(0, 3.6, 0.25, 0.5), "tool", "spindle", (3.4, 0.2)),
        ("arrow", [(-3.2, -2.6), (-2.2, -2.6)], "machine", "X"),
        ("arrow", [(-3.2, -2.6), (-3.2, -1.6)], "machine", "Z"),
    ]


def stack_ab():
    """Lesson 08: A stands on the bed and carries B."""
    return "stack order AB: A on the bed carries B", _stack("A", "B")


def stack_ba():
    """Lesson 08: B stands on the bed and carries A."""
    return "stack order BA: B on the bed carries A", _stack("B", "A")


def head_from_above():
    """Lesson 09: the horizontal head at 0° and 90°, the tip on one point of the block."""
    point, arm = np.zeros(2), 2.6
    parts = [
        ("body", [(-2.4, -2.0), (0, -2.0), (0, 0), (-2.4, 0)], "workpiece", "block"),
        ("point", point, "published", ""),
    ]
    for direction, angle, shift in ((np.array([1, 0]), 0, (0, 1.6)), (np.array([0, 1]), 270, (3.4, 0))):
        side = np.array([-direction[1], direction[0]])
        across = 0.22 * side
        box = [
            0.5 * direction + across,
            arm * direction + across,
            arm * direction - across,
            0.5 * direction - across,
        ]
        parts += [("body", box, "tool", ""), ("line", [point, 0.5 * direction], "tool", "")]
        parts += [("arrow", [0.9 * across, arm * direction + 0.9 * across], "published", f"U at {angle}°", shift)]
        parts += [("point", arm * direction, "machine", f"head, {angle}°", (2.4, -1.8))]
    return "seen from above: the tips of all heads touch one point", [
        *parts,
        ("ring", (point, 0.45), "machine", "vertical head", (-3.6, 1.2)),
        ("turn", (point, 3.4, 80, 10), "machine", "angle grows: clockwise", (2.6, 2.6)),
        ("arrow", [(-2.4, 2.2), (-1.5, 2.2)], "machine", "X"),
        ("arrow", [(-2.4, 2.2), (-2.4, 3.1)], "machine", "Y"),
    ]


def lhyset():
    """Lesson 09: what takes an offset from head to head."""
    vertical, horizontal = np.array([0, 2.2]), np.array([2.4, 3.4])
    return "along Y: two heads on one point, the machine moves by U", [
        ("body", [(-1.8, -1.4), (0, -1.4), (0, 0), (-1.8, 0)], "workpiece", "block"),
        ("body", _box(0, 1.6, 0.3, 0.6), "tool", "vertical head", (-4.2, -0.6)),
        ("line", [(0, 0), (0, 1.0)], "tool", ""),
        ("body", [(0.7, -0.25), (2.65, -0.25), (2.65, 3.2), (2.15, 3.2), (2.15, 0.25), (0.7, 0.25)], "tool", ""),
        ("line", [(0, 0), (0.7, 0)], "tool", "horizontal head", (5.0, -2.0)),
        ("point", vertical, "machine", "machine position", (-4.4, 0.6)),
        ("point", horizontal, "machine", "machine position", (-3.0, 0.8)),
        ("arrow", [vertical, horizontal], "published", "U", (-4.0, -4.0)),
        (
            "arrow",
            [(2.4, 3.15), (0.1, 1.95)],
            "second branch",
            "LHYSET: −U_h",
            (5.6, 0.0),
        ),
        ("arrow", [(-2.8, -1.4), (-2.1, -1.4)], "machine", "X"),
        ("arrow", [(-2.8, -1.4), (-2.8, -0.7)], "machine", "Z"),
    ]


def dial():
    """Lesson 10: X and Y run on a circle, C turns along, the dial looks at one spot of a ring."""
    offset, phi = np.array([0.3, -0.2]), np.radians(50)
    out = np.array([np.cos(phi), np.sin(phi)])
    spindle, spot = offset + 2.2 * out, 1.7 * out
    return "dial and ring, from above", [
        ("ring", ((0, 0), 1.7), "workpiece", "ring on C", (-1.0, -3.0)),
        ("dashed", _circle(offset, 2.2), "machine", ""),
        ("point", (0, 0), "workpiece", "C", (-1.6, 0.0)),
        ("point", offset, "machine", "centre of X Y", (3.8, -1.6)),
        ("arrow", [(0, 0), offset], "published", "e", (-1.6, -1.0)),
        ("line", [offset, spindle], "machine", "R", (1.0, -0.6)),
        ("line", [spot, spindle], "tool", ""),
        ("body", _circle(spindle, 0.2), "tool", "dial", (1.8, 1.2)),
        ("point", spot, "published", "spot", (-1.8, -1.2)),
        ("turn", (offset, 0.9, 0, 50), "machine", "φ", (0.8, 0)),
        ("arrow", [spindle, spindle + 0.7 * out], "tool", "reads +", (1.2, 0.4)),
        ("turn", ((0, 0), 2.75, 120, 165), "workpiece", "table: C−", (-1.6, 1.2)),
        ("arrow", [(-2.9, -2.6), (-2.2, -2.6)], "machine", "X"),
        ("arrow", [(-2.9, -2.6), (-2.9, -1.9)], "machine", "Y"),
    ]


def probe():
    """Lesson 10: one bore seen at two angles of a table A."""
    first, second = np.array([1.5, 1.5]), np.array([1.5, -1.5])
    return "one bore, probed at A0 and at A90, along X", [
        ("point", (0, 0), "machine", "c = ?", (-2.4, -1.2)),
        ("line", [(0, 0), first], "machine", ""),
        ("line", [(0, 0), second], "machine", ""),
        ("body", _circle(first, 0.28), "workpiece", "p₀", (2.2, -0.4)),
        ("body", _circle(second, 0.28), "workpiece", "p₁", (2.2, -0.4)),
        ("turn", ((0, 0), 2.12, 36, -36), "tool", "table: A+", (2.2, 0)),
        ("line", [first, (1.5, 2.6)], "tool", "probe", (1.6, 0.8)),
        ("arrow", [(-1.7, -1.7), (-0.9, -1.7)], "machine", "Y"),
        ("arrow", [(-1.7, -1.7), (-1.7, -0.9)], "machine", "Z"),
    ]


def ball():
    """Lesson 10: a ball on the table, followed by the control; the axis leans."""
    parts = [
        ("body", _box(0, -0.25, 2.2, 0.25), "workpiece", "table", (-5, 0)),
        ("dashed", [(0, -0.9), (0, 3.4)], "machine", "believed", (-2.6, 2.4)),
        ("line", [(0.12, -0.9), (0.75, 3.4)], "workpiece", "true axis", (3.4, 6.2)),
        ("size", [(-2.2, 0), (-2.2, 2.4)], "machine", "h", (-1.0, 0)),
        ("arrow", [(-3.0, -0.9), (-2.2, -0.9)], "machine", "X"),
        ("arrow", [(-3.0, -0.9), (-3.0, -0.1)], "machine", "Z"),
    ]
    for height, words in ((0.4, "low"), (2.4, "high")):
        shift = np.array([0.25 + 0.1 * height, 0.1])
        place = np.array([1.6, height])
        parts += [
            ("dashed", _circle(place, 0.18), "machine", ""),
            ("body", _circle(place + shift, 0.18), "workpiece", ""),
        ]
        parts += [("arrow", [place, place + shift], "tool", f"e, {words}", (3.2, -0.2))]
    return "a ball at two heights, the control follows it", parts


def bar():
    """Lesson 11: a bar in a head that tilts by ψ, the dial at its tip."""
    return "test bar: believed (grey) and true", [
        ("dashed", [(0, 0), (0, -3)], "machine", "L", (-0.9, 0)),
        ("line", [(0, 0), (0.35, 0.02)], "tool", "dy", (0, 1.0)),
        ("line", [(0.35, 0.02), (0.75, -3.35)], "tool", ""),
        ("turn", ((0, 0), 1.3, -90, -83.5), "second branch", "α", (1.0, -1.6)),
        ("point", (0, 0), "machine", "pivot", (-2.0, 0.2)),
        ("point", (0, -3), "machine", ""),
        ("point", (0.75, -3.35), "tool", "true tip", (-2.8, -1.6)),
        ("arrow", [(0, -3), (0.75, -3)], "published", "u", (0.2, 1.0)),
        ("arrow", [(0.75, -3), (0.75, -3.35)], "published", "w < 0", (2.2, 2.2)),
        ("turn", ((0, 0), 2.3, -90, -50), "tool", "tilt ψ", (1.8, -0.6)),
        ("arrow", [(-1.5, -3), (-1.5, -2.3)], "machine", "axial +"),
        ("arrow", [(-1.5, -3), (-0.8, -3)], "machine", "lateral +", (0, -1.1)),
    ]


def tilted_head():
    """Lesson 11: RTCP holds the believed tip; the small vector (u, w) turns with the head."""
    psi, pivot = np.radians(40), np.array([-1.93, 2.3])
    u, w = 0.75 * np.array([np.cos(psi), np.sin(psi)]), 0.35 * np.array([np.sin(psi), -np.cos(psi)])
    return "tilted by ψ: (u, w) turns with the head", [
        ("dashed", [pivot, (0, 0)], "machine", "L", (-1.0, -0.4)),
        ("dashed", [pivot, pivot - [0, 2.6]], "machine", ""),
        ("turn", (pivot, 1.4, -90, -50), "tool", "ψ", (0, -0.8)),
        ("point", pivot, "machine", "pivot", (-1.6, 0.8)),
        ("point", (0, 0), "machine", "held by RTCP", (-0.5, -2.2)),
        ("arrow", [(0, 0), u], "published", "u", (-0.4, 0.8)),
        ("arrow", [u, u + w], "published", ""),
        ("point", u + w, "tool", "tip", (1.6, -0.4)),
        ("dashed", [(0, 0), (0.75, 0)], "tool", ""),
        ("point", (0.75, -0.35), "tool", "tip at ψ = 0", (3.0, -1.0)),
        ("arrow", [(0.75, -0.35), u + w], "second branch", "the dial sees this", (4.0, 1.2)),
    ]


def laser():
    """Lesson 12: a laser and a reflector on a rotary table."""
    turn = np.radians(18)
    mirror = [(0.9 * np.cos(a + turn), 0.9 * np.sin(a + turn)) for a in np.radians([0, 60, 120, 180, 240, 300])]
    return "laser and polygon on the table, from above", [
        ("ring", ((0, 0), 2.0), "machine", "table C", (-5.4, -4.2)),
        ("body", mirror, "workpiece", "polygon"),
        ("body", _box(4.3, 0.35, 0.6, 0.35), "tool", "laser", (0, 1.8)),
        ("line", [(3.7, 0.35), (0.9, 0.35)], "tool", ""),
        ("turn", ((0, 0), 1.5, -50, -10), "first branch", "up: from below", (3.6, -2.2)),
        ("turn", ((0, 0), 1.5, 80, 40), "second branch", "down: from above", (1.6, 2.4)),
        ("dashed", [(0, 0), (2.4, 0)], "machine", "target", (3.6, -1.4)),
        ("line", [(0, 0), (2.3, 0.75)], "published", "actual", (5.4, 1.6)),
        ("turn", ((0, 0), 2.2, 0, 18), "published", "error +", (1.9, 0.2)),
    ]


def error_frame():
    """Lesson 13: the six errors of one joint."""
    x, y, z = np.array([1.0, -0.28]), np.array([0.75, 0.55]), np.array([0.0, 1.0])
    parts = [("body", [-1.6 * x - y, 1.6 * x - y, 1.6 * x + y, -1.6 * x + y], "workpiece", "table C", (-6.0, -1.6))]
    for name, direction, shift in (("X", x, (1.4, -0.4)), ("Y", y, (1.2, 0.4)), ("Z", z, (1.4, -0.4))):
        parts += [("arrow", [(0, 0), 1.9 * direction], "tool", f"E{name}C", shift)]
        place, tilt = 1.35 * direction, "ABC"["XYZ".index(name)]
        parts += [("turn", (place, 0.3, -150, 120), "second branch", f"E{tilt}C", (-3.0, 1.3))]
    return "six errors of one joint, seen in the body before it", parts


def positioning_sign():
    """Lesson 13: the same positioning error about an axis along +Z and along −Z."""
    parts = []
    for left, axis, actual, name in ((-2.6, "[0, 0, 1]", 32, "+"), (2.6, "[0, 0, −1]", -32, "−")):
        centre = np.array([left, 0.0])
        end = centre + 1.9 * np.array([np.cos(np.radians(actual)), np.sin(np.radians(actual))])
        parts += [
            ("ring", (centre, 1.6), "machine", ""),
            ("dashed", [centre, (left + 2.0, 0)], "machine", ""),
            ("line", [centre, end], "published", ""),
            ("turn", (centre, 1.2, 0, actual), "published", f"{name}ECC", (1.4, 0)),
            ("turn", (centre, 0.6, 90, 90 + (150 if actual > 0 else -150)), "tool", "C+", (0, 1.6)),
            ("line", [(left - 1.6, -2.2), (left + 1.6, -2.2)], "machine", f"axis = {axis}", (0, -1.0)),
        ]
    return "10″ too far: about +Z here, about −Z there", parts


def _stack(lower, upper):
    """Two turning bodies on a bed."""
    colours = {"A": "first branch", "B": "second branch"}
    return [
        ("body", _box(0, -1.6, 2.2, 0.3), "machine", "bed"),
        ("body", _box(0, -0.5, 1.7, 0.7), colours[lower], lower),
        ("body", _box(0, 0.6, 1.1, 0.3), colours[upper], upper),
        ("body", _box(0, 1.5, 0.6, 0.5), "workpiece", "part"),
        ("arrow", [(1.9, -0.1), (2.6, -0.1)], colours["A"], "A (along X)", (2.2, 0)),
        ("arrow", [(0, 2.3), (0, 3.0)], colours["B"], "B (along Y)", (0, 0.4)),
    ]


def _box(x, y, half_width, half_height):
    return [(x + a * half_width, y + b * half_height) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _circle(centre, radius):
    angle = np.linspace(0, 2 * np.pi, 49)
    return np.add(centre, radius * np.column_stack([np.cos(angle), np.sin(angle)]))

"""What a program does, measured: tip and tool axis against CL records, travel, rates, time, the tool's body."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass
class Samples:
    """The moves of a program, cut fine: one row for each sample."""

    move: np.ndarray  # index of the move
    t: np.ndarray
    tip: np.ndarray
    axis: np.ndarray
    nose: np.ndarray
    angles: np.ndarray


def sample(model, moves, least=2, turn=1.0, most=400):
    """Cut moves so that no rotary axis turns by more than `turn` degrees between samples, ends included."""
    rows = {name: [] for name in Samples.__dataclass_fields__}
    for n, move in enumerate(moves):
        if move.kind == "dwell" or np.isnan(move.nose(model, 0.0)).any() or np.isnan(move.nose(model, 1.0)).any():
            continue
        swing = float(np.abs(move.end - move.start).max())
        count = min(most, max(least, math.ceil(swing / turn), 32 if move.arc else 1))
        for t in np.linspace(0.0, 1.0, count + 1):
            nose = move.nose(model, t)
            angles = move.angles(t)
            tip, axis = model.place(nose, angles, move.tool_length)
            for name, value in zip(rows, (n, t, tip, axis, nose, angles), strict=True):
                rows[name].append(value)
    return Samples(*(np.array(values) for values in rows.values()))


# Distances.


def to_segment(point, a, b):
    """Distance of a point to the line from a to b."""
    along = b - a
    square = float(along @ along)
    t = 0.0 if square == 0 else min(1.0, max(0.0, float((point - a) @ along) / square))
    return float(np.linalg.norm(point - a - t * along))


def to_path(points, path):
    """Distance of each point to a path of straight lines."""
    along = np.diff(path, axis=0)
    square = np.maximum((along**2).sum(axis=1), 1e-300)
    nearest = np.full(len(points), np.inf)
    for a, line, size in zip(path, along, square, strict=False):
        t = np.clip((points - a) @ line / size, 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(points - a - t[:, None] * line, axis=1))
    return nearest


def between(u, v):
    """Angle between two unit vectors, degrees; exact for small ones."""
    return math.degrees(2 * math.asin(min(1.0, float(np.linalg.norm(u - v)) / 2)))


def to_great_circle(u, a, b):
    """Angle from u to the great-circle arc from a to b (unit vectors), degrees."""
    normal = np.cross(a, b)
    size = float(np.linalg.norm(normal))
    if size > 1e-12:
        normal = normal / size
        foot = u - (u @ normal) * normal
        if np.cross(a, foot) @ normal >= 0 and np.cross(foot, b) @ normal >= 0:
            return math.degrees(abs(math.asin(min(1.0, max(-1.0, float(u @ normal))))))
    return min(between(u, a), between(u, b))


def along_records(tips, axes, cl_tips, cl_axes, window=6, scale=0.1):
    """For each sample: distance to the CL polyline, mm, to the arc of the tool axis, degrees, and the segment.

    The segment never goes back, and advances by at most `window`; among those in reach it is the one with the least
    tip distance + `scale` · axis distance.
    """
    last = len(cl_tips) - 2
    k = 0
    found = []
    for tip, axis in zip(tips, axes, strict=True):
        best = None
        for s in range(k, min(k + window, last) + 1):
            d = to_segment(tip, cl_tips[s], cl_tips[s + 1])
            a = to_great_circle(axis, cl_axes[s], cl_axes[s + 1])
            if best is None or d + scale * a < best[0] - 1e-12:
                best = (d + scale * a, d, a, s)
        k = best[3]
        found.append(best[1:])
    array = np.array(found)
    return array[:, 0], array[:, 1], array[:, 2].astype(int)


def records_missed(tips, axes, cl_tips, cl_axes, tip_within, axis_within):
    """Records that no sample passes in their order within both tolerances."""
    missed = []
    at = 0
    for k in range(len(cl_tips)):
        near = np.linalg.norm(tips[at:] - cl_tips[k], axis=1) <= tip_within
        near &= np.linalg.norm(axes[at:] - cl_axes[k], axis=1) <= 2 * math.sin(math.radians(axis_within) / 2)
        hits = np.flatnonzero(near)
        if len(hits):
            at += int(hits[0])
        else:
            missed.append(k)
    return missed


# Axes.


def positions(model, samples):
    """Slides (machine coordinates) and angles, shape (n, 3 + rotary axes), in the order X Y Z, rotary."""
    return np.column_stack([np.array([model.slides(nose) for nose in samples.nose]), samples.angles])


def axis_names(model):
    return ("X", "Y", "Z", *model.letters)


def beyond_travel(model, moves, samples, slack=1e-3):
    """(line, axis, position) wherever an axis is beyond an end of its travel."""
    found = []
    values = positions(model, samples)
    for n, letter in enumerate(axis_names(model)):
        if n < 3 and model.limits_of == "words":
            continue
        low, high = model.travel[letter]
        for row in np.flatnonzero((values[:, n] < low - slack) | (values[:, n] > high + slack)):
            found.append((moves[samples.move[row]].line, letter, float(values[row, n])))
    return found


def way(model, move, pieces=16):
    """How far each axis goes in a move, and its greatest speed if the move took one second."""
    grid = np.linspace(0.0, 1.0, pieces + 1)
    values = np.array([np.r_[move.nose(model, t), move.angles(t)] for t in grid])
    steps = np.abs(np.diff(values, axis=0))
    return steps.sum(axis=0), steps.max(axis=0) * pieces


def _limits(model, table):
    return np.array([table[letter] for letter in axis_names(model)], dtype=float)


def at_constant_speed(model, move):
    """Seconds of a move at constant speed: those that F asks for, or longer where an axis cannot go so fast."""
    if move.kind == "dwell":
        return move.seconds
    _, fastest = way(model, move)
    by_axes = float(np.max(fastest / _limits(model, model.rates)))
    return by_axes if move.seconds is None else max(move.seconds, by_axes)


def rest_to_rest(model, move):
    """Seconds of a move that begins and ends at rest: a trapezoid of speed within rates and accelerations.

    The whole move shares one profile, as for joints on a straight line; on curved ways the greatest speed of each
    axis stands for its way.
    """
    if move.kind == "dwell":
        return move.seconds
    _, fastest = way(model, move)
    if not fastest.max() > 0:
        return 0.0
    speed = 1.0 / at_constant_speed(model, move)
    with np.errstate(divide="ignore"):
        acceleration = float(np.min(_limits(model, model.accelerations) / fastest))
    if speed * speed / acceleration <= 1.0:
        return 1.0 / speed + speed / acceleration
    return 2.0 / math.sqrt(acceleration)


def exceeded_rates(model, moves, slack=1e-3):
    """(line, axis, asked / greatest) of moves whose F asks an axis for more than its greatest rate."""
    found = []
    for move in moves:
        if move.kind != "feed" or not move.seconds or math.isnan(move.seconds):
            continue
        ratio = way(model, move)[1] / move.seconds / _limits(model, model.rates)
        for n in np.flatnonzero(ratio > 1 + slack):
            found.append((move.line, axis_names(model)[n], float(ratio[n])))
    return found


# The tool's body.


def depth_in_tool(points, tip, axis, radius, length):
    """How deep the deepest of the points is in the cylinder above the tip, mm; 0 if none is inside."""
    from_tip = np.asarray(points) - tip
    height = from_tip @ axis
    off = np.linalg.norm(from_tip - height[:, None] * axis, axis=1)
    inside = np.minimum(np.minimum(height, length - height), radius - off)
    return max(0.0, float(inside.max())) if len(inside) else 0.0

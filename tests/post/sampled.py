"""How far a program strays from its CL data, by plain sampling that shares only the forward kinematics."""

import numpy as np

AT_ONCE = 5000  # samples of one piece


def sampled_errors(kin, cl, joints, place, cut, samples):
    """The largest distance (mm) and angle (degrees) of the moves in cut, from the records and the forward alone."""
    record = np.minimum(np.floor(place[:-1]).astype(int), len(cl) - 2)[cut]
    start, along = cl.points[record], cl.points[record + 1] - cl.points[record]
    square = np.maximum(np.vecdot(along, along), 1e-300)
    normal = np.cross(cl.axes[record], cl.axes[record + 1])
    turn = np.linalg.norm(normal, axis=1)
    first, step = joints[:-1][cut], np.diff(joints, axis=0)[cut]
    tip_error = axis_error = 0.0
    pieces = min(samples, 1 + samples * len(first) // AT_ONCE)
    for t in np.array_split(np.linspace(0, 1, samples), pieces):
        tip, axis = kin.forward(first + t[:, None, None] * step)
        part = np.clip(np.vecdot(tip - start, along) / square, 0, 1)
        tip_error = max(tip_error, np.linalg.norm(tip - start - part[..., None] * along, axis=-1).max())
        # From the great circle through both records, or from them where it has no direction.
        off = np.abs(np.vecdot(axis, normal)) / np.maximum(turn, 1e-300)
        off = np.where(turn > 1e-9, off, np.linalg.norm(axis - cl.axes[record], axis=-1))
        axis_error = max(axis_error, np.degrees(np.arcsin(off.max())))
    return tip_error, axis_error

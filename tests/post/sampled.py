"""How far a program strays from its CL data, by plain sampling that shares only the forward kinematics."""

import numpy as np


def sampled_errors(kin, cl, joints, place, cut, samples):
    """The largest distance (mm) and angle (degrees) of the moves in cut, from the records and the forward alone."""
    tip_error = axis_error = 0.0
    for t in np.linspace(0, 1, samples):
        tip, axis = kin.forward(joints[:-1] + t * np.diff(joints, axis=0))
        record = np.minimum(np.floor(place[:-1]).astype(int), len(cl) - 2)
        start, along = cl.points[record], cl.points[record + 1] - cl.points[record]
        part = np.vecdot(tip - start, along) / np.maximum(np.vecdot(along, along), 1e-300)
        tip_error = max(
            tip_error, np.linalg.norm(tip - start - np.clip(part, 0, 1)[:, None] * along, axis=1)[cut].max()
        )
        # From the great circle through both records, or from them where it has no direction.
        normal = np.cross(cl.axes[record], cl.axes[record + 1])
        turn = np.linalg.norm(normal, axis=1)
        off = np.abs(np.vecdot(axis, normal)) / np.maximum(turn, 1e-300)
        off = np.where(turn > 1e-9, off, np.linalg.norm(axis - cl.axes[record], axis=1))
        axis_error = max(axis_error, np.degrees(np.arcsin(off[cut].max())))
    return tip_error, axis_error

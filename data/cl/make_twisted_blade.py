"""Make twisted_blade.cl: a spiral round a twisted blade, defined here by formula.

The section is an ellipse, turned by up to 35 degrees from tip to root. The ball-nosed tool goes round it, over both
sides and both edges, one section pitch deeper with every turn. Its axis leans from the stacking axis towards the
surface normal by an angle that swings through zero six times, and a little sideways, so that it passes the pole of
a table machine closely each time.

Run from the repository's root: python data/cl/make_twisted_blade.py
"""

from pathlib import Path

import numpy as np

from mathpost.files import write_text
from mathpost.path import cl
from mathpost.rotation import unit

RECORDS = 5600
TURNS = 20
CHORD, THICKNESS, HEIGHT = 60.0, 10.0, 60.0  # mm
TWIST = np.radians(35.0)
BALL = 4.0  # radius of the tool, mm
LEAN, SIDEWAYS = np.radians(25.0), np.radians(0.3)
PASSES = 3  # full swings of the lean: it passes zero twice in each
FEED = 1500.0  # mm/min


def make():
    """Return the path as `CLData`."""
    s = np.linspace(0, 1, RECORDS)
    # Equal steps of the eccentric angle would be too coarse at the edges, where the normal turns fastest.
    around = 2 * np.pi * TURNS * s
    angle = around - 0.4 * np.sin(2 * around)
    twist = TWIST * s
    turned = np.stack([np.cos(twist), np.sin(twist)]), np.stack([-np.sin(twist), np.cos(twist)])
    section = CHORD / 2 * np.cos(angle) * turned[0] + THICKNESS / 2 * np.sin(angle) * turned[1]
    surface = np.column_stack([*section, HEIGHT * (1 - s)])
    outwards = THICKNESS / 2 * np.cos(angle) * turned[0] + CHORD / 2 * np.sin(angle) * turned[1]
    normal = unit(np.column_stack([*outwards, np.zeros(RECORDS)]))
    up = np.broadcast_to([0.0, 0.0, 1.0], normal.shape)
    lean = (LEAN * np.sin(2 * np.pi * PASSES * s + 0.3))[:, None]
    axis = unit(np.cos(lean) * up + np.sin(lean) * normal + np.tan(SIDEWAYS) * np.cross(up, normal))
    return cl.from_arrays(surface + BALL * (normal - axis), axis, feed=FEED, name="twisted_blade.cl")


if __name__ == "__main__":
    path = Path(__file__).with_name("twisted_blade.cl")
    write_text(path, cl.to_text(make(), title="twisted blade by formula: see make_twisted_blade.py"))

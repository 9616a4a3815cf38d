"""The yardstick from end to end: a post-processor written as a loop over records, in plain Python.

The trunnion of `ac_table.toml`, without C limits: GOTO lines in, both branches, the best of them over the path,
the tip between the records checked at sixteen places, Heidenhain blocks out, read back and checked again.
"""

import math
import re
from itertools import pairwise

WORD = re.compile(r"([XYZAC])([-+]?[0-9.]+)")
NAMES, SAMPLES, PIVOT_Z, A_LIMIT = "XYZAC", 16, -50.0, math.radians(120)
RATES = (500.0, 500.0, 500.0, math.radians(60), math.radians(120))


def inverse(x, y, z, i, j, k):
    """Both branches."""
    tilt = math.acos(max(-1.0, min(1.0, k / math.sqrt(i * i + j * j + k * k))))
    for a, c in ((tilt, math.atan2(i, -j)), (-tilt, math.atan2(-i, j))):
        ca, sa, cc, sc = math.cos(a), math.sin(a), math.cos(c), math.sin(c)
        turned = -sc * x + cc * y
        up = z - PIVOT_Z
        yield cc * x + sc * y, ca * turned + sa * up, -sa * turned + ca * up + PIVOT_Z, a, c


def forward(joints):
    """Tip and axis."""
    x, y, z, a, c = joints
    ca, sa, cc, sc = math.cos(a), math.sin(a), math.cos(c), math.sin(c)
    up = z - PIVOT_Z
    turned, height = ca * y - sa * up, sa * y + ca * up + PIVOT_Z
    return (cc * x - sc * turned, sc * x + cc * turned, height), (sc * sa, -cc * sa, ca)


def cost(start, end):
    steps = [b - a for a, b in zip(start, end, strict=True)]
    steps[4] -= 2 * math.pi * round(steps[4] / (2 * math.pi))
    return max(abs(step) / rate for step, rate in zip(steps, RATES, strict=True))


def choose(records):
    """The branch of each record: dynamic programming over two candidates."""
    best, came = [0.0, 1e-6], []
    before = list(inverse(*records[0]))
    rows = [before]
    for record in records[1:]:
        now = list(inverse(*record))
        totals = [[best[f] + cost(before[f], now[t]) for f in range(2)] for t in range(2)]
        came.append([total.index(min(total)) for total in totals])
        best = [min(t) if abs(j[3]) <= A_LIMIT else math.inf for t, j in zip(totals, now, strict=True)]
        before = now
        rows.append(now)
    pick = best.index(min(best))
    chosen = [rows[-1][pick]]
    for row, origin in zip(reversed(rows[:-1]), reversed(came), strict=True):
        pick = origin[pick]
        chosen.append(row[pick])
    chosen.reverse()
    unwound = [list(chosen[0])]
    for joints in chosen[1:]:
        turns = round((unwound[-1][4] - joints[4]) / (2 * math.pi))
        unwound.append([*joints[:4], joints[4] + 2 * math.pi * turns])
    return unwound


def stray(start, end):
    """Largest distance of the tip from the straight segment, at sixteen places of the move."""
    first, last = forward(start)[0], forward(end)[0]
    along = [b - a for a, b in zip(first, last, strict=True)]
    squared = sum(value * value for value in along) or 1.0
    worst = 0.0
    for n in range(SAMPLES + 1):
        tip = forward([a + n / SAMPLES * (b - a) for a, b in zip(start, end, strict=True)])[0]
        offset = [b - a for a, b in zip(first, tip, strict=True)]
        t = max(0.0, min(1.0, sum(a * b for a, b in zip(offset, along, strict=True)) / squared))
        worst = max(worst, math.dist(offset, [t * value for value in along]))
    return worst


def post(text, tolerance=0.01):
    """Return the program, verified."""
    lines = (line for line in text.splitlines() if line.startswith("GOTO/"))
    records = [tuple(map(float, line[5:].split(","))) for line in lines]
    chosen = choose(records)
    for start, end in pairwise(chosen):
        if stray(start, end) > tolerance:
            raise ValueError("the records are too far apart")
    program, before = ["0 BEGIN PGM PLAIN MM"], [None] * 5
    for joints in chosen:
        printed = [f"{value:+.4f}" for value in (*joints[:3], *map(math.degrees, joints[3:]))]
        words = [name + now for name, now, old in zip(NAMES, printed, before, strict=True) if now != old]
        program.append(f"{len(program)} L {' '.join(words)}")
        before = printed
    program = "\n".join([*program, f"{len(program)} END PGM PLAIN MM"]) + "\n"
    state, read = {}, []
    for line in program.splitlines()[1:-1]:
        state |= {name: float(value) for name, value in WORD.findall(line)}
        read.append([*(state[n] for n in "XYZ"), *(math.radians(state[n]) for n in "AC")])
    for joints, record in zip(read, records, strict=True):
        tip, axis = forward(joints)
        if math.dist(tip, record[:3]) > tolerance or math.dist(axis, record[3:]) > 1e-4:
            raise ValueError("off the CL data")
    if any(stray(start, end) > tolerance for start, end in pairwise(read)):
        raise ValueError("off the CL path")
    return program

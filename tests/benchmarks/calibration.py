"""Whether U means what it says: random machines, measured, calibrated, compensated and measured again."""

import os
import tempfile
from pathlib import Path

import numpy as np

from mathpost.shop.compensate.calibrate import calibrate
from tests.benchmarks.timing import row
from tests.compensate.measured import AGAINST, ISO, Real, believed, files, left, nominal

MACHINES = int(os.environ.get("MACHINES", "2000"))
SEED = 20260
TIPS = 4  # the tip of every fourth machine is looked at: it takes as long as the calibration
PLACE, ANGLES = np.array([[60.0, -50.0, 70.0]]), np.deg2rad([[20.0, 40.0]])


def once(machine, rng, folder, tip=True):
    """One machine: for each unknown and the tip along X Y Z, what is missed and U; the tip before and after, mm."""
    real = Real.random(machine, rng)
    found = calibrate(machine, files(real, folder, rng))
    truth = {"EC0Y": real.square[0], "EB0Z": real.square[1], "EA0Z": real.square[2]}
    here = real.aside(found.about[None])[0]  # squareness there: a table is displayed by so much beside where it is
    for each in machine.rotary:
        shift = real.shifts[each.name] - here * (each.carries == "workpiece")
        truth |= {f"E{d}0{each.name}": x for d, x in zip("XYZ", shift, strict=True)}
        truth |= {f"E{d}0{each.name}": x for d, x in zip("ABC", real.tilts[each.name], strict=True)}
    truth |= {"EA0S": real.spindle[0], "EB0S": real.spindle[1]}
    missed = {name: (found[name].value - truth[name], found[name].U) for name in found.values}

    angles = ANGLES if machine.arrangement != "head-table" else ANGLES[:, ::-1]
    length = np.array([120.0])
    before = left(real, Real(machine), PLACE, angles, length)[0]
    after = left(real, believed(found), PLACE, angles, length)[0]
    if not tip:
        return missed, np.linalg.norm(before), np.linalg.norm(after)
    slopes = []
    tables = [each.value for each in found.positioning]
    for name in found.values:
        other = believed(found, values=found.values | {name: found.values[name] + 1e-6})
        slopes.append((left(real, other, PLACE, angles, length)[0] - after) / 1e-6)
    for n, entries in enumerate(tables):
        for step in 1e-6 * np.eye(len(entries)):
            other = believed(found, tables=[*tables[:n], entries + step, *tables[n + 1 :]])
            slopes.append((left(real, other, PLACE, angles, length)[0] - after) / 1e-6)
    for axis in range(3):
        missed[f"tip {'XYZ'[axis]}"] = after[axis], found.value(0.0, np.array(slopes)[:, axis]).U
    return missed, np.linalg.norm(before), np.linalg.norm(after)


def coverage(arrangement, count, rng):
    """Arrays of what is missed over U, by name, and the tip before and after; tables turn both ways in turn."""
    ratios, tips = {}, []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            machine = nominal(arrangement, (ISO, AGAINST)[number % 2])
            missed, *sizes = once(machine, rng, Path(folder), tip=number % TIPS == 0)
            tips.append(sizes)
            for name, (error, u) in missed.items():
                ratios.setdefault(name, []).append(error / u)
    return {name: np.array(each) for name, each in ratios.items()}, np.array(tips)


def run():
    print(f"{MACHINES} random machines of each arrangement, seed {SEED}: shares of errors within U (95 %)")
    for arrangement in ("table", "mixed", "head"):
        ratios, tips = coverage(arrangement, MACHINES, np.random.default_rng(SEED))
        inside = {name: np.mean(np.abs(each) <= 1) for name, each in ratios.items()}
        row(f"{arrangement}: all unknowns and the tip", np.mean(list(inside.values())), None, "what is missed")
        for name, share in inside.items():
            print(f"    {name:6s} {share:.4f}")
        for sign, each in (("-1", slice(0, None, 2)), ("+1", slice(1, None, 2))):
            of_sign = np.mean([np.abs(r[each]) <= 1 for name, r in ratios.items() if "tip" not in name])
            print(f"    tables about [0, 0, {sign}]: {of_sign:.4f}")
        before, after = 1e3 * np.median(tips, axis=0)
        print(f"    tip before {before:.2f} µm, after {after:.3f} µm (medians)", flush=True)

"""Every way through the singular region, on every machine: within both tolerances, or refused with what it needs.

The sampling is ten times denser than the one that built the programs, and shares nothing with it.
"""

from pathlib import Path

import numpy as np

from mathpost import load_machine
from mathpost import postprocess as post
from mathpost.errors import MathpostError
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from mathpost.shop.post.ways import Crossing
from tests.benchmarks.timing import row
from tests.post.sampled import sampled_errors

TOLERANCE, GRANTED = 0.01, (0.1, 3.0)  # mm; degrees
SAMPLES = {"blade.cl": 1281, "twisted_blade.cl": 161}


def run():
    for name, samples in SAMPLES.items():
        path = cl.read(Path("data/cl", name))
        for file in sorted(Path("data/machines").glob("*.toml")):
            kin = Kinematics(load_machine(file))
            for way, granted in ((way, granted) for granted in GRANTED for way in Crossing.SAFE):
                what = f"{name}, {file.stem}, {way}"
                try:
                    done = post(path, kin.machine, singular=way, axis_tolerance=np.radians(granted), split=True)
                except MathpostError as error:
                    print(f"  {what:<58} refused: {str(error)[-66:]}")
                    continue
                joints, tips = done.blocks.joints, path.at(done.place)[0]
                lifted = np.linalg.norm(kin.forward(joints)[0] - tips, axis=1) > 1
                tip, axis = sampled_errors(kin, path, joints, done.place, ~(lifted[:-1] | lifted[1:]), samples)
                row(f"{what}, tip", tip / TOLERANCE, 1, f"{TOLERANCE} mm, {len(joints)} blocks")
                row(f"{what}, axis", axis / granted, 1, f"{granted}°, stated {done.report.path_axis_error:.4f}°")

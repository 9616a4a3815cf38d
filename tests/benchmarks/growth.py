"""How the cost of each stage grows with the number of records, and its exponent."""

import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from mathpost import cldata, postprocess, program, selection
from mathpost.kinematics import Kinematics
from tests.benchmarks.pipeline import cl_text, trunnion
from tests.benchmarks.timing import best

SIZES = [10**n for n in range(3, 1 + int(os.environ.get("LARGEST_POWER", "5")))]
PICTURE = Path(".artefacts/growth.png")


def stages(count):
    """Seconds of each stage for a path of `count` records."""
    text, setup = cl_text(count), trunnion()
    kin, cl = Kinematics(setup), cldata.parse(text)
    result = postprocess.run(cl, setup, compare=False)
    repeats = 3 if count < 10**6 else 1
    return {
        "read CL": best(lambda: cldata.parse(text), repeats),
        "inverse": best(lambda: kin.inverse(cl.points, cl.axes), repeats),
        "selection": best(lambda: selection.choose(kin, cl), repeats),
        "write program": best(lambda: program.write(result.blocks, setup), repeats),
        "read program": best(lambda: program.read(result.program, setup), repeats),
        "whole": best(lambda: postprocess.run(cl, setup, compare=False), repeats),
    }


def run():
    measured = [stages(count) for count in SIZES]
    print(
        f"growth from {SIZES[0]} to {SIZES[-1]} records (LARGEST_POWER=7 for more): exponent, share of the whole:"
    )
    figure, axes = plt.subplots(figsize=(7, 5), layout="constrained")
    for stage in measured[0]:
        seconds = np.array([row[stage] for row in measured])
        exponent = np.polyfit(np.log(SIZES[-2:]), np.log(seconds[-2:]), 1)[0]
        print(f"  {stage:<16} {exponent:6.2f} {seconds[-1] / measured[-1]['whole']:8.3f}")
        axes.loglog(SIZES, seconds / measured[-1]["whole"], "o-", label=f"{stage}, exponent {exponent:.2f}")
    axes.set(xlabel="records", ylabel=f"time / time of the whole at {SIZES[-1]:.0e} records")
    axes.legend()
    axes.grid(alpha=0.3)
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, dpi=100)
    plt.close(figure)

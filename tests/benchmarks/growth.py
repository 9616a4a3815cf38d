"""How the cost of each stage grows with the number of records, and its exponent."""

import os
import tempfile
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from mathpost import postprocess as post
from mathpost.files import write_text
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from tests.benchmarks.pipeline import trunnion, write_cl
from tests.benchmarks.timing import row

LARGEST = int(os.environ.get("LARGEST", "3_000_000"))
SIZES = [size for n in range(4, 9) for size in (10**n, 3 * 10**n) if size <= LARGEST]
LARGE = 2  # number of the first size beside which deriving and compiling the machine is little
PICTURE = Path(__file__).with_name("growth.png")


def stages(path, output):
    """Seconds of each stage of one file."""
    begun = {"reading": time.process_time()}
    result = post(cl.read(path), trunnion(), progress=lambda stage: begun.setdefault(stage, time.process_time()))
    begun["into a file"] = time.process_time()
    write_text(output, result.program)
    times = np.array([*begun.values(), time.process_time()])
    return dict(zip(begun, np.diff(times), strict=True)) | {"whole": times[-1] - times[0]}


def inverse(path):
    """Seconds of the inverse alone."""
    kin, path = Kinematics(trunnion()), cl.read(path)
    kin.inverse([0, 0, 0], [0, 0, 1])
    begun = time.process_time()
    kin.inverse(path.points, path.axes)
    return {"inverse": time.process_time() - begun}


def run():
    measured = []
    with tempfile.TemporaryDirectory() as folder:
        path, output = Path(folder, "path.cl"), Path(folder, "path.h")
        for count in SIZES:
            write_cl(path, count)
            rounds = [inverse(path) | stages(path, output) for _ in range(3 if count < 10**7 else 1)]
            measured.append({stage: min(one[stage] for one in rounds) for stage in rounds[0]})
            path.unlink()
    print(f"growth from {SIZES[0]} to {SIZES[-1]} records (LARGEST=10_000_000 for more):")
    draw(measured)


def draw(measured):
    figure, axes = plt.subplots(figsize=(7, 5), layout="constrained")
    for stage in measured[0]:
        seconds = np.array([times[stage] for times in measured])
        exponent = np.polyfit(np.log(SIZES[LARGE:]), np.log(seconds[LARGE:]), 1)[0]
        row(f"{stage}, exponent from {SIZES[LARGE]} records on", exponent, None, "growth")
        row(f"{stage}, at {SIZES[-1]} records", seconds[-1] / measured[-1]["whole"], None, "the whole")
        axes.loglog(SIZES, seconds / measured[-1]["whole"], "o-", label=f"{stage}, exponent {exponent:.2f}")
    axes.set(xlabel="records", ylabel=f"time / time of the whole at {SIZES[-1]:,} records")
    axes.legend()
    axes.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=100)
    plt.close(figure)

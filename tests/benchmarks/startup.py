"""What it costs to start: importing, and deriving and compiling a machine."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from mathpost import chain, formula, kinematics, machine
from tests.benchmarks.timing import best, row


def fresh(statement):
    """Shortest time of a statement in a fresh interpreter."""
    return best(lambda: subprocess.run([sys.executable, "-c", statement], check=True), clock=time.perf_counter)


def run():
    print("starting, of one second:")
    nothing = fresh("pass")
    row("import mathpost", fresh("import mathpost") - nothing, 0.1, "1 s")
    row("import mathpost.shop.post, sympy included", fresh("import mathpost.shop.post") - nothing, None, "1 s")
    for path in sorted(Path("data/machines").glob("*.toml")):
        for kept in (formula.numeric, kinematics.derive, chain.links, chain.bodies):
            kept.cache_clear()
        start = time.perf_counter()
        kin = kinematics.Kinematics(machine.load(path))
        kin.inverse(*kin.forward(np.zeros((1, len(kin.symbols)))))
        row(f"{path.stem}: read, derived, compiled", time.perf_counter() - start, 1, "1 s")

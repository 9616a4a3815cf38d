"""What it costs to start: importing, commands, and deriving and compiling a machine."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from mathpost import chain, formula, kinematics, load_machine
from tests.benchmarks.timing import interleaved, row

SHELL = {  # what is typed, and the largest ratio
    "--help": 0.3,
    "explain --angles 135 54.7356 -90 --point 3 4 5 --result 1.283069 6.939923 0.437263": 1.5,
    "post data/cl/blade.cl --machine dmu50v -o {}/blade.h": 1.5,
}


def fresh(*words):
    """A function that runs a fresh interpreter; 1 is the exit status of what was found to be wrong.

    What the first run has translated into byte code is kept, as it is for whoever starts a command twice.
    """
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}

    def run():
        done = subprocess.run([sys.executable, *words], capture_output=True, text=True, env=environment)
        assert done.returncode in (0, 1), done.stderr

    return run


def run():
    print("starting, of importing sympy in a fresh interpreter:")
    with tempfile.TemporaryDirectory() as folder:
        lines = [fresh("-m", "mathpost", *line.format(folder).split()) for line in SHELL]
        calls = [fresh("-c", "pass"), fresh("-c", "import sympy"), fresh("-c", "import mathpost"), *lines]
        nothing, sympy, package, *times = interleaved(*calls, repeats=5, clock=time.perf_counter)
    row("import mathpost, without the interpreter", (package - nothing) / sympy, 0.1, "import sympy")
    for line, taken in zip(SHELL, times, strict=True):
        row(line[:50], taken / sympy, SHELL[line], "import sympy")
    taken = {path.stem: derived(path) for path in sorted(Path("data/machines").glob("*.toml"))}
    slowest = max(taken, key=taken.get)
    row(f"{slowest}: read, derived, compiled, the slowest machine", taken[slowest] / sympy, 1, "import sympy")


def derived(path):
    """Seconds in which a machine is read, derived and compiled, with nothing kept."""
    for kept in (formula.numeric, kinematics.derive, chain.links, chain.bodies):
        kept.cache_clear()
    start = time.perf_counter()
    kin = kinematics.Kinematics(load_machine(path))
    kin.inverse(*kin.forward(np.zeros((1, len(kin.symbols)))))
    return time.perf_counter() - start

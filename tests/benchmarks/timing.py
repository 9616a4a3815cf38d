"""What every benchmark needs: the best of several runs, a table, and what machine this is."""

import os
import platform
import time
from pathlib import Path

import numpy as np

QUIET = 1.25  # above it a row has no verdict
_loops = []  # seconds of the processor that the loop of `strain` took, in this run


def best(function, repeats=5, clock=time.process_time):
    """Shortest time of several calls, in seconds: what disturbs a call only makes it longer.

    By default the processor's time of this process, so that others who use the machine do not count.
    """
    times = []
    for _ in range(repeats):
        start = clock()
        function()
        times.append(clock() - start)
    return min(times)


def interleaved(*functions, repeats=5, clock=time.process_time):
    """Shortest time of each function, called in turn, so that a busy spell meets all of them alike."""
    rounds = [[best(function, 1, clock) for function in functions] for _ in range(repeats)]
    return np.min(rounds, axis=0)


def peak_memory(function):
    """Bytes that NumPy and Python allocate during a call, at most, without its result."""
    import tracemalloc

    function()  # what is compiled once and kept is not counted
    tracemalloc.start()
    result = function()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak - getattr(result, "nbytes", 0)


def computer():
    """Processor, cores and versions, in one line."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [
            line.partition(":")[2].strip()
            for line in info.read_text(encoding="utf-8").splitlines()
            if "model name" in line
        ]
        model = names[0] if names else model
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}, NumPy {np.__version__}"


def strain(repeats=3):
    """How busy the machine is, and how much slower its processor is than at its fastest in this run; 1 is best.

    A loop that always does the same is timed by the clock and by the processor's time of this process.
    """
    clocks = time.perf_counter, time.process_time
    shares = []
    for _ in range(repeats):
        start = [clock() for clock in clocks]
        sum(range(1_000_000))
        passed, used = (clock() - began for clock, began in zip(clocks, start, strict=True))
        shares.append((passed / used, used))
    busy, used = np.median(shares, axis=0)
    _loops.append(used)
    return busy, used / min(_loops)


def row(what, ratio, target, against):
    """Print one line of the report; a busy or slowed machine gets no verdict."""
    busy, slowed = strain()
    verdict = "" if target is None else ("reached" if ratio <= target else "SHORT")
    if target is not None and max(busy, slowed) > QUIET:
        verdict = f"no verdict: busy {busy:.2f}, slowed {slowed:.2f}"
    limit = "" if target is None else f"≤ {target:g}"
    print(f"  {what:<58} {ratio:8.3f} {limit:>8}  {verdict:<8} of {against}", flush=True)

"""CL file to verified Heidenhain program, against a plain loop over the records and against text alone."""

import re
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from mathpost import load_machine
from mathpost import postprocess as post
from mathpost.files import write_text
from mathpost.machine import ENDLESS
from mathpost.path import cl
from tests.benchmarks import plain_loop
from tests.benchmarks.timing import interleaved, row

PART = 100_000  # records that are written to a CL file at a time


def write_cl(path, count):
    """A wavy path round a post, the tool leaning by 10 to 40 degrees, as plain GOTO lines."""
    with open(path, "w", encoding="utf-8") as file:
        for first in range(0, count, PART):
            turn = 2 * np.pi * np.arange(first, min(first + PART, count)) / 2000
            tilt, lead = np.radians(25 + 15 * np.sin(0.37 * turn)), 0.6 * np.sin(0.11 * turn)
            points = [40 * np.cos(turn), 40 * np.sin(turn), 5 * np.sin(turn / 20)]
            axes = [np.sin(tilt) * np.cos(lead), np.sin(tilt) * np.sin(lead), np.cos(tilt)]
            line = "GOTO/%.5f,%.5f,%.5f,%.6f,%.6f,%.6f\n"
            file.write(line * len(turn) % tuple(np.stack([*points, *axes], axis=1).ravel().tolist()))


def trunnion():
    """The machine of the plain loop: C endless, no linear limits."""
    data = load_machine("data/machines/ac_table.toml")
    return replace(data, linear=tuple(replace(axis, limits=ENDLESS) for axis in data.linear))


def whole(path, output):
    """What ``python -m mathpost post`` does."""
    write_text(output, post(cl.read(path), trunnion()).program)


def numpy_only(path, output):
    """Numbers into arrays and five columns out again, by the fastest means of NumPy."""
    text = path.read_text(encoding="utf-8").replace("GOTO/", "").replace("\n", ",")
    numbers = np.fromstring(text, sep=",").reshape(-1, 6)
    line = "L X%+.4f Y%+.4f Z%+.4f A%+.4f C%+.4f\n"
    output.write_text(line * len(numbers) % tuple(numbers[:, :5].ravel().tolist()))


def arrow_only(path, output):
    """The same by those of pyarrow on one core, without names before the numbers."""
    import pyarrow as pa
    from pyarrow import csv

    pa.set_cpu_count(1)
    text = pa.py_buffer(path.read_bytes().replace(b"GOTO/", b""))
    options = csv.ReadOptions(autogenerate_column_names=True, use_threads=False)
    table = csv.read_csv(pa.BufferReader(text), read_options=options)
    rounded = [np.round(table.column(n).to_numpy(), 4) for n in range(5)]
    csv.write_csv(pa.table(rounded, names=list("XYZAC")), output)


def peak_memory(count, folder):
    """MiB that a process of its own holds at most while it makes a program of so many records; on Linux."""
    path = Path(folder, f"{count}.cl")
    write_cl(path, count)
    code = (
        "import re, sys; from pathlib import Path; from tests.benchmarks.pipeline import whole; "
        "whole(Path(sys.argv[1]), Path(sys.argv[2])); "
        "print(re.search(r'VmHWM:\\s+(\\d+) kB', Path('/proc/self/status').read_text())[1])"
    )
    command = [sys.executable, "-c", code, path, Path(folder, "peak.h")]
    return int(subprocess.run(command, capture_output=True, text=True, check=True).stdout) / 1024


def against_plain_loop(path, output, count):
    write_cl(path, count)
    text = path.read_text(encoding="utf-8")
    whole(path, output)
    words = re.compile(r"[XYZAC][-+][0-9.]+")
    programs = output.read_text(encoding="utf-8"), plain_loop.post(text)
    mine, theirs = (np.array([float(word[1:]) for word in words.findall(program)]) for program in programs)
    assert len(mine) == len(theirs) and np.abs(mine - theirs).max() < 2e-4
    mine, loop = interleaved(lambda: whole(path, output), lambda: plain_loop.post(text), repeats=2)
    row(f"{count} records", mine / loop, 0.2, "plain loop over the records")


def against_text_alone(path, output, count):
    write_cl(path, count)
    floors = [("NumPy", numpy_only)]
    try:
        import pyarrow

        floors.append((f"pyarrow {pyarrow.__version__}", arrow_only))
    except ImportError:
        print("  pyarrow is not installed, skipped: pip install pyarrow")
    calls = [lambda floor=floor: floor(path, output) for _, floor in floors]
    mine, *alone = interleaved(lambda: whole(path, output), *calls, repeats=3)
    for (name, _), floor in zip(floors, alone, strict=True):
        row(f"{count} records", mine / floor, 3, f"text to arrays and numbers to text, {name}")


def run():
    with tempfile.TemporaryDirectory() as folder:
        path, output = Path(folder, "path.cl"), Path(folder, "path.h")
        print("end to end, GOTO records in a file to a file with a verified Heidenhain program:")
        against_plain_loop(path, output, 100_000)
        for count in (100_000, 1_000_000):
            against_text_alone(path, output, count)
        for count in (100_000, 1_000_000, 3_000_000):
            row(f"memory of {count} records, in a process of its own", peak_memory(count, folder) / 954, 1, "1 GB")

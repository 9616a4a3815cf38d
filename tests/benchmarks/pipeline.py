"""CL file to verified Heidenhain program, against a plain loop over the records and against text in and out."""

import re
from dataclasses import replace

import numpy as np

from mathpost import cldata, machine, postprocess
from mathpost.machine import ENDLESS
from tests.benchmarks import plain_loop
from tests.benchmarks.timing import interleaved, peak_memory, row


def cl_text(count):
    """A wavy path round a post, the tool leaning by 10 to 40 degrees, as plain GOTO lines."""
    turn = 2 * np.pi * np.arange(count) / 2000
    tilt, lead = np.radians(25 + 15 * np.sin(0.37 * turn)), 0.6 * np.sin(0.11 * turn)
    points = [40 * np.cos(turn), 40 * np.sin(turn), 5 * np.sin(turn / 20)]
    axes = [np.sin(tilt) * np.cos(lead), np.sin(tilt) * np.sin(lead), np.cos(tilt)]
    line = "GOTO/%.5f,%.5f,%.5f,%.6f,%.6f,%.6f\n"
    return line * count % tuple(np.stack([*points, *axes], axis=1).ravel().tolist())


def trunnion():
    """The machine of the plain loop: C endless, no linear limits."""
    data = machine.load("data/machines/ac_table.toml")
    return replace(data, linear=tuple(replace(axis, limits=ENDLESS) for axis in data.linear))


def whole(text, setup):
    """What `python -m mathpost post` does between reading and writing the files, without the comparison."""
    return postprocess.run(cldata.parse(text, "path.cl"), setup, compare=False)


def text_only(text):
    """Numbers into arrays and five columns out again, by the fastest means of NumPy: no post-processor beats it."""
    numbers = np.fromstring(text.replace("GOTO/", "").replace("\n", ","), sep=",").reshape(-1, 6)
    return "L X%+.4f Y%+.4f Z%+.4f A%+.4f C%+.4f\n" * len(numbers) % tuple(numbers[:, :5].ravel().tolist())


def run(count=100_000):
    text, setup = cl_text(count), trunnion()
    result, plain = whole(text, setup), plain_loop.post(text)
    words = re.compile(r"[XYZAC][-+][0-9.]+")
    numbers = [np.array([float(word[1:]) for word in words.findall(code)]) for code in (result.program, plain)]
    assert len(numbers[0]) == len(numbers[1]) and np.abs(numbers[0] - numbers[1]).max() < 2e-4
    print(f"end to end, {count} GOTO records to a verified Heidenhain program:")
    mine, loop, floor = interleaved(
        lambda: whole(text, setup), lambda: plain_loop.post(text), lambda: text_only(text), repeats=3
    )
    row("end to end", mine / loop, 0.2, "plain loop over the records")
    row("end to end", mine / floor, 3, "text to arrays and numbers to text, NumPy")
    row("memory for each record", peak_memory(lambda: whole(text, setup)) / count / 1024, None, "1 KiB")

"""Whole programs of drawn jobs, read by the independent reader: no rapid or user's move meets anything unsaid."""

import numpy as np
import pytest

from mathpost import machine_file, postprocess
from mathpost.errors import MathpostError
from mathpost.path import cl
from mathpost.shop.controls.coordinates import Setup
from mathpost.shop.post.verify import verify

from . import drawn

# Why a job is refused: its own line or its safe position is too low, travel ends, a way from there is not clear.
REASONS = ("[program] ", "is not above", "outside", "no solution", "on its way there", "out of reach")


def verdict(seed):
    """What came of a job: "refused", "clear", or "said", if the CL data's own rapid moves meet something."""
    job = drawn.drawn(seed)
    path, setup = cl.parse(job.text, "job.cl"), machine_file.from_dict(job.content)
    try:
        result = postprocess(path, setup, dialect=job.control, tcp=job.tcp)
    except MathpostError as error:
        assert any(why in str(error) for why in REASONS), (seed, str(error))
        return "refused"
    lengths = {str(tool): length for tool, length in drawn.LENGTHS.items()}
    judged = verify(result.program, setup, job.control, cl=path, setup=Setup(lengths=lengths))
    assert judged.along.off is None and not judged.outside and not judged.hits, (seed, str(judged))
    found = drawn.hits(job, result.program, np.random.default_rng(seed))
    said = any("meets" in warning for warning in result.report.warnings)
    assert said or not found, (seed, found)
    lines = {judged.line(block) for block in (*judged.unsure, *judged.unjudged)}
    missed = [hit for hit in found if hit[0] not in lines]
    assert not missed, (seed, missed)
    return "said" if said else "clear"


@pytest.mark.parametrize("seed", range(8))
def test_no_move_of_a_whole_program_meets_anything_unsaid(seed, of):
    """One of each machine, and of each control; of all 200."""
    for each in of([9 * seed], range(seed, 200, 8)):
        assert verdict(each) in ("refused", "clear", "said")


def test_a_lower_safe_position_is_seen():
    """The judge sees what a program does whose lines go through the stock."""
    job = drawn.drawn(2)
    result = postprocess(cl.parse(job.text, "job.cl"), machine_file.from_dict(job.content), dialect=job.control)
    assert not drawn.hits(job, result.program, np.random.default_rng(0))
    lower = result.program.replace("L Z+390 R0 FMAX M91\n", "L X+0 Y+0 R0 FMAX M91\nL Z+10 R0 FMAX M91\n")
    assert lower != result.program and drawn.hits(job, lower, np.random.default_rng(0))

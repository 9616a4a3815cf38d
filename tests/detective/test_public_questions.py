"""Questions that people asked in public, in their numbers or our own: the next one is one more line of the table.

`source` is the thread, by project and number; answers were computed with SciPy or by hand, not with the package.
`answer` must be said, in the first line where `in_line` is 1. The lines of a `program` are parted by strokes.
"""

import csv
from pathlib import Path

import pytest

from mathpost.interface.shell.main import main

with open(Path(__file__).with_name("public_questions.csv"), encoding="utf-8", newline="") as file:
    QUESTIONS = list(csv.DictReader(file))


def test_each_names_where_it_was_asked():
    assert len(QUESTIONS) >= 120 and len({row["source"] for row in QUESTIONS}) == len(QUESTIONS)
    assert all("#" in row["source"] or ", " in row["source"] for row in QUESTIONS)


@pytest.mark.parametrize("row", QUESTIONS, ids=lambda row: row["source"])
def test_a_public_question(row, tmp_path, capsys):
    program = tmp_path / "question.nc"
    program.write_text(row["program"].replace("/", "\n"))
    words = [str(program) if word == "PROGRAM" else word for word in row["arguments"].split()]
    assert main(words) == int(row["status"])
    said = capsys.readouterr().out
    assert row["answer"] in (said.splitlines()[0] if row["in_line"] else said), row["question"]

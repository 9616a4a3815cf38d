"""Running a lesson anew: what changed is said, and nothing is written unless it was accepted."""

import os
import signal
import subprocess
import sys

import nbformat
import psutil
import pytest

from mathpost.errors import InputError, MathpostError
from mathpost.interface.shell.main import main
from mathpost.teaching.classroom import lessons
from tests.conftest import ROOT


def notebook(path, *sources):
    """Write a notebook, run it, and return its path."""
    cells = [nbformat.v4.new_code_cell(source) for source in sources]
    nbformat.write(nbformat.v4.new_notebook(cells=cells), path)
    lessons.rerun(path, accept=True)
    return path


def replaced(path, old, new):
    path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")


def test_a_changed_number_is_named_with_its_cell_and_written_only_if_accepted(tmp_path, capsys):
    path = notebook(tmp_path / "lesson.ipynb", "seconds = 60", "print(f'{2 * seconds} s for {seconds} s')")
    assert lessons.rerun(path) == []
    replaced(path, "seconds = 60", "seconds = 6")
    before = path.read_bytes()
    assert lessons.rerun(path) == ["  cell 2: 120 → 12", "  cell 2: 60 → 6"]
    assert main(["lessons", "rerun", str(path)]) == 1 and path.read_bytes() == before
    assert "cell 2: 120 → 12" in capsys.readouterr().out
    assert main(["lessons", "rerun", "--accept", str(path)]) == 0
    assert lessons.rerun(path) == []


def test_a_changed_picture_is_named(tmp_path):
    draw = (
        "from mathpost.teaching.draw import plot\n_, axes = plot.figure()\naxes.plot([0, 1], [0, 2])\nplot.show()"
    )
    path = notebook(tmp_path / "lesson.ipynb", draw)
    replaced(path, "[0, 2]", "[0, 3]")
    changes = lessons.rerun(path)
    assert changes and {change.split(": ")[1] for change in changes} == {"2 → 3"}


def test_a_cell_that_raises_changes_nothing(tmp_path):
    path = notebook(tmp_path / "lesson.ipynb", "1 + 1")
    replaced(path, "1 + 1", "1 / 0")
    before = path.read_bytes()
    with pytest.raises(MathpostError, match="ZeroDivisionError: division by zero"):
        lessons.rerun(path, accept=True)
    assert path.read_bytes() == before
    with pytest.raises(InputError, match="a notebook"):
        lessons.rerun(tmp_path / "none.ipynb")


@pytest.mark.skipif(os.name != "posix", reason="signals are those of Linux and macOS")
def test_a_signal_ends_a_run_with_one_line_and_its_kernel(tmp_path):
    path = notebook(tmp_path / "lesson.ipynb", "1 + 1")
    os.mkfifo(tmp_path / "runs")
    replaced(path, "1 + 1", "import os, time; open('runs', 'w').write(str(os.getpid())); time.sleep(600)")
    command = [sys.executable, "-m", "mathpost", "lessons", "rerun", str(path)]
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as running:
        kernel = psutil.Process(int((tmp_path / "runs").read_text()))
        running.send_signal(signal.SIGTERM)
        _, said = running.communicate()
    assert running.returncode == 130 and said == "mathpost: stopped, no file is half written\n"
    kernel.wait(timeout=300)


@pytest.mark.parametrize(
    ("text", "other", "alike"),
    [
        ("x = 1.0000000001", "x = 1", True),
        ("x = 1.00000001", "x = 1", False),
        ("x = 1", "y = 1", False),
        ("1e-14 mm", "0 mm", True),
        ("-1", "1", False),
        ("a1 b2", "a1 b3", False),
    ],
)
def test_numbers_by_tolerance_and_words_as_they_are(text, other, alike):
    assert lessons.same(text, other) is alike

"""Notebooks that are run: what a stranger's program can do there, and that nothing runs as root."""

import json
import os
import sys

import psutil
import pytest

from mathpost.classroom.grade import grade
from mathpost.classroom.rerun import UID, Place
from mathpost.course import exercise
from mathpost.errors import InputError
from tests.classroom.test_grade import LESSON, cell, forged, write


@pytest.fixture(scope="module")
def place():
    """The bounds; skipped where this Python can only be run by root."""
    try:
        return Place(seconds=90)
    except InputError as error:
        assert sys.platform != "linux" or os.getuid() == 0, "an ordinary account is never refused"
        pytest.skip(f"does not apply to this account: {error}")


def run(place, folder, *sources):
    """The outputs of the cells as text."""
    cells = [cell(source) | {"id": f"c{number}"} for number, source in enumerate(sources)]
    write(folder / "in.ipynb", {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5})
    executed = json.loads(place(folder / "in.ipynb").read_text(encoding="utf-8"))
    return [
        "".join("".join(o.get("text", o.get("ename", ""))) for o in each["outputs"]) for each in executed["cells"]
    ]


def test_what_a_strangers_program_cannot_do(place, tmp_path):
    (tmp_path / "secret").write_text("teacher's")
    os.chmod(tmp_path / "secret", 0o600)
    connect = "import socket; socket.create_connection(('127.0.0.1', 22), 2)"
    look = f"print(open({str(tmp_path / 'secret')!r}).read())"
    environment = "import os; print(os.getuid(), 'SECRET' in os.environ)"
    os.environ["SECRET"] = "token"
    try:
        said = run(place, tmp_path, "b = bytes(3 * 2**30)", connect, look, environment)
    finally:
        del os.environ["SECRET"]
    assert said[0] == "MemoryError" and said[3].split()[1] == "False"
    assert "OSError" in said[1] or "The network was open." in place.open
    if os.getuid() == 0:
        assert said[2] == "PermissionError" and said[3].split()[0] == str(UID)
    else:
        assert any("your own account" in said for said in place.open)


def test_what_goes_on_too_long_is_stopped_with_all_it_started(place, tmp_path):
    mark = f"while True: pass  # {tmp_path.name}"
    start = f"import subprocess, sys; subprocess.Popen([sys.executable, '-c', {mark!r}], start_new_session=True)"
    short = Place(seconds=25)
    with pytest.raises(InputError, match="within 25 s"):
        run(short, tmp_path, start, "while True: pass")
    if "unshare" in short.command:
        left = [each for each in psutil.process_iter(["cmdline"]) if mark in (each.info["cmdline"] or [])]
        assert not psutil.wait_procs(left, timeout=10)[1]


def test_a_forged_answer_shows(place, tmp_path):
    page = forged([("01-sign", [-4, 3, 5])])
    page["cells"][0]["outputs"][0]["data"]["application/vnd.mathpost+json"]["answer"] = [4, -3, 5]
    page["cells"][0]["source"] = 'from mathpost.course import exercise\nexercise.check("01-sign", [-4, 3, 5])'
    write(tmp_path / "eve" / f"{LESSON}.ipynb", page)
    (eve,) = grade(tmp_path, rerun=place).results
    assert eve.status("01-sign") == exercise.RIGHT and not eve.edited, "without running, this cannot be seen"
    assert eve.reran == {"01-sign": exercise.WRONG}

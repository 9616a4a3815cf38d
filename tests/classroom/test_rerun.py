"""Notebooks that are run: what a stranger's program can do there, and that nothing runs as root."""

import ast
import json
import os
import subprocess
import sys
import tempfile

import psutil
import pytest

from mathpost.classroom import apart
from mathpost.classroom.grade import grade
from mathpost.classroom.rerun import UID, Place
from mathpost.course import exercise
from mathpost.errors import InputError
from tests.classroom.test_grade import LESSON, cell, forged, write


@pytest.fixture(scope="module")
def place():
    """The bounds; skipped where this Python can only be run by root."""
    try:
        return Place()
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


LEAVE = """
import ctypes, os
for folder in ("/tmp", "/var/tmp", "/dev/shm"):
    open(f"{folder}/mathpost-left", "w").write("left")
segment = ctypes.CDLL(None).shmget(0x6d617468, 4096, 0o1666)
print("left", segment)
"""
FIND = """
import ctypes, os
print([f for f in ("/tmp", "/var/tmp", "/dev/shm") if os.path.exists(f"{f}/mathpost-left")])
print(ctypes.CDLL(None).shmget(0x6d617468, 4096, 0o666))
"""
ATTACKS = {
    "memory": "b = bytes(3 * 2**30)",
    "shared memory": "import mmap; m = mmap.mmap(-1, 5 * 2**30)",
    "files of shared memory": """
import os
for n in range(40):
    f = open(f"/dev/shm/{n}", "wb"); os.posix_fallocate(f.fileno(), 0, 60 * 2**20)
""",
    "processes": """
import os, time
children = []
try:
    while len(children) < 1000:
        child = os.fork()
        if not child:
            time.sleep(60), os._exit(0)
        children.append(child)
finally:
    for child in children:
        os.kill(child, 9), os.waitpid(child, 0)
""",
    "network": "import socket; socket.create_connection(('127.0.0.1', 22), 2)",
    "a file of the teacher's": "print(open({secret!r}).read())",
    "files elsewhere": """
import os
found = []
for folder, folders, _ in os.walk("/"):
    folders[:] = [f for f in folders if f not in ("proc", "sys", "dev") and folder.count("/") < 4]
    if os.access(folder, os.W_OK):
        found.append(folder)
print(sorted(found))
""",
    "seen": "import os; print(sum(name.isdigit() for name in os.listdir('/proc')))",
    "environment": "import os; print(os.getuid(), 'SECRET' in os.environ)",
}


@pytest.fixture(scope="module")
def said(place, tmp_path_factory):
    """What a stranger's cells print or raise, by what they try."""
    folder = tmp_path_factory.mktemp("strange")
    (folder / "secret").write_text("teacher's", encoding="utf-8")
    os.chmod(folder / "secret", 0o600)
    cells = [source.replace("{secret!r}", repr(str(folder / "secret"))) for source in ATTACKS.values()]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SECRET", "token")
        return dict(zip(ATTACKS, run(place, folder, *cells), strict=True))


def test_memory_is_bounded_private_and_shared(said, place):
    assert said["memory"] == "MemoryError" and said["shared memory"] == "OSError"
    assert said["files of shared memory"] == "OSError" or not place.apart


def test_all_processes_are_bounded_together(said, place):
    if place.root:
        assert said["processes"] == "BlockingIOError"
    else:
        assert any("number of processes" in each for each in place.open)


def test_there_is_no_network(said, place):
    assert "OSError" in said["network"] or not place.apart


def test_the_teachers_files_and_secrets_stay_closed(said, place):
    uid, secret = said["environment"].split()
    assert secret == "False" and int(uid)
    if place.root:
        assert said["a file of the teacher's"] in ("PermissionError", "FileNotFoundError") and int(uid) == UID
    else:
        assert any("your own account" in each for each in place.open)


def test_nothing_else_can_be_written(said, place):
    if place.apart:
        found = ast.literal_eval(said["files elsewhere"])
        private = ("/tmp", "/var/tmp", "/dev/shm")
        assert found and all(each.startswith(private) for each in found)


def test_the_systems_processes_are_not_seen(said, place):
    if place.apart and not any("could be seen" in each for each in place.open):
        assert int(said["seen"]) < 20


def test_what_one_notebook_leaves_the_next_does_not_find(place, tmp_path):
    if not place.apart:
        pytest.skip(f"does not apply to this system: {place.open}")
    assert run(place, tmp_path, LEAVE)[0].startswith("left") and run(place, tmp_path, FIND) == ["[]\n-1\n"]
    folders = ("/tmp", "/var/tmp", "/dev/shm")
    assert not [folder for folder in folders if os.path.exists(f"{folder}/mathpost-left")]


@pytest.mark.skipif(sys.platform != "linux", reason="control groups are Linux's")
@pytest.mark.parametrize("controllers", ["cpu memory pids", "cpu"])
def test_where_there_are_control_groups_all_processes_have_one(controllers, tmp_path, monkeypatch):
    """With a folder in the place of the kernel's: what is written there, and by whom."""
    (tmp_path / "cgroup.controllers").write_text(controllers, encoding="ascii")
    monkeypatch.setattr(apart, "GROUPS", tmp_path)
    with tempfile.TemporaryFile() as said:
        group = apart._group(apart.Options(memory=2**31, processes=100, said=said.fileno()))
        said.seek(0)
        told = said.read().decode()
    if "pids" in controllers:
        written = {path.name: path.read_text(encoding="ascii") for path in group.iterdir()}
        assert written == {"memory.max": "2147483648", "memory.swap.max": "0", "pids.max": "100"} and not told
    else:
        assert group is None and told == apart.NO_GROUP + "\n"


def test_what_goes_on_too_long_is_stopped_with_all_it_started(place, tmp_path, monkeypatch):
    """Time runs out here as soon as there is something to be stopped."""
    mark = f"while True: pass  # {tmp_path.name}"
    start = f"import subprocess, sys; subprocess.Popen([sys.executable, '-c', {mark!r}], start_new_session=True)"
    whole, started = subprocess.Popen.wait, []

    def wait(process, timeout=None):
        while timeout and not started:
            assert process.poll() is None
            started.extend(
                each for each in psutil.process_iter(["cmdline"]) if mark in (each.info["cmdline"] or [])
            )
        if timeout:
            raise subprocess.TimeoutExpired(mark, timeout)
        return whole(process)

    monkeypatch.setattr(subprocess.Popen, "wait", wait)
    with pytest.raises(InputError, match="within 300 s"):
        run(place, tmp_path, start, "while True: pass")
    assert not place.apart or not psutil.wait_procs(started, timeout=300)[1]


def test_a_forged_answer_shows(place, tmp_path):
    page = forged([("01-sign", [-4, 3, 5])])
    page["cells"][0]["outputs"][0]["data"]["application/vnd.mathpost+json"]["answer"] = [4, -3, 5]
    page["cells"][0]["source"] = 'from mathpost.course import exercise\nexercise.check("01-sign", [-4, 3, 5])'
    write(tmp_path / "eve" / f"{LESSON}.ipynb", page)
    (eve,) = grade(tmp_path, rerun=place).results
    assert eve.status("01-sign") == exercise.RIGHT and not eve.edited, "without running, this cannot be seen"
    assert eve.reran == {"01-sign": exercise.WRONG}

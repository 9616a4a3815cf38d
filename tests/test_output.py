"""What a command writes destroys nothing; stopped, it leaves nothing behind; strange input is refused."""

import os
import signal
import subprocess
import sys
import tomllib
from functools import partial

import numpy as np
import pytest

from mathpost import files, load_machine, machine_file
from mathpost.errors import InputError, OutputError
from mathpost.files import write_bytes
from mathpost.interface.shell.main import COMMANDS, main
from mathpost.path import cl
from tests.conftest import DATA, ROOT

posix = pytest.mark.skipif(os.name != "posix", reason="pipes, modes and signals are those of Linux and macOS")
POST = ["post", "--machine", str(DATA / "machines/dmu50v.toml")]


@pytest.fixture
def part(tmp_path):
    (tmp_path / "part.cl").write_bytes((DATA / "cl/blade.cl").read_bytes())
    return tmp_path / "part.cl"


def test_an_input_is_not_replaced(part, capsys):
    before = part.read_bytes()
    link = part.with_name("link.h")
    link.symlink_to(part)
    for output in (part, link):
        assert main([*POST, str(part), "-o", str(output)]) == 2
        assert "one of the files that are read" in capsys.readouterr().err
    assert part.read_bytes() == before and sorted(p.name for p in part.parent.iterdir()) == ["link.h", "part.cl"]


@posix
def test_a_device_or_a_pipe_is_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", os.devnull, tmp_path):
        with pytest.raises(OutputError, match="no regular file"):
            write_bytes(path, b"new")
    assert [p.name for p in tmp_path.iterdir()] == ["pipe"]


@posix
def test_a_link_is_followed_and_the_mode_is_kept(tmp_path):
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_bytes(b"old")
    target.chmod(0o640)
    link.symlink_to(target)
    write_bytes(link, b"new")
    assert link.is_symlink() and target.read_bytes() == b"new" and target.stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() == 0, reason="does not apply: root may write anywhere")
def test_a_file_that_is_read_only_stays(tmp_path):
    (tmp_path / "old").write_bytes(b"old")
    (tmp_path / "old").chmod(0o444)
    with pytest.raises(OutputError, match="Permission"):
        write_bytes(tmp_path / "old", b"new")


def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch):
    (tmp_path / "old").write_bytes(b"old")
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(OutputError, match="No space left"):
        write_bytes(tmp_path / "old", b"new")
    assert [p.name for p in tmp_path.iterdir()] == ["old"] and (tmp_path / "old").read_bytes() == b"old"


@posix
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_with_one_line(number, tmp_path):
    """The command waits for CL data from a pipe that nobody writes."""
    os.mkfifo(tmp_path / "part.cl")
    command = [sys.executable, "-m", "mathpost", *POST, str(tmp_path / "part.cl"), "-o", str(tmp_path / "out.h")]
    # A shell that runs the tests in the background has told them to ignore the interrupt; the command is not to.
    heed = partial(signal.signal, number, signal.SIG_DFL)
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True, preexec_fn=heed) as running:
        handle = os.open(tmp_path / "part.cl", os.O_WRONLY)  # returns as soon as the command reads
        running.send_signal(number)
        os.close(handle)  # should the read begin only now, it ends, and the signal is there
        _, said = running.communicate()
    assert running.returncode == 130 and said == "mathpost: stopped, no file is half written\n"
    assert [p.name for p in tmp_path.iterdir()] == ["part.cl"]


def interrupted(command, library, source, folder):
    """What a command says, and its status, whose library's source raises a signal while it is loaded."""
    (folder / library).mkdir()
    (folder / library / "__init__.py").write_text(f"from signal import *\n{source}", encoding="utf-8")
    ended = subprocess.run(
        [sys.executable, "-m", "mathpost", *command, "--help"],
        cwd=folder, env=os.environ | {"PYTHONPATH": f"{folder}{os.pathsep}{ROOT}"}, stderr=subprocess.PIPE,
        text=True, preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    return ended.stderr, ended.returncode


@posix
@pytest.mark.parametrize("command", COMMANDS)
def test_a_signal_ends_every_command_while_it_starts(command, tmp_path):
    library = "argparse" if command == "lessons" else "numpy"  # that one loads no other, and this is loaded first
    said, status = interrupted([command], library, "raise_signal(SIGINT)", tmp_path)
    assert status == 130 and said == "mathpost: stopped, no file is half written\n"


@posix
@pytest.mark.parametrize("swallowed_by", ["ImportError('no such module')", "MemoryError", "SystemExit(3)"])
def test_a_signal_that_a_library_turns_into_an_error_is_still_one(swallowed_by, tmp_path):
    source = f"try: raise_signal(SIGTERM)\nexcept BaseException: raise {swallowed_by} from None"
    said, status = interrupted(["show"], "sympy", source, tmp_path)
    assert status == 130 and said == "mathpost: stopped, no file is half written\n"


WHILE_SAID = """import builtins
say = print
builtins.print = lambda *words, **how: (raise_signal(SIGINT), say(*words, **how))
"""
WHILE_TIDIED = """try:
    raise_signal(SIGTERM)
finally:
    raise_signal(SIGTERM)
    open("tidied", "w")
"""


@posix
def test_a_second_signal_disturbs_neither_tidying_nor_what_is_said(tmp_path):
    """As timeout(1) sends it, to the command and again to its group."""
    said, status = interrupted(["show"], "sympy", WHILE_SAID + WHILE_TIDIED, tmp_path)
    assert status == 130 and said == "mathpost: stopped, no file is half written\n"
    assert (tmp_path / "tidied").exists()


@posix
def test_a_signal_does_not_disturb_a_refusal(tmp_path):
    said, status = interrupted(["show"], "sympy", WHILE_SAID + "raise ModuleNotFoundError(name='sympy')", tmp_path)
    assert status == 2 and said == "mathpost: this command needs sympy, which comes with mathpost[course]\n"


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError(28, "No space left on device")])
@pytest.mark.parametrize("had", [b"old", None])
def test_of_a_set_of_files_all_are_written_or_none(error, had, tmp_path, monkeypatch):
    """Whatever comes while the last of three is moved into its place, two stand as they were before."""
    paths = [tmp_path / name for name in ("a", "b", "c")]
    if had:
        paths[0].write_bytes(had)
    move = os.replace

    def last(new, path):
        if path.name == "c":
            raise error
        move(new, path)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", last)
        with pytest.raises((OutputError, KeyboardInterrupt)):
            files.write_set(dict.fromkeys(paths, "new"))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == ({"a": had} if had else {})
    files.write_set(dict.fromkeys(paths, "new\udcff"))
    assert [path.read_bytes() for path in paths] == [b"new\\udcff"] * 3


def test_a_file_without_an_end_is_refused():
    with pytest.raises(InputError, match="/dev/zero: expected a file, found a device"):
        files.read_bytes("/dev/zero", most=2**20)


LARGE = 'name = "a"\nsource = "b"\n[[rotary]]\n[[rotary]]\n[workpiece]\norigin = [' + "9" * 400 + ", 0, 0]"


@pytest.mark.parametrize("text", [f"name = {'9' * 400}", f"name = {'9' * 5000}", "a = " + "[" * 3000, LARGE])
def test_strange_machine_files_are_refused(tmp_path, text):
    (tmp_path / "machine.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"machine\.toml"):
        load_machine(tmp_path / "machine.toml")


def test_a_tool_has_defaults():
    text = (DATA / "machines/ac_table.toml").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith(("length", "programmed_point"))]
    content = tomllib.loads("\n".join(lines))
    made = machine_file.from_dict(content)
    assert (made.tool_length, made.programmed_point) == (0.0, "tip")


@pytest.mark.parametrize(
    ("points", "axes", "words"),
    [
        (np.empty((0, 3)), np.empty((0, 3)), "at least one record"),
        (np.ma.masked_less([[1.0, 2, 3]], 2), [[0, 0, 1]], "masked"),
        ([[1e200, 0, 0]], [[0, 0, 1]], "below 1e"),
        ([[1, 2, 3]], [[0, 0, 1]] * 2, "the same shape"),
    ],
)
def test_strange_arrays_are_refused(points, axes, words):
    with pytest.raises(InputError, match=words):
        cl.from_arrays(points, axes)


def test_axes_of_any_length():
    axes = cl.from_arrays(np.zeros((3, 3)), [[0, 3e200, 4e200], [0, 3e-200, 4e-200], [0, 0, 2]]).axes
    np.testing.assert_allclose(axes, [[0, 0.6, 0.8], [0, 0.6, 0.8], [0, 0, 1]], atol=1e-15)


def test_an_error_that_nobody_foresaw_is_one_line_and_no_verdict(monkeypatch, capsys):
    """A traceback would end with status 1, which says "wrong"."""
    monkeypatch.setattr("mathpost.machine_file.load", lambda _: [][0])
    assert main(["pose", "bc_table", "--joints", "0", "0", "0", "0", "0"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(
        "mathpost: internal error, please report: IndexError: list index out of range (test_output"
    )
    assert said.count("\n") == 1


@posix
def test_names_of_two_lines_are_printed_as_one(tmp_path, capsys):
    for name, source in (
        ("cl", "cl/blade.cl"),
        ("csv", "measurements/ball_c_axis.csv"),
        ("xlsx", "workbooks/right.xlsx"),
    ):
        (tmp_path / f"two\nlines.{name}").write_bytes((ROOT / "data" / source).read_bytes())
    program = str(tmp_path / "pro\ngram.h")
    for command in (
        ["post", str(tmp_path / "two\nlines.cl"), "--machine", "dmu50v", "-o", program],
        ["verify", program, "--machine", "dmu50v"],
        ["calibrate", "ac_table", str(tmp_path / "two\nlines.csv")],
        ["check", str(tmp_path / "two\nlines.xlsx")],
        ["pose", str(tmp_path / "no\nmachine.toml"), "--axis", "0", "0", "1"],
    ):
        assert main(command) in (0, 1, 2)
    said = "".join(capsys.readouterr())
    assert said.count(r"two\nlines") >= 3 and r"pro\ngram" in said and r"no\nmachine" in said
    assert not any(line.startswith(("lines.", "gram.h", "machine.toml")) for line in said.splitlines())

"""Mutated inputs of every kind: a verdict or one line with a reason, no unforeseen error, nothing half written."""

import json
import random
import re
import zipfile

import pytest

from mathpost.errors import INTERNAL, OutputError
from mathpost.files import write_set
from mathpost.interface.shell.main import main
from tests.conftest import DATA

ODD = [
    "nan",
    "1e999",
    "-0",
    "9" * 400,
    "1e-320",
    "0",
    "-1",
    "1,5",
    "",
    "°",
    "\x00",
    "\ud83d",
    "１２",
    "=1+1",
    "[[",
    "]",
    '"',
    "$",
]


def mutated(text, line):
    """One to three changes of a text: lines, numbers, words and characters."""
    for _ in range(line.randint(1, 3)):
        lines, numbers = text.splitlines(keepends=True), list(re.finditer(r"[-+]?\d+\.?\d*", text))
        kind, at = line.randrange(9), line.randrange(max(len(lines), 1))
        place = line.randrange(len(text) + 1)
        if kind == 0:
            text = text[:place]
        elif kind == 1:
            text = "".join(lines[:at] + lines[at + 1 :])
        elif kind == 2:
            text = "".join(lines[:at] + lines[at : at + 1] * line.choice((2, 50)) + lines[at + 1 :])
        elif kind == 3:
            line.shuffle(lines)
            text = "".join(lines)
        elif kind == 4:
            text = text[:place] + text[place + line.randint(1, 9) :]
        elif kind == 5:
            text = text[:place] + line.choice(ODD) + text[place:]
        elif kind == 6:
            words = re.split(r"(\W+)", text)
            first, second = line.randrange(len(words)), line.randrange(len(words))
            words[first], words[second] = words[second], words[first]
            text = "".join(words)
        elif numbers:
            found = line.choice(numbers)
            text = text[: found.start()] + line.choice(ODD) + text[found.end() :]
    return text


BLADE, RIGHT, BOHEZ = "cl/blade.cl", "workbooks/right.xlsx", "errors/bohez_machine.toml"
POST, OUT = ["post", BLADE, "--machine"], ["-o", "OUT"]
PROGRAM = """%
O0001
G21 G17 G90 G54
G43.4 H1
G1 X-36.7809 Y-68.5751 Z66.1338 B11.8172 C175.8146 F600
X-30. B5.
G49
M30
%
"""
TASK = """kind = "sequence"
sequence = "ZXZ"
convention = "passive"
angles = [1, 2, 3]
"""
RULES = """students = ["ada"]
exercises = ["05"]
[points]
"05" = 2
"""
ANSWER = {"text/plain": "01-sign", "application/vnd.mathpost+json": {"answer": [1, 0, 0]}}
SHOWN = {"output_type": "display_data", "metadata": {}, "data": ANSWER}
CHECK = {"cell_type": "code", "source": ['exercise.check("01-sign", answer)'], "metadata": {}, "outputs": [SHOWN]}
NOTEBOOK = json.dumps({"cells": [CHECK], "metadata": {}, "nbformat": 4, "nbformat_minor": 5})
KINDS = {  # the file that is mutated, its text or where it is, and the command with FILE in its place
    "CL data": ("part.cl", BLADE, ["post", "FILE", "--machine", "dmu50v", *OUT]),
    "machine, post": ("m.toml", "machines/dmu50v.toml", [*POST, "FILE", *OUT]),
    "machine, pose": ("m.toml", "machines/bc_table.toml", ["pose", "FILE", "--axis", "0", "1", "1"]),
    "control": ("c.toml", "controls/fanuc.toml", [*POST, "dmu50v", "--dialect", "FILE", *OUT]),
    "errors": ("e.toml", "errors/bohez.toml", [*POST, BOHEZ, "--errors", "FILE", *OUT]),
    "program": ("p.nc", PROGRAM, ["verify", "FILE", "--machine", "dmu50v", "--dialect", "fanuc", "--cl", BLADE]),
    "readings": ("r.csv", "measurements/ball_c_axis.csv", ["calibrate", "ac_table", "FILE", *OUT]),
    "vectors": ("v.csv", "measurements/five_face_head.csv", ["head", "FILE", "--at", "45"]),
    "task": ("t.toml", TASK, ["check", RIGHT, "--task", "FILE"]),
    "plane": ("none", "G68.2 X0 Y0 Z0 I135 J54.7356 K-90", ["plane", "TEXT"]),
    "notebook": ("in/a.ipynb", NOTEBOOK, ["grade", "FOLDER", *OUT]),
    "rules": ("rules.toml", RULES, ["grade", "in", *OUT, "--rules", "FILE"]),
    "workbook": ("w.xlsx", "", ["check", "FILE", "--marked", "OUT"]),
}


def spoiled_workbook(path, line):
    """A workbook with one part of it mutated as text, or its bytes cut or changed."""
    source = DATA / "workbooks" / line.choice(("right.xlsx", "lucky.xlsx"))
    if line.random() < 0.2:
        content = bytearray(source.read_bytes())
        for _ in range(line.randint(1, 20)):
            content[line.randrange(len(content))] = line.randrange(256)
        path.write_bytes(content[: line.choice((len(content), line.randrange(len(content))))])
        return
    with zipfile.ZipFile(source) as parts, zipfile.ZipFile(path, "w") as target:
        chosen = line.choice([name for name in parts.namelist() if "sheet" in name or "workbook" in name])
        for name in parts.namelist():
            text = parts.read(name)
            if name == chosen:
                text = mutated(text.decode(), line).encode("utf-8", "surrogatepass")
            target.writestr(name, text)


@pytest.mark.parametrize("kind", KINDS)
def test_a_mutated_input_is_judged_or_refused_in_a_line(kind, tmp_path, capsys, of):
    name, text, words = KINDS[kind]
    text = (DATA / text).read_text(encoding="utf-8") if "\n" not in text and (DATA / text).is_file() else text
    for seed in range(of(4, 240)):
        line, folder = random.Random(f"{kind} {seed}"), tmp_path / str(seed)
        (folder / "in").mkdir(parents=True)
        (folder / "in/ada.ipynb").write_text(NOTEBOOK, encoding="utf-8")
        path, said = folder / name, mutated(text, line)
        if text:
            path.write_bytes(said.encode("utf-8", "surrogatepass"))
        else:
            spoiled_workbook(path, line)
        places = {"FILE": path, "OUT": folder / "out", "FOLDER": path.parent, "in": folder / "in", "TEXT": said}
        shipped = {word: DATA / word for word in words if (DATA / word).is_file()}
        before = set(folder.rglob("*"))
        try:
            status = main([str((shipped | places).get(word, word)) for word in words])
        except SystemExit as error:  # argparse
            status = error.code
        told = capsys.readouterr().err
        assert status in (0, 1, 2) and INTERNAL not in told, f"{kind} {seed}: {told}"
        left = sorted(each.relative_to(folder).as_posix() for each in set(folder.rglob("*")) - before)
        assert status != 2 or kind in ("notebook", "workbook") or not left, f"{kind} {seed} left {left}: {told}"
        assert not any(re.search(r"(^|/)\.[^/]*\.[0-9a-f]{8}$", each) for each in left)


VERIFY = ["verify", "FILE", "--machine", str(DATA / "machines/ac_table.toml"), "--dialect", "fanuc"]


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        (PROGRAM, [*VERIFY, "--skip", ""], "--skip: expected words of the machine"),
        (PROGRAM, [*VERIFY, "--skip", "G43.4"], "a word that fanuc does not know"),
        ("G1 X\x1b[31m\x85\nQ\x07\n", VERIFY, r"\\x1b\[31M.*\\x07"),
        ("G0 X0 Y0 Z0 A0 C0\nG1 X" + "[" * 5000 + "1\n", VERIFY, "at most 50 brackets"),
        ("", ["plane", "G68.2KX0 Y0 Z0 I135 J54 K-90"], "then a blank"),
        ("", ["post", "/dev/zero", "--machine", "dmu50v"], "/dev/zero: expected a file, found a device"),
    ],
)
def test_what_an_attack_has_found_is_refused_in_a_line_that_a_terminal_shows_as_it_is(
    text, words, said, tmp_path, capsys
):
    path = tmp_path / "p.nc"
    path.write_text(text, encoding="utf-8")
    assert main([str(path) if word == "FILE" else word for word in words]) == 2
    told = capsys.readouterr().err
    assert re.search(said, told) and INTERNAL not in told
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]", told)


def test_a_command_whose_output_is_closed_says_so(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdout", None)
    assert main(["rotation", "zxz", "10", "20", "30"]) == 2
    assert capsys.readouterr().err == "mathpost: standard output: closed\n"


def test_an_empty_name_is_none(capsys):
    with pytest.raises(SystemExit):
        main(["grade", ".", "-o", ""])
    assert "expected a name, found an empty one" in capsys.readouterr().err


def test_a_set_that_cannot_be_written_leaves_no_folder(tmp_path):
    with pytest.raises(OutputError, match="not written"):
        write_set({tmp_path / "a/b/c": "text", tmp_path / ("x" * 300): ""}, folders=True)
    assert not list(tmp_path.iterdir())
    write_set({tmp_path / "a/b/c": "text"}, folders=True)
    assert (tmp_path / "a/b/c").read_text() == "text"


def test_a_folder_that_is_a_loop_or_a_device_is_no_class(tmp_path, capsys):
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for place in (tmp_path / "loop", "/dev/zero"):
        assert main(["grade", str(place), "-o", str(tmp_path / "o")]) == 2
        assert "expected a folder of what was handed in" in capsys.readouterr().err
    assert not list(tmp_path.glob("o.[ch]*"))

"""Panels driven as their user drives them, without a browser: set values, press, look at what is said."""

import argparse
import datetime
import functools
import io
import itertools
import re
import tempfile
import time
import zipfile
from pathlib import Path

import ipywidgets as widgets
import numpy as np
import openpyxl
import pytest

from mathpost.errors import InputError
from mathpost.interface import workbench
from mathpost.interface.shell import main, post
from mathpost.interface.workbench.panel import SENTENCE
from mathpost.interface.workbench.run import Made, parsed
from mathpost.path import cl
from mathpost.teaching.course.exercises.capstone import task
from tests.conftest import DATA

NOW = datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC)
GIVEN = {  # to a panel of each kind
    "post": dict(cl="blade.cl", machine="dmu50v.toml"),
    "check": dict(path="right.xlsx"),
    "calibrate": dict(machine="ac_table.toml", readings="ball_c_axis.csv"),
    "explain": dict(angles="1 2 3"),
    "pose": dict(machine="bc_table.toml"),
    "plane": dict(words="G68.2 I135 J54.7356 K-90"),
    "head": dict(vectors="five_face_head.csv"),
    "verify": dict(program="blade.h", machine="dmu50v.toml"),
}


@functools.cache
def panel_of(name):
    """The panel of a command, which no test changes."""
    return getattr(workbench, name)(**GIVEN[name])


def inside(widget):
    """All widgets of a panel."""
    yield widget
    for child in getattr(widget, "children", ()):
        yield from inside(child)


def uploaded(panel, name, files):
    """Upload files, by name, into an option."""
    panel[name].upload.value = [
        {"name": each, "type": "", "size": len(content), "content": memoryview(content), "last_modified": NOW}
        for each, content in files.items()
    ]


def said(panel):
    """The line under the buttons, without its colour, and the colour."""
    found = re.search(r'mathpost-said (\w*)" role="status">(.*)</div>', panel.said.value)
    return found[2], found[1]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path_factory, monkeypatch):
    """Folders of runs are where no other run has any."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path_factory.mktemp("runs")))


def left():
    """Folders of runs that are still there."""
    return set(Path(tempfile.gettempdir()).glob("mathpost-*"))


@pytest.mark.parametrize("name", GIVEN)
def test_every_control_has_a_label(name):
    controls = [
        each for each in inside(panel_of(name))
        if isinstance(each, widgets.ValueWidget) and not isinstance(each, widgets.HTML | widgets.FloatProgress)
    ]  # fmt: skip
    assert len(controls) >= 5 and all(each.description for each in controls)
    assert all(each.tabbable is not False for each in controls), "a key gets there"


@pytest.mark.parametrize("name", GIVEN)
def test_the_controls_begin_with_the_defaults_of_the_shell(name, tmp_path):
    """What the panel would run, against argparse's own defaults."""
    options = vars(parsed(panel_of(name).words(tmp_path)))
    command = argparse.ArgumentParser()
    main.import_module(f"mathpost.interface.shell.{name}").add_arguments(command)
    for action in command._actions:
        if action.option_strings and action.dest not in ("help", "machine", "compare", "angles"):
            as_given = [*action.default] if isinstance(action.default, tuple) else action.default or None
            assert (options[action.dest] or None) == as_given, action.dest


def test_an_option_that_is_new_in_the_shell_is_new_in_the_panel(monkeypatch, tmp_path):
    known = post.add_arguments

    def more(parser):
        known(parser)
        parser.add_argument("--coolant", choices=("off", "on"), help="while it cuts")

    monkeypatch.setattr(post, "add_arguments", more)
    panel = workbench.post(coolant="on")
    assert "while it cuts" in panel["coolant"].box.children[-1].value
    assert "--coolant=on" in panel.words(tmp_path)
    with pytest.raises(InputError, match="panel post: expected the options .*coolant.*, found coolnt"):
        workbench.post(coolnt="on")


def test_the_program_is_the_shells_byte_for_byte(tmp_path):
    """A CL file uploaded, B's travel changed: against the shell on a machine file that was changed by hand."""
    before = left()
    panel = workbench.post(machine="dmu50v.toml", compare=False)
    uploaded(panel, "cl", {"wing.cl": (DATA / "cl/blade.cl").read_bytes()})
    panel.axes.cells["B"]["from"].value = "-25"
    panel.start()
    panel.wait()
    text, colour = said(panel)
    assert colour == "right" and "27 lines, proved" in text, text
    by_hand = (
        (DATA / "machines/dmu50v.toml")
        .read_text(encoding="utf-8")
        .replace("limits = [0, 180]", "limits = [-25, 180]")
    )
    (tmp_path / "mine.toml").write_text(by_hand, encoding="utf-8")
    (tmp_path / "wing.cl").write_bytes((DATA / "cl/blade.cl").read_bytes())
    words = [
        "post",
        f"{tmp_path / 'wing.cl'}",
        "--machine",
        f"{tmp_path / 'mine.toml'}",
        "-o",
        f"{tmp_path / 'out'}",
    ]
    assert main.main(words) == 0
    assert "CL data      wing.cl, 5 records" in panel.files["report.txt"].decode()
    assert panel.files["wing.h"] == (tmp_path / "out").read_bytes()
    assert panel.files["dmu50v_changed.toml"].decode().replace("-25.0, 180.0", "-25, 180") == by_hand
    assert "No rotary axis jumps" in panel.found.children[1].children[1].value
    assert left() == before, "nothing is left of a run"


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("cl", "none.cl", "none.cl: expected a readable file"),
        ("tolerance", "a hair", "argument --tolerance: invalid float value: 'a hair'"),
        ("dialect", "abacus", "abacus"),
        ("tool_length", "-5", "tool length: expected mm, not negative, found -5"),
    ],
)
def test_what_is_wrong_is_one_line(name, value, expected, tmp_path):
    panel = workbench.post(cl="blade.cl", machine="dmu50v.toml")
    panel[name].field.value = value
    with pytest.raises(ValueError) as error:
        panel.work(parsed(panel.words(tmp_path)), lambda *said: None, tmp_path)
    assert expected in str(error.value) and "\n" not in str(error.value)


def test_a_wrong_number_of_an_axis_is_said_before_anything_runs():
    before = left()
    panel = workbench.post(cl="blade.cl", machine="dmu50v.toml")
    for axis, column, typed, expected in (
        ("B", "from", "zero", "B from, °: expected a number, or nothing"),
        ("C", "to", "90", "C from, to: expected both ends of the travel, or neither, found one"),
    ):
        cell = panel.axes.cells[axis][column]
        cell.value, was = typed, cell.value
        panel.start()
        text, colour = said(panel)
        assert colour == "wrong" and text.startswith(expected) and panel.thread is None
        cell.value = was
    assert left() == before


def test_rates_are_the_weights_of_the_selection(tmp_path):
    """Every choice of branches is tried here, of two times the slowest axis; a slow B lets C swing instead."""
    path = cl.read(DATA / "cl/blade.cl")
    tilt, azimuth = np.arccos(path.axes[:, 2]), np.arctan2(path.axes[:, 1], path.axes[:, 0])
    for rate, swings in ((60, False), (1.2, True)):
        panel = workbench.post(cl="blade.cl", machine="bc_table.toml", compare=False, axis_tolerance="10")
        panel.axes.cells["B"]["rate"].value = f"{rate}"
        (folder := tmp_path / str(rate)).mkdir()
        report = worked(panel, folder)[0].files["report.txt"].decode()
        costs = {}
        for signs in itertools.product((1, -1), repeat=len(path)):
            b, c = np.degrees(tilt * signs), np.degrees(azimuth) + 90 * (1 - np.array(signs))
            c_steps = np.abs((np.diff(c) + 180) % 360 - 180)
            costs[signs] = np.maximum(np.abs(np.diff(b)) / rate, c_steps / 120).sum()
        best = min(costs, key=costs.get)
        assert f"selection    optimal, cost {costs[best]:.3f} s" in report
        assert (len(set(best)) == 1) is swings


def test_numbers_of_axes_go_into_the_file_and_what_was_not_changed_stays(tmp_path):
    panel = workbench.post(cl="blade.cl", machine="head_b_table_c.toml")
    assert panel.axes.changed() is None
    panel.axes.cells["B"]["rate"].value = "12,5"
    panel.axes.cells["X"]["from"].value = panel.axes.cells["X"]["to"].value = ""
    changed = panel.axes.changed()
    panel.axes.show("changed", changed)
    assert panel.axes.stated["B"]["rate"] == 12.5 and panel.axes.stated["X"]["from"] is None
    text = (DATA / "machines/head_b_table_c.toml").read_text(encoding="utf-8")
    kept = set(text.splitlines()) - set(changed.splitlines())
    assert len(kept) == 2, "two lines are different"
    panel["machine"].field.value = "bc_table"
    assert panel.axes.cells["B"]["from"].value == "-35", "a different machine, different numbers"


def test_what_was_uploaded_is_used_until_something_else_is_typed(tmp_path):
    panel = workbench.post(cl="blade.cl", machine="dmu50v.toml")
    uploaded(panel, "cl", {"mine.cl": b"GOTO/0,0,0"})
    (path,) = panel["cl"].paths(tmp_path)
    assert path == tmp_path / "cl/mine.cl" and path.read_bytes() == b"GOTO/0,0,0"
    panel["cl"].field.value = "blade.cl"
    assert panel["cl"].paths(tmp_path)[0].samefile(DATA / "cl/blade.cl")


def test_a_machine_that_is_uploaded_again_shows_its_new_numbers():
    panel = workbench.post(cl="blade.cl")
    text = (DATA / "machines/dmu50v.toml").read_bytes()
    for low in (b"0", b"9"):
        uploaded(panel, "machine", {"mine.toml": text.replace(b"limits = [0, 180]", b"limits = [%s, 180]" % low)})
        assert panel.axes.cells["B"]["from"].value == low.decode()


@pytest.mark.parametrize(
    ("name", "inside"),
    [
        ("../../evil.cl", "evil.cl"),
        ("..\\C:\\evil.cl", "evil.cl"),
        ("a\nb\0.cl", "a_b_.cl"),
        ("刀位.cl", "刀位.cl"),
        ("..", "file"),
    ],
)
def test_the_name_of_a_file_stays_inside_its_folder(name, inside, tmp_path):
    panel = workbench.post(machine="dmu50v.toml")
    uploaded(panel, "cl", {name: b"1"})
    assert panel["cl"].paths(tmp_path) == [tmp_path / "cl" / inside] and (tmp_path / "cl" / inside).is_file()


def test_a_folder_comes_as_a_zip(tmp_path):
    """Beside a workbook; one that leads out of its folder is refused before anything runs."""
    content, before = io.BytesIO(), left()
    with zipfile.ZipFile(content, "w") as packed:
        packed.write(DATA / "workbooks/lucky.xlsx", "late/lucky.xlsx")
    files = {"class.zip": content.getvalue(), "right.xlsx": (DATA / "workbooks/right.xlsx").read_bytes()}
    panel = workbench.check()
    uploaded(panel, "path", files)
    made, _ = worked(panel, tmp_path)
    assert made.said == "2 workbooks: 1 right, 1 wrong"
    with zipfile.ZipFile(content, "w") as packed:
        packed.writestr("../evil.xlsx", b"")
    uploaded(panel, "path", {"class.zip": content.getvalue()})
    panel.start()
    text, colour = said(panel)
    assert colour == "wrong" and "path/class.zip: expected names inside" in text and left() == before


def goes_on(options, say, folder):
    """A work that has begun, and does not end."""
    say("cutting", 1, 2)
    time.sleep(3600)


def test_a_cancelled_run_ends_at_once_and_leaves_nothing():
    before = left()
    panel = workbench.post(cl="blade.cl", machine="dmu50v")
    panel.work = goes_on
    panel.start()
    while not panel.bar.value:  # it has begun
        panel.thread.join(0.05)
        assert panel.thread.is_alive(), panel.said.value
    assert panel.run.disabled and not panel.cancel.disabled
    panel.cancel.click()
    panel.wait()
    assert said(panel) == ("stopped: nothing is left of this run", "")
    assert not panel.running.process.is_alive() and left() == before
    assert panel.files == {} and not panel.run.disabled


def test_what_is_saved_replaces_nothing(tmp_path):
    panel = workbench.post()
    panel.show(Made("done", {"Report": "<pre>all</pre>"}, {"a.h": b"1\n", "b.txt": b"2\n"}))
    _, where, button, told = panel.found.children[0].children
    where.value = str(tmp_path)
    button.click()
    assert told.value == "2 written" and (tmp_path / "a.h").read_bytes() == b"1\n"
    (tmp_path / "a.h").write_bytes(b"mine")
    button.click()
    assert "a.h, b.txt: not written" in told.value and (tmp_path / "a.h").read_bytes() == b"mine"
    where.value = str(tmp_path / "none")
    button.click()
    assert "expected a folder" in told.value and not (tmp_path / "none").exists()


def test_without_python_a_panel_is_its_sentence(monkeypatch):
    shown = []
    monkeypatch.setattr("mathpost.interface.workbench.panel.display", lambda data, raw: shown.append(data))
    panel_of("post")._ipython_display_()
    sentence, view = shown
    assert SENTENCE in sentence["text/html"] and SENTENCE in sentence["text/plain"]
    assert list(view) == ["application/vnd.jupyter.widget-view+json"]


def worked(panel, folder):
    """What a panel makes, in this process, and the rows that it says on the way."""
    rows = []
    made = panel.work(parsed(panel.words(folder)), lambda *said, row="": rows.append(row), folder)
    return made, list(filter(None, rows))


def test_a_class_of_workbooks_becomes_a_table_that_opens(tmp_path):
    """Uploaded: right, wrong, and one that is no workbook; against the shell's own words."""
    names = ("right.xlsx", "lucky.xlsx", "missing_transpose.xlsx")
    files = {name: (DATA / "workbooks" / name).read_bytes() for name in names} | {"torn.xlsx": b"torn"}
    panel = workbench.check()
    uploaded(panel, "path", files)
    made, (head, *rows) = worked(panel, tmp_path)
    assert "first wrong cell" in head and len(rows) == 4 and made.fine is None
    assert made.said == "4 workbooks: 1 not read, 1 right, 2 wrong"
    lucky, missing, right, torn = rows
    assert "B21: F16 should be F15" in lucky and 'class="first"' in lucky and "marked_lucky.xlsx" in lucky
    assert re.search(r'class="first"[^>]*title="=[^"]*F16', lucky), "the framed cell is the wrong one"
    assert "the matrix should be transposed" in missing and 'class="first"' not in right
    assert "not read" in torn and "marked_torn" not in torn
    with zipfile.ZipFile(io.BytesIO(made.files["marked.zip"])) as marked:
        assert sorted(marked.namelist()) == sorted(names)
        book = openpyxl.load_workbook(io.BytesIO(marked.read("lucky.xlsx")))
    assert "F16 should be F15" in book["ZXZ"]["B21"].comment.text
    assert sorted(path.name for path in (tmp_path / "path").iterdir()) == sorted(files), "beside them is nothing"
    assert main.main(["check", f"{tmp_path / 'path'}", "--csv", f"{tmp_path / 'shell.csv'}"]) == 2
    assert made.files["class.csv"] == (tmp_path / "shell.csv").read_bytes()


def test_readings_become_files_and_the_worst_is_named(tmp_path):
    """The files against the shell's; a reading that was moved by hand is the first of the table."""
    panel = panel_of("calibrate")
    made, _ = worked(panel, tmp_path)
    assert made.fine and made.said == "The readings fit."
    shell = ["calibrate", "ac_table", f"{DATA / 'measurements/ball_c_axis.csv'}", "-o", f"{tmp_path / 'shell'}"]
    assert main.main(shell) == 0
    for path in (tmp_path / "shell").iterdir():
        if path.suffix == ".toml":
            assert made.files[path.name] == path.read_bytes()
    lines = (DATA / "measurements/ball_c_axis.csv").read_text(encoding="utf-8").splitlines()
    number = next(n for n, line in enumerate(lines) if re.match(r"[-\d]", line)) + 5
    *others, last = lines[number].split(",")
    lines[number] = ",".join([*others, str(float(last) + 0.05)])
    (tmp_path / "b").mkdir()
    moved = workbench.calibrate(machine="ac_table.toml")
    uploaded(moved, "readings", {"moved.csv": "\n".join(lines).encode()})
    made, _ = worked(moved, tmp_path / "b")
    assert made.fine is False and list(made.files) == ["report.txt"]
    assert f"moved.csv, line {number + 1}, column" in made.pages["Readings"].split("</p>")[0]


@pytest.mark.parametrize(
    ("name", "given", "answer", "fine"),
    [
        (
            "explain",
            {"angles": "135 54.7356 -90", "point": "3 4 5", "result": "1.283069 6.939923 0.437263"},
            "the final transpose is missing",
            False,
        ),
        ("pose", {"machine": "bc_table", "axis": "1 -1 1", "present": "-20 100"}, "B 54.7356 C -45", True),
        ("pose", {"machine": "bc_table", "joints": "1 0 2 -20 30"}, "tool axis i -0.296", True),
        ("head", {"vectors": "five_face_head.csv", "at": "45"}, "X 267.988 ± 0.041", True),
        ("plane", {"point": "0 0 0; 40 0 0; 0 30 10"}, "G68.2 X0. Y0. Z0. I0. J18.4349 K0.", True),
    ],
)
def test_numbers_in_answers_out(name, given, answer, fine, tmp_path):
    made, _ = worked(getattr(workbench, name)(**given), tmp_path)
    assert answer in made.files[f"{name}.txt"].decode() and made.fine is fine


def test_a_program_of_any_post_is_verified_and_walked_through(tmp_path):
    program = tmp_path / "blade.h"
    blade, dmu = f"{DATA / 'cl/blade.cl'}", f"{DATA / 'machines/dmu50v.toml'}"
    assert main.main(["post", blade, "--machine", dmu, "-o", f"{program}"]) == 0
    right = program.read_text(encoding="utf-8")
    for text, fine in ((right, True), (right.replace("B+11.8172", "B-11.8172"), False)):
        panel = workbench.verify(machine="dmu50v.toml", cl="blade.cl")
        uploaded(panel, "program", {"mine.h": text.encode()})
        (folder := tmp_path / str(fine)).mkdir()
        made, _ = worked(panel, folder)
        assert ("agrees with all 5 records" in made.said) is fine
        assert made.fine is fine and 'srcdoc="' in made.pages["Machine"]


@pytest.mark.parametrize("number", [0, 5, 14])
def test_what_a_lesson_draws_is_there(number, tmp_path):
    """The part and the machine of lesson 07c, as a panel has them, against the program that the shell makes."""
    drawn = task(number)
    for name, text in (("machine.toml", drawn.machine), ("part.cl", drawn.cl)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    files = [f"{tmp_path / 'part.cl'}", "--machine", f"{tmp_path / 'machine.toml'}"]
    assert main.main(["post", *files, "-o", f"{tmp_path / 'mine.h'}"]) == 0
    panel = workbench.verify(machine={"machine.toml": drawn.machine}, cl={"part.cl": drawn.cl})
    uploaded(panel, "program", {"mine.h": (tmp_path / "mine.h").read_bytes()})
    (tmp_path / "run").mkdir()
    made, _ = worked(panel, tmp_path / "run")
    assert made.fine and "agrees with all 11 records" in made.said


def test_an_app_looks_at_nothing_of_its_server(monkeypatch, tmp_path):
    """Served by voila: what is uploaded and what comes with the package, no path, and nothing is saved there."""
    for module in ("options", "panel"):
        monkeypatch.setattr(f"mathpost.interface.workbench.{module}.IS_APP", True)
    panel = workbench.post(cl="blade.cl", machine="dmu50v")
    assert parsed(panel.words(tmp_path)).cl.name == "blade.cl"
    panel["cl"].field.value = str(DATA / "cl/blade.cl")
    with pytest.raises(InputError, match="cl: expected a file that is uploaded, or one of the list"):
        panel.words(tmp_path)
    panel["cl"].field.value = "blade.cl"
    assert "--dialect=heidenhain" in panel.words(tmp_path / "named")
    panel["dialect"].field.value = str(DATA / "controls/fanuc.toml")
    with pytest.raises(InputError, match="dialect: expected a file that is uploaded, or one of the list"):
        panel.words(tmp_path)
    uploaded(panel, "dialect", {"mine.toml": (DATA / "controls/fanuc.toml").read_bytes()})
    assert f"--dialect={tmp_path / 'dialect/mine.toml'}" in panel.words(tmp_path)
    panel.show(Made("done", {}, {"a.h": b"1"}))
    assert not hasattr(panel.found.children[0], "children")

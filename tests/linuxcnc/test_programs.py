"""Programs of the package run on LinuxCNC: what the joints did, judged by formulas that share nothing with it."""

import re
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.shop.controls.simulation import write_folder
from tests.conftest import DATA, runs_all
from tests.independent import judge
from tests.independent.machine_model import Model
from tests.linuxcnc import control

MISSING = control.missing() if sys.platform == "linux" else "LinuxCNC runs on Linux"
pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)
MACHINES = [file.stem for file in sorted((DATA / "machines").glob("*.toml"))]
# Of each arrangement one; all of them by --hypothesis-profile=many.
FEW = ["ac_table", "head_b_table_c", "nutating_head", "dividing_head"]
WAYS = {  # of a program: the control's file, TCP, how well its seconds are known
    "joints G61": ("linuxcnc", False, 0.01), "TCP G61": ("linuxcnc", True, 0.01),
    "joints G64": ("linuxcnc_g64", False, 0.02), "TCP G64": ("linuxcnc_g64", True, 0.02),
}  # fmt: skip
TOLERANCE = 0.01  # mm
DIGITS = 4e-4  # mm, what the control's cubics between two servo periods make of 2000 mm/s²: a t²/6
OWN_MODULES = {"ac_table": "xyzac-trt-kins", "bc_table": "xyzbc-trt-kins"}
AT_ONCE = 4
AXIS = 0.1  # degrees


def path_for(model):
    """Records that a machine reaches: the tip on an arc, the tool axis where its rotary axes turn it."""
    t = np.linspace(0, 1, 6)
    angles = np.column_stack([15 + 25 * t, 20 + 40 * t])[:, : len(model.letters)]
    tips = np.column_stack([12 * np.cos(t), 12 * np.sin(t), 5 + 2 * t])
    return tips, np.array([model.place(np.zeros(3), row)[1] for row in angles])


def programs(setup, path, ways):
    """What the package makes, and what is typed before each program: joints of the first record, without TCP."""
    made = {}
    for name in ways:
        dialect, tcp, _ = WAYS[name]
        made[name] = postprocess(path, setup, dialect=dialect, tcp=tcp, name="short")
    start = postprocess(path, setup, dialect="linuxcnc").blocks.words[0]
    first = "G0 " + " ".join(f"{name}{value:.4f}" for name, value in zip(setup.joint_names, start, strict=True))
    return made, first


class Run:
    """A machine's programs on the control, and the model that judges them."""

    def __init__(self, file, folder, ways=tuple(WAYS), hal=""):
        self.model = Model(file)
        self.path = cldata.from_arrays(*path_for(Model(file)), feed=600)
        self.results, first = programs(load_machine(file), self.path, ways)
        texts = {name: (result.program, [first]) for name, result in self.results.items()}
        self.samples = control.run(folder, texts, hal=hal)

    def poses(self, name, every=4):
        """Tip and tool axis in the workpiece, shape (n, 3) each; the first and the last among them."""
        joints = self.samples[name][0]
        rows = np.r_[np.arange(0, len(joints) - 1, every), len(joints) - 1]
        poses = [self.model.place(self.model.nose_of_slides(joints[n, :3]), joints[n, 3:]) for n in rows]
        return np.array([tip for tip, _ in poses]), np.array([axis for _, axis in poses])

    def stray(self, name):
        """How far the tip is from the CL polyline, mm, and the tool axis from its arcs, degrees."""
        off, turned, _ = judge.along_records(*self.poses(name), self.path.points, self.path.axes)
        return off.max(), turned.max()


def on_printed_kinematics(file):
    """A machine, printed by the shell, compiled, and its programs run in one start of the control."""
    with control.folder() as folder:
        assert main(["print", str(file), "--to", "linuxcnc", "-o", folder]) == 0
        control.build(Path(folder))
        return Run(file, Path(folder))


def on_their_module(file, module):
    """The same on LinuxCNC's own module, with TCP only."""
    with control.folder() as folder:
        write_folder(Kinematics(load_machine(file)), folder)
        control.build(Path(folder))
        letters = "".join(load_machine(file).joint_names)
        hal = own_module(Path(folder), module, letters)
        return Run(file, Path(folder), ("TCP G61",), hal=hal)


def pytest_generate_tests(metafunc):
    if "ran" in metafunc.fixturenames:
        metafunc.parametrize("ran", MACHINES if runs_all(metafunc.config) else FEW, indirect=True)


@pytest.fixture(scope="module")
def started(tmp_path_factory, of):
    """All runs, a few at once, for the control mostly waits."""
    positive = tmp_path_factory.mktemp("positive")
    with ThreadPoolExecutor(AT_ONCE) as pool:
        files = {name: DATA / f"machines/{name}.toml" for name in of(FEW, MACHINES)}
        runs = {name: pool.submit(on_printed_kinematics, file) for name, file in files.items()}
        for name, module in OWN_MODULES.items():
            iso = DATA / f"machines/{name}.toml"
            for kind, file in (("iso", iso), ("positive", turned_positively(iso, positive / f"{name}.toml"))):
                runs[module, kind] = pool.submit(on_their_module, file, module)
        yield runs


@pytest.fixture
def ran(request, started):
    return started[request.param].result()


@pytest.mark.parametrize("name", WAYS)
def test_tip_axis_and_records(ran, name):
    off, turned = ran.stray(name)
    assert off < TOLERANCE + DIGITS and turned < AXIS
    if "G61" in name:  # and no further than the report says
        report = ran.results[name].report
        assert off < report.path_tip_error + DIGITS and turned < report.path_axis_error + 1e-3
        assert judge.records_missed(*ran.poses(name, 1), ran.path.points, ran.path.axes, 0.002, 0.02) == []


@pytest.mark.parametrize("name", WAYS)
def test_rates_and_seconds(ran, name):
    joints, line = ran.samples[name]
    rates = np.abs(np.diff(joints, axis=0)).max(axis=0) / control.PERIOD
    most = [ran.model.rates[letter] for letter in ("X", "Y", "Z", *ran.model.letters)]
    assert (rates <= 1.01 * np.array(most)).all()
    running = line[line > 0]
    assert (np.diff(running) >= 0).all()
    report = ran.results[name].report
    seconds = (np.abs(np.diff(joints, axis=0)).max(axis=1) > 1e-9).sum() * control.PERIOD
    assert report.time == pytest.approx(seconds, rel=WAYS[name][2], abs=0.003)


@pytest.mark.parametrize("name", WAYS)
def test_the_interpreter_reads_the_words_that_stand_there(ran, name, tmp_path):
    result = ran.results[name]
    (tmp_path / "p.ngc").write_text(result.program, encoding="ascii")
    read = subprocess.run(["rs274", "-g", tmp_path / "p.ngc"], capture_output=True, text=True, check=True).stdout
    rows = [row.split(",") for row in re.findall(r"STRAIGHT_(?:FEED|TRAVERSE)\(([^)]*)\)", read)]
    letters = [*"XYZ", *ran.model.letters]
    found = np.array(rows, dtype=float)[:, ["XYZABC".index(letter) for letter in letters]]
    np.testing.assert_array_equal(found, result.blocks.words)
    assert max(map(len, result.program.splitlines())) <= 255 and result.program.isascii()


# LinuxCNC's own modules for two tables.


def own_module(folder, module, letters):
    """What `README.txt` says of LinuxCNC's own module, as HAL lines; it takes the place of the printed one."""
    told = (folder / "README.txt").read_text(encoding="utf-8").split(f"{module} takes ")[1]
    pins = re.findall(r"((?:[xyz]-rot-point|[xyz]-offset|tool-offset)) ([-\d.]+?)(?=[,.]?\s)", told)
    ini = (folder / "machine.ini").read_text(encoding="utf-8")
    kinematics = f"KINEMATICS = {module} sparm=identityfirst coordinates={letters}"
    (folder / "machine.ini").write_text(re.sub("KINEMATICS = .*", kinematics, ini), encoding="utf-8")
    assert len(pins) == 6
    return "".join(f"setp {module}.{pin} {value}\n" for pin, value in pins)


def turned_positively(file, to):
    """A machine file whose tables turn the workpiece positively."""
    text = file.read_text(encoding="utf-8")
    signed = re.sub(r"axis = \[(-?\d), (-?\d), (-?\d)\]", lambda m: m[0].replace("-", ""), text)
    to.write_text(signed, encoding="utf-8")
    assert any(min(joint["axis"]) < 0 for joint in tomllib.loads(text)["rotary"])
    return to


@pytest.mark.parametrize("module", OWN_MODULES.values())
def test_their_module_fits_a_machine_that_turns_positively_and_no_other(started, module):
    """The negative control: by ISO 841 the same program, told the same numbers, puts the tip elsewhere."""
    off, turned = started[module, "positive"].result().stray("TCP G61")
    assert off < DIGITS and turned < AXIS
    assert started[module, "iso"].result().stray("TCP G61")[0] > 1

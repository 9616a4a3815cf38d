"""The loop on a real control: readings, calibrate, LinuxCNC's five parameters, and where its joints put the tip.

The machine is not where its file has its axes. Readings and verdict come from the formulas of
`tests.independent.machine_model`; the joints between come from the control with what `terms` told it to hold.
"""

import re
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from mathpost import load_machine
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.shop.compensate.calibrate import calibrate
from mathpost.shop.compensate.terms import terms
from mathpost.shop.controls.simulation import write_folder
from tests.conftest import DATA
from tests.independent import judge
from tests.independent.machine_model import Model
from tests.linuxcnc import control
from tests.linuxcnc.test_programs import DIGITS, path_for, programs, turned_positively

MISSING = control.missing() if sys.platform == "linux" else "LinuxCNC runs on Linux"
pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)
MODULES = {"ac_table": "xyzac-trt-kins", "bc_table": "xyzbc-trt-kins"}
OFF = [(0.021, -0.034, 0.018), (-0.027, 0.016, 0.0)]  # mm, by which the axes stand elsewhere
NOISE = 5e-4  # mm


def displaced(file):
    """The machine as it is: the content of its file with the axes' points elsewhere."""
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    for joint, off in zip(content["rotary"], OFF, strict=True):
        joint["point"] = list(np.add(joint["point"], np.multiply(off, joint["axis"] == np.zeros(3))))
    return content


def readings(believed, real, path):
    """A file of two balls that the control, with the numbers of its file, keeps the tip on."""
    rng, names = np.random.default_rng(7), believed.letters
    lines = ["# method = ball", "# unit = mm", f"{names[0]},{names[1]},x,y,z,ex,ey,ez"]
    for ball in np.array([(110.0, 30.0, 20.0), (-50.0, 90.0, 60.0)]):
        stands = ball + rng.normal(0, 0.01, 3)
        for tilt in (0.0, 30.0, -25.0):
            for turn in (0.0, 90.0, 180.0, 270.0):
                angles = [tilt, turn]
                tip, _ = real.place(believed.nose_for(ball - believed.origin, angles), angles)
                gap = real.table(angles)[0] @ (stands - real.origin - tip) + NOISE * rng.standard_normal(3)
                lines.append(",".join(f"{number:.6f}" for number in (*angles, *ball, *gap)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def pins(found, module):
    """What the terms of a calibration tell LinuxCNC: pin to value and U."""
    rows = re.findall(rf"{module}\.([xyz]-rot-point|[xyz]-offset)\s+([-\d.]+)(?:\s+± ([\d.]+))?", terms(found))
    return {name: (float(value), float(expanded or 0)) for name, value, expanded in rows}


def believed(file, names):
    """The same parameters as the file has the axes."""
    tilt, turn = (np.array(each["point"], dtype=float) for each in tomllib.loads(file.read_text())["rotary"])
    places = {"rot-point": turn, "offset": tilt - turn}
    return {name: places[name[2:]]["xyz".index(name[0])] for name in names}


def stray(file, real, module, said):
    """By how much the tip leaves its path on the control that holds the numbers `said`, mm."""
    setup, believed = load_machine(file), Model(file)
    path = cldata.from_arrays(*path_for(believed), feed=600)
    made, first = programs(setup, path, ("TCP G61",))
    program = made["TCP G61"].program
    with control.folder() as folder:
        write_folder(Kinematics(setup), folder)
        control.build(Path(folder))
        ini = Path(folder) / "machine.ini"
        kinematics = f"KINEMATICS = {module} sparm=identityfirst coordinates={''.join(setup.joint_names)}"
        ini.write_text(re.sub("KINEMATICS = .*", kinematics, ini.read_text(encoding="utf-8")), encoding="utf-8")
        hal = "".join(f"setp {module}.{pin} {value}\n" for pin, value in said.items())
        hal += f"setp {module}.tool-offset {setup.tool_length}\n"
        samples = control.run(Path(folder), {"run": (program, [first])}, hal=hal)
    joints, _ = samples["run"]
    turning = np.flatnonzero(np.abs(joints[:, 3:] - joints[0, 3:]).max(axis=1) > 0)
    joints = joints[turning[0] :: 4]  # before that the tip comes from where the file believes the start to be
    poses = [real.place(real.nose_of_slides(each[:3]), each[3:]) for each in joints]
    tips, axes = (np.array(each) for each in zip(*poses, strict=True))
    return judge.along_records(tips, axes, path.points, path.axes)[0].max()


@pytest.mark.parametrize(("name", "module"), MODULES.items())
def test_the_parameters_bring_the_tip_back(name, module, tmp_path):
    file = turned_positively(DATA / f"machines/{name}.toml", tmp_path / f"{name}.toml")
    content = displaced(file)
    real = Model(content)
    found = calibrate(load_machine(file), [readings(Model(file), real, tmp_path / "ball.csv")])
    said = pins(found, module)
    assert found.fits and len(said) == 5
    (tilt, turn), beside = [joint["point"] for joint in content["rotary"]], {"ac": 1, "bc": 0}[module[3:5]]
    true = {"x-rot-point": turn[0], "y-rot-point": turn[1], "z-offset": tilt[2] - turn[2]}
    true[f"{'xyz'[beside]}-offset"] = tilt[beside] - turn[beside]
    for pin, value in true.items():
        assert abs(said[pin][0] - value) <= 1.5 * said[pin][1], pin
    held = believed(file, said), {pin: value for pin, (value, _) in said.items()}
    with ThreadPoolExecutor(2) as pool:  # for the control mostly waits
        was, now = pool.map(lambda numbers: stray(file, real, module, numbers), held)
    print(f"{module}: the tip strays by {1e3 * was:.2f} µm before, {1e3 * now:.2f} µm after")
    assert was > 0.01 and now < 0.001 + DIGITS

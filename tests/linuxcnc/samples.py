"""Make the samples of the control for lesson 07b and the tests of the time: ``python -m tests.linuxcnc.samples``.

Every path is posted by the package for the trunnion machine, printed for LinuxCNC by the package, and run.
"""

from pathlib import Path

import numpy as np

from mathpost import load_machine, postprocess
from mathpost.files import write_text
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.shop.controls.simulation import write_folder
from tests.conftest import DATA
from tests.linuxcnc import control

SETUP = load_machine(DATA / "machines/ac_table.toml")
WAYS = {"G61": ("linuxcnc", False), "G64": ("linuxcnc_g64", False), "TCP G64": ("linuxcnc_g64", True)}


def corner():
    """A right angle in the part, 20 mm each way in steps of 5 mm; the tool leans and turns on the way."""
    tips = [[x, 10, 20] for x in (0, 5, 10, 15, 20)] + [[20, y, 20] for y in (5, 0, -5, -10)]
    kin, share = Kinematics(SETUP), np.linspace(0, 1, len(tips))
    turned = np.column_stack([np.zeros((len(tips), 3)), 15 + 6 * share, 20 + 40 * share])
    return cldata.from_arrays(tips, kin.forward(turned, degrees=True)[1], feed=1500)


def line(beside=1.5, tilt=10):
    """A straight line of 30 mm; the tool axis tilts over in a plane that passes the pole at so many degrees."""
    t, beside = np.radians(np.linspace(-tilt, tilt, 61)), np.radians(beside)
    tilted = np.column_stack([np.sin(t) * np.cos(beside), np.full(61, np.sin(beside)), np.cos(t) * np.cos(beside)])
    tips = np.column_stack([np.linspace(25, 55, 61), np.full(61, 5.0), np.full(61, 20.0)])
    return cldata.from_arrays(tips, tilted, feed=1500)


PATHS = {  # the file: what is said of it, the path, the tolerance, which ways, and every how many servo periods
    "corner": ("a right angle in the part, tolerance 0.5 mm", corner(), 0.5, tuple(WAYS), 10),
    "pole": ("a line of 30 mm, the tool axis passes 1.5 degrees beside the pole", line(), 0.01, tuple(WAYS), 20),
    "upright": ("the same line with the tool axis standing still", line(10, 0), 0.01, ("G61", "G64"), 20),
}


def posted(name):
    """The program of a path for each of its ways, as results of `postprocess`."""
    _, path, tolerance, ways, _ = PATHS[name]
    dialects = {way: WAYS[way] for way in ways}
    return {
        way: postprocess(path, SETUP, dialect=dialect, tcp=tcp, tolerance=tolerance, name=name)
        for way, (dialect, tcp) in dialects.items()
    }


def run(name):
    """Run a path in its ways, each from its first record; return the joints, (n, 5), in every servo period."""
    made = posted(name)
    start = postprocess(PATHS[name][1], SETUP, dialect="linuxcnc").blocks.words[0]
    first = "G0 " + " ".join(f"{axis}{value:.4f}" for axis, value in zip(SETUP.joint_names, start, strict=True))
    with control.folder() as folder:
        write_folder(Kinematics(SETUP), folder)
        control.build(Path(folder))
        samples = control.run(Path(folder), {way: (each.program, [first]) for way, each in made.items()})
    return {way: samples[way][0] for way in made}


def write(name, samples):
    """Write thinned samples to the file of a path."""
    words, _, _, _, step = PATHS[name]
    lines = ["# source: LinuxCNC 2.9 (Debian 12) in simulation, joints sampled in the servo period"]
    lines += [f"# machine ac_table, {words}, 1500 mm/min; joints are slides and angles, mm and degrees"]
    lines += ["way,seconds,X,Y,Z,A,C"]
    for way, joints in samples.items():
        for row in [*range(0, len(joints) - 1, step), len(joints) - 1]:
            values = ",".join(f"{value:z.4f}" for value in joints[row])
            lines.append(f"{way},{row * control.PERIOD:.3f},{values}")
    write_text(DATA / f"measurements/linuxcnc_{name}.csv", "\n".join(lines) + "\n")


if __name__ == "__main__":
    for path in PATHS:
        write(path, run(path))

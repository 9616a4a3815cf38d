"""The printed JavaScript and C against NumPy, on every machine file and on machines that no file describes."""

import ctypes
import json
import re
import shutil
import subprocess
from xml.etree import ElementTree

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from latex2mathml.converter import convert

from mathpost import chain, load_machine
from mathpost.errors import InputError
from mathpost.formula import numeric
from mathpost.kinematics import Kinematics
from mathpost.rotation import unit
from mathpost.shop import codegen
from tests.machines import machines, random_joints

MM, DIRECTION = 1e-9, 1e-12  # what the printed functions may differ by from NumPy

RUN = """
import { readFileSync } from "node:fs";
const m = await import(process.argv[2]), { joints, poses } = JSON.parse(readFileSync(process.argv[3], "utf8"));
const all = (f) => joints.map((q) => Array.from(f(q)));
console.log(JSON.stringify({ bodies: m.bodies, places: all(m.places), forward: all(m.forward),
    jacobian: all(m.jacobian), inverse: poses.map((p) => m.inverse(p.slice(0, 3), p.slice(3))) }));
"""


def javascript(kin, joints, poses, folder):
    """What the printed module gives in a JavaScript engine."""
    (folder / "machine.mjs").write_text(codegen.machine(kin, "js"), encoding="utf-8")
    (folder / "run.mjs").write_text(RUN, encoding="utf-8")
    (folder / "data.json").write_text(json.dumps({"joints": joints.tolist(), "poses": poses.tolist()}))
    command = ["node", folder / "run.mjs", folder / "machine.mjs", folder / "data.json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def compiled(kin, joints, poses, folder):
    """What the printed C gives when a compiler has accepted every line of it."""
    source, library = folder / "machine.c", folder / "machine.so"
    source.write_text(codegen.machine(kin, "c"), encoding="utf-8")
    strict = "-std=c99 -O2 -Wall -Wextra -Werror -Wno-unused-parameter -shared -fPIC".split()
    subprocess.run(["gcc", *strict, source, "-o", library, "-lm"], check=True)
    code, double = ctypes.CDLL(str(library)), ctypes.c_double

    def filled(name, size, *given):
        out = (double * size)()
        status = getattr(code, name)(*((double * len(each))(*each) for each in given), out)
        return None if name == "inverse" and status == 0 else list(out)

    count, joints_of_one = len(chain.bodies(kin.machine)), len(kin.symbols)
    found = {"bodies": [name for name, _ in chain.bodies(kin.machine)]}
    for name, size in (("places", 12 * count), ("forward", 6), ("jacobian", 6 * joints_of_one)):
        found[name] = [filled(name, size, q) for q in joints]
    found["inverse"] = [filled("inverse", 2 * joints_of_one, p[:3], p[3:]) for p in poses]
    return found


ENGINES = {"js": (javascript, "node"), "c": (compiled, "gcc")}


@pytest.fixture(params=ENGINES)
def engine(request):
    run, program = ENGINES[request.param]
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed")
    return run


def agree(kin, runs, folder):
    """Compare what is printed with NumPy at joints all over, near and at the singular ones; out of reach too."""
    joints = random_joints(kin, 40, seed=17)
    tip, axis = kin.forward(joints)
    strange = unit(np.random.default_rng(5).normal(size=(12, 3)))  # many of them out of reach on a nutating head
    poses = np.concatenate([np.hstack([tip, 3 * axis]), np.hstack([tip[:12], strange])])
    names, placed = zip(*chain.bodies(kin.machine), strict=True)
    wanted = numeric(sp.ImmutableMatrix.vstack(*(m[:3, :] for m in placed)), kin.symbols)(*joints.T)
    step = 1e-6
    ends = [
        np.concatenate(kin.forward(joints[:, None] + way * step * np.eye(len(kin.symbols))), axis=-1)
        for way in (1, -1)
    ]
    slopes = np.swapaxes(ends[0] - ends[1], 1, 2) / (2 * step)
    expected = kin.inverse(poses[:, :3], poses[:, 3:])
    count = 1 if kin.tool_side is None else 2
    for run in runs:
        got = run(kin, joints, poses, folder)
        assert got["bodies"] == list(names)
        assert np.array(got["places"]) == pytest.approx(wanted.reshape(len(joints), -1), abs=MM)
        forward = np.array(got["forward"])
        assert forward[:, :3] == pytest.approx(tip, abs=MM) and forward[:, 3:] == pytest.approx(axis, abs=DIRECTION)
        assert np.array(got["jacobian"]).reshape(-1, 6, len(kin.symbols)) == pytest.approx(slopes, abs=1e-5)
        for pose, found, branches in zip(poses, got["inverse"], expected, strict=True):
            assert (found is None) == np.isnan(branches).all()
            if found is not None:
                inverted(kin, pose, np.array(found).reshape(-1, len(kin.symbols))[:count], branches[:count])


def inverted(kin, pose, found, branches):
    """Whether the joints found reach the pose, and are those of NumPy."""
    reached, direction = kin.forward(found)
    assert reached == pytest.approx(np.tile(pose[:3], (len(found), 1)), abs=MM)
    assert direction == pytest.approx(np.tile(unit(pose[3:]), (len(found), 1)), abs=DIRECTION)
    near = (
        len(found) > 1 and np.sqrt(np.prod(kin.reach_terms(unit(pose[3:])))) < 1e-3
    )  # the workpiece-side angle is any angle's neighbour
    if not near:
        apart = found[:, 3:] - branches[:, 3:]
        assert np.abs(np.angle(np.exp(1j * apart))).max() < DIRECTION
        assert found[:, :3] == pytest.approx(branches[:, :3], abs=MM)


def test_every_machine_file(kin, engine, tmp_path):
    agree(kin, [engine], tmp_path)


def test_a_machine_with_one_rotary_axis(engine, tmp_path):
    agree(Kinematics(load_machine("dividing_head")), [engine], tmp_path)


@settings(deadline=None, max_examples=3, derandomize=True)
@given(model=machines())
def test_random_machines(tmp_path_factory, model):
    runs = [run for run, program in ENGINES.values() if shutil.which(program)]
    agree(Kinematics(model), runs, tmp_path_factory.mktemp("machine"))


def test_any_expressions(tmp_path):
    """Names that are reserved elsewhere, unused arguments and constants are all right."""
    lam, new, unused = sp.symbols("lambda new unused")
    expressions = [sp.sqrt(2) * sp.sin(lam) ** 2, new / 3, sp.Integer(7), sp.pi]
    source = codegen.function("f", expressions, [lam, new, unused])
    run = f"{source}\nconsole.log(JSON.stringify(f([0.5, 2, 9])));"
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    out = subprocess.run(["node", "-e", run], check=True, capture_output=True, text=True).stdout
    assert json.loads(out) == pytest.approx([np.sqrt(2) * np.sin(0.5) ** 2, 2 / 3, 7, np.pi], rel=1e-15)


def test_latex_holds_every_formula(kin):
    text = codegen.machine(kin, "latex")
    assert text.isascii() and text.count(r"\begin") == text.count(r"\end")
    written = re.findall(r"(?m)^\\fit\{([^=]+) = (.*)\}$", text)
    assert len(written) == text.count("\n\\fit")
    names = [name for name, _ in written]
    tool_side, workpiece_side = (
        str(getattr(kin.inverse_symbolic, axis)) for axis in ("tool_side", "workpiece_side")
    )
    wanted = {
        "x",
        "k",
        r"\partial k/\partial X",
        "r_{-}",
        f"{tool_side}_{{1}}",
        f"{tool_side}_{{2}}",
        workpiece_side,
        "X",
        "Z",
    }
    assert wanted < set(names)
    for name, formula in written:
        assert formula.count("{") == formula.count("}"), name
        markup = convert(f"{name} = {formula}")  # leaves what it does not know as it is
        assert ElementTree.fromstring(markup) and "\\" not in markup and "minus" not in markup, name
        for used in re.findall(r"[st]_\{\d+\}", formula):
            assert names.index(used) < names.index(name), "what is used has been said before"


def test_a_language_that_is_none(kin):
    with pytest.raises(InputError, match="language: expected latex or js or c, found 'fortran'"):
        codegen.machine(kin, "fortran")

"""Kinematics of a million poses against a routine in C, and ZXZ against SciPy and pytransform3d."""

import ctypes
import subprocess
import tempfile
from importlib import metadata
from pathlib import Path

import numpy as np
import scipy
import sympy as sp
from scipy.spatial.transform import Rotation

from mathpost import load_machine
from mathpost.formula import numeric
from mathpost.kinematics import Kinematics
from mathpost.rotation import PASSIVE
from tests.benchmarks.timing import best, interleaved, peak_memory, row

MACHINES = Path("data/machines")


def c_routine():
    """Compile `ac_table.c` and return its inverse as a function of (tip, axis, centre, pivot)."""
    source = Path(__file__).with_name("ac_table.c")
    library = Path(tempfile.mkdtemp()) / "ac_table.so"
    subprocess.run(["gcc", "-O2", "-shared", "-fPIC", "-o", library, source, "-lm"], check=True)
    compiled = ctypes.CDLL(str(library)).inverse
    array = np.ctypeslib.ndpointer(dtype=float, flags="C_CONTIGUOUS")
    compiled.argtypes, compiled.restype = [ctypes.c_size_t, *[array] * 5], None

    def inverse(tip, axis, centre, pivot):
        joints = np.empty((len(tip), 5))
        compiled(len(tip), tip, axis, centre, pivot, joints)
        return joints

    return inverse


def poses(kin, count, seed=1):
    """Random joints, and the tips and axes that they reach."""
    rng = np.random.default_rng(seed)
    joints = np.concatenate([rng.uniform(-200, 200, (count, 3)), rng.uniform(-np.pi, np.pi, (count, 2))], axis=1)
    return joints, *map(np.ascontiguousarray, kin.forward(joints))


def run(count=1_000_000):
    kins = {name: Kinematics(load_machine(MACHINES / f"{name}.toml")) for name in ("ac_table", "dmu50v")}
    given = {name: poses(kin, count) for name, kin in kins.items()}
    tilting, turning = kins["ac_table"].machine.rotary
    routine, centre, pivot = c_routine(), np.array(turning.point[:2], float), np.array(tilting.point[1:], float)

    def yardstick():
        return routine(*given["ac_table"][1:], centre, pivot)

    back = kins["ac_table"].forward(yardstick())
    for got, wanted in zip(back, given["ac_table"][1:], strict=True):
        assert np.abs(got - wanted).max() < 1e-7, "the routine in C is wrong"

    print(f"kinematics of {count} poses, of the time of the routine in C for one branch:")
    calls = [lambda kin=kins[name], g=given[name]: kin.inverse(*g[1:]) for name in kins]
    calls += [lambda kin=kins[name], g=given[name]: kin.forward(g[0]) for name in kins]
    in_c, *times = interleaved(yardstick, *calls, repeats=7)
    angles = np.random.default_rng(2).uniform(-1, 1, (3, 16384))
    parts = count / angles.shape[1]
    inverse_floor = best(lambda: (np.arccos(angles[0]), *(np.arctan2(*angles[:2]) for _ in "12")), 50) * parts
    forward_floor = best(lambda: [f(a) for f in (np.sin, np.cos) for a in angles[:2]], 50) * parts
    for number, name in enumerate(kins):
        row(f"inverse, both branches, {name}", times[number] / in_c, 1.25, "C -O2")
        row("  of one arccos and two arctan2 in NumPy alone", times[number] / inverse_floor, None, "NumPy")
    for number, name in enumerate(kins, len(kins)):
        row(f"forward, {name}", times[number] / in_c, 2, "C -O2")
        row("  of two sines and two cosines in NumPy alone", times[number] / forward_floor, None, "NumPy")
    print(f"  C: {count / in_c / 1e6:.1f} million poses a second")
    for name, call in zip(kins, calls, strict=False):
        row(f"memory of the inverse besides input and output, {name}", peak_memory(call) / 2**26, 1, "64 MiB")
    zxz(count)


def zxz(count):
    rng = np.random.default_rng(3)
    angles, points = rng.uniform(-np.pi, np.pi, (count, 3)), rng.uniform(-100, 100, (count, 3))

    a, b, c, *point = symbols = sp.symbols("a b c x y z", real=True)
    # One turn after the other takes half of the products that their matrix takes to be made and applied.
    turns = [PASSIVE[letter](angle) for letter, angle in zip("ZXZ", (a, b, c), strict=True)]
    applied = numeric(tuple(turns[2] * (turns[1] * (turns[0] * sp.Matrix(point)))), symbols)

    def ours():
        return applied(*angles.T, *points.T)

    def with_scipy():
        return Rotation.from_euler("ZXZ", angles).apply(points, inverse=True)

    np.testing.assert_allclose(ours(), with_scipy(), atol=1e-9)
    print(f"ZXZ of {count} triples, each applied to a point:")
    mine, peer = interleaved(ours, with_scipy, repeats=5)
    row("ZXZ applied", mine / peer, 0.1, f"SciPy {scipy.__version__} from_euler(...).apply")
    try:
        from pytransform3d.batch_rotations import active_matrices_from_intrinsic_euler_angles as matrices
    except ImportError:
        print("  pytransform3d is not installed, skipped: pip install pytransform3d")
        return

    def with_pytransform3d():
        return np.einsum("nji,nj->ni", matrices(2, 0, 2, angles), points)

    np.testing.assert_allclose(ours(), with_pytransform3d(), atol=1e-9)
    mine, peer = interleaved(ours, with_pytransform3d, repeats=5)
    row("ZXZ applied", mine / peer, 1, f"pytransform3d {metadata.version('pytransform3d')}, batch and einsum")

"""Five-axis kinematics and post-processing, derived in sympy and taught in Jupyter.

Read the files beside this one first: rotation, euler, frame, machine, chain, kinematics, errors; `formula` compiles
what they derive, codegen prints it for other programs. The rest is in rooms, each with its own reading order:
sources, plane, measure, detective, compensate, workbook, path, controls, post, draw, course, classroom, workbench,
site, shell.

Examples
--------
>>> import mathpost
>>> from mathpost.files import data_file
>>> machine = mathpost.load_machine("dmu50v")
>>> kinematics = mathpost.Kinematics(machine)
>>> print(kinematics.inverse([50.3, 58.4, 52.1], [0.145, 0, 0.989], degrees=True)[0].round(2))
[-36.78 -68.56  66.08  11.81 175.82]
>>> result = mathpost.postprocess(mathpost.read_cl(data_file("cl/blade.cl")), machine)
>>> print(result.program.splitlines()[0])
0 BEGIN PGM BLADE MM
>>> print(result.report)
no feed ...
>>> print(mathpost.explain([135, 54.7356, -90], [3, 4, 5], [1.283069, 6.939923, 0.437263]))
the final transpose is missing...
"""

from importlib import import_module
from typing import Any

_OFFERED = {
    "load_machine": "mathpost.machine.load",
    "Kinematics": "mathpost.kinematics.Kinematics",
    "Frame": "mathpost.frame.Frame",
    "Plane": "mathpost.plane.tilted_plane.Plane",
    "read_cl": "mathpost.path.cl.read",
    "postprocess": "mathpost.post.run",
    "read_rotation": "mathpost.detective.notations.read",
    "explain": "mathpost.detective.euler_angles.explain",
    "check_workbook": "mathpost.workbook.check.check_file",
    "check_answer": "mathpost.course.exercise.check",
    "MathpostError": "mathpost.errors.MathpostError",
}
__all__ = list(_OFFERED)


def __getattr__(name: str) -> Any:
    """Load what is asked for, so that ``import mathpost`` loads nothing (PEP 562)."""
    if name not in _OFFERED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, attribute = _OFFERED[name].rpartition(".")
    globals()[name] = found = getattr(import_module(module), attribute)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_OFFERED})

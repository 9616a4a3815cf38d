"""Five-axis kinematics and post-processing, derived in sympy and taught in Jupyter.

Read the files beside this one first: rotation, euler, frame, machine, chain, kinematics, errors; `formula` compiles
what they derive, codegen prints it for other programs. The rest is in rooms, each with its own reading order:
sources, plane, measure, detective, compensate, workbook, path, controls, post, draw, course, classroom, workbench,
site, shell.
"""

from importlib import import_module

_OFFERED = {
    "load_machine": "mathpost.machine.load",
    "Kinematics": "mathpost.kinematics.Kinematics",
    "Frame": "mathpost.frame.Frame",
    "Plane": "mathpost.plane.tilted_plane.Plane",
    "read_cl": "mathpost.path.cl.read",
    "postprocess": "mathpost.post.run",
    "explain": "mathpost.detective.euler_angles.explain",
    "check_workbook": "mathpost.workbook.check.check_file",
    "check_answer": "mathpost.course.exercise.check",
    "MathpostError": "mathpost.errors.MathpostError",
}
__all__ = list(_OFFERED)


def __getattr__(name):
    """Load what is asked for, so that ``import mathpost`` loads nothing (PEP 562)."""
    if name not in _OFFERED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, attribute = _OFFERED[name].rpartition(".")
    globals()[name] = found = getattr(import_module(module), attribute)
    return found


def __dir__():
    return sorted({*globals(), *_OFFERED})

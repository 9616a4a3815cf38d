"""Five-axis kinematics and post-processing, derived in sympy and taught in Jupyter.

Read the files beside this one first. errors, files and formula (from sympy to NumPy) can be skimmed; then rotation,
euler, frame, machine, machine_file, chain, kinematics. Then `sources` (what belongs to one source document, such as
the two ZXZ recipes) and `path` (CL data, solution selection, the spline through the singular region): that is all
that lessons 01 to 06 stand on.

Above it are `detective` (which convention gives this number), `shop` (programs, controls, measuring, compensation),
`teaching` (exercises, pictures, marking, spreadsheets) and `interface` (commands, panels, pages). Nothing imports
from a floor above its own.

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
    "frame": "Frame",
    "kinematics": "Kinematics",
    "errors": "InputError MathpostError ReachError",
    "formula": "numeric",
    "sources.recipes": "zxz_left_transposed zxz_right zxz_steps",
    "sources.csy_transform": "CsyTransform",
    "path.motion": "Motion",
    "path.deviation": "deviation strays",
    "path.between_blocks": "axis_lag linearize subdivide",
    "shop.plane.tilted_plane": "Plane",
    "shop.post.postprocess": "postprocess",
    "shop.post.verify": "verify",
    "shop.post.ways": "Crossing",
    "detective.euler_angles": "explain",
}
_PLACES = {name: (module, name) for module, names in _OFFERED.items() for name in names.split()} | {
    "load_machine": ("machine_file", "load"),
    "read_cl": ("path.cl", "read"),
    "read_rotation": ("detective.notations", "read"),
    "check_workbook": ("teaching.workbook.check", "check_file"),
    "check_answer": ("teaching.course.exercise", "check"),
}
__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    """Load what is asked for, so that ``import mathpost`` loads nothing (PEP 562)."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _PLACES[name]
    globals()[name] = found = getattr(import_module(f"mathpost.{module}"), attribute)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})

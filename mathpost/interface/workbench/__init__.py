"""The workbench: commands of the shell as panels in a notebook, for people who do not program.

A panel is made from the options of its command, so an option has one name, one unit and one help text, and a new
one appears in both. Read `options` (an option as a control), `run` (a process that can be stopped), `panel`, then
`text_panel`, for commands whose result is the text they print, and `post_panel`, `check_panel`, `calibrate_panel`.
`axes` are the axes of a machine as numbers to change, `sheet_page` a checked sheet in colours. A panel writes only
to files that the user names. `spline_panel` is not a command: it belongs to lesson 06b.
"""

from functools import partial
from importlib import import_module
from typing import Any

IN_SIGHT = {  # commands that have a panel: the options that are not in a section which unfolds
    "post": "cl machine dialect tolerance axis_tolerance strategy singular compare",
    "check": "path reference sequence convention machine language",
    "calibrate": "machine readings template accept",
    "head": "vectors at turns measured sigma",
    "verify": "program machine dialect cl origin",
    "explain": "angles sequence point result machine axis",
    "pose": "machine axis tip joints present",
    "plane": "words point normal machine present",
}
OF_ITS_OWN = ("post", "check", "calibrate")  # whose results are more than the text that they print


def panel_of(command: str, **values: Any) -> Any:
    """Return the panel of a command, its options set to `values`: ``workbench.post(cl="blade.cl")``."""
    from mathpost.interface.workbench.panel import Panel  # loads ipywidgets, which the shell does not need

    name = f"{command}_panel" if command in OF_ITS_OWN else "text_panel"
    module = import_module(f"mathpost.interface.workbench.{name}")
    return getattr(module, "PostPanel", Panel)(command, module.work, IN_SIGHT[command].split(), values)


def __getattr__(name: str) -> Any:
    """Return the function that makes a panel."""
    if name == "spline":
        return import_module("mathpost.interface.workbench.spline_panel").SplinePanel
    if name not in IN_SIGHT:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return partial(panel_of, name)

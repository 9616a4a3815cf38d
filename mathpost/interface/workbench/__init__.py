"""The workbench: commands of the shell as panels in a notebook, for people who do not program.

A panel is made from the options of its command, so an option has one name, one unit and one help text, and a new
one appears in both. Read `options` (an option as a control), `run` (a process that can be stopped), `panel`, then
`text_panel`, for commands whose result is the text they print, and `post_panel`, `check_panel`, `calibrate_panel`.
`axes` are the axes of a machine as numbers to change, `sheet_page` a checked sheet in colours. A panel writes only
to files that the user names. `spline_panel` is not a command: it belongs to lesson 06b.
"""

from importlib import import_module
from typing import Any

PANELS = {
    "post": "post_panel.panel",
    "check": "check_panel.panel",
    "calibrate": "calibrate_panel.panel",
    "head": "text_panel.head",
    "verify": "text_panel.verify",
    "explain": "text_panel.explain",
    "pose": "text_panel.pose",
    "plane": "text_panel.plane",
    "spline": "spline_panel.SplinePanel",
}
__all__ = list(PANELS)


def __getattr__(name: str) -> Any:
    """Load the function that makes a panel, when it is used."""
    if name not in PANELS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, function = PANELS[name].partition(".")
    return getattr(import_module(f"mathpost.interface.workbench.{module}"), function)

"""The workbench: commands of the shell as panels in a notebook, for people who do not program.

A panel is made from the options of its command, so that an option has one name, one unit and one help, and what is
new there is new here. Read `options` (an option as a control), `run` (a process that can be stopped), `panel`, then
one panel: `post`. A panel writes only where it is told to.
"""

from importlib import import_module
from typing import Any

PANELS = ("post",)
__all__ = list(PANELS)


def __getattr__(name: str) -> Any:
    """The function that makes a panel, loaded when it is used."""
    if name not in PANELS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(f"mathpost.workbench.{name}_panel").panel

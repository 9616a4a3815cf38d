"""Ctrl-C and SIGTERM at any moment end with one line; loaded before everything that takes long to load.

While modules are loaded there is nothing to tidy up, and the process ends at once: a module that is interrupted
would show a traceback, or swallow the interruption. A command is interrupted in order. What it has done is done.
"""

import os
import signal
import sys
from collections.abc import Callable

STATUS = 130
_came = False


def at_once(*_: object) -> None:
    """End the process, with one line."""
    os.write(2, b"mathpost: stopped, nothing was written\n")
    os._exit(STATUS)


def in_order(*_: object) -> None:
    """Interrupt the command, which then removes what it left half done."""
    global _came
    _came = True
    sys.unraisablehook = _silent
    raise KeyboardInterrupt


def came() -> bool:
    """Whether the command was interrupted; a library may have made any other error of that."""
    return _came


def take(handler: Callable[..., None] | signal.Handlers) -> None:
    """Have signals handled so, but not those that whoever started this process wants to be ignored."""
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _silent(*_: object) -> None:
    """An interruption in a place that cannot raise, such as a finalizer, is no news."""

"""Ctrl-C and SIGTERM end the process with one line at any moment; loaded before everything that loads slowly.

While modules are loaded there is nothing to tidy up, and the process ends at once: an interrupted import would show
a traceback, or swallow the interruption. A command is interrupted in order; files that it has written remain.
"""

import os
import signal
import sys
from collections.abc import Callable

STATUS = 130
over = False  # the command has ended, one way or the other: set where no signal can come between
_came = False


def at_once(*_: object) -> None:
    """End the process, with one line."""
    os.write(2, b"mathpost: stopped, no file is half written\n")
    os._exit(STATUS)


def in_order(*_: object) -> None:
    """Interrupt the command, which then removes what it left half done; a second signal does not disturb it."""
    global _came
    is_tidying = _came and sys.exc_info()[1] is not None
    _came = True
    sys.unraisablehook = _silent
    if not is_tidying and not over:
        raise KeyboardInterrupt


def came() -> bool:
    """Return whether the command was interrupted; a library may have turned that into a different error."""
    return _came


def take(handler: Callable[..., None] | signal.Handlers) -> None:
    """Install a handler of the signals, except for those that the parent process has set to be ignored."""
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _silent(*_: object) -> None:
    """Ignore an interruption in a place that cannot raise, such as a finalizer."""

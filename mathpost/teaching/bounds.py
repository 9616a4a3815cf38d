"""Bounds of time and memory for work on what strangers send.

Sizes are counted first, where possible, so that every machine refuses the same files. These bounds catch what no
count foresees.
"""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

SECONDS = 60.0  # of the processor
MEMORY = 2 * 2**30  # bytes beyond what the process holds


class TooLarge(Exception):
    """Work that takes more time or memory than it may; the message names the figure."""


@contextmanager
def bounded(seconds: float = SECONDS, memory: int = MEMORY) -> Iterator[None]:
    """Raise `TooLarge` if the work inside takes more processor time or more memory than given.

    Of two nested bounds, the one that is reached first applies. Time is bounded in the main thread, but not on
    Windows; memory is bounded on Linux.

    Parameters
    ----------
    seconds : float, optional
        Processor time, so that a busy machine changes nothing.
    memory : int, optional
        Bytes beyond what the process holds already.
    """
    try:
        with _time(seconds), _memory(memory):
            yield
    except MemoryError:
        raise TooLarge(f"more than {memory / 2**30:g} GB of memory") from None


@contextmanager
def _time(seconds: float) -> Iterator[None]:
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return
    begun, (outer, _) = time.process_time(), signal.getitimer(signal.ITIMER_PROF)
    if outer and outer < seconds:
        yield
        return

    def stop(*_: Any) -> NoReturn:
        raise TooLarge(f"more than {seconds:g} s")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds, 1.0)  # and again, in case it is caught
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
        if outer:
            left = outer - (time.process_time() - begun)
            signal.setitimer(signal.ITIMER_PROF, max(left, 0.001), 1.0)


@contextmanager
def _memory(size: int) -> Iterator[None]:
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            held = int(file.read().split()[5]) * resource.getpagesize()
    except OSError:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most = [limit for limit in (soft, hard, held + size) if limit != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_DATA, (min(most), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))

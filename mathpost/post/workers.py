"""Work that splits, done by several processes in order: the results are those of one, to the last bit."""

from collections import deque
from concurrent.futures import ProcessPoolExecutor

from mathpost.errors import InputError

AHEAD = 3  # tasks for each process that are handed out before the first result is asked for

_shared = None


class Workers:
    """A number of processes; with one, everything is done here.

    Parameters
    ----------
    count : int
    shared : optional
        What every call gets as its first argument; each process has it once.

    Examples
    --------
    >>> with Workers(1, shared=10) as workers:
    ...     list(workers.map(pow, [("two", 2), ("three", 3)]))
    [('two', 100), ('three', 1000)]
    """

    def __init__(self, count=1, shared=None):
        if count < 1:
            raise InputError("workers", "a number from 1 on", f"{count}")
        self.shared = shared
        self.pool = ProcessPoolExecutor(count, initializer=_begin, initargs=(shared,)) if count > 1 else None
        self.ahead = AHEAD * count

    def map(self, function, items):
        """Yield what is kept of each item, and ``function(shared, sent)``, in the order of the items.

        Parameters
        ----------
        function : callable
            Of a module, so that another process finds it.
        items : iterable of (kept, sent)
            Is not run through further ahead than the processes need.
        """
        if self.pool is None:
            for kept, sent in items:
                yield kept, function(self.shared, sent)
            return
        waiting = deque()
        for kept, sent in items:
            waiting.append((kept, self.pool.submit(_call, function, sent)))
            if len(waiting) > self.ahead:
                yield _done(*waiting.popleft())
        while waiting:
            yield _done(*waiting.popleft())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.pool is not None:
            self.pool.shutdown(cancel_futures=True)


def _begin(shared):
    global _shared
    _shared = shared


def _call(function, item):
    return function(_shared, item)


def _done(kept, future):
    return kept, future.result()

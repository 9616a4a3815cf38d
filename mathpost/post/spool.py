"""A list on disk: what a long path needs again later does not stay in memory."""

import pickle
import tempfile


class Spool:
    """A sequence that keeps its items in a temporary file, for as long as it lives.

    Append, length, index and iteration are those of a list; an item that was taken out is a copy.

    Examples
    --------
    >>> with Spool() as spool:
    ...     for word in ("left", "right"):
    ...         spool.append(word)
    ...     len(spool), spool[1], list(spool)
    (2, 'right', ['left', 'right'])
    """

    def __init__(self):
        self._file = tempfile.TemporaryFile(prefix="mathpost")  # noqa: SIM115, it is closed with the spool
        self._starts = []

    def append(self, item):
        """Put an item at the end."""
        self._starts.append(self._file.seek(0, 2))
        pickle.dump(item, self._file, protocol=pickle.HIGHEST_PROTOCOL)

    def __len__(self):
        return len(self._starts)

    def __getitem__(self, index):
        self._file.seek(self._starts[index])
        return pickle.load(self._file)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()

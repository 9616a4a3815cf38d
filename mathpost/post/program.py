"""NC programs (加工程序) out and back in: Heidenhain, Fanuc and Siemens.

A program is a list of blocks that name all five axes. Writing and reading are inverse to each other to the
printed digits, so that a program can be verified from its own text. The readers know the words that the writers
use and a few that do not move an axis; any other word is an error with its line.
"""

import numpy as np

from mathpost.errors import InputError
from mathpost.post import program_reader
from mathpost.post.dialect import DECIMALS, DIALECTS, SHORTEST_TIME, Blocks, dialect_named, printed
from mathpost.post.program_reader import Reader
from mathpost.post.program_writer import Writer, printed_feed

__all__ = [
    "DECIMALS",
    "DIALECTS",
    "SHORTEST_TIME",
    "Blocks",
    "Reader",
    "Writer",
    "dialect_named",
    "joined",
    "read",
    "reader_at",
    "rounded",
    "write",
]


def rounded(joints):
    """Return joints (n, 5) in mm and radians as words in mm and degrees, rounded as they will be printed."""
    return printed(np.concatenate([joints[:, :3], np.rad2deg(joints[:, 3:])], axis=1))


def write(blocks, machine, dialect="heidenhain", *, name="MATHPOST"):
    """Return the text of a program; words that do not change are left out.

    Parameters
    ----------
    blocks : Blocks
        At least one block, and none that repeats all words of the one before.
    machine : Machine
        For the names of its axes.
    dialect : str
        ``"heidenhain"``, ``"fanuc"`` or ``"siemens"``.
    name : str
        Program name; letters, digits and underscores of it are used.

    Examples
    --------
    >>> from mathpost import machine
    >>> dmu = machine.load("data/machines/dmu50v.toml")
    >>> words = np.array([[1, 2, 3, 4, 5], [1, 2, 3.5, 4, 5]])
    >>> two = Blocks(words, np.full(2, 500.0), np.full(2, np.nan), np.array([True, False]))
    >>> print(write(two, dmu, name="demo"), end="")
    0 BEGIN PGM DEMO MM
    1 L X+1.0000 Y+2.0000 Z+3.0000 B+4.0000 C+5.0000 FMAX
    2 L Z+3.5000 F500
    3 END PGM DEMO MM
    """
    writer = Writer(machine, dialect, name=name, tcp=blocks.tcp)
    return writer.head() + writer.write(blocks) + writer.foot()


def read(text, machine, dialect="heidenhain", *, name="program"):
    """Return the `Blocks` of a program's text.

    Parameters
    ----------
    text : str
    machine : Machine
        For the names of its axes.
    dialect : str
    name : str
        Begins every error message.

    Raises
    ------
    InputError
        With the line: for a word that is not known or stands twice, a block before which an axis was never set,
        or a program without a move.
    """
    blocks = Reader(machine, dialect, name=name).read(text)
    if not len(blocks.words):
        raise InputError(name, "at least one move", "none")
    return blocks


def reader_at(writer, *, name="program"):
    """Return a `Reader` for what a `Writer` writes next, as if it had read all that was written before."""
    state = writer.state
    reader = Reader(writer.machine, writer.style.name, name=name)
    reader.state = program_reader.State(
        line=state.lines + 1,
        position=state.words or (None,) * 5,
        feed=None if state.feed is None else float(printed_feed(state.feed)),
        rapid=state.move == "G0",
        inverse=state.mode == "G93",
        tcp=writer.tcp,
        moves_tcp=None if state.words is None else writer.tcp,
    )
    return reader


def joined(parts):
    """Return consecutive `Blocks` without remarks as one."""
    columns = (np.concatenate([getattr(part, name) for part in parts]) for name in ("feeds", "seconds", "rapid"))
    words = np.concatenate([part.words.T for part in parts], axis=1).T
    return Blocks(words, *columns, tcp=parts[0].tcp)

"""One run of a command in a process of its own: it reports progress, can be stopped, and leaves nothing behind."""

import argparse
import io
import multiprocessing
import os
import re
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import redirect_stderr
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from mathpost.errors import MathpostError
from mathpost.interface.shell import main

TEXTS = re.compile(r"\.(txt|csv|html)$")  # files that may name others
EVERY = 0.3  # s between two looks at a silent process


@dataclass
class Made:
    """The results of a run, to be shown: pages of HTML by their titles, and files by their names."""

    said: str  # in one line
    pages: dict[str, str] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    fine: bool | None = True  # None is neither good nor bad


class Run:
    """A process that runs ``work(options, say, folder)``, and the folder for its files, which is removed with it.

    `words` are the words of the command line in the shell. `told` is called with all arguments of ``say(...)``, and
    from time to time with none. A call returns a `Made`, or the sentence of an error, or None if the run was
    stopped.
    """

    def __init__(self, work: Callable) -> None:
        self.work = work
        self.folder = Path(tempfile.mkdtemp(prefix="mathpost-"))
        self.process: Any = None
        self.stopped = False

    def __call__(self, words: list[str], told: Callable[..., None]) -> Made | str | None:
        """Run until it ends or is stopped; then the folder is removed."""
        spawn = multiprocessing.get_context("spawn")
        ours, theirs = spawn.Pipe(duplex=False)
        try:
            self.process = spawn.Process(target=_work, args=(theirs, self.work, words, self.folder), daemon=True)
            self.process.start()
            theirs.close()
            if self.stopped:  # before there was a process to stop
                self.process.kill()
            while True:
                if not ours.poll(EVERY):
                    told()
                    continue
                kind, content = ours.recv()
                if kind == "ended":
                    return content
                told(*content)
        except EOFError:
            return None if self.stopped else "the process ended without a word: out of memory?"
        finally:
            if self.process is not None:
                self.process.kill()
                self.process.join()
            ours.close()
            self.clear()

    def stop(self) -> None:
        """End the process, whatever it does."""
        self.stopped = True
        if self.process is not None and self.process.pid:
            self.process.kill()

    def clear(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _work(connection: Connection, work: Callable, words: list[str], folder: Path) -> None:
    """Run, in the new process, and send progress and result."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the kernel's own
    sys.stdout = sys.stderr = io.StringIO()  # which nobody reads
    threading.Thread(target=_end_with_parent, args=(folder,), daemon=True).start()

    def say(stage: str = "", done: int = 0, total: int = 0, row: str = "") -> None:
        connection.send(("told", (stage, done, total, named(row))))

    def named(text: str) -> str:  # an uploaded file is called by its name alone
        return re.sub(f"{re.escape(str(folder))}{re.escape(os.sep)}\\w+{re.escape(os.sep)}", "", text)

    try:
        ended = work(parsed(words), say, folder)
        ended.pages = {title: named(page) for title, page in ended.pages.items()}
        for name in filter(TEXTS.search, ended.files):
            ended.files[name] = named(ended.files[name].decode()).encode()
    except MathpostError as error:
        ended = named(str(error))
    except Exception as error:
        ended = f"a fault of mathpost, {type(error).__name__}: {error}"
    connection.send(("ended", ended))


def parsed(words: list[str]) -> argparse.Namespace:
    """Return the options that the words name; `MathpostError` for those that argparse refuses."""
    said = io.StringIO()
    try:
        with redirect_stderr(said):
            return main.parse(words)
    except SystemExit:
        raise MathpostError(said.getvalue().strip().rpartition("error: ")[2]) from None


def _end_with_parent(folder: Path) -> None:
    """End, and leave nothing behind, when the kernel is killed."""
    if kernel := multiprocessing.parent_process():
        kernel.join()
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)

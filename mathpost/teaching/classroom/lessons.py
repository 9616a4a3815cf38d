"""Rerun lessons, and list the numbers and pictures that changed, before anything is written.

Two outputs are the same if their words are equal and their numbers agree to 1e-9; a picture is compared by its
description in numbers (`mathpost.teaching.draw.described`).
"""

import atexit
import math
import re
from difflib import SequenceMatcher
from pathlib import Path
from threading import Thread

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, DeadKernelError

from mathpost.errors import InputError, MathpostError
from mathpost.files import write_text

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d+)?")
VIEW = re.compile(r'<div class="mathpost-live".*?</iframe></div>', re.DOTALL)
PANEL = "application/vnd.jupyter.widget-view+json"
TIMEOUT = 120  # s for a cell


def same(text: str, other: str) -> bool:
    """Whether two texts have the same words, and numbers that agree to 1e-9."""
    if NUMBER.split(text) != NUMBER.split(other):
        return False
    pairs = zip(NUMBER.findall(text), NUMBER.findall(other), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=1e-9, abs_tol=1e-12) for a, b in pairs)


def without_views(text: str) -> str:
    """Return HTML without its views, which are compared by their plain text."""
    return VIEW.sub("a view that moves", text)


def rerun(path: Path | str, *, accept: bool = False) -> list[str]:
    """Rerun a notebook and return a line for each change; `accept` writes the new outputs to the file.

    If a cell raises an error, so does this (`MathpostError`), and nothing is written.
    """
    path = Path(path)
    try:
        before, after = (nbformat.read(path, as_version=4) for _ in range(2))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}", "a notebook", f"{error}".splitlines()[0]) from None
    where = {"metadata": {"path": str(path.parent)}}
    client = NotebookClient(
        after, resources=where, extra_arguments=["--log-level=ERROR"], timeout=TIMEOUT, kernel_name="python3",
        record_timing=False, coalesce_streams=True, store_widget_state=False,
    )  # fmt: skip
    try:
        _execute(client)
    except DeadKernelError:
        raise MathpostError(f"{path}: its kernel was stopped") from None
    except CellExecutionError as error:
        raise MathpostError(f"{path}: {error.ename}: {error.evalue}") from None
    for cell in after.cells:  # a reader without Python would see an error in place of a panel
        if cell.cell_type == "code":
            cell.outputs = [each for each in cell.outputs if PANEL not in each.get("data", {})]
    if accept:
        write_text(path, nbformat.writes(after))
    pairs = [each for each in zip(before.cells, after.cells, strict=True) if each[0].cell_type == "code"]
    changes = ((number, _differences(*map(_text, pair))) for number, pair in enumerate(pairs, start=1))
    return [f"  cell {n}: {old or 'nothing'} → {new or 'nothing'}" for n, found in changes for old, new in found]


def _execute(client: NotebookClient) -> None:
    """Run all cells in a thread: in the main one nbclient would catch signals and print tracebacks."""
    failed = []

    def work() -> None:
        try:
            client.execute()
        except Exception as error:  # of any kind: raised again in the thread that waits
            failed.append(error)

    thread = Thread(target=work, daemon=True)
    thread.start()
    try:
        thread.join()
    except KeyboardInterrupt:  # the kernel ends once it sees that this process has ended
        atexit.unregister(client._cleanup_kernel)
        raise
    for error in failed:
        raise error


def _text(cell: nbformat.NotebookNode) -> str:
    """The text of all outputs of a cell."""
    texts = []
    for output in cell.outputs:
        data = output.get("data", {})
        texts += [output.get("text", "")] + [data[kind] for kind in sorted(data) if kind.startswith("text/")]
    return without_views("\n".join(texts))


def _differences(old: str, new: str) -> list[tuple[str, str]]:
    """Pairs (old, new) of differences: numbers where only these differ, lines otherwise."""
    before, after = old.splitlines(), new.splitlines()
    pairs: list[tuple[str, str]] = []
    for _, a, b, c, d in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        gone, come = before[a:b], after[c:d]
        if len(gone) != len(come):
            gone, come = [" / ".join(gone)], [" / ".join(come)]
        for line, other in zip(gone, come, strict=True):
            if NUMBER.split(line) == NUMBER.split(other):
                pairs += zip(NUMBER.findall(line), NUMBER.findall(other), strict=True)
            else:
                pairs.append((line.strip(), other.strip()))
    return [pair for pair in pairs if not same(*pair)]

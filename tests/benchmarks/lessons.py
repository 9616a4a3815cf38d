"""How long each lesson takes, and its slowest cells."""

import subprocess
from datetime import datetime
from pathlib import Path

import nbformat
from nbclient import NotebookClient

from tests.benchmarks.timing import row


def cell_times(path):
    """Seconds of each code cell of a notebook, with its id."""
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(notebook, resources={"metadata": {"path": path.parent}}, record_timing=True)
    client.execute(stderr=subprocess.DEVNULL)  # where a kernel tells of its sockets
    for cell in notebook.cells:
        if timing := cell.metadata.get("execution"):
            begun, done = (timing.get(f"iopub.{key}") for key in ("execute_input", "status.idle"))
            if begun and done:
                yield (datetime.fromisoformat(done) - datetime.fromisoformat(begun)).total_seconds(), cell.id


def run():
    times = {path.stem: list(cell_times(path)) for path in sorted(Path("notebooks").glob("[0-9]*.ipynb"))}
    print("lessons, cells only, of what a class may wait:")
    for name, cells in times.items():
        row(name, sum(seconds for seconds, _ in cells) / 10, 1, "10 s")
    row("all lessons", sum(seconds for cells in times.values() for seconds, _ in cells) / 120, 1, "2 min")
    slowest = sorted(
        ((seconds, name, cell) for name, cells in times.items() for seconds, cell in cells), reverse=True
    )
    for seconds, name, cell in slowest[:8]:
        row(f"  slowest: {name}, {cell}", seconds / 10, None, "10 s")

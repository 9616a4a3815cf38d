"""Copies of lessons that begin by installing the package: ``lessons.py notebooks OUTPUT``."""

import sys
from pathlib import Path

import nbformat

INSTALL = "%pip install -q mathpost matplotlib pillow latex2mathml"

folder, output = map(Path, sys.argv[1:])
output.mkdir(parents=True)
for path in sorted(folder.glob("*.ipynb")):
    notebook = nbformat.read(path, as_version=4)
    cell = nbformat.v4.new_code_cell(INSTALL, id="install")
    notebook.cells.insert(1, cell)
    nbformat.write(notebook, output / path.name)

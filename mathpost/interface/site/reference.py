"""The reference: the docstrings of the package's names and of those that lessons use, as pdoc reads them."""

import ast
import importlib.util
import re
from collections.abc import Iterable
from importlib import import_module
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import pdoc.doc
import pdoc.render

import mathpost

TEMPLATES = Path(__file__).parent / "templates/reference"


def modules(cells: Iterable[str]) -> list[str]:
    """Return the modules to show: `mathpost`, those that define its names, and those that lessons import."""
    offered = {getattr(mathpost, name).__module__ for name in mathpost.__all__}
    return sorted({"mathpost"} | offered | set().union(*map(_imported, cells)))


def _imported(source: str) -> set[str]:
    """The modules of the package that a cell imports; none if the cell is not valid Python."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return set()
    found = set()
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or (node.module or "").split(".")[0] != "mathpost":
            continue
        module = str(node.module)
        if spec := _spec(module):
            for alias in node.names:
                inner = f"{module}.{alias.name}"
                found.add(inner if spec.submodule_search_locations and _spec(inner) else module)
    return found


def _spec(name: str) -> ModuleSpec | None:
    """The spec of a module, or None: a cell may name one that does not exist."""
    try:
        return importlib.util.find_spec(name)
    except ModuleNotFoundError:  # of the room
        return None


def pages(names: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Return for each module the first line of its docstring and its reference as HTML."""
    pdoc.render.configure(
        docformat="numpy", template_directory=TEMPLATES, search=False, show_source=False, include_undocumented=False
    )
    part = re.compile(r"<h[56][^>]*>(.*?)</h[56]>")  # of a docstring, such as Returns: no heading of the page
    every = {name: pdoc.doc.Module(_loaded(name)) for name in names}
    return {
        name: (
            module.docstring.splitlines()[0],
            part.sub(r'<p class="part">\1</p>', pdoc.render.html_module(module, every)),
        )
        for name, module in every.items()
    }


def _loaded(name: str) -> ModuleType:
    """A module, with its lazily loaded names in place, where pdoc looks for them."""
    module = import_module(name)
    for offered in getattr(module, "__all__", ()):
        setattr(module, offered, getattr(module, offered))
    return module

"""The reference: the docstrings of what the package offers and what lessons call, as pdoc reads them."""

import ast
import importlib.util
import re
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path

import pdoc.doc
import pdoc.render

import mathpost

TEMPLATES = Path(__file__).parent / "templates/reference"


def modules(cells: Iterable[str]) -> list[str]:
    """Return the modules to show: `mathpost`, where what it offers is at home, and what code of lessons imports."""
    offered = {getattr(mathpost, name).__module__ for name in mathpost.__all__}
    return sorted({"mathpost"} | offered | set().union(*map(_imported, cells)))


def _imported(source):
    """The modules of the package that a cell imports; a cell that is no Python as it stands imports none."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return set()
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "mathpost":
            is_room = importlib.util.find_spec(node.module).submodule_search_locations
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                found.add(inner if is_room and importlib.util.find_spec(inner) else node.module)
    return found


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


def _loaded(name):
    """A module, with what it loads only when it is asked for in its place: pdoc looks there."""
    module = import_module(name)
    for offered in getattr(module, "__all__", ()):
        setattr(module, offered, getattr(module, offered))
    return module

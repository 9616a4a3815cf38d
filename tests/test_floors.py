"""The floors of the package: what imports what, and how small that is which was asked for."""

import ast
import re
import subprocess

import pytest

from tests.conftest import ROOT

FLOORS = [  # from below; what stands on one line may import each other
    "rotation euler frame machine machine_file chain kinematics formula files errors",
    "path sources",
    "detective",
    "shop",
    "teaching",
    "interface __main__",
]
FLOOR = {name: level for level, line in enumerate(FLOORS) for name in line.split()}
SMALL = ["path.cl", "path.selection", "path.region"]
TOP = """CHANGELOG.md CITATION.cff LICENSE README.md conftest.py environment.txt pyproject.toml
    data mathpost notebooks tests"""


def modules():
    """The files by the names of their modules, without `mathpost.`; a folder is its `__init__`."""
    found = {}
    for path in sorted((ROOT / "mathpost").rglob("*.py")):
        parts = path.relative_to(ROOT / "mathpost").with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


MODULES = modules()


def imported(name):
    """The modules of the package that one names, wherever in its text, for its types, too."""
    for node in ast.walk(ast.parse(MODULES[name].read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and f"{node.module}.".startswith("mathpost."):
            base = node.module[len("mathpost.") :]
            for each in node.names:
                inner = f"{base}.{each.name}".strip(".")
                yield inner if inner in MODULES else base


def floor(name):
    return FLOOR[name.split(".")[0]]


def test_nothing_imports_from_a_floor_above():
    edges = [(name, each) for name in MODULES if name for each in imported(name) if each]
    assert [(name, each) for name, each in edges if floor(each) > floor(name)] == []


def test_the_small_package_is_small():
    """Selection and the spline through the singular region, with the reader of CL data: all that they name."""
    reached, ahead = set(), list(SMALL)
    while ahead:
        if (name := ahead.pop()) not in reached:
            reached.add(name)
            ahead += [*imported(name), *([name.rpartition(".")[0]] if "." in name else [])]
    lines = sum(len(MODULES[name].read_text(encoding="utf-8").splitlines()) for name in reached)
    assert {name.split(".")[0] for name in reached if name} <= set(" ".join(FLOORS[:2]).split())
    assert lines <= 5500, sorted(reached)


def test_the_folder_shows_the_floors():
    held = {name.split(".")[0] for name in MODULES if name}
    assert held == set(FLOOR) and len(held - {"__main__"}) <= 16


@pytest.fixture(scope="module")
def known():
    """Names of modules, and of functions and classes in them."""
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in MODULES.values()]
    made = {node.name for tree in trees for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    return {part for name in MODULES for part in name.split(".")} | made | {"mathpost", "data"}


@pytest.mark.parametrize("name", sorted(name for name, path in MODULES.items() if path.name == "__init__.py"))
def test_the_page_of_a_folder_names_its_files_and_nothing_else(name, known):
    path = MODULES[name]
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    named, quoted = (
        {part for each in re.findall(mark, text) for part in each.split(".") if "toml" not in each}
        for mark in (r"(?<!`)`([a-z_.]+)`", r"``([a-z_.]+)``")
    )
    files = {each.stem for each in path.parent.glob("*.py")} - {"__init__"}
    assert name == "" or "a file each" in text or files <= named | quoted, files - named
    assert named <= known, named - known


def test_the_top_holds_what_is_asked_for_and_what_tools_demand():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout
    top = {line.split("/")[0] for line in listed.splitlines()}
    assert {name for name in top if not name.startswith(".")} <= set(TOP.split())

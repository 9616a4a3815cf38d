"""The README and the page for contributors: their commands and places exist, the map is short."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / ".github/CONTRIBUTING.md").read_text(encoding="utf-8")


def test_shell_commands_are_known():
    from mathpost.interface.shell.main import main

    commands = set(re.findall(r"-m mathpost (\w+)", README + CONTRIBUTING))
    assert {"post", "check"} <= commands
    for command in commands:
        with pytest.raises(SystemExit) as left:
            main([command, "--help"])
        assert left.value.code == 0


def test_the_map_has_ten_rows_and_every_place_exists():
    rows = re.findall(r"^\| (.*) \|$", CONTRIBUTING.split("## Where things are")[1].split("\n## ")[0], re.MULTILINE)
    assert len(rows) - 1 <= 12
    folder = ROOT
    for row in rows[1:]:
        for name in re.findall(r"`([\w./*]+)`", row):
            places = [base / name for base in (ROOT, ROOT / "mathpost", folder, folder.parent)]
            assert name == "derive" or any(list(p.parent.glob(p.name)) for p in places), name
            folder = next((p for p in places if p.is_dir()), folder)


def test_every_room_says_in_what_order_to_read_it():
    rooms = [path.parent for depth in ("*", "*/*") for path in (ROOT / "mathpost").glob(f"{depth}/__init__.py")]
    assert len(rooms) >= 12
    for room in rooms:
        said = (room / "__init__.py").read_text(encoding="utf-8")
        assert f"{room.name}/" in CONTRIBUTING and said.startswith('"""'), room
        named = re.findall(r"`(\w+)[\w.]*`", said.split('"""')[1])
        assert any((room / f"{name}.py").exists() or (room / name).is_dir() for name in named), room


def test_every_link_of_the_readme_leads_to_a_file():
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert len(links) > 20 and [link for link in links if not (ROOT / link).exists()] == []


def test_the_readme_is_short():
    assert len(README) < 9000, "the site has room"

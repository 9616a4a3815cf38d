"""The README: its Python runs as it stands, the places and names that it mentions exist, its map is short."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("code", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_python_runs_as_it_stands(code, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    exec(compile(code, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "END PGM" in printed and "the final transpose is missing" in printed


def test_shell_commands_are_known():
    from mathpost.shell.main import main

    commands = set(re.findall(r"-m mathpost (\w+)", README))
    assert {"post", "check"} <= commands
    for command in commands:
        with pytest.raises(SystemExit) as left:
            main([command, "--help"])
        assert left.value.code == 0


def test_the_map_has_ten_rows_and_every_place_exists():
    rows = re.findall(
        r"^\| (.*) \|$", README.split("## Where things are")[1].split("## For those")[0], re.MULTILINE
    )
    assert len(rows) - 1 <= 12
    folder = ROOT
    for row in rows[1:]:
        for name in re.findall(r"`([\w./*]+)`", row):
            places = [base / name for base in (ROOT, ROOT / "mathpost", folder)]
            assert name == "derive" or any(list(p.parent.glob(p.name)) for p in places), name
            folder = next((p for p in places if p.is_dir()), folder)


def test_every_room_says_in_what_order_to_read_it():
    rooms = [path.parent for path in (ROOT / "mathpost").glob("*/__init__.py")]
    assert len(rooms) >= 12
    for room in rooms:
        said = (room / "__init__.py").read_text(encoding="utf-8")
        assert f"{room.name}/" in README and said.startswith('"""'), room
        named = re.findall(r"`(\w+)[\w.]*`", said.split('"""')[1])
        assert any((room / f"{name}.py").exists() for name in named), room

"""What a person has who installs the package: shipped machines by name, a command, a version."""

import os
import shutil
import subprocess
import sys
import zipfile
from importlib import metadata

import pytest

from mathpost import load_machine
from mathpost.errors import InputError
from mathpost.files import data_file
from tests.conftest import MACHINE_FILES, ROOT


@pytest.mark.parametrize("path", MACHINE_FILES, ids=lambda path: path.stem)
def test_a_shipped_machine_is_found_by_its_name_from_anywhere(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_machine(path.stem) == load_machine(path)


def test_a_name_that_no_machine_has_is_refused_with_those_that_there_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(
        InputError, match="dmu50: expected a TOML file, or one of ac_head, .*dmu50v.*, found neither"
    ):
        load_machine("dmu50")
    with pytest.raises(InputError, match="comes with the package"):
        data_file("cl/none.cl")


def test_a_file_here_goes_before_a_shipped_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dmu50v").write_text('name = "mine"\n')
    with pytest.raises(InputError, match=r"dmu50v.*\[\[rotary\]\]"):
        load_machine("dmu50v")


def test_the_version_is_that_of_the_package():
    said = subprocess.run([sys.executable, "-m", "mathpost", "--version"], capture_output=True, text=True).stdout
    assert said == f"mathpost {metadata.version('mathpost')}\n"


def wheel(folder):
    """Build the wheel of a copy of the course in `folder`; what an earlier build left behind does not come in."""
    course = folder / "course"
    for name in ("mathpost", "data"):
        shutil.copytree(ROOT / name, course / name)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, course)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--quiet", "--wheel-dir", folder, course]
    subprocess.run(command, check=True, capture_output=True, env=os.environ | {"SOURCE_DATE_EPOCH": "1790000000"})
    (made,) = folder.glob("*.whl")
    return made


def test_the_wheel_holds_every_room_and_all_data_and_is_the_same_each_time(tmp_path):
    first, second = (wheel(tmp_path / name) for name in ("first", "second"))
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as archive:
        held = {name for name in archive.namelist() if ".dist-info/" not in name}
    modules = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "mathpost").rglob("*.*")
        if path.parent.name != "__pycache__"
    }
    data = ROOT / "data"
    shipped = {f"mathpost/data/{path.relative_to(data).as_posix()}" for path in data.glob("*/*.*")}
    made_by = {name for name in shipped if name.endswith(".py")}
    assert held == (modules | shipped) - made_by

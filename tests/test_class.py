"""A class on JupyterHub: how the course is handed out, and three students on a real hub on loopback."""

import asyncio
import importlib.util
import json
import os
import stat
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.hub import HUB, PATIENCE, Browser, Hub, accounts, class_folder, hub_lacks, text, tool, work


def load_student():
    """The module .jupyterhub/student.py."""
    spec = importlib.util.spec_from_file_location("student", HUB / "student.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


student = load_student()
ROOT_ONLY = "does not apply: only root may give accounts and become a student"
only_root = pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason=ROOT_ONLY)
pytestmark = pytest.mark.skipif(os.name != "posix", reason="JupyterHub runs on Linux and macOS")


# --- handing out ------------------------------------------------------------------------------------------------


@pytest.fixture
def course(tmp_path):
    """A course of two lessons and a table."""
    files = {"notebooks/01.ipynb": "one", "notebooks/02.ipynb": "two", "data/tables/t.csv": "1,2"}
    litter = {
        "notebooks/conftest.py": "",
        "notebooks/.ipynb_checkpoints/01.ipynb": "",
        "data/__pycache__/x.pyc": "",
    }
    for name, content in (files | litter).items():
        (tmp_path / "course" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "course" / name).write_text(content)
    return tmp_path / "course"


def visible(copy):
    """The files of a copy and their text, without the record."""
    return {
        path.relative_to(copy).as_posix(): path.read_text()
        for path in copy.rglob("*")
        if path.is_file() and path.name != student.RECORD
    }


def test_first_start_hands_out_everything_and_no_litter(course, tmp_path):
    news = student.hand_out(course, tmp_path / "copy")
    assert visible(tmp_path / "copy") == {
        "notebooks/01.ipynb": "one",
        "notebooks/02.ipynb": "two",
        "data/tables/t.csv": "1,2",
    }
    assert len(news["added"]) == 3 and not (news["updated"] or news["kept"] or news["failed"])
    assert not any(student.hand_out(course, tmp_path / "copy").values()), "a second start changes nothing"


def test_work_is_kept_and_the_rest_follows_the_course(course, tmp_path):
    copy = tmp_path / "copy"
    student.hand_out(course, copy)
    (copy / "notebooks/01.ipynb").write_text("my work")
    (copy / "notebooks/mine.ipynb").write_text("my own notebook")
    assert not any(student.hand_out(course, copy).values()), "the student's work alone is no news"

    for name in ("01", "02", "03"):
        (course / f"notebooks/{name}.ipynb").write_text(f"second edition of {name}")
    assert student.hand_out(course, copy) == {
        "added": ["notebooks/03.ipynb"],
        "updated": ["notebooks/02.ipynb"],
        "kept": ["notebooks/01.ipynb"],
        "failed": [],
    }
    assert visible(copy) == {
        "notebooks/01.ipynb": "my work",
        "notebooks/02.ipynb": "second edition of 02",
        "notebooks/03.ipynb": "second edition of 03",
        "notebooks/mine.ipynb": "my own notebook",
        "data/tables/t.csv": "1,2",
    }
    assert student.hand_out(course, copy)["kept"] == ["notebooks/01.ipynb"], "kept at every start"

    (copy / "notebooks/01.ipynb").rename(copy / "notebooks/01_mine.ipynb")
    assert student.hand_out(course, copy)["added"] == ["notebooks/01.ipynb"]
    assert (copy / "notebooks/01_mine.ipynb").read_text() == "my work"


def test_a_lesson_withdrawn_from_the_course_stays_with_the_student(course, tmp_path):
    student.hand_out(course, tmp_path / "copy")
    (course / "notebooks/02.ipynb").unlink()
    assert not any(student.hand_out(course, tmp_path / "copy").values())
    assert (tmp_path / "copy/notebooks/02.ipynb").read_text() == "two"


@pytest.mark.parametrize("record", [None, "", "not json", "[1]", '{"notebooks/01.ipynb": 7}'])
def test_without_a_legible_record_all_that_differs_is_the_students(course, tmp_path, record):
    copy = tmp_path / "copy"
    student.hand_out(course, copy)
    (copy / student.RECORD).unlink() if record is None else (copy / student.RECORD).write_text(record)
    (course / "notebooks/01.ipynb").write_text("second edition")
    news = student.hand_out(course, copy)
    assert news["kept"] == ["notebooks/01.ipynb"] and not news["updated"]
    assert (copy / "notebooks/01.ipynb").read_text() == "one"


def test_one_file_that_fails_does_not_keep_the_others_back(course, tmp_path):
    copy = tmp_path / "copy"
    (copy / "data").mkdir(parents=True)
    (copy / "data/tables").write_text("a file where the course has a folder")
    (copy / "notebooks/01.ipynb").mkdir(parents=True)
    news = student.hand_out(course, copy)
    assert news["added"] == ["notebooks/02.ipynb"] and news["kept"] == ["notebooks/01.ipynb"]
    assert [name.split(":")[0] for name in news["failed"]] == ["data/tables/t.csv"]


def test_a_copy_cut_short_leaves_the_old_file_whole(course, tmp_path, monkeypatch):
    copy = tmp_path / "copy"
    student.hand_out(course, copy)
    (course / "notebooks/01.ipynb").write_text("second edition")
    write = Path.write_bytes

    def full_disk(path, content):
        if "01.ipynb" in path.name:
            write(path, content[:3])
            raise OSError(28, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", full_disk)
    assert student.hand_out(course, copy)["failed"] == ["notebooks/01.ipynb: No space left on device"]
    assert visible(copy)["notebooks/01.ipynb"] == "one"
    assert not list(copy.rglob("*.part"))
    monkeypatch.undo()
    assert student.hand_out(course, copy)["updated"] == ["notebooks/01.ipynb"], "the next start makes it good"


def test_the_real_course_is_handed_out_whole(tmp_path):
    student.hand_out(ROOT, tmp_path)
    tracked = {path.name for path in (ROOT / "notebooks").glob("*.ipynb")}
    assert {path.name for path in (tmp_path / "notebooks").iterdir()} >= tracked
    assert (tmp_path / "data/machines/dmu50v.toml").read_bytes() == (
        ROOT / "data/machines/dmu50v.toml"
    ).read_bytes()


# --- the configuration ------------------------------------------------------------------------------------------


def configuration(folder, monkeypatch, **environment):
    """The configuration as the hub would read it."""
    from traitlets.config import PyFileConfigLoader

    pytest.importorskip("firstuseauthenticator", reason="pip install -r .jupyterhub/requirements.txt")
    monkeypatch.setenv("MATHPOST_CLASS", str(folder))
    monkeypatch.setenv("PATH", os.environ["PATH"])  # the configuration adds to it
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    return PyFileConfigLoader("jupyterhub_config.py", path=str(HUB)).load_config()


def test_the_lists_say_who_may_enter(monkeypatch):
    with class_folder(["Ada", " bob  # from the other group"]) as folder:
        config = configuration(folder, monkeypatch, MATHPOST_ONE_ACCOUNT="1")
    assert config.Authenticator.allowed_users == {"ada", "bob", "teacher"}
    assert "admin_users" not in config.Authenticator, "nobody is the hub's admin"
    (role,) = config.JupyterHub.load_roles
    assert role["users"] == ["teacher"] and not {scope for scope in role["scopes"] if "access" in scope}
    assert not config.Authenticator.allow_existing_users


@pytest.mark.parametrize(
    "name, complaint",
    [("../eve", "line 3: expected a name"), ("a b", "line 3: expected a name"), ("ADA", "ada again")],
)
def test_a_bad_list_is_refused_by_line(monkeypatch, name, complaint):
    with class_folder(["ada", name]) as folder, pytest.raises(ValueError, match=complaint):
        configuration(folder, monkeypatch, MATHPOST_ONE_ACCOUNT="1")


def test_a_missing_list_is_named(monkeypatch):
    with class_folder(["ada"]) as folder:
        (folder / "students.txt").unlink()
        with pytest.raises(ValueError, match=r"students\.txt: expected a readable file"):
            configuration(folder, monkeypatch, MATHPOST_ONE_ACCOUNT="1")


@pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="does not apply: only root may give accounts"
)
def test_students_whom_a_closed_folder_shuts_out_are_not_put_together_in_silence(monkeypatch):
    monkeypatch.delenv("MATHPOST_ONE_ACCOUNT", raising=False)
    with class_folder(["ada"]) as folder:
        folder.chmod(0o700)
        with pytest.raises(ValueError, match=r"chmod o\+x"):
            configuration(folder, monkeypatch)


@pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="does not apply: only root may give accounts"
)
def test_each_home_has_an_owner_of_its_own_for_good(monkeypatch):
    monkeypatch.delenv("MATHPOST_ONE_ACCOUNT", raising=False)
    monkeypatch.setattr(sys, "executable", "/bin/sh")
    if "MATHPOST_ONE_ACCOUNT" in accounts():
        pytest.skip("does not apply: the course stands where other accounts may not go")

    class Spawner:
        pass

    def uid(config, name):
        spawner = Spawner()
        spawner.home_dir = config.SimpleLocalProcessSpawner.home_dir_template.format(username=name)
        config.Spawner.pre_spawn_hook(spawner)
        home = Path(spawner.home_dir).stat()
        assert stat.S_IMODE(home.st_mode) == 0o700
        assert json.loads(spawner.cmd[3])["account"] == home.st_uid
        return home.st_uid

    with class_folder(["ada", "bob", "cai"]) as folder:
        config = configuration(folder, monkeypatch)
        first = [uid(config, name) for name in ("ada", "bob")]
        config = configuration(folder, monkeypatch)
        again = [uid(config, name) for name in ("cai", "bob", "ada")]
    assert again[1:] == first[::-1]
    assert len({0, *first, *again}) == 4


def test_binder_and_the_class_install_what_the_course_installs():
    for path in (ROOT / ".binder/requirements.txt", HUB / "requirements.txt"):
        line = path.read_text().splitlines()[0]
        assert line == "-r ../environment.txt" and (path.parent / line.split()[1]).resolve().exists()


def owned(homes):
    """Give homes to accounts of their own where we may."""
    if os.getuid() == 0:
        for number, home in enumerate(sorted(homes.iterdir())):
            for path in (home, *home.rglob("*")):
                os.chown(path, 200_000 + number, 200_000 + number, follow_symlinks=False)
                if not path.is_symlink():
                    path.chmod(0o700)


def test_collecting_takes_what_was_asked_and_follows_no_link(tmp_path):
    handed_in = {
        "ada/mathpost/notebooks/05_mine.ipynb": "ada's",
        "bob/mathpost/notebooks/05_mine.ipynb": "bob's",
        "bob/mathpost/notebooks/.ipynb_checkpoints/05_mine.ipynb": "an old one",
        "bob/mathpost/notebooks/06_other.ipynb": "not asked for",
        "bob/作业 1.xlsx": "bob's workbook",
        "bob/mathpost/data/workbooks/given.xlsx": "the course's",
    }
    with class_folder(["ada", "bob", "cai"]) as folder:
        homes = folder / "homes"
        for name, content in handed_in.items():
            (homes / name).parent.mkdir(parents=True, exist_ok=True)
            (homes / name).write_text(content)
        (homes / "cai/mathpost").mkdir(parents=True)
        (homes / "cai/mathpost/notebooks").symlink_to(homes / "ada/mathpost/notebooks")
        (homes / "cai/copied.xlsx").symlink_to(homes / "bob/作业 1.xlsx")
        os.mkfifo(homes / "cai/waits.xlsx")
        owned(homes)
        (homes / "eve").symlink_to(homes / "ada")
        out = tmp_path / "collected"
        done = tool("collect.py", folder, out, "05_*.ipynb", "*.xlsx")
        assert not done.returncode and not done.stderr, done.stderr
        wanted = ("ada/mathpost/notebooks/05_mine.ipynb", "bob/mathpost/notebooks/05_mine.ipynb", "bob/作业 1.xlsx")
        assert visible(out) == {name: handed_in[name] for name in wanted}
        assert tool("collect.py", folder, out).returncode, "never into a folder that is there"


@pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="does not apply: only root may become a student"
)
def test_who_reads_a_home_is_its_owner(tmp_path):
    """The race cannot be won: the reader has no right to a neighbour's file, by whichever way it gets there."""
    spec = importlib.util.spec_from_file_location("collect", HUB / "collect.py")
    collecting = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(collecting)
    with class_folder(["ada", "bob"]) as folder:
        homes = folder / "homes"
        for name in ("ada", "bob"):
            (homes / name / "work").mkdir(parents=True)
            (homes / name / "work/secret.ipynb").write_text(name)
        owned(homes)
        ada, bob = homes / "ada", (homes / "bob").lstat()
        assert not collecting._from_home(ada, ada.lstat(), tmp_path / "own", ["*.ipynb"])
        assert visible(tmp_path / "own") == {"work/secret.ipynb": "ada"}
        collecting._from_home(ada, bob, tmp_path / "foreign", ["*.ipynb"])
        assert not visible(tmp_path / "foreign")


def test_passwords_are_set_for_names_of_the_lists_alone():
    pytest.importorskip("bcrypt")
    with class_folder(["ada"]) as folder:
        assert not tool("password.py", folder, "Teacher", said="a long password\n").returncode
        assert "not in" in tool("password.py", folder, "eve", said="a long password\n").stderr
        assert "At least 8" in tool("password.py", folder, "ada", said="short\n").stderr
        assert stat.S_IMODE((folder / "hub").stat().st_mode) == 0o700
        assert not tool("password.py", folder, "teacher", "--drop").returncode


@pytest.mark.parametrize("password", ["密" * 40, "p" * 73, "a" * 100_000, "eight ch"], ids=len)
def test_a_long_password_is_taken_whole(password, monkeypatch):
    """By the script and by the hub alike: at the first log-in, at the next ones, and when it is changed."""
    pytest.importorskip("bcrypt")
    with class_folder(["ada", "bob"]) as folder:
        config = configuration(folder, monkeypatch, MATHPOST_ONE_ACCOUNT="1")
        config.Listed.create_users = True  # there is no database here to ask who exists
        listed = config.JupyterHub.authenticator_class(config=config)

        def enters(name, typed):
            said = asyncio.run(listed.authenticate(None, {"username": name, "password": typed}))
            return said == {"name": name, "admin": False}

        assert not tool("password.py", folder, "ada", said=f"{password}\n").returncode
        assert enters("ada", password) and not enters("ada", password[:-1] + "x")
        assert enters("bob", password) and enters("bob", password) and not enters("bob", password[:-1] + "x")
        assert "success" in listed.reset_password("bob", password + "y")
        assert enters("bob", password + "y") and not enters("bob", password)


def test_values_for_a_faculty_start_what_the_class_starts():
    yaml = pytest.importorskip("yaml", reason="PyYAML reads the values; it comes with JupyterLab")
    single = yaml.safe_load((HUB / "zero-to-jupyterhub.yaml").read_text())["singleuser"]
    course = Path(single["cmd"][1]).parent.parent
    assert single["cmd"] == ["python", str(course / ".jupyterhub/student.py")]
    lesson = single["defaultUrl"].removeprefix("/lab/tree/mathpost/")
    assert (ROOT / lesson).exists()
    assert f"--target-repo-dir {course}" in (HUB / "README.md").read_text()


# --- three students on a hub ------------------------------------------------------------------------------------


@pytest.mark.skipif(hub_lacks() is not None, reason=str(hub_lacks()))
def test_three_students_work_apart_and_find_their_work_after_a_restart():
    students = ["ada", "bob", "2026-03"]
    with class_folder(students) as folder, ThreadPoolExecutor(3) as pool:
        with Hub(folder) as hub:
            browsers = [Browser(hub, name) for name in students]
            assert [b.login(f"password of {b.name}") for b in browsers] == [200] * 3
            stranger = Browser(hub, "eve")
            assert stranger.login("password of eve") == 403, "who is not on the list stays outside"
            assert Browser(hub, "ada").login("password of bob") == 403
            list(pool.map(Browser.start, browsers))
            saved = list(pool.map(work, browsers))

            ada, bob, _ = browsers
            assert ada.session.get(f"{bob.home}/api/contents/mathpost", timeout=PATIENCE).status_code == 403
            with ada.kernel() as run:
                assert "MemoryError" in text(run("blocks = [bytes(2**27) for _ in range(16)]"))
                assert text(run("print('still here')")).strip() == "still here"
                foreign = text(run(f"print(open({str(folder / 'homes/bob/mathpost/answer.txt')!r}).read())"))
                assert ("work of bob" in foreign) == bool(accounts())
            for name in students:
                assert (folder / f"homes/{name}/mathpost/answer.txt").read_text() == f"work of {name}"

        (folder / "students.txt").write_text("ada\nbob\n2026-03\nnewcomer\n")
        with Hub(folder) as hub:
            browsers = [Browser(hub, name) for name in students]
            assert Browser(hub, "ada").login("another password") == 403
            assert [b.login(f"password of {b.name}") for b in browsers] == [200] * 3
            assert Browser(hub, "newcomer").login("a new password") == 200
            list(pool.map(Browser.start, browsers))
            for browser, notebook in zip(browsers, saved, strict=True):
                found = [(cell["source"], cell.get("outputs")) for cell in browser.notebook()["cells"]]
                assert found == [(cell["source"], cell.get("outputs")) for cell in notebook["cells"]]

"""A class on JupyterHub: how the course is handed out, and three students on a real hub on loopback."""

import asyncio
import importlib.util
import json
import os
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
import time
import uuid
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest
import requests
import websocket

from tests.conftest import ROOT

HUB = ROOT / ".jupyterhub"
LESSON = "01_rotating_a_point.ipynb"
PATIENCE = 90  # seconds for any one thing: a bound, not a measure


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
    for name, text in (files | litter).items():
        (tmp_path / "course" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "course" / name).write_text(text)
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


@contextmanager
def class_folder(students, teachers=("teacher",)):
    """A folder of a class that accounts other than ours may pass through."""
    folder = Path(tempfile.mkdtemp(prefix="class-"))
    folder.chmod(0o755)
    (folder / "students.txt").write_text("# group 5\n" + "\n".join(students) + "\n\n")
    (folder / "teachers.txt").write_text("\n".join(teachers) + "\n")
    try:
        yield folder
    finally:
        shutil.rmtree(folder)


def accounts():
    """Environment for a hub here: accounts of their own where we are root and they can run this Python."""
    reachable = all(f.stat().st_mode & stat.S_IXOTH for f in Path(sys.executable).resolve().parents)
    reachable = reachable and all(f.stat().st_mode & stat.S_IXOTH for f in HUB.parents)
    return {} if os.getuid() == 0 and reachable else {"MATHPOST_ONE_ACCOUNT": "1"}


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
        assert spawner.popen_kwargs["user"] == spawner.popen_kwargs["group"] == home.st_uid
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


def tool(name, folder, *words, said=None):
    """Run one of the scripts beside the hub."""
    return subprocess.run(
        [sys.executable, str(HUB / name), *map(str, words)],
        env=os.environ | {"MATHPOST_CLASS": str(folder)},
        input=said,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


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


def free_ports(count):
    """Ports of loopback that nobody listens on."""
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def wait(condition, what):
    """Wait for something to hold, within bounds."""
    end = time.monotonic() + PATIENCE
    while not (value := condition()):
        assert time.monotonic() < end, f"{what}: not within {PATIENCE} s"
        time.sleep(0.3)  # each question costs the hub a page
    return value


class Hub:
    """A hub with its proxy on loopback; on leaving, everything that it started is over."""

    def __init__(self, folder):
        self.folder = folder
        self.log = folder / "hub.log"

    def __enter__(self):
        front, back, api = free_ports(3)
        self.url = f"http://127.0.0.1:{front}"
        command = [sys.executable, "-m", "jupyterhub", "--config", str(HUB / "jupyterhub_config.py")]
        options = [
            f"--JupyterHub.bind_url={self.url}",
            f"--JupyterHub.hub_port={back}",
            f"--ConfigurableHTTPProxy.api_url=http://127.0.0.1:{api}",
        ]
        environment = os.environ | accounts() | {"MATHPOST_CLASS": str(self.folder)}
        with self.log.open("a") as log:
            self.process = subprocess.Popen(
                command + options, stdout=log, stderr=log, env=environment, cwd=self.folder, start_new_session=True
            )
        try:
            wait(self.answers, "the hub answers")
        except BaseException:
            self.__exit__()
            raise
        return self

    def answers(self):
        assert self.process.poll() is None, self.log.read_text()[-3000:]
        try:
            return requests.get(f"{self.url}/hub/health", timeout=5).ok
        except requests.ConnectionError:
            return False

    def __exit__(self, *_):
        family = [psutil.Process(self.process.pid), *psutil.Process(self.process.pid).children(recursive=True)]
        self.process.terminate()
        left = psutil.wait_procs(family, timeout=PATIENCE)[1]
        for process in left:
            process.kill()
        self.process.wait(PATIENCE)
        assert not left, f"still running after the hub was stopped: {left}\n{self.log.read_text()[-3000:]}"


class Browser:
    """One person's browser: cookies, and the few requests that JupyterLab makes."""

    def __init__(self, hub, name):
        self.hub, self.name = hub, name
        self.session = requests.Session()
        self.home = f"{hub.url}/user/{name}"

    def login(self, password):
        """Log in; the status of the answer."""
        login = f"{self.hub.url}/hub/login"
        self.session.get(login, timeout=PATIENCE)
        form = {"username": self.name, "password": password, "_xsrf": self.session.cookies["_xsrf"]}
        return self.session.post(f"{login}?next=/hub/home", data=form, timeout=PATIENCE).status_code

    def start(self):
        """Start the server, as the button of the hub's home page does, and wait until Lab is there."""
        self.session.get(f"{self.hub.url}/hub/spawn/{self.name}", timeout=PATIENCE)
        wait(lambda: self.get("lab").url.startswith(f"{self.home}/lab"), f"the server of {self.name}")
        return self

    def get(self, path, **options):
        return self.session.get(f"{self.home}/{path}", timeout=PATIENCE, **options)

    def send(self, method, path, body):
        xsrf = next(c.value for c in self.session.cookies if c.name == "_xsrf" and c.path == f"/user/{self.name}/")
        answer = self.session.request(
            method, f"{self.home}/{path}", json=body, headers={"X-XSRFToken": xsrf}, timeout=PATIENCE
        )
        answer.raise_for_status()
        return answer.json()

    def notebook(self, lesson=LESSON):
        return self.get(f"api/contents/mathpost/notebooks/{lesson}").json()["content"]

    def save(self, notebook, lesson=LESSON):
        body = {"type": "notebook", "format": "json", "content": notebook}
        self.send("PUT", f"api/contents/mathpost/notebooks/{lesson}", body)

    @contextmanager
    def kernel(self, lesson=LESSON):
        """A kernel for the lesson; yields ``run(source) -> outputs``."""
        body = {"path": f"mathpost/notebooks/{lesson}", "name": lesson, "type": "notebook"}
        opened = self.send("POST", "api/sessions", body | {"kernel": {"name": "python3"}})
        address = f"{self.home}/api/kernels/{opened['kernel']['id']}/channels".replace("http", "ws", 1)
        cookies = requests.cookies.get_cookie_header(self.session.cookies, requests.Request("GET", self.home + "/"))
        channel = websocket.create_connection(address, timeout=PATIENCE, cookie=cookies, origin=self.hub.url)
        try:
            yield lambda source: execute(channel, source)
        finally:
            channel.close()


def execute(channel, source):
    """Run one cell and return its outputs in the form of a notebook."""
    asked = uuid.uuid4().hex
    header = {"msg_id": asked, "msg_type": "execute_request", "session": asked, "username": "", "version": "5.3"}
    content = {"code": source, "silent": False, "store_history": True, "user_expressions": {}, "allow_stdin": False}
    message = {"header": header, "parent_header": {}, "metadata": {}, "content": content, "channel": "shell"}
    channel.send(json.dumps(message | {"buffers": []}))
    outputs = []
    while True:
        frame = channel.recv()
        if isinstance(frame, bytes):  # a picture of a widget, sent with buffers
            continue
        answer = json.loads(frame)
        if answer["parent_header"].get("msg_id") != asked:
            continue
        kind, content = answer["msg_type"], answer["content"]
        if kind == "status" and content["execution_state"] == "idle":
            return outputs
        if kind in ("stream", "error", "display_data", "execute_result"):
            outputs.append({"output_type": kind} | {k: v for k, v in content.items() if k != "transient"})


def text(outputs):
    """What the cell printed and raised."""
    return "".join(o.get("text", "") + "".join(o.get("traceback", [])) for o in outputs)


def work(browser):
    """Run the lesson as its student, sign it and save it; the notebook as saved."""
    notebook = browser.notebook()
    with browser.kernel() as run:
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                cell["outputs"] = run(cell["source"])
                assert not [o for o in cell["outputs"] if o["output_type"] == "error"], text(cell["outputs"])
        signature = f"work of {browser.name}"
        source = f"open('../answer.txt', 'w').write('{signature}'); print('{signature}')"
        signed = {"cell_type": "code", "id": "signed", "metadata": {}, "execution_count": 1, "source": source}
        notebook["cells"].append(signed | {"outputs": run(source)})
        assert text(notebook["cells"][-1]["outputs"]).strip() == signature
    browser.save(notebook)
    return notebook


def hub_lacks():
    """What is missing for a hub here, or None."""
    if sys.platform != "linux":
        return "the bound of memory is Linux's"
    beside = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    for module in ("jupyterhub", "firstuseauthenticator"):
        if importlib.util.find_spec(module) is None:
            return f"no {module}: pip install -r .jupyterhub/requirements.txt"
    if not shutil.which("configurable-http-proxy", path=beside):
        return "no configurable-http-proxy: see .jupyterhub/README.md"
    return None


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
                assert "work of bob" in foreign if accounts() else "PermissionError" in foreign
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


@pytest.mark.skipif(hub_lacks() is not None, reason=str(hub_lacks()))
def test_threats_on_a_hub():
    """A stranger types the teacher's name, a student's page acts for the teacher, a fork bomb, a big file."""
    with class_folder(["ada", "bob"]) as folder, Hub(folder) as hub:
        thief = Browser(hub, "teacher")
        assert thief.login("I was here first") == 403, "a teacher's name cannot be taken"
        assert not tool("password.py", folder, "teacher", said="password of teacher\n").returncode
        assert thief.login("I was here first") == 403
        ada, teacher = Browser(hub, "ada"), Browser(hub, "teacher")
        assert (ada.login("password of ada"), teacher.login("password of teacher")) == (200, 200)
        ada.start()

        def api(browser, method, path, **options):
            xsrf = next(c.value for c in browser.session.cookies if c.name == "_xsrf" and c.path == "/hub/")
            headers = {"X-XSRFToken": xsrf, "Referer": f"{hub.url}/hub/home"} | options.pop("headers", {})
            address = f"{hub.url}/hub/api/{path}"
            return browser.session.request(method, address, headers=headers, timeout=PATIENCE, **options)

        assert api(teacher, "GET", "users").status_code == 200, "a teacher sees who is there"
        assert not any(user["admin"] for user in api(teacher, "GET", "users").json())
        assert api(ada, "GET", "users").status_code == 403
        for browser in (ada, teacher):
            assert api(browser, "PATCH", "users/ada", json={"admin": True}).status_code == 403
            assert api(browser, "POST", "users/bob/tokens", json={}).status_code in (403, 404)
        # the page of a student, on the same domain, opened by the teacher
        assert teacher.session.get(f"{ada.home}/api/contents", timeout=PATIENCE).status_code == 403
        page = {"Referer": f"{ada.home}/files/page.html", "X-XSRFToken": ""}
        assert api(teacher, "DELETE", "users/ada/server", headers=page).status_code == 403

        with ada.kernel() as run:
            big = text(run("f = open('big', 'wb'); f.truncate(2**31)"))
            assert "OSError" in big or "File too large" in big
            if not accounts():  # processes are counted by account
                bomb = "import os, time\nwhile True:\n    if os.fork() == 0:\n        time.sleep(30), os._exit(0)"
                assert "BlockingIOError" in text(run(bomb))
                uid = (folder / "homes/ada").stat().st_uid
                assert sum(p.uids().real == uid for p in psutil.process_iter()) <= 256
        assert Browser(hub, "bob").login("password of bob") == 200, "the hub lives"
        assert api(teacher, "DELETE", "users/ada/server").status_code in (202, 204), "a teacher stops a server"

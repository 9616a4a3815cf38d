"""A hub on loopback for the tests, with its proxy and each student's domain, and the browsers of a class."""

import importlib.util
import json
import os
import secrets
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
import time
import uuid
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil
import requests
import websocket

from tests.conftest import ROOT

HUB = ROOT / ".jupyterhub"
LESSON = "01_rotating_a_point.ipynb"
PATIENCE = 300  # seconds for any one thing: a bound, not a measure
DOMAIN = "mathpost.localhost"

_resolve = socket.getaddrinfo


def _as_browsers_do(host, *how, **more):
    """Every name below localhost is this machine (RFC 6761), for browsers everywhere, for this system perhaps."""
    return _resolve("127.0.0.1" if str(host).endswith(".localhost") else host, *how, **more)


socket.getaddrinfo = _as_browsers_do


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


def free_ports(count):
    """Ports of loopback that nobody listens on, below those that the system itself gives away meanwhile."""
    ports = []
    while len(ports) < count:
        with socket.socket() as tried, suppress(OSError):
            tried.bind(("127.0.0.1", 10_000 + secrets.randbelow(20_000)))
            ports.append(tried.getsockname()[1])
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
        self.port, back, api = free_ports(3)
        self.url = f"http://{DOMAIN}:{self.port}"
        command = [sys.executable, "-m", "jupyterhub", "--config", str(HUB / "jupyterhub_config.py")]
        options = [
            f"--JupyterHub.hub_port={back}",
            f"--ConfigurableHTTPProxy.api_url=http://127.0.0.1:{api}",
        ]
        environment = os.environ | accounts()
        environment |= {"MATHPOST_CLASS": str(self.folder), "MATHPOST_ADDRESS": self.url}
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
        with suppress(requests.ConnectionError):
            return requests.get(f"{self.url}/hub/health", timeout=PATIENCE).ok

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
        self.home = f"http://{name}.{DOMAIN}:{hub.port}/user/{name}"

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
        origin = self.home.partition("/user")[0]
        channel = websocket.create_connection(address, timeout=PATIENCE, cookie=cookies, origin=origin)
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

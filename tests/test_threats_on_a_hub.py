"""What a student may try on a hub: against the accounts, the machine, a neighbour, and whoever opens their page."""

import json
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import psutil
import pytest
import zmq
from playwright.sync_api import sync_playwright

from tests.hub import PATIENCE, Browser, Hub, accounts, class_folder, hub_lacks, text, tool, wait

CHROMIUM = "/usr/bin/chromium"
pytestmark = pytest.mark.skipif(hub_lacks() is not None, reason=str(hub_lacks()))
separate = pytest.mark.skipif(
    os.name != "posix" or bool(accounts()), reason="does not apply: students have no accounts of their own here"
)
PAGE = """<!DOCTYPE html><button>More about rotations</button><script>
const hub = HUB, bob = BOB, own = location.origin;
const read = async (address, how) => {
    try { const answer = await fetch(address, {credentials: "include", ...how}); return await answer.text() }
    catch (error) { return `closed: ${error.name}` }
};
const opened = async (address) => { // until the window has left the empty page that it begins with
    const other = window.open(address);
    try {
        while (other.location.href === "about:blank" || other.document.readyState !== "complete")
            await new Promise((done) => setTimeout(done, 50));
        return other.document.documentElement.outerHTML;
    }
    catch (error) { return `closed: ${error.name}` }
    finally { other?.close() }
};
const token = (page) => (/xsrf_token: "([^"]+)"/.exec(page) || ["", ""])[1];
const talk = (address) => new Promise((resolve) => {
    const socket = new WebSocket(address.replace("http", "ws"));
    socket.onopen = () => resolve("open");
    socket.onerror = () => resolve("closed: WebSocket");
});
document.querySelector("button").onclick = async () => {
    const seen = {};
    seen.home = await read(hub + "/hub/home");
    seen["own home"] = await read(own + "/hub/home");
    [seen.window, seen["window of bob"], seen["own window"]] =
        await Promise.all([hub + "/hub/home", bob + "/lab", own + "/hub/home"].map(opened));
    const key = token(seen.window) || token(seen["own window"]) || token(seen.home) || "";
    for (const where of [hub, own]) {
        const api = where + "/hub/api/users";
        for (const headers of [{"X-XSRFToken": key}, {}]) {
            const body = "{}", more = `?_xsrf=${key}`, kind = Object.keys(headers).length ? " with" : " without";
            const mode = kind === " with" ? "cors" : "no-cors";
            for (const name of ["bob", "teacher"])
                seen[`token ${name} ${where === hub}${kind}`] =
                    await read(`${api}/${name}/tokens${more}`, {method: "POST", headers, body, mode});
            seen[`stop ${where === hub}${kind}`] =
                await read(`${api}/ada/server${more}`, {method: "DELETE", headers, mode: "cors"});
        }
    }
    seen.files = await read(bob + "/api/contents/mathpost");
    seen.kernels = await read(bob + "/api/kernels");
    seen.kernel = await talk(bob + `/api/kernels/${location.search.slice(1)}/channels`);
    seen.frame = await new Promise((resolve) => {
        const frame = document.createElement("iframe");
        frame.src = hub + "/hub/home";
        frame.onload = () => {
            try { resolve(frame.contentDocument.documentElement.outerHTML) } catch (error) { resolve("closed") }
        };
        document.body.append(frame);
    });
    seen.cookies = document.cookie;
    window.seen = seen;
};
</script>"""
SERVED = """
from pathlib import Path
from jupyter_server import serverapp
from tornado import web

class Page(web.RequestHandler):  # of the student's own server, without anybody's log-in
    def get(self):
        self.write(Path(PAGE).read_text())

handlers = serverapp.ServerWebApplication.init_handlers
serverapp.ServerWebApplication.init_handlers = lambda *given: [(r"/user/eve/page", Page), *handlers(*given)]
"""


@pytest.fixture(scope="module")
def hub():
    """A hub with a teacher, a student's page that acts for whoever opens it, and two neighbours at work."""
    names = ("ada", "bob", "cai", "eve", "teacher")
    with class_folder(names[:-1]) as folder, Hub(folder) as started, ThreadPoolExecutor(3) as pool:
        started.thief = Browser(started, "teacher").login("I was here first")
        done = tool("password.py", folder, "teacher", said="password of teacher\n")
        assert not done.returncode, done.stderr
        started.browsers = {name: Browser(started, name) for name in names}
        assert [b.login(f"password of {b.name}") for b in started.browsers.values()] == [200] * 5
        _prepare(folder / "homes/eve", started)
        list(pool.map(Browser.start, [started.browsers[name] for name in ("ada", "bob", "eve")]))
        yield started


def _prepare(home, hub):
    """The home of a student whose server shows a page to everybody."""
    home.mkdir(mode=0o777)
    page = PAGE.replace("HUB", json.dumps(hub.url)).replace("BOB", json.dumps(hub.browsers["bob"].home))
    (home / "page.html").write_text(page, encoding="utf-8")
    (home / ".jupyter").mkdir()
    config = SERVED.replace("PAGE", repr(str(home / "page.html")))
    (home / ".jupyter/jupyter_server_config.py").write_text(config, encoding="utf-8")
    for path in home.rglob("*"):
        path.chmod(0o755)


@pytest.fixture(scope="module")
def ada(hub):
    """Run a cell as a student who stops at nothing."""
    with hub.browsers["ada"].kernel() as run:
        yield lambda source: text(run(source))


def api(browser, method, path, **options):
    """A request to the hub from its own page, as the browser of somebody who has logged in sends it."""
    xsrf = next(c.value for c in browser.session.cookies if c.name == "_xsrf" and c.path == "/hub/")
    headers = {"X-XSRFToken": xsrf, "Sec-Fetch-Mode": "cors"} | options.pop("headers", {})
    address = f"{browser.hub.url}/hub/api/{path}"
    return browser.session.request(method, address, headers=headers, timeout=PATIENCE, **options)


def test_a_teachers_name_cannot_be_taken(hub):
    assert hub.thief == 403 and Browser(hub, "teacher").login("I was here first") == 403


def test_a_long_password_enters_and_a_part_of_it_does_not(hub):
    assert not tool("password.py", hub.folder, "cai", said=f"{'密' * 40}\n").returncode
    assert Browser(hub, "cai").login("密" * 40) == 200 and Browser(hub, "cai").login("密" * 39) == 403


def test_nobody_has_rights_to_anothers_server(hub):
    ada, teacher = hub.browsers["ada"], hub.browsers["teacher"]
    assert api(teacher, "GET", "users").status_code == 200, "a teacher sees who is there"
    assert not any(user["admin"] for user in api(teacher, "GET", "users").json())
    assert api(ada, "GET", "users").status_code == 403
    for browser in (ada, teacher):
        assert api(browser, "PATCH", "users/ada", json={"admin": True}).status_code == 403
        assert api(browser, "POST", "users/bob/tokens", json={}).status_code in (403, 404)
    assert teacher.session.get(f"{ada.home}/api/contents", timeout=PATIENCE).status_code == 403


def test_a_request_without_the_token_of_the_form_does_nothing(hub):
    for xsrf in ("", "made up"):
        said = api(hub.browsers["teacher"], "DELETE", "users/ada/server", headers={"X-XSRFToken": xsrf})
        assert said.status_code == 403


def test_a_large_file_is_bounded(ada):
    said = ada("f = open('big', 'wb'); f.truncate(2**31)")
    assert "OSError" in said or "File too large" in said


def test_shared_memory_is_bounded(ada):
    assert "Error" in ada("import mmap; m = mmap.mmap(-1, 3 * 2**29)")
    assert "still here" in ada("print('still here')")


@separate
def test_folders_of_shared_memory_are_bounded_and_private(ada):
    fill = "import os; f = open('/dev/shm/{0}', 'wb'); os.posix_fallocate(f.fileno(), 0, 2**27); print('full')"
    said = [ada(fill.format(number)) for number in range(4)]
    assert "full" in said[0] and "OSError" in said[-1]
    assert not Path("/dev/shm/0").exists()


@separate
def test_a_fork_bomb_is_bounded(hub, ada):
    bomb = "import os, time\nwhile True:\n    if os.fork() == 0:\n        time.sleep(30), os._exit(0)"
    assert "BlockingIOError" in ada(bomb)
    uid = (hub.folder / "homes/ada").stat().st_uid
    assert sum(p.uids().real == uid for p in psutil.process_iter()) <= 256
    assert Browser(hub, "bob").login("password of bob") == 200, "the hub lives"


@separate
def test_the_processes_of_others_are_not_seen(ada):
    assert "jupyterhub_config" not in ada("import subprocess; print(subprocess.run(['ps', 'ax'], text=True, "
                                          "capture_output=True).stdout)")  # fmt: skip
    assert int(ada("import os; print(sum(n.isdigit() for n in os.listdir('/proc')))").split()[-1]) < 300


def test_a_neighbour_cannot_listen_to_a_kernel(hub, ada):
    """The ports of the loopback are open to all accounts of the machine: who subscribes to one hears nothing."""
    home = f"{hub.folder}/homes/ada"
    family = [p for p in psutil.process_iter(["environ"]) if (p.info["environ"] or {}).get("HOME") == home]
    kernels = [p for p in family if "ipykernel_launcher" in " ".join(p.cmdline())]
    ports = {c.laddr.port for p in kernels for c in p.net_connections("inet") if c.status == "LISTEN"}
    with zmq.Context() as context, context.socket(zmq.SUB) as listener:
        listener.setsockopt(zmq.SUBSCRIBE, b"")
        for port in ports:
            listener.connect(f"tcp://127.0.0.1:{port}")
        for attempt in range(5):
            assert str(attempt) in ada(f"import time; time.sleep(0.1); print({attempt})")
        assert kernels and not listener.poll(500)


@pytest.fixture(scope="module")
def seen(hub):
    """By visitor: what a student's page gets when somebody who has logged in opens it and clicks."""
    visitors, windows = ("bob", "teacher"), {}
    kernel = hub.browsers["bob"].send("POST", "api/kernels", {"name": "python3"})["id"]
    with sync_playwright() as driver:
        given = ["--no-sandbox", "--disable-popup-blocking"]
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=given)
        for who in visitors:
            window = windows[who] = chromium.new_context().new_page()
            window.set_default_timeout(PATIENCE * 1000)
            window.goto(f"{hub.url}/hub/login")
            window.fill("#username_input", who)
            window.fill("#password_input", f"password of {who}")
            window.click("#login_submit")
            window.wait_for_url(lambda address: "/hub/login" not in address)
            if who == "bob":
                window.goto(f"{hub.browsers['bob'].home}/api/status")
                assert "connections" in window.content(), "bob's browser has entered bob's server"
            window.goto(f"{hub.browsers['eve'].home}/page?{kernel}")
            window.click("button")
        for window in windows.values():
            window.wait_for_function("window.seen")
        yield {who: window.evaluate("window.seen") for who, window in windows.items()}
        chromium.close()


@pytest.mark.skipif(not Path(CHROMIUM).exists(), reason=f"no {CHROMIUM}")
@pytest.mark.parametrize("who", ["bob", "teacher"])
def test_a_students_page_reaches_nothing_of_whoever_opens_it(who, hub, seen):
    found = seen[who]
    for what in ("home", "window", "window of bob", "files", "kernels", "kernel", "frame"):
        assert found[what].startswith("closed"), f"{what}: {found[what][:300]}"
    assert "Sign in" in found["own window"] or "Sign in" in found["own home"], (
        "on the student's domain nobody is known"
    )
    assert not [what for what, said in found.items() if what.startswith("token") and '"token"' in said]
    assert "jupyterhub" not in found["cookies"]
    running = {user["name"] for user in api(hub.browsers["teacher"], "GET", "users").json() if user["server"]}
    assert {"ada", "bob", "eve"} <= running, "no server was stopped"
    tokens = api(hub.browsers[who], "GET", f"users/{who}/tokens").json()["api_tokens"]
    assert not [each for each in tokens if "Requested" in (each["note"] or "")], "no token was made"


def test_a_teacher_stops_a_server(hub, ada):
    wait(
        lambda: api(hub.browsers["teacher"], "DELETE", "users/ada/server").status_code in (202, 204),
        "it is stopped",
    )

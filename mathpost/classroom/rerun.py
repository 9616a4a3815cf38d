"""Run a student's notebook in a sandbox: bounded time and memory, no network, a different account.

This is optional: answers are judged without running anything. A notebook is a stranger's program. On Linux it gets
its own processes, network, shared memory and temporary folders, and sees all other files as read-only (`apart`);
if started as root, also an account that owns nothing. `Place.open` lists what could not be bounded; nothing is ever
run as root.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from mathpost.classroom import apart
from mathpost.errors import InputError
from mathpost.files import data_file

UID = 199_999  # an account number that owns nothing, below those of the students on a hub
SECONDS = 300  # for a notebook
MEMORY, PROCESSES = 2 * 2**30, 100  # of all processes together
FOLDERS = dict.fromkeys(("/tmp", "/var/tmp", "/dev/shm"), apart.SHARED)
# Of each process; AS counts shared memory, too. Processes are counted by account: only a separate one is bounded.
LIMITS = {"DATA": MEMORY, "AS": 2 * MEMORY, "FSIZE": 64 * 2**20, "CORE": 0, "NOFILE": 512}
# The environment: nothing of the caller's, so no secrets.
SETTINGS = {"PYTHONDONTWRITEBYTECODE": "1", "MPLBACKEND": "agg", "LANG": "C.UTF-8", "OPENBLAS_NUM_THREADS": "1"}
SETTINGS["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.defpath])

PROBE = """
import os, subprocess, sys
import ipykernel, nbclient, mathpost.course.exercise
assert os.getuid() and not subprocess.call([sys.executable, "-c", "import ipykernel"])
"""


class Place:
    """A sandbox: each notebook runs for at most `seconds`, in a folder of its own that is removed afterwards.

    The attribute `open` lists, in sentences, what cannot be bounded here. Raises `InputError` if students' code
    could only be run as root.
    """

    def __init__(self, seconds: int = SECONDS) -> None:
        if sys.platform != "linux":
            raise InputError("--rerun", "Linux, whose processes can be bounded", sys.platform)
        self.seconds, self.root = seconds, os.getuid() == 0
        with tempfile.TemporaryFile() as said:
            if self._run(PROBE, subprocess.DEVNULL, said=said) != 0:
                found = (
                    "none: start this from an ordinary account, or install Python where every account may run it"
                )
                raise InputError("--rerun", "an account other than root that can run this Python", found)
            said.seek(0)
            self.open = said.read().decode().splitlines()
        self.apart = apart.NOTHING_APART not in self.open
        if not self.root:
            self.open += ["Students' code ran with your own account: it could read your files."]
            self.open += ["The number of processes was bounded by time only."]

    def __call__(self, path: Path | str) -> Path:
        """Run a notebook; return the path of the result, which is valid until the next call."""
        self._kept = tempfile.TemporaryDirectory()
        executed = Path(self._kept.name) / Path(path).name
        with executed.open("wb") as output:
            status = self._run("from mathpost.classroom.rerun import inside; inside()", output, Path(path))
        if status is None:
            raise InputError(executed.name, f"a notebook that runs within {self.seconds} s", "one that did not")
        if status or not executed.stat().st_size:
            found = f"one that was stopped (status {status})"
            raise InputError(executed.name, "a notebook that runs within its bounds", found)
        return executed

    def _run(
        self, code: str, output: IO[bytes] | int, notebook: Path | None = None, said: IO[bytes] | None = None
    ) -> int | None:
        """Run Python code in the sandbox; return its status, None if time ran out."""
        with tempfile.TemporaryDirectory(prefix="rerun-", ignore_cleanup_errors=True) as folder:
            work = Path(folder) / "notebooks"
            work.mkdir()
            data = data_file("machines").parent
            (Path(folder) / "data").symlink_to(data)
            if notebook:
                shutil.copyfile(notebook, work / "notebook.ipynb")
            if self.root:
                for each in (Path(folder), work, *work.iterdir()):
                    os.chown(each, UID, UID)
            modules = [str(Path(__file__).parents[2]), *filter(None, sys.path)]
            own = {"HOME": folder, "TMPDIR": folder, "JUPYTER_RUNTIME_DIR": f"{folder}/run"}
            own["PYTHONPATH"] = os.pathsep.join(modules)
            options: dict[str, Any] = {
                "private": FOLDERS,
                "copied": folder,
                "memory": MEMORY,
                "processes": PROCESSES,
            }
            options["keep"] = [sys.prefix, sys.base_prefix, str(data), *modules]
            options["limits"] = LIMITS | {"CPU": self.seconds}
            if self.root:
                options["account"] = UID
                options["limits"]["NPROC"] = PROCESSES
            if said:
                options["said"] = said.fileno()
            command = [sys.executable, "-I", apart.__file__, json.dumps(options), sys.executable, "-c", code]
            process = subprocess.Popen(
                command, cwd=work, env=SETTINGS | own, start_new_session=True, stdin=subprocess.DEVNULL,
                stdout=output, stderr=subprocess.DEVNULL, pass_fds=[options["said"]] if said else [],
            )  # fmt: skip
            try:
                return process.wait(self.seconds)
            except subprocess.TimeoutExpired:
                return None
            finally:
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()


def inside() -> None:
    """Run notebook.ipynb, in the sandbox, and write it to standard output, out of the kernel's reach."""
    import nbformat
    from jupyter_client import AsyncKernelManager
    from nbclient import NotebookClient

    output = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    notebook = nbformat.read("notebook.ipynb", as_version=4)
    manager = AsyncKernelManager(kernel_name="python3", transport="ipc")  # there is no network to talk over
    client = NotebookClient(notebook, km=manager, timeout=None, allow_errors=True, store_widget_state=False)
    client.execute()
    with open(output, "w", encoding="utf-8") as file:
        file.write(nbformat.writes(notebook))

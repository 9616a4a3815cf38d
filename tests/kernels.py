"""Kernels of lessons, forked from a process that holds the libraries: to load them was half of a short lesson.

What a lesson uses of mathpost, it imports itself.
"""

import atexit
import contextlib
import importlib
import os
import runpy
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import warnings
from multiprocessing.connection import Client, Connection

import psutil

LIBRARIES = (
    "ipykernel.kernelapp", "ipywidgets", "matplotlib.pyplot", "openpyxl", "scipy.interpolate", "scipy.spatial",
    "scipy.special", "sympy", "tomlkit",
)  # fmt: skip
ADDRESS = "MATHPOST_KERNELS"  # where this process and those that it starts ask for a kernel
INLINE = {"MPLBACKEND": "module://matplotlib_inline.backend_inline"}  # as a kernel has it


def fork():
    """Let the kernels that Jupyter starts in this process be forked, where that can be done."""
    if sys.platform != "linux":
        return
    from jupyter_client.provisioning import local_provisioner

    if ADDRESS not in os.environ:
        folder = tempfile.mkdtemp()
        atexit.register(shutil.rmtree, folder)
        os.environ[ADDRESS] = f"{folder}/kernels"
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(os.environ[ADDRESS])
            server.listen()
            command = [sys.executable, "-P", __file__]  # in a session of its own, where no Ctrl-C reaches it
            subprocess.Popen(command, stdin=server, env=os.environ | INLINE, start_new_session=True)
    local_provisioner.launch_kernel = Forked


class Forked(psutil.Process):
    """A kernel, in place of what `jupyter_client.launcher.launch_kernel` starts."""

    stdin = stdout = stderr = None

    def __init__(self, command, *, cwd=None, env=None, **_):
        with Client(os.environ[ADDRESS]) as holder:
            holder.send((command, cwd or os.getcwd(), env))
            super().__init__(holder.recv())

    def poll(self):
        return None if self.is_running() else 0

    def send_signal(self, number):
        with contextlib.suppress(psutil.NoSuchProcess):  # nor does Popen mind
            super().send_signal(number)


def hold(server, parent):
    """Fork a kernel for each process that asks, until the parent has ended."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # a kernel that has ended leaves nothing behind
    server.settimeout(1)
    while os.getppid() == parent:
        try:
            asked, _ = server.accept()
        except TimeoutError:
            continue
        for name in LIBRARIES:  # not before: there are runs without a kernel
            importlib.import_module(name)
        with Connection(asked.detach()) as caller:
            with warnings.catch_warnings(action="ignore"):  # since Python 3.12: of threads, OpenBLAS's
                forked = os.fork() == 0
            if forked:
                return become(caller, *caller.recv())


def become(caller, command, cwd, env):
    """Become the kernel that the command would start."""
    os.setsid()  # signals go to its group
    caller.send(os.getpid())
    for stream in range(3):
        os.dup2(os.open(os.devnull, os.O_RDWR), stream)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env)
    sys.argv = [*command[command.index("ipykernel_launcher") :], f"--IPKernelApp.parent_handle={os.getppid()}"]
    runpy.run_module("ipykernel_launcher", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    hold(socket.socket(fileno=sys.stdin.fileno()), os.getppid())

"""Run a stranger's program apart from the system: namespaces, private temporary folders, bounds, no way back.

``python -I apart.py OPTIONS COMMAND …`` with the options of `Options` as JSON. On Linux, with the standard library
alone, because a part of it runs as root: the caller's process makes the namespaces and waits; the first process in
them sets them up, starts the command under its account, and ends with it, and with it all others. Each protection
that fails is a line on the file descriptor `said`.
"""

from __future__ import annotations

import ctypes
import json
import os
import resource
import shutil
import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

NEW = {"mount": 0x0002_0000, "ipc": 0x0800_0000, "pid": 0x2000_0000, "user": 0x1000_0000, "net": 0x4000_0000}
NOSUID, NODEV, NOEXEC, BIND, RECURSIVE, PRIVATE = 2, 4, 8, 4096, 16384, 1 << 18  # of mount(2)
MOUNT_SETATTR, AT_FDCWD, AT_RECURSIVE, READ_ONLY = 442, -100, 0x8000, 1  # of mount_setattr(2)
PR_SET_PDEATHSIG, PR_SET_NO_NEW_PRIVS = 1, 38  # of prctl(2)
GROUPS = Path("/sys/fs/cgroup")
SHARED = 256 * 2**20  # bytes of shared memory of each kind
NOTHING_APART = (
    "Nothing was apart: the system allows no namespaces. The network, files in /tmp and processes were shared."
)
NO_GROUP = "There is no control group (cgroup v2) to bound all processes together: each was bounded for itself."


@dataclass
class Options:
    """The surroundings of a command, and its bounds."""

    account: int | None = None  # to change to, as root; None: the caller's own
    network: bool = False
    read_only: bool = True  # all but the private folders
    # Folder → bytes of the file system in memory that replaces it.
    private: dict[str, int] = field(default_factory=dict)
    copied: str = ""  # a folder that is replaced by a private copy in memory
    keep: list[str] = field(default_factory=list)  # folders that stay visible within a private one
    limits: dict[str, int] = field(default_factory=dict)  # RLIMIT_ name → number, for each process
    memory: int = 0  # bytes of all processes together, where there are control groups
    processes: int = 0
    said: int = 2  # file descriptor


def main() -> None:
    """Run the command of the command line; never return."""
    options, command = Options(**json.loads(sys.argv[1])), sys.argv[2:]
    group = _group(options)
    alone = _unshare(options)
    status = _wait(_fork(lambda: _first(options, command, group, alone)))
    if group:
        group.rmdir()
    os._exit(status)


def _first(options: Options, command: list[str], group: Path | None, alone: bool) -> NoReturn:
    """The first process of the namespaces: it sets up, starts the command, and reaps whatever ends."""
    _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if group:
        _write(group / "cgroup.procs", "0")  # this process
    if alone:
        _set_up(options)
    os._exit(_wait(_fork(lambda: _become(options, command))))


def _become(options: Options, command: list[str]) -> NoReturn:
    """Take the bounds and the account, and turn into the command."""
    for name, most in options.limits.items():
        number = getattr(resource, f"RLIMIT_{name}")
        hard = resource.getrlimit(number)[1]
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(number, (most, most))
    if options.account is not None:
        os.setgroups([])
        os.setresgid(*[options.account] * 3)
        os.setresuid(*[options.account] * 3)
    _prctl(PR_SET_NO_NEW_PRIVS, 1)
    _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)  # the change of account cleared it
    os.execvp(command[0], command)


def _unshare(options: Options) -> bool:
    """Enter new namespaces; return whether that succeeded."""
    kinds = ["mount", "ipc", "pid", *["net"] * (not options.network), *["user"] * (os.geteuid() != 0)]
    user, group = os.geteuid(), os.getegid()
    if _libc().unshare(sum(NEW[kind] for kind in kinds)):
        _say(options, NOTHING_APART)
        return False
    if "user" in kinds:
        _write("/proc/self/setgroups", "deny")
        _write("/proc/self/uid_map", f"{user} {user} 1")
        _write("/proc/self/gid_map", f"{group} {group} 1")
    return True


def _set_up(options: Options) -> None:
    """Make folders private, everything else read-only, and only these processes visible."""
    here, mask = Path.cwd(), os.umask(0o022)  # so that the account may enter the parents of kept folders
    seen = {path: os.open(path, os.O_PATH) for path in options.keep if Path(path).exists()}
    if options.copied:
        seen[options.copied] = os.open(options.copied, os.O_PATH)
    _mount(None, "/", None, RECURSIVE | PRIVATE)
    if options.read_only and _set_read_only():
        _say(options, "Files outside the temporary folders were not made read-only.")
    for path, size in options.private.items():
        if Path(path).is_dir() and not Path(path).is_symlink():
            _mount("tmpfs", path, "tmpfs", NOSUID | NODEV, f"size={size},mode=1777")
    for path, handle in seen.items():
        if path == options.copied:
            Path(path).mkdir(parents=True, exist_ok=True)
            _mount("tmpfs", path, "tmpfs", NOSUID | NODEV, f"size={SHARED},mode=0700")
            shutil.copytree(f"/proc/self/fd/{handle}", path, symlinks=True, dirs_exist_ok=True)
            owner = os.geteuid() if options.account is None else options.account
            os.chown(path, owner, owner)
            for folder, folders, files in os.walk(path):
                for name in (*folders, *files):
                    os.chown(f"{folder}/{name}", owner, owner, follow_symlinks=False)
        elif any(Path(folder) in Path(path).parents for folder in options.private):
            Path(path).mkdir(parents=True, exist_ok=True)
            _mount(f"/proc/self/fd/{handle}", path, None, BIND | RECURSIVE)
    for handle in seen.values():
        os.close(handle)
    try:
        _mount("proc", "/proc", "proc", NOSUID | NODEV | NOEXEC)
    except OSError:
        _say(options, "The names of the system's processes could be seen.")
    try:
        _write("/proc/sys/kernel/shmall", str(SHARED // os.sysconf("SC_PAGE_SIZE")))
    except OSError:  # only root may
        _say(options, "Segments of shared memory (System V) were not bounded.")
    os.chdir(here)
    os.umask(mask)


def _group(options: Options) -> Path | None:
    """Make a control group and return its folder, or None if that is impossible."""
    if not options.memory:
        return None
    group = GROUPS / f"mathpost-{os.getpid()}"
    try:
        if not {"memory", "pids"} <= set((GROUPS / "cgroup.controllers").read_text(encoding="ascii").split()):
            raise OSError
        _write(GROUPS / "cgroup.subtree_control", "+memory +pids")
        group.mkdir()
        _write(group / "memory.max", str(options.memory))
        _write(group / "memory.swap.max", "0")
        _write(group / "pids.max", str(options.processes))
        return group
    except OSError:
        _say(options, NO_GROUP)
        return None


def _set_read_only() -> int:
    """Make all mounts read-only; return whether that failed (Linux before 5.12)."""
    wanted = (ctypes.c_uint64 * 4)(READ_ONLY, 0, 0, 0)
    return _libc().syscall(MOUNT_SETATTR, AT_FDCWD, b"/", AT_RECURSIVE, wanted, ctypes.sizeof(wanted))


def _mount(source: str | None, target: str, kind: str | None, flags: int, data: str | None = None) -> None:
    names = [None if each is None else str(each).encode() for each in (source, target, kind)]
    if _libc().mount(*names, flags, None if data is None else data.encode()):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number), str(target))


def _write(path: Path | str, text: str) -> None:
    Path(path).write_text(text, encoding="ascii")


def _fork(work: Callable[[], None]) -> int:
    """Start a process that does some work, and ends with status 125 if that fails."""
    if child := os.fork():
        return child
    try:
        work()
    except BaseException as error:
        os.write(2, f"apart: {type(error).__name__}: {error}\n".encode())
    os._exit(125)


def _wait(child: int) -> int:
    """Pass signals on to a child, reap all processes that end, and return the child's status."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _: os.kill(child, number))
    while True:
        ended, status = os.wait()
        if ended == child:
            return os.waitstatus_to_exitcode(status) % 256


def _prctl(number: int, value: int) -> None:
    _libc().prctl(number, ctypes.c_ulong(value), 0, 0, 0)


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _say(options: Options, sentence: str) -> None:
    os.write(options.said, f"{sentence}\n".encode())


if __name__ == "__main__":
    main()

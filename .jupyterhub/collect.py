"""Collect what students made: `python .jupyterhub/collect.py OUT PATTERN …`, such as `OUT '05_*.ipynb' '*.xlsx'`.

Each home is read by a process that has become the student, and so sees nothing that the student could not read
anyway: however fast a file is exchanged for a link, nobody hands in a neighbour's. Links are not followed. This
process only takes down what the others say, in a new folder, and checks every name and size.
"""

import argparse
import fnmatch
import os
import pwd
import signal
import stat
import sys
import tarfile
from pathlib import Path, PurePosixPath

CLASS = Path(os.environ.get("MATHPOST_CLASS", Path(__file__).resolve().parent.parent / "class")).resolve()
FILE_LIMIT, HOME_LIMIT, COUNT_LIMIT, SECONDS = 64 * 2**20, 512 * 2**20, 2000, 120
PASSED_OVER = {"mathpost/data"}  # the course's own


def collect(homes, out, patterns):
    """Copy files from all homes; return what was refused, as lines.

    Parameters
    ----------
    homes, out : Path
        `out` must not exist, so that no student can have put anything there.
    patterns : list of str
        Of file names.
    """
    out.mkdir(mode=0o700)
    refused = []
    for home in sorted(homes.iterdir()):
        owner = home.lstat()
        if not stat.S_ISDIR(owner.st_mode):
            continue
        if os.getuid() == 0 and owner.st_uid == 0:
            refused.append(f"{home.name}: its home belongs to root, which reads nothing here")
            continue
        refused += [f"{home.name}: {line}" for line in _from_home(home, owner, out / home.name, patterns)]
    return refused


def _from_home(home, owner, out, patterns):
    """Let a process of the student's read the home, and take down what it says."""
    reading, writing = os.pipe()
    if not (student := os.fork()):
        os.close(reading)
        _as_student(owner, home, writing, patterns)
    os.close(writing)
    refused, size, count = [], 0, 0
    try:
        with open(reading, "rb") as pipe, tarfile.open(fileobj=pipe, mode="r|") as said:
            for member in said:
                name = PurePosixPath(member.name)
                size, count = size + member.size, count + 1
                if size > HOME_LIMIT or count > COUNT_LIMIT:
                    refused.append(f"more than {HOME_LIMIT // 2**20} MB or {COUNT_LIMIT} files; the rest was left")
                    break
                if not member.isreg() or name.is_absolute() or ".." in name.parts or member.size > FILE_LIMIT:
                    refused.append(f"{member.name!r}: no file of at most {FILE_LIMIT // 2**20} MB inside the home")
                    continue
                target = out / name
                target.parent.mkdir(parents=True, exist_ok=True)
                with target.open("xb") as copy:
                    copy.write(said.extractfile(member).read())
    except (tarfile.TarError, OSError, ValueError) as error:
        refused.append(f"not read to the end: {error}")
    finally:
        os.kill(student, signal.SIGKILL)
        os.waitpid(student, 0)
    return refused


def _as_student(owner, home, writing, patterns):
    """In a process of its own: become the student for good, read, and end."""
    try:
        if os.getuid() == 0:
            os.setgroups([])
            os.setgid(owner.st_gid)
            os.setuid(owner.st_uid)
        signal.alarm(SECONDS)
        with open(writing, "wb") as pipe:
            read(home, patterns, pipe)
    finally:
        os._exit(0)


def read(home, patterns, pipe):
    """As the student: write the files that fit into a pipe."""
    with tarfile.open(fileobj=pipe, mode="w|", format=tarfile.PAX_FORMAT) as out:
        for folder, folders, names, place in os.fwalk(home, follow_symlinks=False):
            inside = os.path.relpath(folder, home)
            folders[:] = sorted(
                name
                for name in folders
                if name[0] != "." and os.path.normpath(f"{inside}/{name}") not in PASSED_OVER
            )
            for name in sorted(names):
                if name[0] in ".~" or not any(fnmatch.fnmatch(name, pattern) for pattern in patterns):
                    continue
                try:
                    handle = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=place)
                except OSError:
                    continue
                with open(handle, "rb") as file:
                    found = os.fstat(handle)
                    if stat.S_ISREG(found.st_mode):
                        member = tarfile.TarInfo(os.path.normpath(f"{inside}/{name}"))
                        member.size, member.mtime = found.st_size, found.st_mtime
                        out.addfile(member, file)


def main():
    """Collect, give the copies to who will look at them, and say what was refused."""
    parser = argparse.ArgumentParser(description="Collect what students made.")
    parser.add_argument("out", type=Path, metavar="OUT", help="a new folder")
    parser.add_argument("patterns", nargs="*", metavar="PATTERN", default=["*.ipynb", "*.xlsx"])
    parser.add_argument(
        "--owner", metavar="ACCOUNT", help="the system's account that gets the copies, to grade them"
    )
    options = parser.parse_args()
    if options.out.exists():
        sys.exit(f"{options.out}: is there already; collect into a new folder")
    owner = pwd.getpwnam(options.owner) if options.owner else None
    refused = collect(CLASS / "homes", options.out, options.patterns)
    if owner:
        for path in (options.out, *options.out.rglob("*")):
            os.chown(path, owner.pw_uid, owner.pw_gid, follow_symlinks=False)
    print(*refused, sep="\n", end="\n" * bool(refused), file=sys.stderr)
    return int(bool(refused))


if __name__ == "__main__":
    sys.exit(main())

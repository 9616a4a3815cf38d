"""Start one student's server: the course copied into the home, the memory bounded, then Jupyter.

The hub runs this as the student (`Spawner.cmd`), whichever spawner it uses, so nothing here has more rights than
the student has. It needs the standard library alone.
"""

import hashlib
import json
import os
import sys
import tempfile
from pathlib import Path

COURSE = Path(__file__).resolve().parent.parent
PARTS = ("notebooks", "data")
RECORD = ".handed_out.json"


def hand_out(course, copy):
    """Bring a student's copy of the course up to date without touching the student's work.

    What is missing is added. What the student has not changed since it was handed out follows the course. What the
    student has changed stays as it is; to have the course's edition beside it, the student renames the own file and
    starts the server again.

    Parameters
    ----------
    course : Path
        Holds the folders of `PARTS`.
    copy : Path
        The student's folder, made where it is missing.

    Returns
    -------
    dict of str to list of str
        Files by what happened to them: ``added``, ``updated``, ``kept`` (the student's, while the course has
        another edition by now) and ``failed`` (with the reason; the others are handed out all the same).
    """
    copy.mkdir(parents=True, exist_ok=True)
    handed_out = _read_record(copy / RECORD)
    news = {"added": [], "updated": [], "kept": [], "failed": []}
    for source in _files(course):
        name = source.relative_to(course).as_posix()
        try:
            content, target = source.read_bytes(), copy / name
            edition = _digest(content)
            happened = _decide(target, edition, handed_out.get(name))
            if happened in ("added", "updated"):
                target.parent.mkdir(parents=True, exist_ok=True)
                _write(target, content)
            if happened != "kept":
                handed_out[name] = edition
            if happened != "current":
                news[happened].append(name)
        except OSError as error:
            news["failed"].append(f"{name}: {error.strerror}")
    _write(copy / RECORD, json.dumps(handed_out, indent=1).encode())
    return news


def limit(**sizes):
    """Bound this server and all that it starts; none of them can lift it again.

    Parameters
    ----------
    **sizes
        ``DATA``: bytes that a process may hold; a greedy cell then raises MemoryError. ``AS``: the same with what
        it shares or has reserved. ``NPROC``: processes and threads of the account. ``FSIZE``: bytes of a file.
    """
    import resource

    for name, size in sizes.items():
        resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (size, size))


def _files(course):
    """The files of the course in order, without what Python, editors and test runs leave beside them."""
    for part in PARTS:
        for path in sorted((course / part).rglob("*")):
            names = path.relative_to(course).parts
            if path.is_file() and not any(name[0] in "._~" or name == "conftest.py" for name in names):
                yield path


def _decide(target, edition, handed_out):
    """What is to happen to one file, by the digests of the course's edition and of the one handed out last."""
    if not os.path.lexists(target):
        return "added"
    found = _digest(target.read_bytes()) if target.is_file() else "not a file"
    if found == edition or handed_out == edition:
        return "current"
    return "updated" if found == handed_out else "kept"


def _digest(content):
    return hashlib.sha256(content).hexdigest()


def _read_record(path):
    """What was handed out; without a legible record everything that differs counts as the student's."""
    try:
        record = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return {}
    return record if isinstance(record, dict) else {}


def _write(path, content):
    """Whole or not at all, even if the disk is full."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(content)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def main(arguments):
    """Hand out, bound, and become the server."""
    try:
        news = hand_out(COURSE, Path.home() / "mathpost")
    except OSError as error:  # a full disk must not lock the student out
        news = {"failed": [str(error)]}
    for happened, names in news.items():
        for name in names:
            print(f"course {happened}: {name}", file=sys.stderr)
    if "MEM_LIMIT" in os.environ:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # every thread reserves a buffer of its own
        os.environ.setdefault("MALLOC_ARENA_MAX", "2")  # and addresses, which are bounded, too
    said = {
        "DATA": "MEM_LIMIT",
        "AS": "MATHPOST_ADDRESSES",
        "NPROC": "MATHPOST_PROCESSES",
        "FSIZE": "MATHPOST_FILE",
    }
    limit(**{name: int(os.environ[key]) for name, key in said.items() if key in os.environ})
    os.environ["JUPYTER_RUNTIME_DIR"] = tempfile.mkdtemp(prefix="jupyter-")  # a socket's path is to be short
    os.chdir(Path.home())
    os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    os.execv(sys.executable, [sys.executable, "-m", "jupyterhub.singleuser", *arguments])


if __name__ == "__main__":
    main(sys.argv[1:])

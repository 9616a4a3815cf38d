"""The files that a class handed in: each student's notebooks and workbooks in a folder, and those refused.

Each student has a folder, a zip, or files that contain the name (``王小明_05_inverse.ipynb``); or the folder is
nbgrader's (``submitted/NAME/ASSIGNMENT``, or the exchange's ``inbound/NAME+ASSIGNMENT+TIME``). Nothing is run, and
nothing outside the folder is read: links are not followed.
"""

from __future__ import annotations

import re
import shutil
import unicodedata
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from mathpost.errors import InputError, internal, one_line

NOTEBOOKS = {".ipynb"}
WORKBOOKS = {".xlsx", ".xlsm", ".xlsb", ".xls", ".ods", ".et"}
FILE_LIMIT, ZIP_LIMIT, COUNT_LIMIT = 64 * 2**20, 256 * 2**20, 2000  # bytes of a file and a zip unpacked, members
STUDENT_LIMIT, DEEPEST = 200, 40  # notebooks or workbooks of a student, folders in folders
MOODLE = re.compile(r"_\d+_assignsubmission_file_?.*$")
SEPARATORS = " _-–—.()（）[]【】+"
PASSED_OVER = {"__MACOSX", "node_modules", "venv"}


@dataclass
class Student:
    """One student's files."""

    name: str
    notebooks: list[Path] = field(default_factory=list)
    workbooks: list[Path] = field(default_factory=list)
    refused: list[tuple[str, str]] = field(default_factory=list)  # (file, why it was not opened)
    unpacked: int = 0  # bytes, of all zips


def collect(folder: Path | str, unpacked: Path | str, lessons: Iterable[str] = ()) -> list[Student]:
    """Return the students in a folder or zip, sorted by name; zips are unpacked into the folder `unpacked`.

    `lessons` are the stems of the lessons' file names, which are not part of a student's name.
    """
    folder, unpacked = Path(folder), Path(unpacked)
    if folder.is_file() and zipfile.is_zipfile(folder):
        unzip(folder, unpacked / "class")
        folder = unpacked / "class"
    if not folder.is_dir():
        raise InputError(str(folder), "a folder of what was handed in, or a zip of it", "none")
    found: dict[str, Student] = {}
    for number, (name, path) in enumerate(_whose(folder, tuple(lessons))):
        name = one_line(unicodedata.normalize("NFC", name))
        student = found.setdefault(name, Student(name))
        _take(path, student, unpacked / str(number), path.name)
    if not found:
        raise InputError(str(folder), "notebooks, workbooks, zips, or a folder for each student", "nothing")
    for student in found.values():
        for files in (student.notebooks, student.workbooks):
            if len(files) > STUDENT_LIMIT:
                student.refused.append(("", f"only the first {STUDENT_LIMIT} of {len(files)} files were read"))
                del files[STUDENT_LIMIT:]
    return [found[name] for name in sorted(found)]


def unzip(path: Path, target: Path, limit: int = ZIP_LIMIT) -> int:
    """Unpack a zip and return its size unpacked.

    Raises `InputError` if it is broken, leads out of `target`, contains links, or has more than `limit` bytes.
    """
    try:
        with zipfile.ZipFile(path) as packed:
            members = [each for each in packed.infolist() if not each.is_dir()]
            size = sum(each.file_size for each in members)
            if len(members) > COUNT_LIMIT or size > limit:
                expected = f"at most {COUNT_LIMIT} files and {limit // 2**20} MB unpacked"
                raise InputError(str(path), expected, f"{len(members)} files, {size / 2**20:.0f} MB")
            for member in members:
                name = _said(member)
                parts = PurePosixPath(name.replace("\\", "/")).parts
                if any(part in ("..", "/") or ":" in part or "\0" in part for part in parts):
                    raise InputError(str(path), "names inside the zip's own folder", repr(name))
                if member.external_attr >> 28 == 0xA:
                    raise InputError(str(path), "files", f"a link, {name!r}")
                place = target.joinpath(*parts)
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_bytes(packed.read(member))  # at most the size that the zip declares
            return size
    except InputError:
        raise
    except Exception as error:  # what zipfile and its decompressors raise is not listed anywhere
        raise InputError(str(path), "a zip that can be unpacked", str(error) or type(error).__name__) from None


def _said(member: zipfile.ZipInfo) -> str:
    """The name of a file in a zip, which may be in an undeclared Chinese code page."""
    if not member.flag_bits & 0x800:
        for encoding in ("utf-8", "gb18030"):
            with suppress(UnicodeDecodeError):
                return member.filename.encode("cp437", "replace").decode(encoding)
    return member.filename


def _whose(folder: Path, lessons: Sequence[str]) -> Iterator[tuple[str, Path]]:
    """Yield the name of a student and a file or folder of theirs."""
    submitted, inbound = (folder if folder.name == name else folder / name for name in ("submitted", "inbound"))
    if submitted.is_dir():
        yield from ((path.name, path) for path in _entries(submitted) if path.is_dir())
        return
    if inbound.is_dir():
        stamped = (path for path in _entries(inbound) if "+" in path.name)  # NAME+ASSIGNMENT+TIME, latest last
        latest = {tuple(path.name.split("+")[:2]): path for path in stamped}
        yield from ((name, path) for (name, _), path in latest.items())
        return
    entries, named = _entries(folder), {}
    for path in entries:
        if path.is_dir() or path.is_symlink():
            named[path] = MOODLE.sub("", path.name)
        elif path.suffix.lower() in NOTEBOOKS | {".zip"}:
            named[path] = _without_lesson(MOODLE.sub("", path.stem), lessons) or folder.resolve().name
    known = sorted(set(named.values()), key=len, reverse=True)
    for path in entries:
        if path in named:
            yield named[path], path
        elif path.suffix.lower() in WORKBOOKS:
            stem = unicodedata.normalize("NFC", MOODLE.sub("", path.stem))
            yield next((name for name in known if _belongs(stem, name)), stem), path


def _without_lesson(stem: str, lessons: Sequence[str]) -> str:
    stem = unicodedata.normalize("NFC", stem)
    for lesson in sorted(lessons, key=len, reverse=True):
        if lesson in stem:
            return stem.replace(lesson, "").strip(SEPARATORS)
    return re.sub(r"(^|[ _-])\d\d[a-z]?_\w+$", "", stem, flags=re.ASCII).strip(SEPARATORS) or stem


def _belongs(stem: str, name: str) -> bool:
    """Whether a file's name begins or ends with a student's, as a word."""
    before, found, after = stem.partition(unicodedata.normalize("NFC", name))
    alone = not before or (not after and before[-1] in SEPARATORS)
    return bool(found) and alone and after[:1] in ("", *SEPARATORS)


def _entries(folder: Path) -> list[Path]:
    return [path for path in sorted(folder.iterdir()) if path.name[0] not in ".~" and path.name not in PASSED_OVER]


def _take(path: Path, student: Student, unpacked: Path, said: str) -> None:
    """Add a file, or all of a folder or zip, to the student's."""
    folder = path  # or where a zip goes
    try:
        if path.is_symlink() or not (path.is_dir() or path.is_file()):
            raise InputError(said, "a file or folder", "a link" if path.is_symlink() else "something else")
        if path.is_file() and path.suffix.lower() == ".zip":
            if "zip" in unpacked.parts:
                raise InputError(said, "files", "a zip in a zip")
            folder = unpacked = unpacked / "zip"
            student.unpacked += unzip(path, folder, ZIP_LIMIT - student.unpacked)
        if said.count("/") > DEEPEST:
            raise InputError(said, f"at most {DEEPEST} folders in each other", "more")
        if folder.is_dir():
            for number, inner in enumerate(_entries(folder)):
                _take(inner, student, unpacked / str(number), f"{said}/{inner.name}")
        elif path.suffix.lower() in NOTEBOOKS | WORKBOOKS:
            if (size := path.stat().st_size) > FILE_LIMIT:
                raise InputError(said, f"at most {FILE_LIMIT // 2**20} MB", f"{size / 2**20:.0f} MB")
            (student.notebooks if path.suffix.lower() in NOTEBOOKS else student.workbooks).append(path)
    except InputError as error:
        student.refused.append((said, f"expected {error.expected}, found {error.found}"))
        if folder != path:
            shutil.rmtree(folder, ignore_errors=True)
    except OSError as error:
        student.refused.append((said, error.strerror or str(error)))
    except Exception as error:  # whatever it is: the others are still collected
        student.refused.append((said, internal(error)))

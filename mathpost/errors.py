"""The package's own errors, and where most of them arise: a caller's arrays, and files read and written."""

import os
from contextlib import suppress
from pathlib import Path
from secrets import token_hex

import numpy as np

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"  # a decimal number as CL files, NC programs and worksheets write it


class MathpostError(ValueError):
    """Every error that mathpost raises on purpose."""


class InputError(MathpostError):
    """Something given to mathpost is wrong: `where` (file and line or key, cell, argument), what should stand there
    and what does, all str.
    """

    def __init__(self, where, expected, found):
        self.where, self.expected, self.found = where, expected, found
        super().__init__(f"{where}: expected {expected}, found {found}")


class ReachError(MathpostError):
    """The machine cannot go there: the tool axis is out of reach or a joint out of travel."""


class OutputError(MathpostError):
    """A result could not be written; nothing was."""


def as_array(values, length, where):
    """Return `values` as a float array of shape ``(..., length)``, all finite, or raise `InputError`."""
    if np.ma.is_masked(values):
        raise InputError(where, "numbers", "masked ones")
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(where, f"numbers of shape (..., {length})", repr(values)) from None
    if array.ndim == 0 or array.shape[-1] != length:
        raise InputError(where, f"shape (..., {length})", f"shape {array.shape}")
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(map(int, np.argwhere(~finite)[0]))
        raise InputError(where, "finite numbers", f"{array[index]} at index {index}")
    return array


def read_bytes(path):
    """Return the content of the file `path`; raise `InputError` if it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise InputError(str(path), "a readable file", error.strerror or str(error)) from None


def data_file(path):
    """Return the path of a file that comes with the package, such as ``"cl/blade.cl"``; `InputError` if none does.

    In a checkout the folder `data` stands beside the package, in an installed package inside it.
    """
    for folder in (Path(__file__).parents[1] / "data", Path(__file__).parent / "data"):
        if (folder / path).exists():
            return folder / path
    raise InputError("data", "a file that comes with the package", f"no data/{path}")


def read_text(path):
    """Return the text of the UTF-8 file `path`; raise `InputError` if it cannot be read."""
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise InputError(f"{path}, line {line}", "UTF-8 text", f"byte 0x{error.object[error.start]:02x}") from None


def write_text(path, text, *, inputs=()):
    """Write `text` as UTF-8; see `write_bytes`."""
    write_bytes(path, text.encode("utf-8"), inputs=inputs)


def write_bytes(path, content, *, inputs=()):
    """Write `content` to `path` whole or not at all; raise `OutputError` if that fails.

    A temporary file in the same folder takes the place of `path` in one step, with the mode and the owner that the
    file had. A link is followed. What is no regular file (a device, a pipe) or one of `inputs` is not replaced.
    """
    path = Path(os.path.realpath(path))
    temporary = path.parent / f".{path.name}.{token_hex(4)}"
    try:
        if old := path.stat() if path.exists() else None:
            _may_be_replaced(path, inputs)
        with open(temporary, "xb") as file:
            if old and hasattr(os, "chown"):
                os.chown(temporary, old.st_uid, old.st_gid)
            if old:
                os.chmod(temporary, old.st_mode & 0o7777)
            file.write(content)
        os.replace(temporary, path)
    except OSError as error:
        raise OutputError(f"{path}: not written, {error.strerror or error}") from None
    finally:
        with suppress(OSError):  # it took the place, or was never there
            temporary.unlink()


def _may_be_replaced(path, inputs):
    if not path.is_file():
        raise OutputError(f"{path}: not written, it is no regular file")
    if any(os.path.exists(each) and path.samefile(each) for each in inputs):
        raise OutputError(f"{path}: not written, it is one of the files that are read")
    if not os.access(path, os.W_OK):
        raise OutputError(f"{path}: not written, Permission denied")

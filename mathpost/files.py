"""Text files, read and written whole or not at all."""

import os
import tempfile
from contextlib import contextmanager
from pathlib import Path

from mathpost.errors import InputError, OutputError


def read_bytes(path):
    """Return the content of the file `path`; raise `InputError` if it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise InputError(str(path), "a readable file", error.strerror or str(error)) from None


def read_text(path):
    """Return the text of the UTF-8 file `path`; raise `InputError` if it cannot be read."""
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise InputError(f"{path}, line {line}", "UTF-8 text", f"byte 0x{error.object[error.start]:02x}") from None


def write_text(path, text):
    """Write `text` as UTF-8 to `path` whole or not at all; raise `OutputError` if that fails."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path, content):
    """Write `content` to `path` whole or not at all; raise `OutputError` if that fails."""
    with replacing(path) as file:
        file.write(content)


@contextmanager
def replacing(path):
    """Open a file for bytes that takes the place of `path` at the end, in one step, unless an error comes first.

    Until then it is a temporary file in the same folder. Raises `OutputError` if it cannot be written.
    """
    path, temporary = Path(path), None
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        with open(handle, "wb") as file:
            yield file
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        raise OutputError(f"{path}: not written, {error.strerror or error}") from None
    finally:
        if temporary:
            Path(temporary).unlink(missing_ok=True)


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask

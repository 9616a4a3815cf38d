"""Is it safe to open this workbook? What could harm or mislead is refused by name, before anything is unpacked."""

from __future__ import annotations

import html
import re
import zipfile
import zlib
from collections.abc import Iterable
from os import PathLike

from mathpost.errors import InputError

MEGABYTE = 2**20
PART_LIMIT = 32 * MEGABYTE  # of a part that is read whole, such as the shared strings
WHOLE_LIMIT = 512 * MEGABYTE  # unpacked
RATIO_LIMIT = 100  # a sheet of a million rows packs about 1:20; a bomb 1:1000
MEMBER_LIMIT = 2000
FORMULA = re.compile(
    r"(?:<(?:\w+:)?(?:f|definedName)\b[^>]*>|table:formula=\"|table:expression=\")([^<\"]*(?:\"[^<]*)?)"
)
OUTSIDE = re.compile(r"WEBSERVICE|\bDDE\s*\(|\w\|\s*'|\[[^\]]*\.(?:xls|ods|csv)|\[\d+\]|'(?:file|https?):", re.I)
FORBIDDEN = {
    "no macros": re.compile(r"vbaProject|macrosheets/|^Basic/|^Scripts/", re.I),
    "no links to other files": re.compile(r"externalLinks/", re.I),
    "no data connections": re.compile(r"xl/(connections|queryTables)", re.I),
    "no embedded objects": re.compile(r"xl/(embeddings|activeX|ctrlProps)/", re.I),
}


def inspect(path: str | PathLike[str]) -> str:
    """Return what `path` is, "xlsx", "ods", "xls" or "text"; an `InputError` names what is not safe."""
    try:
        with open(path, "rb") as file:
            start = file.read(PART_LIMIT)
        if start[:8] == bytes.fromhex("d0cf11e0a1b11ae1"):
            return _inspect_binary(path, start)
        if start[:2] != b"PK":
            return _inspect_text(path, start)
        with zipfile.ZipFile(path) as archive:
            return _inspect_members(path, archive)
    except InputError:
        raise
    except OSError as error:
        raise InputError(str(path), "a readable file", error.strerror or str(error)) from None
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError) as error:
        raise InputError(str(path), "an .xlsx workbook", f"a damaged file ({error})") from None


def _inspect_binary(path: str | PathLike[str], content: bytes) -> str:
    """An old workbook: refused if it is encrypted, or holds macros or names of what reaches outside."""

    for found, expected, words in (
        ("an encrypted file: save it without a password", "a spreadsheet", ("EncryptedPackage", "EncryptionInfo")),
        ("a workbook with macros", "no macros", ("_VBA_PROJECT",)),
        ("WEBSERVICE or DDE", "no links to outside", ("WEBSERVICE", "DDE(")),
    ):
        if _holds(content, words):
            raise InputError(str(path), expected, found)
    if not _holds(content, ("Workbook", "Book")):
        raise InputError(str(path), "a spreadsheet", "another kind of file, or a damaged one")
    return "xls"


def _holds(content: bytes, words: Iterable[str]) -> bool:
    return any(word.encode(code) in content for word in words for code in ("ascii", "utf-16-le"))


def _inspect_text(path: str | PathLike[str], content: bytes) -> str:
    if not str(path).lower().endswith((".csv", ".txt", ".tsv")) or b"\0" in content:
        raise InputError(str(path), "an .xlsx workbook", "another kind of file")
    if found := OUTSIDE.search(content.decode("utf-8", "replace")):
        raise InputError(str(path), "no links to outside", found[0])
    return "text"


def _inspect_members(path: str | PathLike[str], archive: zipfile.ZipFile) -> str:
    members = archive.infolist()
    names = [member.filename for member in members]
    if "xl/workbook.xml" not in names and "content.xml" not in names:
        kind = "a binary workbook" if "xl/workbook.bin" in names else "another kind of archive"
        raise InputError(str(path), "an .xlsx workbook", f"{kind}: save it as .xlsx")
    if any(member.flag_bits & 1 for member in members):
        raise InputError(str(path), "an .xlsx workbook", "an encrypted file: save it without a password")
    unpacked = sum(member.file_size for member in members)
    if len(members) > MEMBER_LIMIT or unpacked > WHOLE_LIMIT:
        found = f"{len(members)} parts, unpacked {unpacked / MEGABYTE:.0f} MB"
        raise InputError(str(path), f"at most {MEMBER_LIMIT} parts and {WHOLE_LIMIT // MEGABYTE} MB", found)
    for member in members:
        is_sheet, where = member.filename.startswith("xl/worksheets/"), f"{path}, {member.filename}"
        limit = max(PART_LIMIT, RATIO_LIMIT * member.compress_size * is_sheet)
        if member.file_size > limit:
            found = f"{member.file_size / MEGABYTE:.0f} MB unpacked, a zip bomb?"
            raise InputError(where, f"at most {limit / MEGABYTE:.0f} MB", found)
        for expected, pattern in FORBIDDEN.items():
            if pattern.search(member.filename):
                raise InputError(str(path), expected, member.filename)
        if member.filename.endswith((".xml", ".rels")):
            _inspect_part(where, archive, member)
    if "[Content_Types].xml" in names and b"macroEnabled" in archive.read("[Content_Types].xml"):
        raise InputError(str(path), "no macros", "a macro-enabled workbook")
    return "xlsx" if "xl/workbook.xml" in names else "ods"


def _inspect_part(where: str, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> None:
    """Look at all of a part, piece by piece: for a document type, and for formulas and names that reach outside."""
    before = b""
    with archive.open(member) as part:
        while piece := part.read(MEGABYTE):
            if not before and b"<!DOCTYPE" in piece[:4096]:
                raise InputError(where, "no document type", "<!DOCTYPE")
            text = html.unescape((before + piece).decode("utf-8", "replace"))
            for found in FORMULA.finditer(text):
                if OUTSIDE.search(found[1]):
                    cells = re.findall(r'<(?:\w+:)?c [^>]*?r="([A-Z]+\d+)"', text[: found.start()])
                    raise InputError(", ".join([where, *cells[-1:]]), "no links to outside", found[1][:80])
            before = piece[-8192:]

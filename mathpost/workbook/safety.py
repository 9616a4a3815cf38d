"""Is it safe to open this workbook? What could harm or mislead is refused by name, before anything is unpacked."""

import html
import re
import zipfile
import zlib

from mathpost.errors import InputError

MEGABYTE = 2**20
PART_LIMIT = 32 * MEGABYTE  # of a part that is read whole, such as the shared strings
WHOLE_LIMIT = 512 * MEGABYTE  # unpacked
RATIO_LIMIT = 100  # a sheet of a million rows packs about 1:20; a bomb 1:1000
MEMBER_LIMIT = 2000
FORMULA = re.compile(
    r"(?:<(?:\w+:)?(?:f|definedName)\b[^>]*>|table:formula=\"|table:expression=\")([^<\"]*(?:\"[^<]*)?)"
)
OUTSIDE = re.compile(
    r"WEBSERVICE|\bDDE\s*\(|\w\|\s*'|\[[^\]]*\.(?:xls|ods|csv)|\[\d+\]|'(?:file|https?):", re.IGNORECASE
)
FORBIDDEN = (
    (re.compile(r"vbaProject|macrosheets/|^Basic/|^Scripts/", re.IGNORECASE), "no macros"),
    (re.compile(r"externalLinks/", re.IGNORECASE), "no links to other files"),
    (re.compile(r"xl/(connections|queryTables)", re.IGNORECASE), "no data connections"),
    (re.compile(r"xl/(embeddings|activeX|ctrlProps)/", re.IGNORECASE), "no embedded objects"),
)


def inspect(path):
    """Return what `path` is, ``"xlsx"``, ``"ods"``, ``"xls"`` or ``"text"``, if it can be opened safely.

    Raises
    ------
    InputError
        Names what is in the way.
    """
    try:
        with open(path, "rb") as file:
            start = file.read(8)
            if start == bytes.fromhex("d0cf11e0a1b11ae1"):
                return _inspect_binary(path, start + file.read(PART_LIMIT))
            if start[:2] != b"PK":
                return _inspect_text(path, start + file.read(PART_LIMIT))
    except OSError as error:
        raise InputError(str(path), "a readable file", error.strerror or str(error)) from None
    try:
        with zipfile.ZipFile(path) as archive:
            return _inspect_members(path, archive)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(str(path), "an .xlsx workbook", f"a damaged file ({error})") from None


def _inspect_binary(path, content):
    """An old workbook: refused if it is encrypted, or holds macros or names of what reaches outside."""
    wide = lambda text: text.encode("utf-16-le")  # noqa: E731
    if wide("EncryptedPackage") in content or wide("EncryptionInfo") in content:
        raise InputError(str(path), "a spreadsheet", "an encrypted file: save it without a password")
    if wide("_VBA_PROJECT") in content or b"_VBA_PROJECT" in content:
        raise InputError(str(path), "no macros", "a workbook with macros")
    if any(form(word) in content for word in ("WEBSERVICE", "DDE(") for form in (wide, str.encode)):
        raise InputError(str(path), "no links to outside", "WEBSERVICE or DDE")
    if wide("Workbook") not in content and wide("Book") not in content:
        raise InputError(str(path), "a spreadsheet", "another kind of file, or a damaged one")
    return "xls"


def _inspect_text(path, content):
    if not str(path).lower().endswith((".csv", ".txt", ".tsv")) or b"\0" in content:
        raise InputError(str(path), "an .xlsx workbook", "another kind of file")
    if found := OUTSIDE.search(content.decode("utf-8", "replace")):
        raise InputError(str(path), "no links to outside", found[0])
    return "text"


def _inspect_members(path, archive):
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
        in_memory = not member.filename.startswith("xl/worksheets/")
        limit = PART_LIMIT if in_memory else max(PART_LIMIT, RATIO_LIMIT * member.compress_size)
        if member.file_size > limit:
            where, found = (
                f"{path}, {member.filename}",
                f"{member.file_size / MEGABYTE:.0f} MB unpacked, a zip bomb?",
            )
            raise InputError(where, f"at most {limit / MEGABYTE:.0f} MB", found)
        for pattern, expected in FORBIDDEN:
            if pattern.search(member.filename):
                raise InputError(str(path), expected, _describe(archive, member))
        if member.filename.endswith((".xml", ".rels")):
            _inspect_part(path, archive, member)
    types = archive.read("[Content_Types].xml") if "[Content_Types].xml" in names else b""
    if b"macroEnabled" in types:
        raise InputError(str(path), "no macros", "a macro-enabled workbook")
    return "xlsx" if "xl/workbook.xml" in names else "ods"


def _inspect_part(path, archive, member):
    """Look at all of a part, piece by piece: for a document type, and for formulas and names that reach outside."""
    before, first = b"", True
    with archive.open(member) as part:
        while piece := part.read(MEGABYTE):
            if first and b"<!DOCTYPE" in piece[:4096]:
                raise InputError(f"{path}, {member.filename}", "no document type", "<!DOCTYPE")
            text = html.unescape((before + piece).decode("utf-8", "replace"))
            for found in FORMULA.finditer(text):
                if OUTSIDE.search(found[1]):
                    cells = re.findall(r'<(?:\w+:)?c [^>]*?r="([A-Z]+\d+)"', text[: found.start()])
                    where = f"{path}, {member.filename}" + (f", {cells[-1]}" if cells else "")
                    raise InputError(where, "no links to outside", found[1][:80])
            before, first = piece[-8192:], False


def _describe(archive, member):
    """Name what was found: of a link to another file, the file."""
    if "externalLinks/" in member.filename:
        rels = [name for name in archive.namelist() if "externalLinks/_rels/" in name]
        targets = [
            t
            for name in rels
            for t in re.findall(r'Target="([^"]*)"', archive.read(name).decode("utf-8", "replace"))
        ]
        if targets:
            return f"a link to {', '.join(targets)}"
    return member.filename

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
FORBIDDEN = (
    (re.compile(r"vbaProject|macrosheets/", re.IGNORECASE), "no macros"),
    (re.compile(r"externalLinks/", re.IGNORECASE), "no links to other files"),
    (re.compile(r"xl/(connections|queryTables)", re.IGNORECASE), "no data connections"),
    (re.compile(r"xl/(embeddings|activeX|ctrlProps)/", re.IGNORECASE), "no embedded objects"),
)
FORMULA = re.compile(rb"<(?:\w+:)?(?:f|definedName)\b[^>]*>([^<]+)")
PLACE = re.compile(rb'\sr="([A-Z]+\d+)"')
OUTSIDE = re.compile(  # a formula that fetches something: from the net, from a program (DDE), from a file
    r"WEBSERVICE\s*\(|\bDDE\s*\(|\w\|\s*('[^']*'|\w+)\s*!|\[[^\]]*\.(?:xls|ods|csv)|\[\d+\]", re.IGNORECASE
)


def inspect(path):
    """Raise `InputError` if `path` is not a workbook that can be opened safely."""
    try:
        with open(path, "rb") as file:
            start = file.read(8)
            if start == bytes.fromhex("d0cf11e0a1b11ae1"):
                encrypted = "EncryptedPackage".encode("utf-16-le") in file.read(4 * MEGABYTE)
                found = "an encrypted file: save it without a password" if encrypted else "an old binary workbook"
                raise InputError(str(path), "an .xlsx workbook", found)
    except OSError as error:
        raise InputError(str(path), "a readable file", error.strerror or str(error)) from None
    try:
        with zipfile.ZipFile(path) as archive:
            _inspect_members(path, archive)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        found = "a damaged file" if zipfile.is_zipfile(path) else "another kind of file"
        raise InputError(str(path), "an .xlsx workbook", f"{found} ({error})") from None


def _inspect_members(path, archive):
    members = archive.infolist()
    names = [member.filename for member in members]
    if "xl/workbook.xml" not in names:
        found = {"xl/workbook.bin": "a binary workbook", "content.xml": "an OpenDocument file"}
        kind = next((text for name, text in found.items() if name in names), "another kind of archive")
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
            with archive.open(member) as part:
                if b"<!DOCTYPE" in part.read(4096):
                    raise InputError(f"{path}, {member.filename}", "no document type", "<!DOCTYPE")
        if member.filename == "xl/workbook.xml" or member.filename.startswith("xl/worksheets/"):
            _inspect_formulas(path, archive, member)
    types = archive.read("[Content_Types].xml") if "[Content_Types].xml" in names else b""
    if b"macroEnabled" in types:
        raise InputError(str(path), "no macros", "a macro-enabled workbook")


def _inspect_formulas(path, archive, member):
    """Raise `InputError` if a formula or a name anywhere in the part reaches out of the workbook."""
    rest = b""
    with archive.open(member) as part:
        while chunk := part.read(MEGABYTE):
            content = rest + chunk
            for found in FORMULA.finditer(content):
                formula = html.unescape(found[1].decode("utf-8", "replace"))
                if OUTSIDE.search(re.sub(r'"[^"]*"', "", formula)):
                    places = PLACE.findall(content[max(0, found.start() - 500) : found.start()])
                    place = places[-1].decode() if places else "a defined name"
                    raise InputError(f"{path}, {member.filename}, {place}", "no links to outside", formula)
            rest = content[-10_000:]  # a formula may lie across two chunks


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

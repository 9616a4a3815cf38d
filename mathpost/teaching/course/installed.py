"""A check that the installed packages are those that the course requires."""

from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement


def check(pins: Path | str = "../environment.txt") -> None:
    """Print each package whose version is not that required by `pins`, or without that file by the package."""
    path = Path(pins)
    asked = path.read_text(encoding="utf-8").splitlines() if path.exists() else metadata.requires("mathpost")
    wrong = []
    for line in asked or ():
        if not line[:1].isalpha():
            continue
        need = Requirement(line.partition("#")[0])
        if need.marker and not need.marker.evaluate({"extra": "course"}):
            continue
        try:
            here = metadata.version(need.name)
        except metadata.PackageNotFoundError:
            here = None
        if here is None or here not in need.specifier:
            wrong.append(f"{need} was asked for, {here or 'none'} is here")
    print("\n".join(wrong) or "all packages as asked for")

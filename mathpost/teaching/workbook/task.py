"""What a sheet was asked to do; what the caller leaves open the sheet's texts say, or else source 000 does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mathpost import euler
from mathpost.errors import InputError, as_array
from mathpost.files import beside, read_toml

if TYPE_CHECKING:
    from mathpost.machine import Machine


@dataclass(frozen=True)
class Task:
    """What the sheet was asked to do; None leaves it to the sheet, and then to source 000.

    Attributes
    ----------
    kind : str
        ``"zxz"``, ``"sequence"`` or ``"nc"``.
    sequence : str
        As in `mathpost.euler`: ``"ZXZ"`` about turned axes, ``"zxz"`` about fixed ones.
    convention : str
        ``"passive"``: coordinates of a fixed point in the turned frame; ``"active"``: the turned point.
    angles, point, origin : sequence of 3 numbers
        Degrees and mm, to be found in the input cells.
    machine : Machine or path of a machine file
    cells : dict
        ``{"angles": "B2:B4", "point": "C2:C4", "origin": "D2:D4", "result": "H2:H4"}``.
    """

    kind: str | None = None
    sequence: str | None = None
    convention: str | None = None
    angles: Sequence[float] | None = None
    point: Sequence[float] | None = None
    origin: Sequence[float] | None = None
    machine: Machine | str | Path | None = None
    cells: dict[str, str] | None = None

    def __post_init__(self) -> None:
        for name, known in (("kind", ("zxz", "sequence", "nc")), ("convention", ("active", "passive"))):
            if getattr(self, name) not in (None, *known):
                raise InputError(name, " or ".join(known), repr(getattr(self, name)))
        for name in ("angles", "point", "origin"):
            if getattr(self, name) is not None:
                as_array(getattr(self, name), 3, name)
        if self.sequence is not None:
            euler.matrix(self.sequence, (0, 0, 0))


def task_file(path: str | Path) -> dict[str, Any]:
    """Return the fields of a `Task` from a TOML file.

    Raises
    ------
    InputError
        If it cannot be read or holds another key.
    """
    given = read_toml(path)
    known = [each.name for each in fields(Task)]
    for key in given:
        if key not in known:
            raise InputError(f"{path}, {key}", f"one of {', '.join(known)}", key)
    name = given.get("machine")
    if isinstance(name, str) and not name.isidentifier():  # the name of one that comes with the package
        given["machine"] = str(beside(path, name, ".toml", f"{path}, machine"))
    return given

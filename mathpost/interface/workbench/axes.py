"""Travel, rates and accelerations of a machine's axes as numbers to change, and the machine file with them."""

from __future__ import annotations

import tomllib
from typing import Any

import ipywidgets as widgets
import tomlkit

from mathpost.errors import InputError, MathpostError
from mathpost.files import typed_number
from mathpost.machine import LETTERS
from mathpost.machine_file import from_dict

COLUMNS = ("from", "to", "rate", "acceleration")
Row = dict[str, float | None]  # from column to number; None: not stated
CELL = widgets.Layout(width="255px")
LABEL = {"description_width": "155px"}
WEIGHTS = (
    "Rates are the weights of the selection: a move costs the seconds of its slowest axis, so half the rate counts "
    "twice. An axis without a rate costs nothing."
)


class Axes(widgets.VBox):
    """A row of numbers for each axis of a machine file, in the file's own units; an empty field is not stated."""

    def __init__(self) -> None:
        super().__init__()
        self.name = ""
        self.content: str | None = ""
        self.stated: dict[str, Row] = {}
        self.cells: dict[str, dict[str, widgets.Text]] = {}
        self.add_class("mathpost-axes")

    def show(self, name: str, content: str | None) -> None:
        """Show the axes of a machine file; numbers typed for a different one are dropped."""
        if content == self.content:
            return
        try:
            self.stated = _stated(content, name) if content is not None else {}
        except MathpostError:  # which the run will report
            content, self.stated = None, {}
        self.name, self.content, rows = name, content, []
        self.cells = {axis: dict.fromkeys(COLUMNS) for axis in self.stated}
        for name, values in self.stated.items():
            unit = "mm" if name in LETTERS else "°"
            units = dict(zip(COLUMNS, (unit, unit, f"{unit}/s", f"{unit}/s²"), strict=True))
            for column in COLUMNS:
                self.cells[name][column] = widgets.Text(
                    value=_text(values[column]), description=f"{name} {column}, {units[column]}", layout=CELL,
                    placeholder="none", style=LABEL,
                )  # fmt: skip
            rows.append(widgets.HBox(list(self.cells[name].values())))
        said = WEIGHTS if rows else "choose a machine first"
        self.children = (widgets.HTML(f"<span class=mathpost-help>{said}</span>"), *rows)

    def changed(self) -> str | None:
        """Return the machine file with the numbers that were typed, its comments kept; None if none was changed."""
        typed = {name: {column: _number(cell) for column, cell in row.items()} for name, row in self.cells.items()}
        if self.content is None or typed == self.stated:
            return None
        content = tomlkit.parse(self.content)
        for name, row in typed.items():
            if (row["from"] is None) != (row["to"] is None):
                raise InputError(f"{name} from, to", "both ends of the travel, or neither", "one")
            if row != self.stated[name]:
                _put(_table(content, name), row, self.stated[name])
        return tomlkit.dumps(content)


def _stated(text: str, name: str) -> dict[str, Row]:
    """Return axis → column → number of a machine file, None where it states none."""
    try:
        content = tomllib.loads(text)
        from_dict(content, name)
    except tomllib.TOMLDecodeError as error:
        raise InputError(name, "a TOML file", str(error)) from None
    found = {}
    linear = content.get("linear", {})
    for entry in [{"name": name, **linear.get(name, {})} for name in LETTERS] + content["rotary"]:
        low, high = entry.get("limits", (None, None))
        values = (low, high, entry.get("max_rate"), entry.get("max_acceleration"))
        numbers = (None if each is None else float(each) for each in values)
        found[entry["name"]] = dict(zip(COLUMNS, numbers, strict=True))
    return found


def _text(value: float | None) -> str:
    return "" if value is None else f"{value:.12g}"


def _number(cell: widgets.Text) -> float | None:
    try:
        return float(typed_number(cell.value)) if cell.value.strip() else None
    except ValueError:
        raise InputError(cell.description, "a number, or nothing", repr(cell.value)) from None


def _table(content: tomlkit.TOMLDocument, name: str) -> dict[str, Any]:
    """Return the table of an axis in a machine file, made if it is missing."""
    if name in LETTERS:
        linear = content.setdefault("linear", tomlkit.table())
        return linear.setdefault(name, tomlkit.inline_table())
    return next(entry for entry in content["rotary"] if entry["name"] == name)


def _put(table: dict[str, Any], row: Row, before: Row) -> None:
    """Write the numbers of one axis that have changed; the comment of each stays."""
    values, was = _keys(row), _keys(before)
    for key, value in values.items():
        if value is None:
            table.pop(key, None)
        elif value != was[key]:
            item = tomlkit.item(value)
            if key in table:
                there = table[key].trivia
                item.trivia.comment_ws, item.trivia.comment = there.comment_ws, there.comment
            table[key] = item


def _keys(row: Row) -> dict[str, Any]:
    """Return the numbers of one axis by their keys in a machine file; None: not stated."""
    ends = [row["from"], row["to"]]
    return {
        "limits": None if ends == [None, None] else ends,
        "max_rate": row["rate"],
        "max_acceleration": row["acceleration"],
    }

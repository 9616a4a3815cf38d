"""Places of cells: (sheet, row, column), rows and columns from 1."""

from __future__ import annotations

Place = tuple[str, int, int]
Line = tuple[Place, ...]  # in their order


def beside(place: Place) -> list[Place]:
    """The four places beside a place."""
    sheet, row, column = place
    return [(sheet, row + down, column + right) for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1))]


def offset(place: Place, down: int, right: int) -> Place:
    """The place so many rows further down and columns further right."""
    return place[0], place[1] + down, place[2] + right


def number_along(place: Place, along: int) -> int:
    """Return the row of a place for `along` 1, its column for 2."""
    return place[1] if along == 1 else place[2]

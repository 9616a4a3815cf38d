"""Where the point is taken: about which origin or centre it is turned, and what is added to it."""

from dataclasses import dataclass

import numpy as np

from mathpost.detective.misreadings import Slip

NOWHERE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Placing:
    """What is added to the point before the rotation and after it, in words and as it is written."""

    before: tuple = NOWHERE
    after: tuple = NOWHERE
    slips: tuple = ()
    point: str = "p"
    added: str = ""


PLAIN = Placing()


def about(origin):
    """Return the placings to try where the point is to be taken relative to `origin`; the first is right."""
    o, minus = tuple(origin.tolist()), tuple((-origin).tolist())
    centre = "the origin is added again after the rotation: it is taken for the centre of rotation"
    return (
        Placing(minus, point="(p − o)"),
        Placing(slips=(Slip("origin", 1, "the origin is not subtracted"),)),
        Placing(o, slips=(Slip("origin", 1, "the origin is added, not subtracted"),), point="(p + o)"),
        Placing(minus, o, (Slip("centre", 1, centre),), "(p − o)", " + o"),
        Placing(NOWHERE, minus, (Slip("origin", 1.1, "the origin is subtracted after the rotation"),), "p", " − o"),
        Placing(NOWHERE, o, (Slip("origin", 1.25, "the origin is added after the rotation"),), "p", " + o"),
    )


def translated(matrix, shift, tolerance):
    """Return the placing of points that were turned by `matrix` and then moved by `shift`.

    A shift across the axis of rotation is what a rotation about another centre makes: the centre that is nearest
    to the origin is named.
    """
    moved = np.eye(3) - matrix
    centre = np.linalg.lstsq(moved, shift, rcond=1e-6)[0]
    if np.abs(moved @ centre - shift).max() <= 4 * tolerance:
        phrase = f"it is turned about another centre, such as ({_numbers(centre, tolerance)})"
        slip = Slip("centre", 1.25, phrase)
    else:
        slip = Slip("translation", 1.25, f"({_numbers(shift, tolerance)}) is added to every point")
    return Placing(after=tuple(shift.tolist()), slips=(slip,), added=" + t")


def _numbers(values, tolerance):
    decimals = max(0, int(np.ceil(-np.log10(2 * tolerance))) - 1)
    return ", ".join(f"{value:z.{decimals}f}" for value in values)

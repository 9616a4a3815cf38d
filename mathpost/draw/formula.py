"""Views that move by any sympy expressions: where bodies stand, where lines run, which numbers are said."""

import re

import numpy as np
import sympy as sp

from mathpost import codegen
from mathpost.draw.live import Live
from mathpost.rotation import numeric

GAP = re.compile(r"\{(?::(\d+)|\?([^}]*))\}")


def slider(name, low, high, value, *, step=1.0, unit="°", **more):
    """Return a slider: an angle in degrees unless `unit` says otherwise; `hidden=True` leaves it to the buttons.

    Its value times its factor is what printed functions take: radians of degrees, and other units as they are.
    """
    made = {"name": name, "low": low, "high": high, "value": value, "step": step, "unit": unit}
    return made | {"factor": np.pi / 180 if unit == "°" else 1.0} | more


def compiled(symbols, sliders, text, ways, **functions):
    """Print what sliders move, and evaluate it at their start.

    `text` is that of `formula`, `ways` are lists of points, `functions` expressions by name. Return the state for
    the browser, the JavaScript, the text and the ways at the start, and the values of the functions, a dict.
    """
    functions["points"] = [entry for way in ways for point in way for entry in point]
    functions["numbers"] = [entry for _, *entries in text for entry in entries]
    code = "\n".join(codegen.function(name, entries, symbols) for name, entries in functions.items())
    start = [each["value"] * each["factor"] for each in sliders]
    values = {name: numeric(tuple(entries), tuple(symbols))(*start) for name, entries in functions.items()}
    numbers, left = iter(values["numbers"]), iter(values["points"])
    ends = [np.reshape([[next(left) for _ in point] for point in way], (len(way), -1)) for way in ways]

    def filled(gap):
        digits, words = gap.groups()
        return f"{next(numbers):z.{digits}f}" if digits else words * bool(next(numbers))

    lines = [line for line, *_ in text]
    said = "; ".join(GAP.sub(filled, line) for line in lines)
    return {"sliders": list(sliders), "text": lines}, [code], said, ends, values


def formula(scenes, symbols, sliders, places, text, *, buttons=(), play=None, **options):
    """Return a view of one or more `Scene`s that move by printed expressions.

    The sliders, from `slider`, set the `symbols`, one each, angles in radians. `places` has for each name of a body
    of the scenes a matrix in the symbols: 3×3 a rotation, 4×4 a transform. A line of the scenes that has `points`,
    3×1 matrices in the coordinates of its body, is drawn anew through them. `text` are tuples of a line under the
    pictures and the numbers in it: ``{:4}`` is the next with four decimals, ``{?words}`` shows the words if the
    next is not 0. `buttons` are pairs of a label and the values that are set, None where a slider stays; `play` is
    the number of the slider that buttons play, pause and step move; `options` are those of `Live`.

    Examples
    --------
    >>> from mathpost.draw.scene import Scene
    >>> from mathpost.rotation import ACTIVE
    >>> t = sp.Symbol("t")
    >>> plate = {"plate": ACTIVE["Z"](t)}
    >>> formula([Scene(["plate"])], [t], [slider("t", 0, 90, 60)], plate, [("cosine {:2}", sp.cos(t))])
    cosine 0.50
    """
    placed = [matrix if matrix.rows == 4 else sp.diag(matrix, 1) for matrix in places.values()]
    lines = [line for scene in scenes for line in scene.lines if line.points]
    entries = [entry for matrix in placed for entry in matrix[:3, :]]
    state, code, said, ends, start = compiled(symbols, sliders, text, [e.points for e in lines], places=entries)
    for line, way in zip(lines, ends, strict=True):
        line.parts = [way]
    rows = start["places"].reshape(-1, 3, 4)
    at = {"bed": np.eye(4)} | {n: np.vstack([r, [0, 0, 0, 1]]) for n, r in zip(places, rows, strict=True)}
    state |= {"kind": "formula", "play": play, "places": [list(button) for button in buttons]}
    return Live(state, code, said, scenes, [at] * len(scenes), **options)

"""Views that move by any sympy expressions: where bodies stand, where lines run, which numbers are said."""

import re

import numpy as np
import sympy as sp

from mathpost import codegen
from mathpost.draw.live import Live
from mathpost.rotation import numeric

NUMBER = re.compile(r"\{(\d+)(?::(\d+)|\?([^}]*))\}")


def slider(name, low, high, value, *, step=1.0, unit="°", **more):
    """Return a slider: an angle in degrees unless `unit` says otherwise; `hidden=True` leaves it to the buttons.

    Its value times its factor is what printed functions take: radians of degrees, and other units as they are.
    """
    made = {"name": name, "low": low, "high": high, "value": value, "step": step, "unit": unit}
    return made | {"factor": np.pi / 180 if unit == "°" else 1.0} | more


def written(text, numbers):
    """Return the lines of `text` with these numbers in their places, as `live.js` does."""

    def filled(found):
        index, digits, words = found.groups()
        return f"{numbers[int(index)]:z.{digits}f}" if digits else words * bool(numbers[int(index)])

    return [NUMBER.sub(filled, line) for line in text]


def compiled(functions, symbols, sliders, text):
    """Print `functions`, expressions by name, and evaluate them at the start of the sliders.

    Return their JavaScript, a dict of arrays, and the `text` with the "numbers" among them.
    """
    symbols = tuple(symbols)
    code = "\n".join(codegen.function(name, entries, symbols) for name, entries in functions.items())
    start = [each["value"] * each["factor"] for each in sliders]
    values = {name: numeric(tuple(entries), symbols)(*start) for name, entries in functions.items()}
    return code, values, "; ".join(written(text, values["numbers"]))


def formula(
    scene, symbols, sliders, places, text, *, numbers=(), points=(), buttons=(), beside=(), play=None, **options
):
    """Make a view of a scene that moves by printed expressions.

    Parameters
    ----------
    scene : mathpost.draw.scene.Scene
        Its lines with a name are drawn through ``points[span[0]:span[1]]``, anew for each position.
    symbols : sequence of sympy symbols
        What the sliders set; angles in radians.
    sliders : sequence of dict
        From `slider`, one for each symbol.
    places : dict
        Name of each of the scene's bodies to a matrix in the symbols: 3×3 a rotation, 4×4 a transform.
    text : sequence of str
        Lines under the picture; ``{0:4}`` is the first of the numbers with four decimals, ``{1?words}`` shows the
        words where the second is not 0.
    numbers, points : sequences of sympy expressions, and of 3×1 sympy matrices
        Those of the text, and in the coordinates of the body of the line that runs through them.
    buttons : sequence of (str, list)
        Label of a button and the values that it sets, None where a slider stays.
    play : int, optional
        The slider that buttons play, pause and step move.
    beside : sequence of Scene
        More pictures of the same bodies.
    **options
        Of `Live`.

    Examples
    --------
    >>> from mathpost.draw.scene import Scene
    >>> from mathpost.rotation import ACTIVE
    >>> t = sp.Symbol("t")
    >>> scene = Scene(["plate"])
    >>> plate = {"plate": ACTIVE["Z"](t)}
    >>> formula(scene, [t], [slider("t", 0, 90, 60)], plate, ["cosine {0:2}"], numbers=[sp.cos(t)])
    cosine 0.50
    """
    placed = [matrix if matrix.rows == 4 else sp.diag(matrix, 1) for matrix in places.values()]
    functions = {"places": [entry for matrix in placed for entry in matrix[:3, :]]}
    functions |= {"numbers": list(numbers), "points": [entry for point in points for entry in point]}
    code, start, said = compiled(functions, symbols, sliders, text)
    rows = start["places"].reshape(-1, 3, 4)
    at = {"bed": np.eye(4)} | {n: np.vstack([r, [0, 0, 0, 1]]) for n, r in zip(places, rows, strict=True)}
    scenes, ends = [scene, *beside], start["points"].reshape(-1, 3)
    for line in (line for each in scenes for line in each.lines if line.name):
        line.parts = [ends[slice(*line.span)]]
    state = {"kind": "formula", "sliders": list(sliders), "text": list(text), "play": play}
    state["places"] = [list(button) for button in buttons]
    return Live(state, [code], tuple(functions), scenes, [at] * len(scenes), said, **options)

"""Cells of a spreadsheet as sympy expressions of its inputs."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike

import numpy as np
import sympy as sp

from mathpost.errors import InputError
from mathpost.teaching.workbook.sheet.evaluate import FUNCTIONS
from mathpost.teaching.workbook.sheet.file import read
from mathpost.teaching.workbook.sheet.graph import Graph
from mathpost.teaching.workbook.sheet.tree import heads

EXACT = {
    **{name: FUNCTIONS[name] for name in ("+", "-", "*", "minus", "MMULT", "TRANSPOSE", "SUM", "SUMPRODUCT")},
    **{"/": np.divide, "^": np.power},
    **{
        name: np.frompyfunc(getattr(sp, name.lower()), 1, 1)
        for name in ("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT")
    },
    **{"ATAN2": np.frompyfunc(lambda x, y: sp.atan2(y, x), 2, 1), "PI": lambda: np.full((1, 1, 1), sp.pi)},
    **{"RADIANS": lambda x: x * sp.pi / 180, "DEGREES": lambda x: x * 180 / sp.pi},
}


def symbolic(path: str | PathLike[str], cells: str, symbols: Mapping[str, sp.Symbol]) -> sp.Matrix:
    """Return cells of a spreadsheet as a matrix of expressions, through however many cells their formulas pass.

    Parameters
    ----------
    path : str or path-like
    cells : str
        An address such as ``"E20:G22"`` or ``"Sheet1!J20"``.
    symbols : dict
        Address of an input → its sympy symbol.

    Returns
    -------
    sympy.Matrix

    Raises
    ------
    InputError
        If the file or an address cannot be read, or a formula uses a function that has no sympy form here.

    Examples
    --------
    >>> alpha = sp.Symbol("alpha")
    >>> symbolic("data/workbooks/right.xlsx", "A14:B14", {"C5": alpha})
    Matrix([[cos(pi*alpha/180), sin(pi*alpha/180)]])
    """
    graph = Graph(read(path))
    given = {graph.named("symbols", address).places[0]: np.array([symbol]) for address, symbol in symbols.items()}
    area = graph.named("cells", cells)
    needed = graph.upstream(area.places)
    used = set().union(*(heads(graph.tree(place)) for place in needed - given.keys()))
    if other := sorted(used - EXACT.keys() - {"number", "text", "area"}):
        raise InputError(str(path), "functions with a sympy form", ", ".join(other))
    graph.functions = EXACT
    entries = graph.look(area, graph.run(given, only=needed))[0]
    return sp.Matrix(entries).applyfunc(lambda entry: sp.nsimplify(entry, rational=True))

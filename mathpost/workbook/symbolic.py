"""Cells of a spreadsheet as sympy expressions of its inputs."""

import operator
from functools import reduce

import sympy as sp

from mathpost.errors import InputError
from mathpost.workbook.file import read
from mathpost.workbook.formula import NotUnderstood, fold
from mathpost.workbook.graph import Graph

FUNCTIONS = {
    **{name: getattr(sp, name.lower()) for name in ("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT")},
    **{"ATAN2": lambda x, y: sp.atan2(y, x), "PI": lambda: sp.pi},
    **{"RADIANS": lambda x: x * sp.pi / 180, "DEGREES": lambda x: x * 180 / sp.pi},
    **{"MMULT": operator.mul, "TRANSPOSE": lambda a: a.T, "minus": operator.neg, "^": operator.pow},
    **{"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv},
    "SUM": lambda *values: sum(sum(v) if isinstance(v, sp.MatrixBase) else v for v in values),
    "SUMPRODUCT": lambda *values: sum(reduce(lambda a, b: a.multiply_elementwise(b), values)),
}


def symbolic(path, cells, symbols):
    """Return cells of a spreadsheet as a matrix of what their formulas are, however many cells they pass through.

    Parameters
    ----------
    path : str or path-like
    cells : str
        An address such as ``"E20:G22"`` or ``"Sheet1!J20"``.
    symbols : dict
        Address of an input → sympy symbol that stands for it.

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
    known = {graph.named("symbols", address).places[0]: symbol for address, symbol in symbols.items()}

    def of_cell(place):
        if place not in known:
            tree = graph.trees.get(place, ("number", graph.value(place) or 0))
            found = fold(tree, of_leaf, FUNCTIONS)
            known[place] = found[graph.part[place]] if place in graph.part else found
        return known[place]

    def of_leaf(kind, content):
        if kind == "area":
            entries = [of_cell(place) for place in content.places]
            return entries[0] if len(entries) == 1 else sp.Matrix(*content.shape, entries)
        return sp.nsimplify(content)

    area = graph.named("cells", cells)
    try:
        return sp.Matrix(*area.shape, [of_cell(place) for place in area.places])
    except NotUnderstood as error:
        raise InputError(str(path), "functions with a sympy form", str(error)) from None

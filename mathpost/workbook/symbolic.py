"""Cells of a spreadsheet as sympy expressions of its inputs."""

from functools import reduce

import sympy as sp

from mathpost.errors import InputError
from mathpost.workbook.file import read
from mathpost.workbook.graph import Graph, area_named

FUNCTIONS = {
    **{name: getattr(sp, name.lower()) for name in ("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SQRT")},
    "ATAN2": lambda x, y: sp.atan2(y, x),
    "RADIANS": lambda x: x * sp.pi / 180,
    "DEGREES": lambda x: x * 180 / sp.pi,
    "PI": lambda: sp.pi,
    "MMULT": lambda a, b: a * b,
    "TRANSPOSE": lambda a: a.T,
    "SUM": lambda *values: sum(sum(v) if isinstance(v, sp.MatrixBase) else v for v in values),
    "SUMPRODUCT": lambda *values: sum(reduce(lambda a, b: a.multiply_elementwise(b), values)),
}
OPERATORS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "^": lambda a, b: a**b,
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
    known = {area_named(graph, "symbols", address).places[0]: symbol for address, symbol in symbols.items()}

    def of_cell(place):
        if place not in known:
            number = graph.value(place)
            known[place] = of_tree(graph.trees[place]) if place in graph.trees else sp.nsimplify(number or 0)
            if place in graph.part:
                known[place] = known[place][graph.part[place]]
        return known[place]

    def of_tree(tree):
        kind = tree[0]
        if kind == "number":
            return sp.nsimplify(tree[1])
        if kind == "area":
            entries = [of_cell(place) for place in tree[1].places]
            return entries[0] if len(entries) == 1 else sp.Matrix(*tree[1].shape, entries)
        if kind == "minus":
            return -of_tree(tree[1])
        if kind == "call" and tree[1] in FUNCTIONS:
            return FUNCTIONS[tree[1]](*map(of_tree, tree[2]))
        if kind in OPERATORS:
            return OPERATORS[kind](of_tree(tree[1]), of_tree(tree[2]))
        raise InputError(str(path), "functions with a sympy form", tree[1] if kind == "call" else kind)

    area = area_named(graph, "cells", cells)
    return sp.Matrix(*area.shape, [of_cell(place) for place in area.places])

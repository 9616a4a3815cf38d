"""The derivation printed for other programs: a machine, or any sympy expressions, as JavaScript, C or LaTeX.

`function` prints expressions as one function of an array, their common subexpressions computed once. `machine`
prints a machine as a self-contained file: every body's pose, forward, both inverse branches, the Jacobian.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

import sympy as sp
from sympy.printing.c import C99CodePrinter
from sympy.printing.codeprinter import CodePrinter
from sympy.printing.jscode import JavascriptCodePrinter

from mathpost import chain
from mathpost.errors import InputError
from mathpost.files import read_text
from mathpost.formula import shared
from mathpost.kinematics import ABOVE, AT_POLE, BELOW, PRINTED, REACH_TOLERANCE, solved

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics

LANGUAGES = ("latex", "js", "c")
TEMPLATES = Path(__file__).parent / "codegen_templates"  # code that calls the printed functions, by language


def function(
    name: str,
    outputs: Iterable[sp.Expr],
    arguments: Sequence[sp.Symbol],
    language: str = "js",
    named: Iterable[tuple[sp.Symbol, sp.Expr]] = (),
) -> str:
    """Print expressions as the source of a function ``name(q, out)`` that reads one array and fills another.

    `arguments` are symbols of any name, in their order in the array `q`; `language` is ``"js"`` or ``"c"``. The
    JavaScript function also returns `out`, by default a new array. `named` are pairs of a further symbol and its
    expression.

    Examples
    --------
    >>> x, y = sp.symbols("x y")
    >>> print(function("turned", [sp.cos(x) * y, sp.sin(x) * y], [x, y], "c"))
    static void turned(const double *q, double *out) {
        const double q0 = q[0];
        const double q1 = q[1];
        out[0] = q1*cos(q0);
        out[1] = q1*sin(q0);
    }
    """
    read = dict(zip(arguments, sp.symbols(f"q:{len(arguments)}"), strict=True))
    meaning = [*read.items(), *((symbol, read.get(value, value)) for symbol, value in named)]
    common, results = shared(outputs, sp.numbered_symbols("t"), meaning)
    head, number, code = _DIALECTS[language]
    used = set().union(*(entry.free_symbols for entry in (*results, *(value for _, value in common))))
    lines = [f"    {number} {symbol} = q[{index}];" for index, symbol in enumerate(read.values()) if symbol in used]
    lines += [f"    {number} {symbol} = {code(value)};" for symbol, value in common]
    lines += [f"    out[{index}] = {code(value)};" for index, value in enumerate(results)]
    return "\n".join([head.format(name=name), *lines, *(["    return out;"] if language == "js" else []), "}"])


class _Doubles(CodePrinter):
    """Constants with all digits of a double, squares as products, roots as such."""

    def _print_Float(self, number: sp.Float) -> str:
        return repr(float(number))

    def _print_Pow(self, power: sp.Pow) -> str:
        if power.exp == 2 and power.base.is_Symbol:
            return f"{power.base}*{power.base}"
        if power.exp == -sp.S.Half:
            return f"1.0/{self._print(sp.sqrt(power.base))}"
        return super()._print_Pow(power)


class _JavaScript(_Doubles, JavascriptCodePrinter):
    pass


class _C(_Doubles, C99CodePrinter):
    pass


_DIALECTS = {
    "js": ("function {name}(q, out = []) {{", "const", _JavaScript().doprint),
    "c": ("static void {name}(const double *q, double *out) {{", "const double", _C().doprint),
}


def machine(kin: Kinematics, language: str) -> str:
    """Print a machine, a `Kinematics`, as a self-contained file; its header describes the inputs and outputs.

    `language` is one of `LANGUAGES`, or `InputError` is raised. JavaScript: an ES module that exports `EXPORTS`. C:
    the same functions, C99. LaTeX: an article with the formulas.
    """
    if language not in LANGUAGES:
        raise InputError("language", " or ".join(LANGUAGES), repr(language))
    if language == "latex":
        return _latex(kin)
    title = f"/* {_title(kin)}. Printed by mathpost from its symbolic derivation."
    comment = "\n".join([title, *_header(kin), " */"])
    if language == "js":
        return f"{comment}\n{body(kin)}\nexport {{ {', '.join(EXPORTS)} }};\n"
    public = re.sub(r"static (void (?:places|forward|jacobian|close_loop)\()", r"\1", _printed(kin, "c"))
    return f"{comment}\n#include <math.h>\n\n{public}"


EXPORTS = ("bodies", "places", "forward", "jacobian", "close", "inverse")


def body(kin: Kinematics, *, jacobian: bool = True) -> str:
    """Print a machine as JavaScript without exports, to be embedded in a page: it defines the `EXPORTS`."""
    names = ", ".join(f'"{name}"' for name, _ in chain.bodies(kin.machine))
    return f"const bodies = [{names}];\n\n{_printed(kin, 'js', jacobian)}"


def _printed(kin: Kinematics, language: str, jacobian: bool = True) -> str:
    """All functions of a machine in one language, and the inverse, which calls them."""
    functions = "\n\n".join(
        function(name, printed.outputs, printed.arguments, language, printed.named)
        for name, printed in _functions(kin, jacobian).items()
    )
    inverse = "inverse_of_one" if kin.tool_side is None else "inverse"
    template = Template(read_text(TEMPLATES / f"{inverse}.{language}"))
    filled = template.substitute(
        workpiece_side=kin.workpiece_side, tolerance=REACH_TOLERANCE, printed=PRINTED, pole=AT_POLE
    )
    return f"{functions}\n\n{filled}"


@dataclass(frozen=True)
class _Function:
    """Outputs and arguments of a printed function; `named` as in `function`."""

    outputs: Sequence[sp.Expr]
    arguments: tuple[sp.Symbol, ...]
    named: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()


def _functions(kin: Kinematics, jacobian: bool = True) -> dict[str, _Function]:
    """The functions that both languages print, by name."""
    derived, matrix = kin.inverse_symbolic, kin.forward_symbolic()
    pose = [*matrix[:3, 3], *matrix[:3, 2]]
    slopes = [*sp.Matrix(pose).jacobian(kin.symbols)] if jacobian else []
    places = [entry for _, place in chain.bodies(kin.machine) for entry in place[:3, :]]
    return {
        "places": _Function(places, kin.symbols),
        "forward": _Function(pose, kin.symbols),
        **({"jacobian": _Function(slopes, kin.symbols)} if jacobian else {}),
        "close_loop": _Function(derived.linear, (*derived.tip, *kin.symbols[3:])),
        **({"reach": _Function((derived.below, derived.above), derived.axis)} if derived.solutions else {}),
        "solve": _Function(*solved(derived, kin.symbols[3:])),
    }


def _title(kin: Kinematics) -> str:
    name = re.sub(r"[^\w ,.()+-]|_", " ", kin.machine.name)  # nothing that could end a comment
    return f"{name} ({kin.machine.arrangement})"


def _header(kin: Kinematics) -> tuple[str, ...]:
    joints, derived = ", ".join(kin.machine.joint_names), kin.inverse_symbolic
    bodies = ", ".join(name for name, _ in chain.bodies(kin.machine))
    one, count = derived.tool_side is None, len(kin.symbols)
    found = "the joints, angle" if one else "the joints of both branches, angles"
    angles = (
        f"Angle {derived.workpiece_side}"
        if one
        else f"Tool-side angle {derived.tool_side}, workpiece-side angle {derived.workpiece_side}"
    )
    return (
        f" * q: the joints {joints}; mm and radians. A pose: tool tip x, y, z (mm) and tool axis i, j, k, a unit",
        " * vector from the tip towards the spindle, both in the workpiece.",
        f" * places    q -> three rows of four numbers for each body: {bodies}; machine_from_body.",
        " * forward   q -> x, y, z, i, j, k.",
        f" * jacobian  q -> 6 rows of {count} numbers: the derivatives of the pose with respect to the joints.",
        " * close     tip and the rotary angles -> X, Y, Z that put the tip there (C: close_loop).",
        f" * inverse   tip and tool axis (of any length) -> {found} in (-pi, pi].",
        f" *           {angles}: 0 at the pole, where any fits.",
        f" *           null (C: the result 0 instead of {2 - one}) out of reach. Travel is not looked at.",
    )


def _latex(kin: Kinematics) -> str:
    """An article: the links, the pose with its Jacobian, and the inverse; each section with its own s and t."""
    derived, functions = kin.inverse_symbolic, _functions(kin)
    header = [line.strip(" *") for line in _header(kin)]
    pose = ["x", "y", "z", "i", "j", "k"]
    slopes = [rf"\partial {p}/\partial {q}" for p in pose for q in kin.machine.joint_names]
    tool_side = [(f"{derived.tool_side}_{{{n}}}", angle) for n, angle in enumerate(derived.solutions, 1)]
    inverse = [("r_{-}", derived.below), ("r_{+}", derived.above), *tool_side] if tool_side else []
    inverse += _shared([str(derived.workpiece_side)], [sp.atan2(*derived.turn, evaluate=False)], "s")
    inverse += _shared("XYZ", derived.linear)
    first = f"{derived.tool_side} on both branches, then " if tool_side else ""
    sections = {
        "The links, from the workpiece to the tool": [(rf"\text{{{x.name}}}", x.matrix) for x in kin.links()],
        "Forward: tip and tool axis": _shared(pose, functions["forward"].outputs),
        "Jacobian of the pose": _shared(slopes, functions["jacobian"].outputs),
        f"Inverse: {first}{derived.workpiece_side}, then X Y Z": inverse,
    }
    name = _title(kin).encode("ascii", "ignore").decode()
    lines = [f"% {name}. Printed by mathpost from its symbolic derivation.", read_text(TEMPLATES / "article.tex")]
    beyond = (
        "Out of reach where an $r$ is negative."
        if tool_side
        else "Out of reach if the forward pose has another tool axis."
    )
    lines += [rf"\section*{{{name}}}", *header[:2], header[-2], beyond]
    for title, formulas in sections.items():
        lines += [rf"\subsection*{{{title}}}", *(rf"\fit{{{left} = {_tex(value)}}}" for left, value in formulas)]
    return "\n".join([*lines, r"\end{document}", ""])


def _tex(expression: sp.Basic) -> str:
    written = sp.latex(expression, fold_func_brackets=True, symbol_names={BELOW: "r_{-}", ABOVE: "r_{+}"})
    return written.replace(r"\operatorname{atan}_{2}", r"\operatorname{atan2}")


def _shared(names: Iterable[str], outputs: Iterable[sp.Expr], letter: str = "t") -> list[tuple[str, sp.Expr]]:
    """Pairs of name and expression, the common parts first as t_0, t_1, …"""
    common, results = sp.cse(list(outputs), symbols=sp.numbered_symbols(f"{letter}_"))
    return [(_tex(symbol), value) for symbol, value in common] + list(zip(names, results, strict=True))

"""Mistakes between a tool and its words: the chain of a machine as somebody may have computed it.

`COST` is how far-fetched a cause is, from how often it was found (`causes.toml`). A `Setup` computes the chain with
numbers, an order or words that are not the machine's; each of `causes` changes one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import permutations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost import chain
from mathpost.detective.explanation import Misread, Slip
from mathpost.files import read_toml
from mathpost.formula import numeric
from mathpost.machine import MM_PER_INCH, Machine
from mathpost.rotation import unit

if TYPE_CHECKING:
    import sympy as sp

STEP, LEAST = 0.04, 0.6  # of the cost: less for each thread in which a cause was found, and no less than this
CAUSES = read_toml(Path(__file__).with_name("causes.toml"))
COST = {name: max(1.0 - STEP * len(cause["seen"]), LEAST) for name, cause in CAUSES.items()}


def slip(name: str, phrase: str, more: float = 0.0, **changes: Any) -> Slip:
    """Return the `Slip` of a cause of the catalogue; it costs `more` than its plain form."""
    return Slip(CAUSES[name]["kind"], COST[name] + more, phrase, changes)


@dataclass(frozen=True, eq=False)
class Setup(Misread):
    """A chain as somebody computed it: that of `machine` with the changes of the `slips`."""

    machine: Machine
    links: tuple[str, ...]  # names, from the workpiece to the tool
    values: dict[sp.Symbol, float]  # the values of the symbols of `mathpost.chain.Geometry`
    tool: np.ndarray  # the tip from the nose at rotary zero, turned with the heads, mm
    unturned: np.ndarray  # the same, but not turned
    source: tuple[int, ...]  # index of the rotary word used for each joint
    factor: tuple[float, ...]  # by which it is multiplied
    zero: tuple[float, ...]  # degrees added to it
    order: tuple[int, ...] = (0, 1, 2)  # where the entries of the answer come from
    signs: tuple[float, ...] = (1.0, 1.0, 1.0)  # factors of these
    added: tuple[float, ...] = (0.0, 0.0, 0.0)  # mm, in every row
    slips: tuple[Slip, ...] = ()

    @classmethod
    @lru_cache(maxsize=64)
    def right(cls, machine: Machine) -> Setup:
        """Return the correct chain of a machine."""
        symbols, numbers = chain.Geometry.symbols(machine).flat(), chain.Geometry.numbers(machine).flat()
        values = {
            symbol: float(number) for symbol, number in zip(symbols, numbers, strict=True) if symbol.is_Symbol
        }
        links = tuple(link.name for link in chain.links(machine)[:-1])
        tool, count = -machine.tool_length * unit(np.array(machine.tool_axis)), len(machine.rotary)
        return cls(machine, links, values, tool, np.zeros(3), tuple(range(count)), (1.0,) * count, (0.0,) * count)

    def point(self, name: str) -> np.ndarray:
        """Return a point on a rotary axis; for `"origin"` the workpiece origin."""
        return self._vector("o" if name == "origin" else f"p_{name}")

    def moved(self, name: str, point: np.ndarray) -> Setup:
        """Return the setup with a different point, or a different workpiece origin."""
        return self._with("o" if name == "origin" else f"p_{name}", point)

    def pivoted(self, name: str, point: np.ndarray) -> Setup:
        """Return the setup with a different point of a head; if X Y Z name that point, they still do."""
        named = self.machine.programmed_point
        moved = self.moved(name, point)
        is_pivot = not isinstance(named, str) and np.array_equal(named, self.point(name))
        return moved._with("r", point) if is_pivot else moved

    def longer(self, more: float) -> Setup:
        """Return the setup with a tool that is `more` mm longer; if X Y Z name its tip, they still do."""
        length = self.machine.tool_length + more
        made = self.values | {chain.Geometry.symbols(self.machine).tool_length: length}
        return replace(self, values=made, tool=self.tool - more * unit(np.array(self.machine.tool_axis)))

    def reversed(self, name: str) -> Setup:
        """Return the setup with a rotary axis that turns the other way."""
        return self._with(f"V_{name}", -self._vector(f"V_{name}"))

    def _vector(self, name: str) -> np.ndarray:
        return np.array([self.values[entry] for entry in chain.vector_symbols(name)])

    def _with(self, name: str, vector: np.ndarray) -> Setup:
        entries = zip(chain.vector_symbols(name), map(float, vector), strict=True)
        return replace(self, values=self.values | dict(entries))

    def _product(self, names: Iterable[str], linear: np.ndarray, rotary: np.ndarray) -> np.ndarray:
        """The product of links, (n, 4, 4); `rotary` are words in degrees, (n, k)."""
        angles = np.deg2rad(rotary[:, list(self.source)] * self.factor + self.zero)
        compiled, symbols = _links(self.machine)
        values = [*linear.T, *angles.T, *(self.values[symbol] for symbol in symbols)]
        made = np.eye(4)
        for name in names:
            made = made @ compiled[name](*values)
        return np.broadcast_to(made, (len(linear), 4, 4))

    def pose(self, joints: np.ndarray) -> np.ndarray:
        """Return tip and tool axis, shape (n, 6), of joints (n, 3 + k) in mm and degrees."""
        made = self._product(self.links, joints[:, :3] + self.unturned, joints[:, 3:])
        tip = made[:, :3, :3] @ self.tool + made[:, :3, 3]
        axis = made[:, :3, :3] @ unit(np.array(self.machine.tool_axis))
        return np.concatenate([tip[:, list(self.order)] * self.signs + self.added, axis], axis=1)

    def linear(self, poses: np.ndarray) -> np.ndarray:
        """Return the words X Y Z, shape (n, 3), of a tip and rotary words, together (n, 3 + k)."""
        nothing = np.zeros((len(poses), 3))
        plain = replace(self, order=(0, 1, 2), signs=(1.0, 1.0, 1.0), added=(0.0, 0.0, 0.0))
        start = plain.pose(np.concatenate([nothing, poses[:, 3:]], axis=1))[:, :3]
        turned = self._product(self.links[: self.links.index("linear")], nothing, poses[:, 3:])[:, :3, :3]
        words = np.einsum("nji,nj->ni", turned, poses[:, :3] - start)
        return words[:, list(self.order)] * self.signs + self.added


@lru_cache(maxsize=64)
def _links(machine: Machine) -> tuple[dict[str, Callable], tuple[sp.Symbol, ...]]:
    """The links compiled, by name, and the symbols that they take besides the joints."""
    entries = [entry for entry in chain.Geometry.symbols(machine).flat() if entry.is_Symbol]
    symbols = tuple(dict.fromkeys(entries))
    arguments = (*chain.joint_symbols(machine), *symbols)
    # The tool's own link is left out: `Setup.tool` replaces it.
    return {link.name: numeric(link.matrix, arguments) for link in chain.links(machine, True)[:-1]}, symbols


@dataclass(frozen=True)
class Cause:
    """One mistake: its slip, and the change that it makes to a `Setup`."""

    slip: Slip
    change: Callable[[Setup], Setup]


def misread(setup: Setup, *found: Cause) -> Setup:
    """Return a setup with causes applied in order."""
    for cause in found:
        setup = replace(cause.change(setup), slips=(*setup.slips, cause.slip))
    return setup


def causes(machine: Machine) -> list[Cause]:
    """Return all causes for a machine, the least far-fetched first.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> [cause.slip.phrase for cause in causes(load_machine("head_b_table_c"))][:2]
    ['C turns the other way', 'B turns the other way']
    """
    found = [*_rotary(machine), *_points(machine), *_tool(machine), *_answer()]
    return sorted(found, key=lambda cause: cause.slip.cost)


def _with(**changes: Any) -> Callable[[Setup], Setup]:
    """A change of whole fields of a setup."""
    return lambda setup: replace(setup, **changes)


def _set(name: str, index: int | None, value: float) -> Callable[[Setup], Setup]:
    """A change of one entry, or of all if `index` is None, of a tuple of a setup."""

    def change(setup: Setup) -> Setup:
        old = getattr(setup, name)
        new = tuple(value if n == index or index is None else old[n] for n in range(len(old)))
        return _with(**{name: new})(setup)

    return change


def _rotary(machine: Machine) -> Iterator[Cause]:
    """Sense, names, units and zeros of the rotary axes, and which carries which."""
    names = [each.name for each in machine.rotary]
    together = " and ".join(names)
    each_and_all: list[tuple[int | None, str, str, str]] = [(n, name, "is", "") for n, name in enumerate(names)]
    if len(names) > 1:
        each_and_all.append((None, together, "are", "s"))
    for n, name in enumerate(names):
        yield Cause(slip("reversed", f"{name} turns the other way"), partial(Setup.reversed, name=name))
        for degrees in (180, 90, -90):
            phrase = f"{name} is off by {degrees:+d} degrees"
            yield Cause(slip("zero", phrase, 0.1 * (degrees != 180)), _set("zero", n, float(degrees)))
    for which, name, verb, plural in each_and_all:
        for factor, phrase in (
            (1 / MM_PER_INCH, f"the word{plural} {name} {verb} taken for mm and divided by 25.4"),
            (MM_PER_INCH, f"the word{plural} {name} {verb} taken for inches and multiplied by 25.4"),
        ):
            yield Cause(slip("inch", phrase), _set("factor", which, factor))
        degree = np.degrees(1)
        yield Cause(slip("radians", f"the degrees of {name} are taken for radians"), _set("factor", which, degree))
        yield Cause(
            slip("radians", f"{name} {verb} converted to radians twice", 0.2), _set("factor", which, 1 / degree)
        )
        yield Cause(slip("left-out", f"{name} {verb} left out"), _set("factor", which, 0.0))
    if len(names) < 2:
        return
    first, second = names
    both = f"{together} turn the other way"
    yield Cause(slip("reversed", both, 0.1), lambda s: s.reversed(first).reversed(second))
    yield Cause(
        slip("names", f"{together} stand in each other's place"), lambda s: replace(s, source=s.source[::-1])
    )
    if machine.rotary[0].carries == machine.rotary[1].carries:
        phrase = f"{second} carries {first}, not {first} {second}"
        yield Cause(slip("carried", phrase), lambda s: replace(s, links=_exchanged(s.links, names)))
        transposed = "the whole rotation is transposed"
        yield Cause(
            slip("transposed", transposed),
            lambda s: replace(s.reversed(first).reversed(second), links=_exchanged(s.links, names)),
        )


def _exchanged(links: tuple[str, ...], names: Sequence[str]) -> tuple[str, ...]:
    other = dict(zip(names, reversed(names), strict=True))
    return tuple(other.get(name, name) for name in links)


def _points(machine: Machine) -> Iterator[Cause]:
    """Pivots and the workpiece origin: left out, of opposite sign or twice, counted from workpiece or machine."""
    origin, nowhere = np.array(machine.origin, dtype=float), np.zeros(3)
    points = {each.name: np.array(each.point, dtype=float) for each in machine.rotary}
    axes = {each.name: unit(np.array(each.axis)) for each in machine.rotary}
    starts = {"origin": ("workpiece origin", [nowhere])}
    for each in machine.rotary:
        from_where = [nowhere] if each.carries == "tool" else [origin, nowhere]
        starts[each.name] = (f"pivot of {each.name}", from_where)
    for name, (called, from_where) in starts.items():
        where = points.get(name, origin)
        kind = "origin" if name == "origin" else "pivot"
        for n, start in enumerate(from_where):
            if n and np.array_equal(start, from_where[0]):
                continue
            if np.linalg.norm(_across(where - start, axes.get(name))) < 1e-9:
                continue
            more = 0.05 * n
            for factor, said in ((0, "left out"), (2, "taken twice"), (-1, "of the opposite sign")):
                moved = start + factor * (where - start)
                phrase = f"the {called} is {said}" + ", counted from machine zero" * bool(n)
                yield Cause(slip(kind, phrase, more), partial(Setup.pivoted, name=name, point=moved))


def _across(offset: np.ndarray, axis: np.ndarray | None) -> np.ndarray:
    """The part of an offset that is square to an axis: along the axis the point is arbitrary."""
    return offset if axis is None else offset - offset @ axis * axis


def _tool(machine: Machine) -> Iterator[Cause]:
    """The tool length, not turned with the head, left out, and taken twice."""
    if machine.tool_length == 0:
        return
    tip = -machine.tool_length * unit(np.array(machine.tool_axis))
    if any(each.carries == "tool" for each in machine.rotary):
        phrase = "the tool length is not turned with the head"
        yield Cause(slip("tool", phrase), _with(tool=np.zeros(3), unturned=tip))
    yield Cause(slip("tool", "the tool length is left out", 0.02), _with(tool=np.zeros(3)))
    yield Cause(slip("tool", "the tool length is taken twice", 0.02), _with(tool=2 * tip))


def _answer() -> Iterator[Cause]:
    """X Y Z of the answer exchanged, of another sign, in inches."""
    for order in permutations(range(3)):
        moved = ["XYZ"[n] for n in range(3) if order[n] != n]
        if moved:
            phrase = f"{', '.join(moved[:-1])} and {moved[-1]} of the answer are exchanged"
            phrase += f" in a cycle: {' '.join('XYZ'[n] for n in order)}" * (len(moved) > 2)
            yield Cause(slip("exchanged", phrase, 0.2 * (len(moved) > 2)), _with(order=order))
    for n, name in enumerate("XYZ"):
        signs = tuple(-1.0 if n == other else 1.0 for other in range(3))
        yield Cause(
            slip("copied-sign", f"the sign of the answer's {name} is lost", 0.1),
            _with(signs=signs),
        )
    for reversed_slides in ("XY", "XZ", "YZ", "XYZ"):
        signs = tuple(-1.0 if name in reversed_slides else 1.0 for name in "XYZ")
        names = f"{', '.join(reversed_slides[:-1])} and {reversed_slides[-1]}"
        phrase = f"the slides {names} are counted the other way"
        yield Cause(slip("copied-sign", phrase, 0.15), _with(signs=signs))
    for factor, phrase in (
        (1 / MM_PER_INCH, "the answer is in inches"),
        (MM_PER_INCH, "the answer's mm are taken for inches"),
    ):
        yield Cause(slip("inch", phrase, 0.3), _with(signs=(factor,) * 3))

"""Mistakes between a tool and its words: the chain of a machine as somebody may have computed it.

`COST` is how far-fetched a cause is, from how often it was found (`causes.toml`). A `Setup` computes the chain with
numbers, an order or words that are not the machine's; each of `causes`, and of `causes_of_words`, changes one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import permutations, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost import chain
from mathpost.detective.explanation import Slip, setting
from mathpost.files import read_toml
from mathpost.formula import numeric
from mathpost.machine import MM_PER_INCH, Machine
from mathpost.rotation import unit

if TYPE_CHECKING:
    import sympy as sp

STEP, LEAST = 0.04, 0.6  # of the cost: less for each thread in which a cause was found, and no less than this
CAUSES = read_toml(Path(__file__).with_name("causes.toml"))
NUMBER = (  # of one axis and of two, in a sentence
    {"turns": "turns", "sign": "sign", "is": "is", "word": "word", "it": "it"},
    {"turns": "turn", "sign": "signs", "is": "are", "word": "words", "it": "they"},
)
COST = {name: max(1.0 - STEP * len(cause["seen"]), LEAST) for name, cause in CAUSES.items()}


def slip(name: str, phrase: str, more: float = 0.0, change: Callable[[Any], Any] = lambda way: way) -> Slip:
    """Return the `Slip` of a cause of the catalogue; it costs `more` than its plain form."""
    return Slip(CAUSES[name]["kind"], COST[name] + more, phrase, change)


@dataclass(frozen=True, eq=False)
class Setup:
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

    def times(self, factor: float, *which: int) -> Setup:
        """Return the setup whose rotary words `which` are multiplied by a factor."""
        return replace(self, factor=tuple(f * factor if n in which else f for n, f in enumerate(self.factor)))

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

    def axis(self, words: np.ndarray) -> np.ndarray:
        """Return the tool axis, (n, 3), of rotary words (n, k), ordered and signed as the answer's entries are."""
        axis = self.pose(np.pad(words, ((0, 0), (3, 0))))[:, 3:]
        return axis[:, list(self.order)] * self.signs

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


def causes(machine: Machine) -> list[Slip]:
    """Return all causes of a wrong tip or X Y Z on a machine, the least far-fetched first; each changes a `Setup`.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> [cause.phrase for cause in causes(load_machine("head_b_table_c"))][:2]
    ['C turns the other way', 'B turns the other way']
    """
    found = [*_rotary(machine, "machine"), *_chain(machine), *_points(machine), *_tool(machine), *_answer()]
    return sorted(found, key=lambda cause: cause.cost)


def causes_of_words(machine: Machine) -> list[Slip]:
    """Return all causes of wrong rotary words, the least far-fetched first; each changes a `Setup` that takes them.

    The tool axis that they were made for may be a different one, too.
    """
    found = [*_rotary(machine, "word"), *_tool_axis()]
    return sorted(found, key=lambda cause: cause.cost)


def _rotary(machine: Machine, told: str) -> Iterator[Slip]:
    """Sense, zeros, units and names of rotary axes, told of the "machine" that has the words, or of each "word"."""
    names = [each.name for each in machine.rotary]
    for (cause, content), which in product(CAUSES.items(), [(0,), (1,), (0, 1)]):
        for way in content.get("rotary", []):
            if which[-1] < len(names) and told in way and (len(which) == 1 or "both" in way):
                more = way.get("more", 0.0) + way.get("both", 0.0) * (len(which) - 1)
                phrase = way[told].format(" and ".join(names[n] for n in which), **NUMBER[len(which) - 1])
                yield slip(cause, phrase, more, partial(_meant, way=way, which=which))
    if len(names) > 1:
        phrase = f"{' and '.join(names)} stand in each other's place"
        yield slip("names", phrase, 0.0, lambda s: replace(s, source=s.source[::-1]))


def _meant(setup: Setup, way: dict[str, Any], which: tuple[int, ...]) -> Setup:
    """Return the setup in which rotary words mean something else."""
    zero = tuple(way["degrees"] * (n in which) for n in range(len(setup.zero))) if "degrees" in way else setup.zero
    return replace(setup.times(way.get("factor", 1.0), *which), zero=zero)


def _chain(machine: Machine) -> Iterator[Slip]:
    """Which of two rotary axes carries which, and the rotation the other way."""
    names = [each.name for each in machine.rotary]
    if len({each.carries for each in machine.rotary}) == 1 < len(names):
        first, second = names
        phrase = f"{second} carries {first}, not {first} {second}"
        yield slip("carried", phrase, 0.0, lambda s: replace(s, links=_exchanged(s.links, names)))
        yield slip(
            "transposed", "the whole rotation is transposed", 0.0,
            lambda s: replace(s.times(-1, 0, 1), links=_exchanged(s.links, names)),
        )  # fmt: skip


def _exchanged(links: tuple[str, ...], names: Sequence[str]) -> tuple[str, ...]:
    other = dict(zip(names, reversed(names), strict=True))
    return tuple(other.get(name, name) for name in links)


def _points(machine: Machine) -> Iterator[Slip]:
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
                yield slip(kind, phrase, more, partial(Setup.pivoted, name=name, point=moved))


def _across(offset: np.ndarray, axis: np.ndarray | None) -> np.ndarray:
    """The part of an offset that is square to an axis: along the axis the point is arbitrary."""
    return offset if axis is None else offset - offset @ axis * axis


def _tool(machine: Machine) -> Iterator[Slip]:
    """The tool length, not turned with the head, left out, and taken twice."""
    if machine.tool_length == 0:
        return
    tip = -machine.tool_length * unit(np.array(machine.tool_axis))
    if any(each.carries == "tool" for each in machine.rotary):
        phrase = "the tool length is not turned with the head"
        yield slip("tool", phrase, 0.0, setting(tool=np.zeros(3), unturned=tip))
    yield slip("tool", "the tool length is left out", 0.02, setting(tool=np.zeros(3)))
    yield slip("tool", "the tool length is taken twice", 0.02, setting(tool=2 * tip))


def _orders(names: str) -> Iterator[tuple[tuple[int, ...], list[str]]]:
    """Every other order of three entries, and the names of those that are moved."""
    for order in permutations(range(3)):
        if order != (0, 1, 2):
            yield order, [names[n] for n in range(3) if order[n] != n]


def _factors(*factors: float) -> Callable[[Setup], Setup]:
    return lambda s: replace(s, signs=tuple(old * new for old, new in zip(s.signs, factors, strict=True)))


def _without(lost: str, names: str) -> tuple[float, ...]:
    return tuple(-1.0 if name in lost else 1.0 for name in names)


def _answer() -> Iterator[Slip]:
    """X Y Z of the answer exchanged, of another sign, in inches."""
    for order, moved in _orders("XYZ"):
        phrase = f"{', '.join(moved[:-1])} and {moved[-1]} of the answer are exchanged"
        phrase += f" in a cycle: {' '.join('XYZ'[n] for n in order)}" * (len(moved) > 2)
        yield slip("exchanged", phrase, 0.2 * (len(moved) > 2), setting(order=order))
    for name in "XYZ":
        yield slip("copied-sign", f"the sign of the answer's {name} is lost", 0.1, _factors(*_without(name, "XYZ")))
    for slides in ("XY", "XZ", "YZ", "XYZ"):
        phrase = f"the slides {', '.join(slides[:-1])} and {slides[-1]} are counted the other way"
        yield slip("copied-sign", phrase, 0.15, _factors(*_without(slides, "XYZ")))
    yield slip("inch", "the answer is in inches", 0.3, _factors(*[1 / MM_PER_INCH] * 3))
    yield slip("inch", "the answer's mm are taken for inches", 0.3, _factors(*[MM_PER_INCH] * 3))


def _tool_axis() -> Iterator[Slip]:
    """The entries of the tool axis exchanged, or of another sign."""
    for order, moved in _orders("ijk"):
        phrase = f"{', '.join(moved)} of the tool axis are exchanged" + " in a cycle" * (len(moved) > 2)
        yield Slip("exchange", len(moved) - 1, phrase, setting(order=order))
    for name in "ijk":
        yield Slip("axis sign", 1, f"the sign of {name} is lost", _factors(*_without(name, "ijk")))
    yield Slip("axis sign", 1, "the tool axis points away from the spindle", _factors(-1, -1, -1))

"""Where the columns of a table of NC words stand: told by what the numbers are, and by headings where that is open.

The tool axis is three columns from which the machine's inverse makes two others, the rotary words; the tip, if
there is one, is three columns that go with these to X Y Z. So neither order nor sheet matters, nor columns of
something else.
"""

import re
import unicodedata
from collections import Counter
from dataclasses import dataclass
from itertools import accumulate, pairwise, permutations, product

import numpy as np

from mathpost.rotation import wrap
from mathpost.workbook.meaning.label import IN_DEGREES, IN_RADIANS
from mathpost.workbook.sheet.place import beside

CLOSE = 0.1  # degrees, mm: what is told apart here; what is right is judged elsewhere
LOOKED_AT = 200  # rows are enough to tell a column
SMALLEST, LARGEST = 5, 60  # numbers in a row: the words alone; more columns than these are no such table
# How many words must fit, so that it is no coincidence: without all their headings, and with them.
ENOUGH, ENOUGH_OF_ONE_ROW, ENOUGH_BESIDE = (3, 0), (6, 3), (4, 4)
ENOUGH_OF_ROTARY = (2, 1)  # of a table of rotary words alone
PLAIN, AMONG_OTHERS = 1.1, 0.4  # what a heading counts that is a letter or word, or has a letter; 1 if numbers fit
MACHINE = re.compile(r"(?<![a-z])(?:nc|machine|mcs|posted)(?![a-z])|机床|maschine|^[xyzabc]m$")
OF_CL = re.compile(r"(?<![a-z])(?:cl|apt|tip|part|workpiece|wcs|werkstück)(?![a-z])|刀位|刀尖")
UNIT = re.compile(r"[\[(（/].*|\b(?:deg|rad|mm|grad)\b\.?$|[°度]")
STATISTIC = re.compile("(?:min|max|mean|average|sum|total|mittel|summe|最小值?|最大值?|平均值?|合计)[ .:=]*", re.I)


@dataclass(frozen=True)
class Column:
    """The cells of a column, one of each row, and their numbers; `letters` is how well its heading says each."""

    places: tuple
    values: np.ndarray
    letters: dict
    typed: bool
    unit: float  # degrees of 1, if it is an angle
    said: str  # "nc" or "cl" if its heading, or that of its group, says one of the two
    more: float  # what it counts that the heading says degrees; less if it says radians


@dataclass(eq=False)
class Table:
    """Of each row the places of tip, tool axis and words; `units` are the degrees that 1 of a rotary word is."""

    rows: list
    units: tuple
    counters: tuple = ()
    left: tuple = ()  # rows in between that are not of the table
    others: tuple = ()  # columns of numbers that are none of these, and that nobody uses
    exchanged: tuple = ()  # a cell that stands under another one's heading, and a sentence
    source: tuple = ()  # the columns of tip and axis
    words: tuple = ()

    def said(self, graph):
        """Where the columns stand."""
        texts = []
        parts = zip(("tip", "axis", "words"), self.rows[0], self.rows[-1], strict=True)
        for name, first, last in (part for part in parts if part[1]):
            side_by_side = all(b in beside(a) for a, b in pairwise(first))
            ends = [(first[0], last[-1])] if side_by_side else zip(first, last, strict=True)
            ranges = graph.ranges(first) if first == last else map(graph.range, ends)
            texts.append(f"{name} {' '.join(ranges)}")
        not_seen = f"; numbers not looked at: {', '.join(map(graph.range, self.others))}"
        return ", ".join(texts) + not_seen * bool(self.others)


def find_tables(graph, kinematics, tried=(ENOUGH, ENOUGH_OF_ROTARY)):
    """Return the tables of a workbook, and the ranges of what may be one and is not understood.

    Rows of one table may stand on two sheets, its words on several; points may stand in columns instead of rows,
    or there may be one, if that is `tried`. Both solutions may stand beside each other: these are two tables. There
    may be rotary words alone, from the tool axis alone.
    """
    for enough, along in product(tried, (1, 2)):  # points in rows, points in columns
        single = enough == ENOUGH_OF_ONE_ROW
        blocks, left = _blocks(graph, along, single)
        several = [n for n, block in enumerate(blocks) if single or len(block[0].places) > 1]
        found = {n: _table(graph, kinematics, blocks[n], enough) for n in several}
        found = {n: table for n, table in found.items() if table}
        for a, b in () if single else permutations(several, 2):
            if b not in found and len(blocks[a][0].places) == len(blocks[b][0].places):
                table = _table(graph, kinematics, blocks[a] + blocks[b], enough)
                found |= {a: found.get(a, table), b: table} if table else {}
        for n, table in list(found.items()):  # the other solution, in what is left or beside it
            for b, block in enumerate(blocks):
                rest = [column for column in block if column not in (*table.source, *table.words)]
                alike = len(rest) >= 5 and len(rest[0].places) == len(table.words[0].places)
                if alike and (b == n or b not in found):
                    twin = _table(graph, kinematics, [*table.source, *rest], ENOUGH_BESIDE)
                    twin = twin if twin and twin.source == table.source else None
                    found |= {b if b not in found else (b, "twin"): twin} if twin else {}
        if found:
            cells = {table: {p for *_, words in table.rows for p in words} for table in found.values()}
            before = {table: graph.upstream(words) - words for table, words in cells.items()}
            tables = [t for t in cells if not any(up.issuperset(cells[t]) for up in before.values())]  # no steps
            judged = graph.upstream(p for table in tables for p in cells[table])
            other = [block for n, block in enumerate(blocks) if n not in found]
            other = [block for block in other if not all(judged.issuperset(column.places) for column in block)]
            other = [block for block in other if _are_typed(graph, [p for column in block for p in column.places])]
            left += [(block[0].places[0], block[-1].places[-1]) for block in other]
            return tables, [graph.range(ends) for ends in (*left, *(ends for t in tables for ends in t.left))]
    return [], []


def _blocks(graph, along, single):
    """Lists of columns: of rows of numbers without a gap; rows are counted by the place's number `along`.

    With `single` each row is alone. And the first and last cells of rows that are left out, as of a largest or a
    mean.
    """
    lines, blocks, left = {}, [], []
    for place in graph.component:
        lines.setdefault((place[0], place[along]), []).append(place)
    lines = {line: places for line, places in lines.items() if len(places) >= SMALLEST}
    for place, cell in graph.cells.items():
        if STATISTIC.fullmatch(str(cell.value).strip()) and (place[0], place[along]) in lines:
            places = lines.pop((place[0], place[along]))
            left += [(min(places), max(places))] * _are_typed(graph, places)
    while lines:
        sheet, first = min(lines, key=lambda line: (graph.numbers[line[0]], line[1]))
        run = []
        while (sheet, first + len(run)) in lines and not (single and run):
            run.append(lines.pop((sheet, first + len(run))))
        counted = Counter(place[3 - along] for places in run for place in places)
        own = {place[3 - along] for place in run[0]}  # below which a blank is the word before
        numbers = sorted(number for number, count in counted.items() if 2 * count > len(run) or number in own)
        if SMALLEST <= len(numbers) <= LARGEST:
            found = [_column(graph, sheet, range(first, first + len(run)), n, along) for n in numbers]
            blocks.append(
                [c for n, c in zip(numbers, found, strict=True) if 2 * counted[n] > len(run) or c.letters]
            )
    return blocks, left


def _column(graph, sheet, lines, number, along):
    """The column, or row, of a number, with what the three nearest texts before it say."""

    def place(line):
        return (sheet, line, number) if along == 1 else (sheet, number, line)

    texts, raw = [], set()
    for line in range(lines[0] - 1, 0, -1):
        cell = graph.cells.get(place(line))
        if cell and isinstance(cell.value, str) and len(texts) < 3:
            texts.append(normal(cell.value))
            raw = raw or {UNIT.sub("", cell.value).strip()}
    letters = next(filter(None, map(letters_of, texts)), {})
    places = tuple(map(place, lines))
    numbers = accumulate((graph.own.get(p) if p in graph.component else None for p in places), _or_before)
    values = np.array([*numbers], dtype=float)
    typed = 2 * sum(p in graph.trees for p in places) < len(places)
    unit = np.rad2deg(1) if any(re.search(IN_RADIANS, text) for text in texts) else 1.0
    says_degrees = unit == 1 and any(re.search(IN_DEGREES, text) for text in texts)
    said = _side(graph, sheet, lines[0], number) if along == 1 else ""
    said = said or next(({"XYZ": "nc", "xyz": "cl"}[case] for case in ("XYZ", "xyz") if set(case) & raw), "")
    return Column(places, values, letters, typed, unit, said, 0.5 * says_degrees - 0.75 * (unit > 1))


def _or_before(before, number):
    """A number or, where there is none, the one before, as of words that say only what changes."""
    return before if number is None else number


def _side(graph, sheet, first, number):
    """Whose data a column holds by its headings, or by the nearest to the left of each: "nc", "cl", or nothing."""
    for line in range(first - 1, max(first - 4, 0), -1):
        cells = (graph.cells.get((sheet, line, n)) for n in range(number, 0, -1))
        text = next((normal(cell.value) for cell in cells if cell and isinstance(cell.value, str)), "")
        names = [name for name, pattern in (("nc", MACHINE), ("cl", OF_CL)) if pattern.search(text)]
        if len(names) == 1:
            return names[0]
    return ""


def normal(text):
    """A text in small letters and plain signs."""
    return unicodedata.normalize("NFKC", text).strip().lower()


def letters_of(heading):
    """The letters that a heading names, as in "a", "x_nc", "刀轴i", "px", "ti" or "zm"."""
    said = UNIT.sub("", heading).strip()
    if re.fullmatch("[a-z]", said):
        return {said: PLAIN}
    named = re.findall(r"(?<![a-z])(?:(?:tip|axis|tool|ax|[ptnev])(?=[xyzijk]))?([a-z])(?![a-z0-9])", said)
    named += re.findall(r"(?<![a-z])([xyz])(?:cl|nc|mcs|wcs|[a-z])(?![a-z])", said)
    return dict.fromkeys(named, PLAIN if MACHINE.search(said) else AMONG_OTHERS)


def _table(graph, kinematics, columns, enough):
    """The `Table` in some columns, or None."""
    count = len(columns[0].places)
    sample = np.unique(np.linspace(0, count - 1, min(count, LOOKED_AT)).astype(int))
    roles = _Roles(graph, columns, kinematics, sample).find(enough)
    if roles is None:
        return None
    tip, axis, words = *(_sources(graph, columns, roles[part]) for part in ("tip", "axis")), roles["words"]
    source = [columns[n] for n in (*tip, *axis)]
    given = {p for column in source for p in column.places}
    if any(not columns[n].typed and graph.upstream(columns[n].places).isdisjoint(given) for n in words):
        return None
    alike = [[c.typed != (c.places[row] in graph.trees) for c in source] for row in range(count)]
    kept = [2 * sum(row) >= len(row) for row in alike]
    for row in range(count):  # one of statistics has no tip and no axis
        kept[row] &= any(c.places[row] in graph.component for c in source)
    if 2 * sum(kept) <= count:
        return None
    cells = [[columns[n].places for n in part] for part in (tip, axis, words)]
    rows = [tuple(tuple(places[row] for places in part) for part in cells) for row in range(count) if kept[row]]
    left = [
        [c.places[row] for c in columns if c.places[row] in graph.component]
        for row in range(count)
        if not kept[row]
    ]
    left = [(places[0], places[-1]) for places in left if _are_typed(graph, places)]
    others = [c for n, c in enumerate(columns) if n not in (*roles["tip"], *roles["axis"], *tip, *axis, *words)]
    others = [c.places for c in others if c.typed and not _is_count(c.values)]
    others = [(places[0], places[-1]) for places in others if graph.used.keys().isdisjoint(places)]
    units = tuple(columns[n].unit for n in words[-2:])
    counters = tuple(p for c in columns if not c.typed and _is_count(c.values) for p in c.places)
    parts = [[columns[n] for n in part] for part in (tip, axis, words)]
    exchanged = headings_exchanged(graph, kinematics, *parts, _stand_apart(tip, axis, words))
    columns = tuple(source), tuple(columns[n] for n in words)
    return Table(rows, units, counters, tuple(left), tuple(others), exchanged, *columns)


def _stand_apart(tip, axis, words):
    """Whether the tip stands beside the rotary words, and X Y Z beside the tool axis, as the other way round."""

    def near(part, other):
        return min((abs(a - b) for a in part for b in other), default=0) == 1

    linear, rotary = words[-5:-2], words[-2:]
    return near(tip, rotary) and near(linear, axis) and not (near(tip, axis) or near(linear, rotary))


def headings_exchanged(graph, kinematics, tip, axis, words, apart=False):
    """The first cell under the heading of another column, or that is made of such, and what is said there."""
    names = "".join(name[0].lower() for name in kinematics.machine.joint_names)
    said = [{c.said for c in part} for part in (tip, words[-5:-2])]
    if said == [{"nc"}, {"cl"}] or (apart and said[0] == said[1] == {""}):
        return words[0].places[0], "the headings say that this is the tip, and that the tip is X Y Z: exchanged"
    parts = (
        (tip, "xyz"),
        (axis, "ijk"),
        (axis, "uvw"),
        (axis, "xyz"),
        (words[-5:-2], names[:3]),
        (words[-2:], names[3:]),
    )
    for part, letters in parts:
        said = ["".join(column.letters) for column in part]
        if sorted(said) == sorted(letters) and said != [*letters]:
            k = next(k for k in range(len(said)) if said[k] != letters[k])
            place = part[k].places[0]
            made = [p for column in words for p in column.places[:1] if place in graph.upstream([p])]
            text = f"{letters[k]} stands under the heading {said[k]}: exchanged"
            return next(iter(made), place) if part[k].typed else place, text
    return ()


def _are_typed(graph, places):
    """Whether there are numbers among some cells that no formula makes: formulas are judged beside a table."""
    return any(p in graph.component and p not in graph.trees for p in places)


def _is_count(values):
    """Whether these are the numbers of blocks or points."""
    steps = np.unique(np.diff(values))
    return len(steps) == 1 and steps[0] >= 1 and not (values % 1).any()


def _sources(graph, columns, chosen):
    """The columns of typed numbers that a tip, or a direction, is but copied or normalised from; else its own."""
    if all(columns[n].typed for n in chosen):
        return chosen
    votes, of = Counter(), {p: n for n, column in enumerate(columns) for p in column.places}
    for cells in zip(*(columns[n].places for n in chosen), strict=True):
        used = [p for p in graph.upstream(cells) - graph.trees.keys() if p in of]
        votes[tuple(sorted({of[p] for p in used}))] += 1
    found = votes.most_common(1)[0][0]
    if len(found) != 3 or not all(columns[n].typed for n in found):
        return chosen
    now, then = (np.stack([columns[n].values for n in part], axis=-1) for part in (chosen, found))
    length = np.linalg.norm(then, axis=1, keepdims=True)
    copied, normalised = (np.abs(now - each).max(axis=1) < 1e-6 for each in (then, then / length))
    return list(found) if (copied | normalised).mean() > 0.5 else chosen


class _Roles:
    """The search for the numbers of the columns of tip, axis and words."""

    def __init__(self, graph, columns, kinematics, sample):
        self.graph, self.columns, self.kinematics = graph, columns, kinematics
        self.values = np.array([column.values[sample] for column in columns])
        self.names = [name[0].lower() for name in kinematics.machine.joint_names]

    def find(self, enough):
        """The columns by "tip", "axis", "words"; None if there are not all, or fewer words fit than `enough`."""
        axis = max(self.triples("ijk", "uvw", "xyz"), key=self.axis_score, default=None)
        if axis is None or self.axis_score(axis) < 0.5:
            return None
        self.demanded, words = self.inverse(axis), {}
        for k in (3, 4):
            words[k] = self.choose(k, self.turning(self.demanded[..., k - 3]), {*axis, *words.values()})
        if list(words.values()).count(None) > 1:
            return None
        words = self.as_they_fit(words, {k: self.turning(self.demanded[..., k - 3]) for k in words})
        if enough == ENOUGH_OF_ROTARY:
            return self.rotary_alone(axis, words)
        tips = [t for t in self.triples("xyz") if not {*axis, *words.values()}.intersection(t)]
        after = {self.columns[n].places[0] for n in (*axis, *words.values()) if n is not None}
        tips = [t for t in tips if after.isdisjoint(self.graph.upstream(self.columns[n].places[0] for n in t))]
        choices = [n for n in range(len(self.columns)) if n not in (*axis, *words.values())]
        lost = next((k for k in words if words[k] is None), None)
        best = 0.3 if lost is None else 2.9, None, None  # a lost one is told by X Y Z
        for n in choices if lost else (None,):
            self.turn_by({**words, lost: n})
            scores = [(self.tip_score(t, axis), t, n) for t in tips if n not in t]
            best = max([best, *scores], key=lambda score: score[0])
        _, tip, n = best
        if tip is None:
            return None
        words |= {lost: n} if lost else {}
        self.turn_by(words)
        fits, plain = self.linear(tip), {k: self.plainly(k, {*tip, *axis, *words.values()}) for k in range(3)}
        for k in range(3):
            words[k] = (
                max(plain[k], key=lambda n, k=k: (fits[k][n], n))  # these are it, whatever fits: a step may
                if all(plain.values())
                else self.choose(k, fits[k], {*tip, *axis, *words.values()}, 2 * AMONG_OTHERS)
            )
        for k, n in product(range(3), repeat=2):  # one that is all wrong stands between the others, or beside them
            free = set(range(len(self.columns))) - {*tip, *axis, *words.values()}
            if words[k] is None and words[n] is not None and words[n] + k - n in free:
                words[k] = words[n] + k - n
        for k in range(3):
            if words[k] is None:
                words[k] = self.choose(k, fits[k], {*tip, *axis, *words.values()})
        if None in words.values() or len(set(words.values())) < 5:
            return None
        words |= self.as_they_fit({k: words[k] for k in range(3)}, fits)
        fits = [*fits, *(self.turning(self.demanded[..., k]) for k in (0, 1))]
        fitting = sum(fits[k][n] >= 0.5 for k, n in words.items())
        headed = all(self.names[k] in self.columns[n].letters for k, n in words.items())
        if fitting < enough[headed]:
            return None  # a coincidence
        return {"tip": tip, "axis": axis, "words": [words[k] for k in range(5)]}

    @staticmethod
    def as_they_fit(words, fits):
        """Columns, by joint, that are only right if some stand under each other's headings: by what they are."""
        for columns in permutations(words.values()) if None not in words.values() else ():
            if all(fits[k][n] > 0.5 for k, n in zip(words, columns, strict=True)):
                return dict(zip(words, columns, strict=True))
        return words

    def rotary_alone(self, axis, words):
        """Rotary words without others, unless as many numbers stand beside them as a tip and X Y Z are."""
        others = [c for n, c in enumerate(self.columns) if n not in (*axis, *words.values()) and c.typed]
        if None in words.values() or len(others) >= 6:
            return None
        fitting = sum(self.turning(self.demanded[..., k - 3])[n] >= 0.5 for k, n in words.items())
        headed = all(self.names[k] in self.columns[n].letters for k, n in words.items())
        found = {"tip": (), "axis": axis, "words": [*words.values()]}
        return found if fitting >= ENOUGH_OF_ROTARY[headed] else None

    def triples(self, *groups):
        """Three columns side by side, or as far apart, of headings that name such letters."""
        found = [(n, n + 1, n + 2) for n in range(len(self.columns) - 2)]
        for group in groups:
            headed = [[n for n, c in enumerate(self.columns) if letter in c.letters] for letter in group]
            found += [(a, b, c) for a, b, c in product(*headed) if a != b and b - a == c - b][:200]
        return list(dict.fromkeys(found))

    def vectors(self, triple):
        return np.stack([self.values[n] for n in triple], axis=-1)

    def inverse(self, axis):
        """The rotary words of both branches in degrees, shape (rows, 2, 2); NaN where there are none."""
        vectors = self.vectors(axis)
        good = np.isfinite(vectors).all(axis=1) & (np.abs(vectors).max(axis=1) > 1e-6)
        found = np.full((len(vectors), 2, 2), np.nan)
        found[good] = self.kinematics.inverse(np.zeros(3), vectors[good], degrees=True)[..., 3:]
        return found

    def turn_by(self, words):
        """Take the rotary words as they are, or, unless these are told by X Y Z, as they are demanded."""
        own = np.stack([self.values[words[k]] * self.columns[words[k]].unit for k in (3, 4)], axis=-1)
        self.rotary = [own, self.demanded[:, 0], self.demanded[:, 1]][: 1 if None in words else 3]

    def turning(self, wanted):
        """How much of each column is one of the angles wanted, shape (rows, branches)."""
        off = [wrap(v[:, None] * c.unit - wanted) for v, c in zip(self.values, self.columns, strict=True)]
        return (np.abs(off) < CLOSE).any(axis=-1).mean(axis=-1)

    def axis_score(self, triple):
        both, vectors = self.inverse(triple), self.vectors(triple)
        others = [n for n in range(len(self.columns)) if n not in triple]
        fit = sum(self.turning(both[..., k])[others].max(initial=0) for k in (0, 1))
        units = np.mean(np.abs(np.linalg.norm(vectors, axis=1) - 1) < 2e-3)
        return fit + 0.2 * units + self.headed(triple, "ijk", "uvw", "xyz") + self.typed(triple)

    def linear(self, tip):
        """How much of each column is X, Y, Z with that tip, shape (3, columns); half if it is but shifted."""
        points, found = self.vectors(tip), []
        for rotary in self.rotary:
            wanted = self.kinematics.close(points, np.deg2rad(rotary))[:, :3]
            off = self.values - wanted.T[:, None]
            shifted = off - np.median(np.nan_to_num(off, nan=1e9), axis=-1, keepdims=True)
            found += [
                (np.abs(each) < CLOSE).mean(axis=-1) * weight for each, weight in ((off, 1.0), (shifted, 0.5))
            ]
        return np.max(found, axis=0)

    def tip_score(self, tip, axis):
        others = [n for n in range(len(self.columns)) if n not in (*tip, *axis)]
        fit = self.linear(tip)[:, others].max(axis=1, initial=0).sum()
        return fit + self.headed(tip, "xyz") + self.typed(tip)

    def headed(self, triple, *groups):
        return 0.3 * any(
            all(letter in self.columns[n].letters for n, letter in zip(triple, group, strict=True))
            for group in groups
        )

    def typed(self, triple):
        return 0.2 * all(self.columns[n].typed for n in triple)

    def plainly(self, joint, taken):
        """The columns with nothing but the letter of a word over them."""
        letter = self.names[joint]
        return [n for n, c in enumerate(self.columns) if n not in taken and c.letters.get(letter) == PLAIN]

    def choose(self, joint, fits, taken, least=AMONG_OTHERS):
        """The column of a word: the one with its letter over it, if there is one, that fits best."""
        letter = self.names[joint]
        left = {n: c for n, c in enumerate(self.columns) if n not in taken}
        value = {n: fits[n] + c.letters.get(letter, -c.more) + c.more for n, c in left.items()}
        best = max(value, key=lambda n: (value[n], n), default=None)
        headed = any(c.letters.get(letter) == PLAIN for c in left.values())
        if best is None or value[best] < least or (headed and letter not in left[best].letters):
            return None  # what has the heading is not it, and another that has none is: who knows
        return best

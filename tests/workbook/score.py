"""How good the check of spreadsheets is: right sheets and planted slips, drawn at random, scored by kind.

    python -m tests.workbook.score --count 500 --seed 1 --keep FOLDER

prints a table; the sheets that went wrong are kept in the folder, with what was planted and what was said.
"""

import argparse
import shutil
import subprocess
import tempfile
import time
from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np
import openpyxl

from tests.workbook import layouts, machining_sheets, mistakes
from tests.workbook.cells import SAMPLES, CircularError, Values, address, formula_of, letters, save

AUTHORS = {
    layouts.matrix_sheet: 6,
    layouts.many_points: 4,
    layouts.rotations_in_rows: 3,
    layouts.direct_elements: 3,
    layouts.two_tables: 2,
    layouts.four_by_four: 2,
    layouts.quaternions: 1,
    layouts.axis_angle: 1,
    layouts.unnamed_reading: 1,
    machining_sheets.nc_table: 4,
    machining_sheets.nc_values: 1,
    machining_sheets.tilted_plane: 2,
}
NUMBERS = ("wrong value", "offset", "branch", "travel")  # slips that can be seen where there are no formulas
COLUMNS = (
    "cases",
    "silent passes",
    "not counted",
    "false alarms",
    "unclear",
    "refused",
    "crashed",
    "first cell",
    "cause",
)


@dataclass
class Case:
    """A sheet, what is wrong with it, and what a check must say."""

    name: str
    book: object
    slip: mistakes.Slip
    values: dict
    original: object

    @property
    def kind(self):
        return self.slip.cause or "right"

    def planted(self):
        changes = list(self.slip.changes.items())
        text = "; ".join(
            f"{address(key)}: {shown(self.original.cells.get(key))} → {shown(content)}"
            for key, content in changes[:3]
        )
        return text + (f"; … {len(changes)} cells" if len(changes) > 3 else "")


def shown(content):
    return formula_of(content) or str(content)


def draw_cases(seed, count, authors=None):
    """Yield `count` cases: of each sheet the right one, and slips of five kinds at places drawn at random."""
    rng = np.random.default_rng(seed)
    authors = AUTHORS if authors is None else authors
    chances = np.array(list(authors.values())) / sum(authors.values())
    made = 0
    while made < count:
        author = list(authors)[rng.choice(len(authors), p=chances)]
        book = author(rng)
        values = Values(book, seed=int(rng.integers(1_000_000)))
        layouts.verify(book, values)
        unnamed = author is layouts.unnamed_reading
        right = mistakes.Slip("", {}, verdict="not right" if unnamed else "right")
        yield make_case(f"{seed}_{made:04d}", book, right, values)
        made += 1
        if unnamed:
            continue
        kinds = defaultdict(list)
        for cause, changes in mistakes.candidates(book, values):
            if not book.as_values or cause in NUMBERS:
                kinds[cause].append(changes)
        inputs = list(mistakes.wrong_inputs(book))
        for cause in rng.permutation(sorted(kinds) + ["wrong input"] * bool(inputs))[:5]:
            if cause == "wrong input":
                slip = inputs[rng.integers(len(inputs))]
            else:
                slip = mistakes.judge(book, values, str(cause), kinds[cause][rng.integers(len(kinds[cause]))])
            if slip is None or made >= count:
                continue
            yield make_case(f"{seed}_{made:04d}", book, slip, values)
            made += 1


def make_case(name, book, slip, values):
    """The sheet with the slip in it, and its values."""
    spoiled = slip.applied(book)
    given = {**values.given}
    for key in slip.changes.keys() & given.keys():  # a wrong input
        given[key] = np.full(SAMPLES, float(slip.changes[key]))
    found = spoiled_values(spoiled, given)
    if book.as_values:
        plain = {key: v if isinstance(v, str) else np.round(v, 6) for key, v in found.items()}
        spoiled = replace(spoiled, cells={key: v if isinstance(v, str) else v[0] for key, v in plain.items()})
        found = plain
    return Case(name, spoiled, slip, found, book)


def source_cases(recipe, step=1):
    """Yield every single reference in the source's sheet moved to every neighbouring cell, or of these each nth."""
    book = layouts.source_sheet(recipe)
    values = Values(book)
    moved = (
        (k, *m) for k in book.formulas() for m in mistakes.moved_references(book, k, formula_of(book.cells[k]))
    )
    for key, cause, formula in islice(moved, 0, None, step):
        slip = mistakes.judge(book, values, cause, {key: formula})
        yield make_case(
            f"source_{recipe}_{address(key).split('!')[1]}_{formula[1:]}".replace("*", "x"), book, slip, values
        )


def spoiled_values(book, given):
    """The values of a sheet; zero where cells go round in a circle, as spreadsheet programs store it."""
    spoiled, result = Values(book, given=given), {}
    for key in {**book.cells, **spoiled.spilled}:
        try:
            result[key] = spoiled[key]
        except CircularError:
            result[key] = np.zeros(SAMPLES)
        spoiled.active.clear()
    return result


def judge(case, path):
    """Check the sheet in `path`; return what counts, and what was said."""
    from mathpost.errors import InputError
    from mathpost.workbook import Task, check_file

    slip = case.slip
    try:
        report = check_file(path, Task(**case.book.task) if case.book.task else None)
    except InputError as error:
        return {"refused"}, str(error)
    except Exception as error:  # whatever it is: the score goes on
        return {"crashed"}, f"{type(error).__name__}: {error}"
    said = f"{report.verdict}, checked {report.checked} of {report.total}"
    if report.faults:
        fault = report.faults[0]
        said += f"; {fault.cell}: {fault.cause}: {fault.message}"
    if report.not_checked:
        said += f"; not checked: {', '.join(map(str, report.not_checked[:12]))}"
    if report.warnings:
        said += f"; warnings: {'; '.join(map(str, report.warnings[:3]))}"
    counts = set()
    if slip.verdict == "right":
        counts |= {"false alarms"} if report.verdict == "wrong" else set()
    elif slip.verdict == "either":
        return set(), said
    elif report.verdict == "right" and not (slip.verdict == "not silent" and report.warnings):
        counts.add("silent passes")
    if report.verdict == "right" and report.checked < max(report.total, downstream(case.book)):
        counts.add("not counted")
    if report.verdict == "unclear" and slip.verdict != "not right":
        counts.add("unclear")
    if report.verdict == "wrong" and slip.verdict == "wrong":
        first = {address(key) for key in slip.first}
        counts |= {"first cell"} if str(report.faults[0].cell).replace("'", "") in first else set()
        counts |= {"cause"} if report.faults[0].cause in slip.causes else set()
    return counts, said


def downstream(book):
    """The number of cells with formulas that give a number: those that a check must judge or list."""
    spilled = [cell for key in book.formulas() for cell in mistakes.spilled(book, key)]
    return sum('"' not in (formula_of(book.cells.get(key)) or "") for key in spilled)


def bad(case, counts):
    wanted = {"first cell", "cause"} if case.slip.verdict == "wrong" else set()
    return bool(counts - {"first cell", "cause"}) or not wanted <= counts


def run(cases, keep):
    """Score all cases; return the counts by kind and by family, and the lines about those that went wrong."""
    totals, lines = {"kind": defaultdict(Counter), "family": defaultdict(Counter)}, []
    for case in cases:
        path = keep / f"{case.name}.xlsx"
        save(path, case.book, case.values)
        counts, said = judge(case, path)
        for table, key in (("kind", case.kind), ("family", case.book.family)):
            totals[table][key].update(["cases", *counts])
            if case.slip.verdict == "wrong":
                totals[table][key]["located"] += 1
        if bad(case, counts):
            first = ", ".join(sorted(map(address, case.slip.first))[:6])
            lines.append(
                f"{path.name} [{case.book.family}] {case.kind}, task {case.book.task or None}\n"
                f"    planted {case.planted() or 'nothing'}\n"
                f"    truth   {case.slip.verdict} {first} {sorted(case.slip.causes)}\n"
                f"    said    {said}"
            )
        else:
            path.unlink()
    return totals, lines


def table(rows, title):
    lines = [f"{title:24}" + "".join(f"{name:>15}" for name in COLUMNS)]
    total = Counter()
    for name in sorted(rows):
        lines.append(_line(name, rows[name]))
        total.update(rows[name])
    return "\n".join([*lines, _line("all", total)])


def _line(name, counts):
    cells = []
    for column in COLUMNS:
        text = str(counts[column])
        if column in ("first cell", "cause"):
            text = f"{100 * counts[column] / counts['located']:.1f} %" if counts["located"] else ""
        cells.append(f"{text:>15}")
    return f"{name:24}" + "".join(cells)


# LibreOffice as a second opinion about the values.


def disagreements(cases, sample=1):
    """Cells in which LibreOffice has a different value at the inputs of `sample`; and how many were compared."""
    wrong, compared = [], 0
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in"), Path(folder, "out")
        source.mkdir()
        # What goes round in a circle has no value.
        cases = {case.name: case for case in cases if case.slip.first or case.slip.verdict in ("right", "either")}
        for case in cases.values():
            inputs = {key: float(case.values[key][sample]) for key in case.book.input_cells()}
            save(
                source / f"{case.name}.xlsx",
                replace(case.book, cells={**case.book.cells, **inputs}),
                {
                    key: value if isinstance(value, str) else np.roll(value, -sample)
                    for key, value in case.values.items()
                },
                cached=False,
            )
        recalculate(source, target)
        for name, case in cases.items():
            book = openpyxl.load_workbook(target / f"{name}.xlsx", data_only=True)
            for key, value in case.values.items():
                found = book[key[0]][f"{letters(key[2])}{key[1]}"].value
                compared += 1
                if not alike(value, found, sample):
                    wrong.append(f"{name} {address(key)} {shown(case.book.cells.get(key))}: {value}, not {found}")
    return wrong, compared


def alike(value, found, sample):
    if isinstance(value, str):
        return isinstance(found, str)
    if isinstance(found, str) or found is None:
        return not np.isfinite(value[sample]) or (found is None and value[sample] == 0)
    return bool(np.isclose(value[sample], found, rtol=1e-9, atol=1e-9))


def recalculate(source, target):
    """Let LibreOffice calculate all workbooks of a folder."""
    with tempfile.TemporaryDirectory() as profile:
        office = ["soffice", "--headless", "--norestore", f"-env:UserInstallation=file://{profile}"]
        files = map(str, sorted(source.glob("*.xlsx")))
        subprocess.run(
            [*office, "--convert-to", "xlsx", "--outdir", str(target), *files], check=True, capture_output=True
        )


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.workbook.score", description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--author", choices=[author.__name__ for author in AUTHORS])
    parser.add_argument(
        "--source", action="store_true", help="references moved in the sheet of source 000 (2400 in all)"
    )
    parser.add_argument("--keep", type=Path, default=Path(tempfile.gettempdir(), "planted"))
    parser.add_argument("--libreoffice", action="store_true", help="compare the values with LibreOffice's instead")
    options = parser.parse_args()
    authors = {author: n for author, n in AUTHORS.items() if options.author in (None, author.__name__)}
    cases = draw_cases(options.seed, options.count, authors)
    if options.source:
        cases = [case for recipe in (1, 2) for case in source_cases(recipe)]
        chosen = np.random.default_rng(options.seed).permutation(len(cases))[: options.count]
        cases = [cases[number] for number in chosen]
    if options.libreoffice:
        wrong, compared = disagreements(cases)
        print(*wrong[:40], f"{len(wrong)} of {compared} cells disagree", sep="\n")
        return
    shutil.rmtree(options.keep, ignore_errors=True)
    options.keep.mkdir(parents=True)
    start = time.perf_counter()
    totals, lines = run(cases, options.keep)
    (options.keep / "failures.txt").write_text("\n".join(lines), encoding="utf-8")
    for title, rows in totals.items():
        print(table(rows, title), end="\n\n")
    print(f"{len(lines)} cases went wrong: {options.keep / 'failures.txt'}; {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()

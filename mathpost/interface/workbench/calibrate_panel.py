"""Readings to a calibrated machine: errors with U, the residual of each reading, the control's terms, the files."""

import argparse
from collections.abc import Callable
from html import escape
from pathlib import Path

from mathpost import machine_file
from mathpost.errors import InputError
from mathpost.interface.shell.calibrate import SAID
from mathpost.interface.shell.options import given
from mathpost.interface.workbench.run import Made
from mathpost.shop.compensate import handover, readings
from mathpost.shop.compensate.calibrate import calibrate
from mathpost.shop.compensate.calibration import Calibration
from mathpost.shop.compensate.terms import terms

MOST_ROWS = 300  # of residuals, the largest first
HEAD = "<tr><th>file<th>line<th>column<th>off, µm<th>times its own scatter"


def work(options: argparse.Namespace, say: Callable[..., None], folder: Path) -> Made:
    """Estimate as the shell does."""
    setup = machine_file.load(options.machine)
    if options.template:
        text = readings.template(options.template, setup)
        made = {f"{options.template}.csv": text.encode()}
        return Made("a file to fill in", {"Template": f"<pre>{escape(text)}</pre>"}, made)
    if not options.readings:
        raise InputError("readings", "files of readings, or a template", "none")
    say("estimating", 1, 3)
    found = calibrate(setup, options.readings, **given(options, SAID))
    files = {"report.txt": f"{found}\n".encode()}
    if found.fits or options.accept:
        say("writing", 2, 3)
        written = handover.write(found, options.machine, folder / "out", inputs=options.readings)
        files |= {path.name: path.read_bytes() for path in written}
    pages = {
        "Errors": f"<pre>{escape(str(found))}</pre>",
        "Readings": residuals(found),
        "Terms": f"<pre>{escape(terms(found))}</pre>",
    }
    said = "The readings fit." if found.fits else f"The readings do not fit: {found.doubts[0]}"
    return Made(said, pages, files, found.fits)


def residuals(found: Calibration) -> str:
    """Return the residual of each reading, as HTML, the one that the others contradict most first."""
    rows = sorted(found.residuals, key=lambda each: -abs(each.times))
    if not rows:
        return "<p>These readings have no rows to look at.</p>"
    worst, lines = rows[0], [HEAD]
    for each in rows[:MOST_ROWS]:
        texts = (Path(each.file).name, each.line, each.column, f"{each.off:+.2f}", f"{each.times:+.1f}")
        lines.append(f"<tr>{''.join(f'<td>{escape(str(text))}' for text in texts)}")
    said = f"The worst: {Path(worst.file).name}, line {worst.line}, column {worst.column!r}, {worst.off:+.2f} µm."
    table = f'<table class="mathpost-sheet mathpost-list">{"".join(lines)}</table>'
    return f'<p>{escape(said)}</p><div class="mathpost-sheet-frame">{table}</div>'

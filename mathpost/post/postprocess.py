"""From CL data to a verified program: selection, the singular region, linearization, output, and the proof.

No program is handed out unverified. Its own text is read back, sent through the forward kinematics and compared
with the CL data, at the records and along the path that the joints really run between the blocks.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from mathpost.errors import MathpostError, replacing
from mathpost.post import cl as cldata
from mathpost.post import program, selection
from mathpost.post.production import produce
from mathpost.post.report import Report
from mathpost.post.setting import Setting
from mathpost.post.spool import Spool
from mathpost.post.workers import Workers


@dataclass(frozen=True)
class Result:
    """A verified program and how it came about.

    Attributes
    ----------
    joints : ndarray, shape (n, 5)
        The joints chosen for the n records, mm and radians.
    blocks : mathpost.post.program.Blocks
        The moves as read back from the program.
    place : ndarray, shape (m,)
        Where each block ends on the CL path: 2.25 is a quarter of the way from record 2 to record 3.
    program : str
        The text.
    report : Report
    """

    joints: np.ndarray
    blocks: program.Blocks
    place: np.ndarray
    program: str
    report: Report


def run(cl, machine, *, name=None, **options):
    """Post-process CL data into a verified program.

    Parameters
    ----------
    cl : CLData
    machine : Machine
    name : str, optional
        Program name; by default that of the CL file.
    **options
        ``dialect``, ``strategy``, ``singular``, ``tolerance``, ``tcp``, ``split``, ``start``, ``prefer``, ``cone``,
        ``lean``, ``clearance``, ``compare``, ``errors``: see `mathpost.post.setting.Setting`.

    Returns
    -------
    Result

    Raises
    ------
    ReachError
        If the tool axis, a joint or the path is out of reach, with the record.
    InputError
        If an option is not known.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.post import cl as cldata
    >>> result = run(cldata.read("data/cl/blade.cl"), machine.load("data/machines/dmu50v.toml"))
    >>> print("\\n".join(result.program.splitlines()[:4]))
    0 BEGIN PGM BLADE MM
    1 L X-36.7809 Y-68.5751 Z+66.1338 B+11.8172 C+175.8146
    2 L X-38.5803 Y-67.4446 Z+64.5272 B+10.3971 C+176.3180
    3 L X-40.3337 Y-66.2876 Z+62.8983 B+8.9770 C+176.8215
    >>> result.report.tip_error < 0.01
    True
    """
    setting = Setting(machine, name or Path(cl.name).stem, **options)
    pieces = [cl.part(first, first + cldata.PIECE) for first in range(0, len(cl), cldata.PIECE)]
    tally = _Tally(setting)
    made = [tally.taken(part) for part in produce(setting, pieces, Workers(1, setting))]
    return Result(
        joints=np.concatenate([part.stretch.joints[part.stretch.lead :] for part in made]),
        blocks=program.joined([part.proved.blocks for part in made]),
        place=np.concatenate(
            [part.planned.cl.first + part.planned.motion.place[part.planned.behind :] for part in made]
        ),
        program="".join(part.proved.text for part in made),
        report=tally.report(cl.name, pieces, _silent),
    )


def run_file(source, output, machine, *, name=None, workers=1, progress=None, **options):
    """Post-process a CL file of any length into a verified program, in memory that does not grow with it.

    The program is written whole or not at all. It is the same, to the byte, as that of `run`, for any number of
    workers. A singular region that is not passed ``"direct"`` is held in memory as a whole.

    Parameters
    ----------
    source : str or path-like
        An APT CL file.
    output : str or path-like
    machine : Machine
    name, **options
        As in `run`.
    workers : int
        How many processes write and prove stretches of the program at once.
    progress : callable, optional
        Called with a word for what is being done, how much of it is done, and how much there is.

    Returns
    -------
    Report

    Raises
    ------
    ReachError, InputError
        As `run`, and as `mathpost.post.cl.read`.
    OutputError
        If the program cannot be written.
    """
    progress = progress or _silent
    setting = Setting(machine, name or Path(source).stem, **options)
    tally = _Tally(setting)
    with replacing(output) as file, Spool() as pieces, Spool() as store, Workers(workers, setting) as team:
        for piece in cldata.pieces(source, progress=partial(progress, "reading, bytes")):
            pieces.append(piece)
        records = piece.first + len(piece)
        made = produce(
            setting,
            pieces,
            team,
            store=store,
            blocks=False,
            progress=_part_of(progress, "selecting, records", records),
        )
        for part in made:
            file.write(part.proved.text.encode())
            tally.taken(part)
            progress("writing and proving, records", tally.records, records)
        return tally.report(str(source), pieces, progress)


def _silent(*_):
    pass


def _part_of(progress, doing, total):
    return lambda done: progress(doing, done, total)


class _Tally:
    """What the report says, gathered from stretch to stretch."""

    def __init__(self, setting):
        self.setting = setting
        self.records, self.moves, self.seconds, self.cost, self.first_branch = 0, 0, 0.0, 0.0, 0
        self.proof, self.uncompensated, self.cautions = None, None, {}
        self.regions, self.passages, self.breaks = [], {}, []
        self.feed_missing, self.swing = False, (0.0, 0)

    def taken(self, made):
        """Count a stretch, and return it."""
        stretch, planned, proved, setting = made.stretch, made.planned, made.proved, self.setting
        cl, own = stretch.cl, slice(stretch.lead, None)
        self.records, self.moves = cl.first + len(cl), self.moves + len(planned.blocks.words)
        self.seconds, self.cost = self.seconds + planned.seconds, self.cost + stretch.cost
        self.first_branch += stretch.first_branch
        self.breaks += [cl.first + record for record in stretch.breaks]
        self.proof = _worse(self.proof, proved.verification)
        self.uncompensated = _worse(self.uncompensated, proved.uncompensated)
        self.cautions |= dict.fromkeys(planned.cautions)
        for region in stretch.regions:
            first, last = (cl.first + record for record in region)
            if self.regions and first <= self.regions[-1][1]:  # it goes on where the stretch before ended
                first = self.regions.pop()[0]
            self.regions.append((first, last))
            if setting.compare:
                self.passages[first, last] = stretch.crossing(setting, region).compare(**setting.ways)
        self.feed_missing |= bool((np.isnan(cl.feeds) & ~cl.rapid)[own].any())
        steps = np.degrees(np.abs(np.diff(stretch.joints[max(stretch.lead - 1, 0) :, 3:], axis=0))).max(axis=1)
        if len(steps) and steps.max() > self.swing[0]:
            self.swing = float(steps.max()), cl.first + max(stretch.lead - 1, 0) + int(steps.argmax())
        return made

    def report(self, source, pieces, progress):
        """Return the `Report`; it compares the strategies now, if at all."""
        return Report(
            verification=self.proof,
            settings=dict(self._settings(source)),
            time=self.seconds,
            uncompensated=self.uncompensated,
            warnings=(*self._warnings(), *self.cautions),
            strategies=tuple(self._strategies(pieces, progress)),
            passages=self.passages,
        )

    def _strategies(self, pieces, progress):
        for name in selection.STRATEGIES if self.setting.compare else ():
            doing = f"selecting by {name!r}, records"
            yield _strategy(self.setting, name, pieces, _part_of(progress, doing, self.records))

    def _settings(self, source):
        setting, machine = self.setting, self.setting.machine
        unit = "s" if not np.isnan(machine.max_rates).all() else "mm and degrees of travel"
        ranges = ", ".join(f"{first + 1}–{last + 1}" for first, last in self.regions[:8])
        more = ", …" if len(self.regions) > 8 else ""
        yield "CL data", f"{source}, {self.records} records"
        yield "machine", f"{machine.name} ({machine.arrangement})"
        yield "selection", f"{setting.strategy}, cost {self.cost:.3f} {unit}"
        yield "branches", f"first {self.first_branch}, second {self.records - self.first_branch}"
        yield "splits", ", ".join(f"before record {record + 1}" for record in self.breaks) or "none"
        yield "singular", f"records {ranges}{more}: {setting.singular}" if self.regions else "no region"
        yield "tolerance", f"{setting.tolerance:g} mm"
        yield "program", f"{self.moves} moves, TCP {'on' if setting.tcp else 'off'}"

    def _warnings(self):
        degrees, record = self.swing
        if self.feed_missing:
            yield "the CL data state no feed for some moves; they carry no F word"
        if degrees > 90:
            yield f"a rotary axis swings {degrees:.1f}° from record {record + 1} to the next"


def _worse(before, now):
    return now if before is None else before if now is None else before.worse(now)


def _strategy(setting, name, pieces, progress):
    """A row of `Report.strategies`."""
    cost, largest, before = 0.0, np.zeros(2), np.empty((0, 2))
    try:
        with Spool() as store:
            for chosen in selection.choose_pieces(
                setting.kin,
                pieces,
                name,
                start=setting.start,
                prefer=setting.prefer,
                store=store,
                progress=progress,
            ):
                rotary = np.concatenate([before, chosen.joints[:, 3:]])
                cost, before = cost + chosen.cost, rotary[-1:]
                largest = np.maximum(largest, np.degrees(np.abs(np.diff(rotary, axis=0)).max(axis=0, initial=0)))
    except MathpostError as error:
        return name, np.nan, (), str(error)
    return name, cost, tuple(largest), ""

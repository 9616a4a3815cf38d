"""One calibration: all readings of a machine, one least-squares estimate, its uncertainty, and whether it fits.

What is sought: where the rotary axes are and how they lean, named as in ISO 230-7 (EX0C, EA0C, …), how the spindle
leans on a head (EA0S, EB0S), the squareness of the slides (EC0Y, EB0Z, EA0Z), and the positioning error of each
axis that a laser has seen. A calibrated machine is a machine file with other points and axes: those that are
displayed with the slides in the middle of the readings, where squareness counts as nothing. The workpiece is
where probing finds it at rotary zero. `estimate` makes the estimate, `suspect` seeks a cause if it does not
fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mathpost.errors import InputError
from mathpost.shop.compensate import probed, suspect
from mathpost.shop.compensate import readings as files
from mathpost.shop.compensate.estimate import estimate

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.compensate.calibration import Calibration


def calibrate(machine: Machine, paths: Sequence[Path | str], **settings: Any) -> Calibration:
    """Return the `Calibration` of `machine`, as the control believed it to be, from files of readings.

    `paths` are files, see `mathpost.shop.compensate.readings.template`; `settings` (``unit``, ``method``, ``axis``,
    ``positive``, …) are for files that do not state them. `InputError` if a file leaves something unclear, there is
    nothing to estimate the noise from, or what comes out is no machine. Whether the readings fit is in `doubts`.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> found = calibrate(load_machine("data/machines/ac_table.toml"), ["data/measurements/ball_c_axis.csv"])
    >>> f"{1e3 * found['EX0C'].value:.1f} ± {1e3 * found['EX0C'].U:.1f} µm", found.fits
    ('10.3 ± 0.5 µm', True)
    """
    read = [files.read(each, machine, **settings) for each in paths]
    try:
        found = estimate(machine, read)
    except InputError as error:
        causes = suspect.causes(machine, paths, read, settings, None)
        said = [str(error.found), *probed.unexplained(machine, read), *causes]
        raise InputError(error.where, error.expected, "; ".join(said)) from None
    causes = suspect.causes(machine, paths, read, settings, found)
    return replace(found, doubts=(*found.doubts, *causes))

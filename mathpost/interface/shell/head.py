"""A horizontal head from its measured vectors: their residuals, and the blocks for any position."""

import argparse

import numpy as np
import scipy

from mathpost.interface.shell.options import FILE, columns, vector
from mathpost.shop.measure.horizontal_head import VERTICAL, FittedHead, fit_head, lhy, lhyset, read_head

SENSE = {"clockwise": -1, "counterclockwise": 1}
CHANCE = 0.05  # of rejecting vectors that are as they should be


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("vectors", **FILE, help="CSV: angle, x, y, z; horizontal minus vertical head")
    add("--at", type=float, metavar="DEG", help="any position; default: those that were measured")
    add("--turns", choices=tuple(SENSE), default="clockwise", help="seen from +Z, as its angle grows")
    add("--zero", type=float, default=0.0, metavar="DEG", help="where Z′ points at angle 0, from +X towards +Y")
    said = "of the work offset: the head's angle when each axis was measured, -1 (default) with the vertical head"
    add("--measured", type=vector, metavar="X,Y,Z", help=said)
    add("--sigma", type=float, metavar="MM", help="standard deviation of a coordinate; default: from what is left")


def run(options: argparse.Namespace) -> int:
    """Print the residual of each vector, the head's axis and the blocks; return 1 if the vectors do not fit."""
    head = read_head(options.vectors, sense=SENSE[options.turns], zero=options.zero)
    fitted = fit_head(head, sigma=options.sigma)
    correction = lhyset(head, *(options.measured or [VERTICAL] * 3))
    said, fits = _verdict(fitted, options.sigma)
    print("\n".join([said, "", *_left(fitted), "", *_axis(fitted)]))
    used = head if options.at is None else fitted.at([options.at])
    for angle in used.angles:
        print(f"\nat {angle:g}°, {'measured' if options.at is None else 'from the model'}")
        if options.at is not None:
            values = zip("XYZ", used.vector(angle), fitted.expanded(angle), strict=True)
            print("U " + " ".join(f"{axis} {value:z.3f} ± {U:.3f}" for axis, value, U in values) + " mm, 95 %")
        print(lhy(used, correction, angle).block)
    return int(not fits)


def _verdict(fitted: FittedHead, sigma: float | None) -> tuple[str, bool]:
    """Say whether the vectors are those of an arm that turns about a line; True if that cannot be judged."""
    estimate, largest = fitted.estimate, 1e3 * np.abs(fitted.residuals).max()
    if sigma is None:
        return f"at most {largest:.1f} µm are left; whether that fits is not judged without --sigma", True
    fits = bool(scipy.special.chdtrc(estimate.spare, estimate.spare * estimate.noise**2) >= CHANCE)
    said = f"the vectors {'fit' if fits else 'do not fit'} an arm that turns"
    return f"{said}: at most {largest:.1f} µm are left", fits


def _left(fitted: FittedHead) -> list[str]:
    """A table of the vectors and their residuals."""
    head, rows = fitted.measured, [("", *"XYZ", *"XYZ")]
    for angle, u, left in zip(head.angles, head.vectors, 1e3 * fitted.residuals, strict=True):
        rows.append((f"{angle:g}", *(f"{value:z.3f}" for value in u), *(f"{value:z.1f}" for value in left)))
    repeated = "repeats to the last digit: was it measured? It says nothing of the noise"
    said = [f"{name.upper()} {repeated}" for name in fitted.repeated]
    return ["the vector at each angle, mm, and what is left of it, µm", *columns(rows), *said]


def _axis(fitted: FittedHead) -> list[str]:
    """The line that the head turns about, and its arm."""
    x, y, along, square = (fitted.estimate.expanded(name) for name in ("cx", "cy", "a", "b"))
    return [
        f"turns about X {x.value:z.4f} ± {x.U:.4f}, Y {y.value:z.4f} ± {y.U:.4f} mm beside the vertical head",
        f"leans by {1e6 * fitted.tilt:.0f} µrad",
        f"arm {along.value:z.4f} ± {along.U:.4f} mm along Z′, {square.value:z.4f} ± {square.U:.4f} mm square to it",
    ]

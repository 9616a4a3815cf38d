"""What a post-processing run is asked to do, as one value that checks itself."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.machine import Machine
from mathpost.path.deviation import AXIS_RESOLUTION, AXIS_TOLERANCE, TOLERANCE
from mathpost.path.region import Region
from mathpost.path.selection import STRATEGIES
from mathpost.path.singular import CLEARANCE, CONE, LEAN, refuse_nonsense
from mathpost.shop.compensate.compensation import Compensator
from mathpost.shop.compensate.model import MachineErrors
from mathpost.shop.controls.control import Control, control_for


@dataclass(frozen=True, kw_only=True, eq=False)
class Options:
    """All that a program depends on apart from the CL data and the machine."""

    control: Control
    tcp: bool = False  # whether the control keeps the tip (M128, G43.4, TRAORI)
    expand: bool = False  # whether arcs, cycles and tilted planes are straight moves, not the control's own words
    tolerance: float = TOLERANCE  # mm, of the tip
    axis_tolerance: float = AXIS_TOLERANCE  # radians, of the tool axis
    errors: MachineErrors | None = None  # what was measured on the machine, to be compensated
    # How branch and winding of each record are chosen; the arguments of `mathpost.path.selection.choose`.
    strategy: str = "optimal"
    start: ArrayLike | None = None  # present joints, shape (j,), mm and radians
    prefer: int | None = None
    split: bool = False
    # Where a path is singular, and how it is led through; `lean` and `clearance` as in `Region.motion`.
    singular: str = "direct"  # the way through
    cone: float | None = CONE  # radians about the singular tool axes, see `mathpost.path.singular.regions`
    lean: float = LEAN  # radians
    clearance: float = CLEARANCE  # mm

    def __post_init__(self) -> None:
        if self.strategy not in STRATEGIES:
            raise InputError("strategy", " or ".join(STRATEGIES), repr(self.strategy))
        if self.prefer not in (None, 1, -1):
            raise InputError("prefer", "1 or -1", repr(self.prefer))
        if self.start is not None:
            as_array(self.start, np.size(self.start), "start")
        if self.singular not in Region.SAFE:
            raise InputError("singular", " or ".join(Region.SAFE), repr(self.singular))
        if self.cone is not None and not 0 < self.cone < np.pi:
            raise InputError("cone", "radians above 0 and below π, or none", repr(self.cone))
        refuse_nonsense(self.lean, self.clearance)
        if not 0 < self.tolerance < np.inf:
            raise InputError("tolerance", "mm above 0", repr(self.tolerance))
        if not 2 * self.axis_digits <= self.axis_tolerance < np.inf:
            digits = f"words of {self.control.decimals} decimals"
            expected = f"at least {np.degrees(2 * self.axis_digits):.4f}°, for {digits}"
            raise InputError("axis_tolerance", expected, f"{np.degrees(self.axis_tolerance):g}°")

    @classmethod
    def of(cls, machine: Machine, *, dialect: Control | str = "heidenhain", **given: Any) -> "Options":
        """Return the options that keywords name.

        `InputError` is raised for one that is not known or has a wrong value, a control that cannot name the axes
        of the machine, and errors of another machine.

        Examples
        --------
        >>> from mathpost import load_machine
        >>> Options.of(load_machine("dmu50v"), dialect="fanuc", singular="retract").control.name
        'fanuc'
        """
        known = [each.name for each in fields(cls) if each.name != "control"]
        if unknown := [name for name in given if name not in known]:
            raise InputError("run", f"the options {', '.join(['dialect', *known])}", ", ".join(unknown))
        made = cls(control=control_for(machine, dialect), **given)
        if made.errors is not None and made.errors.machine != machine:
            raise InputError("errors", f"those of {machine.name!r}, set up alike", repr(made.errors.machine.name))
        return made

    @property
    def axis_digits(self) -> float:
        """Radians; how far the printed digits of both rotary axes may turn the tool axis, and what samples miss."""
        return np.radians(10.0**-self.control.decimals) + AXIS_RESOLUTION

    def share(self, machine: Machine) -> float:
        """How much of the tolerances is for the moves: half, where the program lets the control round off."""
        return 0.5 if machine.complete and any("{rounding}" in line for line in self.control.start) else 1.0

    def axis_room(self, machine: Machine) -> float:
        """Return radians left for the tool axis in the moves, after the rounding of the printed digits."""
        return max(self.share(machine) * self.axis_tolerance, 2 * self.axis_digits) - self.axis_digits

    def real(self, machine: Machine) -> Compensator | None:
        """Return the machine as it was measured, if it was, set up as `machine`: with its origin and tool."""
        return None if self.errors is None else Compensator(replace(self.errors, machine=machine))

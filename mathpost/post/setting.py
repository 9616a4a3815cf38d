"""How a program is made: the machine, and every choice that a person has."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from mathpost.compensate.compensation import Compensator
from mathpost.compensate.machine_errors import MachineErrors
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.machine import Machine
from mathpost.post import program, selection
from mathpost.post.passage import CLEARANCE, LEAN, Crossing

TOLERANCE = 0.01  # mm
CONE = np.radians(1.0)  # about the singular tool axes


@dataclass(frozen=True)
class Setting:
    """How a program is made.

    Attributes
    ----------
    machine : Machine
    name : str
        Program name.
    dialect : str
        ``"heidenhain"``, ``"fanuc"`` or ``"siemens"``.
    strategy, start, prefer, split
        As in `mathpost.post.selection.choose`; at a split the tool is retracted, unwound and returned.
    singular : str
        The way through singular regions, one of `Crossing.SAFE`.
    tolerance : float
        mm; how far the tip may be from the CL path, everything included. Without TCP the moves are divided until
        they keep it.
    tcp : bool
        Whether the control keeps the tip (M128, G43.4, TRAORI): X Y Z are then the tip in the workpiece.
    cone : float or None
        Radians about the singular tool axes; None lets feed and rates decide. See `singularity.regions`.
    lean, clearance : float
        Radians and mm; see `Crossing.way`.
    compare : bool
        Whether the report compares all strategies, and all ways through each region.
    errors : mathpost.compensate.machine_errors.MachineErrors, optional
        What was measured on the machine: the program is compensated for it, and verified on the machine as it is.

    Raises
    ------
    InputError
        If an option is not known, or the errors are those of another machine.
    """

    machine: Machine
    name: str
    dialect: str = "heidenhain"
    strategy: str = "optimal"
    singular: str = "direct"
    tolerance: float = TOLERANCE
    tcp: bool = False
    split: bool = False
    start: tuple | None = None
    prefer: int | None = None
    cone: float | None = CONE
    lean: float = LEAN
    clearance: float = CLEARANCE
    compare: bool = True
    errors: MachineErrors | None = None

    def __post_init__(self):
        program.dialect_named(self.dialect)
        if self.strategy not in selection.STRATEGIES:
            raise InputError("strategy", " or ".join(selection.STRATEGIES), repr(self.strategy))
        if self.singular not in Crossing.SAFE:
            raise InputError("singular", " or ".join(Crossing.SAFE), repr(self.singular))
        if not self.tolerance > 0:
            raise InputError("tolerance", "mm above 0", repr(self.tolerance))
        if self.errors is not None and self.errors.machine != self.machine:
            found = f"{self.errors.machine.name!r}"
            raise InputError("errors", f"those of {self.machine.name!r}, set up alike", found)

    @cached_property
    def kin(self):
        """The kinematics that the control has."""
        return Kinematics(self.machine)

    @cached_property
    def calibrated(self):
        """The machine as it is, or None if nothing was measured on it."""
        return None if self.errors is None else Compensator(self.errors)

    @property
    def ways(self):
        """The options of `Crossing.way`."""
        return {"lean": self.lean, "clearance": self.clearance}

    def writer(self):
        """A writer at the beginning of the program."""
        return program.Writer(self.machine, self.dialect, name=self.name, tcp=self.tcp)

    def __getstate__(self):
        """For another process, which compiles its own formulas."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

"""The exact inverse of a machine whose errors are constants: Bohez's first group, put into the inverse directly.

Constant error frames can be moved through the chain. A turn behind an error frame E is the turn about the line that
E has moved, followed by E: E·Turn(line) = Turn(E·line)·E. Moved outwards joint by joint, they leave a machine with
other axes and pivots, slides with other directions, and one small displacement of the workpiece or the tool. That
machine has the closed-form inverse of `mathpost.kinematics`, and so has the one with errors.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np
import sympy as sp

from mathpost.compensate.error_model import COMPONENTS, SQUARENESS, error_frame
from mathpost.kinematics import Kinematics
from mathpost.rotation import numeric

_SIX, _POINT = sp.symbols(tuple(COMPONENTS), real=True), sp.symbols(("px", "py", "pz"), real=True)


class CalibratedKinematics:
    """Inverse kinematics of a machine with constant errors.

    Parameters
    ----------
    model : mathpost.compensate.error_model.ErrorModel
    constant : array_like, shape (33,)
        In the order of `model.names`; mm and radians.

    Attributes
    ----------
    machine : mathpost.machine.Machine
        The machine as it is: lines, tool and programmed point moved by the errors.
    workpiece : ndarray, shape (4, 4)
        Takes workpiece coordinates to those of the ideal machine's workpiece.
    slides : ndarray, shape (3, 3)
        The true directions of X, Y and Z as columns.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.compensate.error_model import ErrorModel
    >>> model = ErrorModel(machine.load("data/machines/ac_table.toml"))
    >>> errors = np.where([name == "EYA" for name in model.names], 0.01, 0)
    >>> CalibratedKinematics(model, errors).machine.rotary[0].point
    (0.0, 0.01, -50.0)
    """

    def __init__(self, model, constant):
        machine = model.machine
        errors = dict(zip(model.names, np.asarray(constant, dtype=float), strict=True))
        directions = [_path(name, errors) for name in "XYZ"]
        self.slides = np.empty((3, 3))

        moved, frame = {}, np.eye(4)
        for name in model.structure.workpiece:
            frame = self._pass_slide(name, frame, errors, directions)
        for rotary in machine.rotary:
            if rotary.carries == "workpiece":
                moved[rotary.name], frame = _pass_rotary(rotary, frame, errors)
        origin = _translation(machine.origin)
        self.workpiece = np.linalg.inv(origin) @ frame @ origin

        frame = np.eye(4)
        for name in model.structure.tool:
            frame = self._pass_slide(name, frame, errors, directions)
        # Beyond the slides the chain counts from the spindle nose.
        length, axis = machine.tool_length, np.array(machine.tool_axis) / np.linalg.norm(machine.tool_axis)
        named = {"tip": -length * axis, "nose": np.zeros(3)}.get(machine.programmed_point)
        programmed = np.array(machine.programmed_point) if named is None else named
        frame = _translation(programmed) @ frame @ _translation(-programmed)
        for rotary in machine.rotary:
            if rotary.carries == "tool":
                moved[rotary.name], frame = _pass_rotary(rotary, frame, errors)
        nose = frame[:3, 3]
        self.machine = replace(
            machine,
            rotary=tuple(self._from_nose(moved[rotary.name], nose) for rotary in machine.rotary),
            tool_axis=tuple((frame[:3, :3] @ axis).tolist()),
            programmed_point=tuple((programmed - nose).tolist()),
        )

    def inverse(self, tip, axis):
        """Return the joints of both branches with which the machine, errors and all, reaches a pose.

        Parameters, result and errors are those of `mathpost.kinematics.Kinematics.inverse`; radians.
        """
        tip, axis = np.asarray(tip, dtype=float), np.asarray(axis, dtype=float)
        turned = self.workpiece[:3, :3]
        joints = self._kinematics.inverse(tip @ turned.T + self.workpiece[:3, 3], axis @ turned.T)
        origin = np.array(self.machine.origin)
        joints[..., :3] = np.linalg.solve(self.slides, (joints[..., :3] + origin)[..., None])[..., 0] - origin
        return joints

    @cached_property
    def _kinematics(self):
        return Kinematics(self.machine)

    def _pass_slide(self, name, frame, errors, directions):
        index = "XYZ".index(name)
        self.slides[:, index] = frame[:3, :3] @ directions[index]
        return frame @ _frame(name, np.zeros(3), errors)

    @staticmethod
    def _from_nose(rotary, nose):
        if rotary.carries == "workpiece":
            return rotary
        return replace(rotary, point=tuple((np.array(rotary.point) - nose).tolist()))


def _pass_rotary(rotary, frame, errors):
    """Move the error frame of a rotary joint, and all before it, to behind the joint."""
    point = np.array(rotary.point)
    frame = frame @ _frame(rotary.name, point, errors)
    moved = frame[:3, :3] @ point + frame[:3, 3]
    axis = frame[:3, :3] @ (np.array(rotary.axis) / np.linalg.norm(rotary.axis))
    return replace(rotary, axis=tuple(axis.tolist()), point=tuple(moved.tolist())), frame


def _frame(joint, point, errors):
    kernel = numeric(error_frame(_SIX, sp.Matrix(_POINT)), (*_SIX, *_POINT))
    return kernel(*(errors[f"E{component}{joint}"] for component in COMPONENTS), *point)


def _path(name, errors):
    """The direction of a slide's path, out of square."""
    along = np.eye(3)["XYZ".index(name)]
    turned = [errors[f"E{axis}0{name}"] if f"E{axis}0{name}" in SQUARENESS else 0 for axis in "ABC"]
    return along + np.cross(turned, along)


def _translation(vector):
    matrix = np.eye(4)
    matrix[:3, 3] = vector
    return matrix

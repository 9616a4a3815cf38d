"""The data that lessons, exercises and views load, each once, from any folder below the course."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost import machine_file
from mathpost.files import data_file
from mathpost.kinematics import Kinematics
from mathpost.path import cl

if TYPE_CHECKING:
    from mathpost.path.cl import CLData

SWING = 90.0  # degrees of C between two records; more is a swing


def data(path: str) -> Path:
    """Return the path of a data file: from a folder `data` above the working folder, or from the package."""
    for folder in (Path.cwd(), *Path.cwd().parents):
        if (found := folder / "data" / path).exists():
            return Path(os.path.relpath(found))
    return data_file(path)


@cache
def load(name: str) -> Kinematics:
    """Return the kinematics of a machine of the course, by its file name."""
    return Kinematics(machine_file.load(data(f"machines/{name}.toml")))


@cache
def blade() -> CLData:
    """Return the CL data of table 1 of source 002."""
    return cl.read(data("cl/blade.cl"))


def ellipse(turn: np.ndarray) -> np.ndarray:
    """Return the joints of lessons 13 and 13b: C turns once, A tilts to 60° and back, X and Y follow an ellipse."""
    tilt = np.radians(35 - 25 * np.cos(turn))
    return np.column_stack([80 * np.cos(turn), 60 * np.sin(turn), np.full_like(turn, 20), tilt, turn])


def with_travel(kin: Kinematics, low: float, high: float) -> Kinematics:
    """Return the kinematics of the machine with other limits, in degrees, of its first rotary axis."""
    return with_axis(kin, limits=(np.radians(low), np.radians(high)))


def with_axis(kin: Kinematics, **how: Any) -> Kinematics:
    """Return the kinematics of the machine with a different tilting axis, its first rotary one."""
    first, second = kin.machine.rotary
    return Kinematics(replace(kin.machine, rotary=(replace(first, **how), second)))


def largest_swing(kin: Kinematics) -> float:
    """Return how far C turns at most from one record of the blade to the next, degrees."""
    from mathpost.path import selection  # slow to load, and most lessons do not choose

    return np.abs(np.degrees(np.diff(selection.choose(kin, blade()).joints[:, 4]))).max()

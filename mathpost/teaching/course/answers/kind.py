"""The base class of all kinds of answer."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, Generic, TypeVar

import numpy as np

Data = TypeVar("Data")  # an answer as a kind reads it
Numbers = float | list | np.ndarray  # a number, or lists of them


class Kind(ABC, Generic[Data]):
    """A kind of answer: reading, comparing, showing, and the mix-ups that all answers share."""

    @property
    @abstractmethod
    def asked(self) -> str:
        """The answer asked for, in words."""

    @abstractmethod
    def read(self, answer: Any) -> Data:
        """Return the answer as data, or raise an error."""

    @abstractmethod
    def show(self, value: Data) -> str:
        """Return a solution as text that could be typed."""

    def same(self, value: Data, target: Data) -> bool:
        """Return whether two data are the same answer."""
        return value == target

    def coarse(self, value: Data, target: Data) -> bool:
        """Return whether they agree to the digits of the value, but these are too few."""
        return False

    def units(self, target: Data) -> Iterable[tuple[str, Data]]:
        """Yield the right answer in units that were not asked for, and a sentence that says so."""
        return ()

    def mixups(self, target: Data) -> Iterable[tuple[str, Data]]:
        """Yield the common mix-ups: a sentence and the wrong answer that each leads to."""
        return ()

    def nearly(self, value: Data, target: Data) -> str:
        """Say which part of a wrong answer is right, if any."""
        return ""

    def remark(self, value: Data, target: Data) -> str:
        """Say under which different but usual reading the answer is right, or return an empty text."""
        return ""

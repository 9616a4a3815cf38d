"""What all kinds of answer have in common."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, Generic, TypeVar

import numpy as np

Data = TypeVar("Data")  # what a kind makes of an answer
Numbers = float | list | np.ndarray  # a number, or lists of them


class Kind(ABC, Generic[Data]):
    """What all kinds have in common."""

    @property
    @abstractmethod
    def asked(self) -> str:
        """What to answer with, in words."""

    @abstractmethod
    def read(self, answer: Any) -> Data:
        """Return the answer as data, or raise an error."""

    @abstractmethod
    def show(self, value: Data) -> str:
        """Write a solution as one could type it."""

    def same(self, value: Data, target: Data) -> bool:
        """Whether two data are the same answer."""
        return value == target

    def coarse(self, value: Data, target: Data) -> bool:
        """Whether they agree to the digits that the value has, but those are too few."""
        return False

    def mixups(self, target: Data) -> Iterable[tuple[str, Data]]:
        """Yield the common mix-ups: a sentence and the wrong answer that each leads to."""
        return ()

    def nearly(self, value: Data, target: Data) -> str:
        """Say which part of a wrong answer is right, if any."""
        return ""

    def remark(self, value: Data, target: Data) -> str:
        """Say under which different but usual reading the answer is right; empty if there is none."""
        return ""

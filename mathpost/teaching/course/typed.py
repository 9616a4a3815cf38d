"""A learner's input as plain numbers and words: NC words, units, brackets and signs of every usual form."""

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import astuple, is_dataclass
from typing import Any

import numpy as np

from mathpost.errors import InputError

UNITS = {  # spellings of a unit, as a pattern; units it is mixed up with, and how many of them make one of it
    "degrees": ("°|degrees?|deg|度", {"radians": np.deg2rad(1), "arcseconds": 3600.0}),
    "radians": ("radians?|rad|弧度", {"degrees": np.rad2deg(1)}),
    "mm": ("mm|毫米", {"µm": 1e3, "inches": 1 / 25.4}),
    "µm": ("μm|um|微米", {"mm": 1e-3}),
    "µrad": ("μrad|urad|微弧度", {"radians": 1e-6}),
    "s": ("seconds?|sec|s|秒", {}),
}
PREPARATORY = re.compile(r"^G68\.2\s*(?:[XYZ]\s*[-+]?[\d.]+\s*)*|^PLANE EULER\s*", re.IGNORECASE)
NUMBER = r"(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)"
OVER = r"(?:\s*/\s*(?P<over>\d+\.?\d*))?(?:\s*(?P<percent>%))?"
ANY_NAME = r"(?!not?(?![^\W\d_]))[^\W\d_]+"  # letters of any script
BETWEEN = re.compile(r"[\s,;、]*")
COUNTED = ("no", "one", "two", "three", "four", "five", "six")


def numbers(
    answer: Any, asked: str, unit: str = "", orders: Sequence[Sequence[str]] = (), counts: Sequence[int] = ()
) -> np.ndarray:
    """Return an answer as an array of finite floats.

    Each of `orders` is a tuple of names: numbers that all carry names of one of them are returned in its order,
    however they were typed. `counts` says how many there may be: where a text has a different number of them, its
    commas between digits are decimal commas. `asked` is the expectation in an `InputError`.

    Examples
    --------
    >>> numbers("G68.2 I180 J90 K-90", "", "degrees", [("I", "J", "K")]).tolist()
    [180.0, 90.0, -90.0]
    >>> numbers("C -24.6°, B = 52.4°", "", "degrees", [("B", "C")]).tolist()
    [52.4, -24.6]
    >>> numbers("ρ=100°", "", "degrees").tolist(), numbers("K74.46", "").tolist()
    (100.0, 74.46)
    >>> numbers("4,5 -1,25", "", counts=[2]).tolist(), numbers("-1/2", "").item(), numbers("12.5 %", "").item()
    ([4.5, -1.25], -0.5, 0.125)
    """
    if isinstance(answer, str):
        answer = _of_text(answer, asked, unit, orders, counts)
    if isinstance(answer, dict):
        answer = _by_name(answer, asked, orders, answer)
    if isinstance(answer, (list, tuple)):
        answer = [astuple(each) if is_dataclass(each) and not isinstance(each, type) else each for each in answer]
    if np.asarray(answer).dtype.kind in "bcmM":
        raise TypeError("truth values, complex numbers or dates")
    array = np.asarray(answer, dtype=float)
    if not np.isfinite(array).all():
        raise InputError("answer", asked, "what is not a finite number")
    return array


def _of_text(
    text: str, asked: str, unit: str, orders: Sequence[Sequence[str]], counts: Sequence[int]
) -> float | list[float]:
    """Return the number in a text, or a list of several."""
    found = _words(text, asked, unit, orders)
    with_points = re.sub(r"(?<=\d),(?=\d)", ".", text)
    if counts and len(found) not in counts and with_points != text and "." not in text:
        found = _words(with_points, asked, unit, orders)
    values = [value for _, value in found]
    if len(found) < 2:
        return values[0] if values else []
    named = [name for name, _ in found if name]
    if not named:
        return values
    by_name = dict(found)
    if len(by_name) < len(found) or len(named) < len(found):
        raise InputError("answer", asked, brief(text))
    return _by_name(by_name, asked, orders, text)


def _words(text: str, asked: str, unit: str, orders: Sequence[Sequence[str]]) -> list[tuple[str | None, float]]:
    """Return the numbers in a text, each with the name before it; a fraction and a percentage are one number."""
    bare = re.sub(r"[\[\](){}]", " ", _plain(text).replace("′", "'"))
    spelled = UNITS.get(unit, (re.escape(_plain(unit or "°")),))[0]
    bare = re.sub(rf"(?<=[\d.])\s*(?:°|(?:{spelled})(?!\w))", " ", bare, flags=re.IGNORECASE)
    bare, found, place = PREPARATORY.sub("", bare.strip()), [], 0
    known = [re.escape(_plain(name)) for order in orders for name in order]
    names = "|".join([*sorted(known, key=len, reverse=True), ANY_NAME])
    word_of_text = re.compile(rf"(?:(?P<name>{names})'?\s*[=:]?\s*)?{NUMBER}{OVER}", re.IGNORECASE)
    while place < len(bare):
        word = word_of_text.match(bare, _past_marks(bare, place))
        if not word:
            raise InputError("answer", asked, brief(text))
        over = float(word["over"] or 1) * (100 if word["percent"] else 1)
        if over == 0 or (word["percent"] and unit):
            raise InputError("answer", asked, brief(text))
        found.append((word["name"], float(word["number"]) / over))
        place = _past_marks(bare, word.end())
    return found


def _past_marks(text: str, place: int) -> int:
    """Return where the next word begins."""
    found = BETWEEN.match(text, place)
    return found.end() if found else place


def _by_name(answer: dict, asked: str, orders: Sequence[Sequence[str]], written: Any) -> list[float]:
    """Return the values of a dict in the order of its names in `orders`; an error shows the answer as `written`."""
    plain = {_plain(name).rstrip("'").casefold(): value for name, value in answer.items()}
    for order in orders:
        names = [_plain(name).casefold() for name in order]
        if len(plain) == len(answer) and set(plain) == set(names):
            return [plain[name] for name in names]
    raise InputError("answer", asked, brief(written))


def counted(size: int) -> str:
    """Return a count of numbers in words."""
    return f"{COUNTED[size] if size < len(COUNTED) else size} number{'' if size == 1 else 's'}"


def bare(name: object) -> str:
    """Return a name without case, spaces, quotes, primes, brackets and degree signs, which do not matter."""
    text = f"{name:g}" if isinstance(name, float) else str(name)
    return re.sub(r"[\s'\"`´‘’“”′()\[\].,;_°]", "", _plain(text)).casefold()


def _plain(text: object) -> str:
    """Return a text with every kind of minus, small digit and wide letter in its plain form."""
    return unicodedata.normalize("NFKC", str(text)).replace("−", "-")


def brief(answer: Any) -> str:
    """Return an answer as it was typed, shortened."""
    try:
        text = repr(answer)
    except Exception:  # a class of the learner's
        text = f"a {type(answer).__name__}"
    return text if len(text) <= 60 else text[:57] + "..."

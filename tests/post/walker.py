"""A walker for NC programs: runs their text as a control would, and shares nothing with the package.

It knows the words that the programs of the tests have, one machine with a turning table and one with a fork head,
and says of every move where the tip goes in the workpiece, with which tool axis, tool, and time.
"""

import re
from dataclasses import dataclass, field

import numpy as np

WORD = re.compile(r"([A-Z])\s*=?\s*([-+]?\d*\.?\d+)")


def turn(axis, degrees):
    """Rodrigues: the matrix that turns right-handed about a unit vector."""
    x, y, z = axis
    k, a = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=float), np.radians(degrees)
    return np.eye(3) + np.sin(a) * k + (1 - np.cos(a)) * k @ k


def table_tip(words, origin, length):
    """Data/machines/ac_table.toml: A about −X through (0, 0, −50) carries C about −Z; words name the tip."""
    turned = turn((-1, 0, 0), words["A"]) @ np.eye(3), np.array([0, 0, -50])
    at = np.array([words["X"], words["Y"], words["Z"]]) + origin
    back = turned[0].T @ (at - turned[1]) + turned[1]
    spun = turn((0, 0, -1), words["C"]).T
    return spun @ back - origin, spun @ turned[0].T @ [0, 0, 1]


def head_tip(words, origin, length):
    """Data/machines/ac_head.toml: C about Z carries A about X; words name the pivot, 200 above the nose."""
    axis = turn((0, 0, 1), words["C"]) @ turn((1, 0, 0), words["A"]) @ [0, 0, 1]
    return np.array([words["X"], words["Y"], words["Z"]]) - (200 + length) * axis, axis


@dataclass
class Walk:
    """Where a program went: of each move the tip, the tool axis, whether it was rapid, its seconds, the tool."""

    tips: list = field(default_factory=list)
    axes: list = field(default_factory=list)
    rapid: list = field(default_factory=list)
    seconds: list = field(default_factory=list)
    tools: list = field(default_factory=list)
    sides: list = field(default_factory=list)
    said: list = field(default_factory=list)


def walk(text, where=table_tip, origin=(0, 0, 0), lengths=None):
    """Run a Heidenhain program or one in G codes; `lengths` is the tool table."""
    walked, words, tool, rapid, inverse, feed, side = Walk(), {}, 0, False, False, None, "off"
    heidenhain = "BEGIN PGM" in text
    for line in text.splitlines():
        line = re.sub(r"\(.*?\)|;.*", "", line).strip()
        line = re.sub(r"^\d+\s*|^N\d+\s*", "", line)
        if not line or line.startswith(("%", "O", "BEGIN", "END")):
            continue
        if match := re.match(r"T(\d+)$", line):
            ready = int(match[1])  # in the magazine
            continue
        if match := re.match(r"TOOL CALL (\d+)|T(\d+) M6|M6", line):
            tool, words = int(match[1] or match[2] or ready), {}  # the tool is changed where nobody knows
            walked.said.append(f"T{tool}")
            continue
        line = re.sub(r"\bG43 H\d+ (?=[A-Z])", "", line)
        if re.match(r"TOOL CALL S|CYCL|S\d|M\d|D\d|G4 |TRA|G43|G49", line):
            walked.said.append(line)
            continue
        for code, effect in (("G40", "off"), ("R0", "off"), ("G41", "left"), ("RL", "left"), ("G42", "right")):
            if re.search(rf"\b{code}\b", line):
                side, line = effect, re.sub(rf"\b{code}( D\d+)?\b", "", line)
        codes = re.findall(r"\bG0*(\d+)\b", line)
        rapid = {"0": True, "1": False}.get(
            next((c for c in codes if c in "01"), ""), False if heidenhain else rapid
        )
        inverse = {"93": True, "94": False}.get(next((c for c in codes if c in ("93", "94")), ""), inverse)
        rapid |= "FMAX" in line
        time = re.search(r"FT([\d.]+)", line)
        found = dict(WORD.findall(re.sub(r"FT[\d.]+|FMAX|^L ", "", re.sub(r"\bG\d+\b", "", line))))
        number = float(found.pop("F")) if "F" in found else None
        if number is not None and not inverse:
            feed = number
        if not found:
            continue
        before = dict(words)
        words |= {axis: float(value) for axis, value in found.items()}
        assert len(words) == 5, f"{line}: an axis was never set"
        tip, axis = where(words, np.array(origin, dtype=float), (lengths or {}).get(tool, 0.0))
        seconds = np.nan
        if time or (inverse and number):
            seconds = float(time[1]) if time else 60 / number
        elif feed and len(before) == 5 and all(before[name] == words[name] for name in "AC"):
            seconds = 60 * np.linalg.norm([before[name] - words[name] for name in "XYZ"]) / feed
        for column, value in zip(
            ("tips", "axes", "rapid", "seconds", "tools", "sides"),
            (tip, axis, rapid, seconds, tool, side),
            strict=True,
        ):
            getattr(walked, column).append(value)
    return walked

"""Right programs for every control, and slips planted in them, as a post or a person at the control makes them.

A slip is made in the text, or by a post for another machine or path. It counts only if it moves tip or tool axis
off what the right program cuts, by the reader and the machine of `tests.independent`, which share nothing with the
package.
"""

import re
from dataclasses import dataclass, replace

import numpy as np

from mathpost import machine_file as machines
from mathpost import postprocess
from mathpost.errors import MathpostError
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from mathpost.shop.post.verify import Verified, verify
from tests.conftest import DATA
from tests.independent import judge, reader
from tests.independent.machine_model import Model
from tests.independent.words import Refused
from tests.post import test_own_words as own_words

CONTROLS = own_words.CONTROLS
MACHINES = ("ac_table", "bc_table", "dmu50v", "head_b_table_c", "ac_head", "nutating_head", "nutating_head_table")
EFFECT = 0.2  # mm or degrees, by which a slip changes a word at least
MOVED = 3 * np.array([0.01, np.radians(0.1)])


@dataclass(frozen=True)
class Job:
    """A path, a machine and a right program."""

    file: str  # of the machine
    machine: object
    control: str
    tcp: bool
    path: cl.CLData
    text: str

    def judged(self, text: str | None = None) -> Verified:
        return verify(self.text if text is None else text, self.machine, self.control, cl=self.path)

    def cut(self, text: str) -> tuple[np.ndarray, np.ndarray]:
        """What a program cuts: poses (n, 6) in units of `MOVED`, and of which move each is."""
        setup = self.machine
        model = Model(DATA / f"machines/{self.file}.toml", length=setup.tool_length, origin=setup.origin)
        moves = reader.read(text, self.control, reader.Setup(model, length_on=True))
        found = judge.sample(model, moves, turn=0.5)
        feed = np.array([moves[move].kind == "feed" for move in found.move], bool)
        return np.c_[found.tip / MOVED[0], found.axis / MOVED[1]][feed], found.move[feed]


def job(rng, control=None, *, tcp=None) -> Job:
    """A random job; a path that a machine cannot run is drawn anew."""
    while True:
        file = str(rng.choice(MACHINES))
        machine = machines.load(DATA / f"machines/{file}.toml")
        kin, name = Kinematics(machine), control or str(rng.choice(CONTROLS))
        with_tcp = bool(rng.random() < 0.5) if tcp is None else tcp
        path = _path(rng, kin)
        try:
            made = postprocess(path, machine, dialect=name, tcp=with_tcp)
        except MathpostError:
            continue
        return Job(file, machine, name, with_tcp, path, made.program)


def own_words_job(rng, control=None, *, tcp=None) -> Job:
    """A random job of arcs or holes, upright or tilted, sometimes with TCP, in the control's own words."""
    while True:
        file, dialect = str(rng.choice(own_words.MACHINES)), control or str(rng.choice(CONTROLS))
        angles = {letter: rng.uniform(10, 30) for letter in "ABC"} if rng.random() < 0.5 else {}
        setup, *vectors = own_words.on_machine(file, **angles)
        with_tcp = bool(rng.random() < 0.3) if tcp is None else tcp
        if rng.random() < 0.5:
            text, _ = own_words.arcs_file(rng, *vectors, int(rng.integers(3, 9)))
        else:
            text, _ = own_words.holes_file(rng, *vectors)
        path = cl.parse(text)
        try:
            made = postprocess(path, setup, dialect=dialect, tcp=with_tcp)
        except MathpostError:
            continue
        return Job(file, setup, dialect, with_tcp, path, made.program)


def _path(rng, kin):
    """A curved path of some 20 records whose tool axis leans 5 to 35 degrees from the pole and goes about it."""
    count = int(rng.integers(12, 30))
    t = np.linspace(0, 1, count)
    wave = rng.normal(size=(3, 3)) * [[30], [30], [8]]
    points = sum(wave[:, n, None] * np.sin((n + 1.5) * t + rng.uniform(0, 6)) for n in range(3)).T
    pole = np.array(kin.inverse_symbolic.pole, dtype=float)
    if pole[2] < 0.5:
        pole = np.array([0, 0, 1.0])
    around = rng.uniform(0, 2 * np.pi) + rng.uniform(0.5, 1.5) * t
    lean = np.radians(rng.uniform(8, 15) + 8 * np.sin(3 * t))
    across = np.cross(pole, [1, 0, 0.3])
    across /= np.linalg.norm(across)
    other = np.cross(pole, across)
    side = np.cos(around)[:, None] * across + np.sin(around)[:, None] * other
    axes = np.cos(lean)[:, None] * pole + np.sin(lean)[:, None] * side
    return cl.from_arrays(points, axes, feed=1000.0)


def slip(rng, kind: str, control: str | None = None) -> tuple[Job, str, str]:
    """A job, its program with a slip of this kind that changes what is cut, and an expression for its name."""
    while True:
        draw = own_words_job if kind in ("sign", "digit", "lost", "inch", "rapid") and rng.random() < 0.3 else job
        made = draw(rng, control, tcp=False if kind in ("pivot", "length") else None)
        planted = PLANTED[kind](rng, made)
        if planted is not None and changes(made, planted[0]):
            return made, *planted


def changes(made: Job, text: str) -> bool:
    """Whether another text cuts elsewhere than the right one, or leaves something out."""
    try:
        right = made.cut(made.text)
    except Refused:
        return False  # what a slip would change cannot be seen
    try:
        wrong = made.cut(text)
    except Refused:
        return True
    return max(_furthest(right[0], *wrong), _furthest(wrong[0], *right)) > 1


def _furthest(points, poses, move):
    """How far the one of the points is from the ways of poses that is furthest."""
    same = move[1:] == move[:-1]
    start, along = poses[:-1][same], np.diff(poses, axis=0)[same]
    if not len(start):
        return np.inf
    off = points[:, None] - start
    t = np.clip(np.vecdot(off, along) / np.maximum(np.vecdot(along, along), 1e-300), 0, 1)
    return np.linalg.norm(off - t[..., None] * along, axis=2).min(axis=1).max()


def _word(names):
    letters = "|".join(re.escape(name) for name in names)
    return re.compile(rf"(?<![A-Z0-9.])({letters})(=?)([-+]?\d+\.?\d*)")


def _rows(text):
    return [n for n, line in enumerate(text.splitlines()) if _word("XYZABC").search(line) and "CONTROL" not in line]


def _edited(made, names, change, rows=None):
    """The text with the numbers of some axes changed, in some lines or all."""
    lines = made.text.splitlines()
    for n in _rows(made.text) if rows is None else rows:
        lines[n] = _with_words(lines[n], names, change, _sign(made))
    return "\n".join(lines) + "\n"


def _with_words(line, names, change, sign):
    """A line with other numbers in the words of some axes: what `change` makes of a name and its number."""
    return _word(names).sub(lambda word: f"{word[1]}{word[2]}{change(word[1], float(word[3])):{sign}.4f}", line)


def _sign(made):
    return "+" if made.control == "heidenhain" else ""


def _sign_slip(rng, made):
    name = made.machine.rotary[rng.integers(2)].name
    return _edited(made, [name], lambda _, value: -value), f"^{name} turns the other way"


def _posted(made, path=None, machine=None):
    """The program of another path or machine."""
    try:
        found = postprocess(path or made.path, machine or made.machine, dialect=made.control, tcp=made.tcp)
    except MathpostError:
        return None
    return found.program


def _pivot_slip(rng, made):
    which, factor = int(rng.integers(2)), float(rng.choice([0, 2]))
    rotary = list(made.machine.rotary)
    rotary[which] = replace(rotary[which], point=tuple(factor * np.array(rotary[which].point)))
    changed = _posted(made, machine=replace(made.machine, rotary=tuple(rotary)))
    return None if changed is None else (changed, f"pivot of {rotary[which].name} ")


def _length_slip(rng, made):
    more = round(float(rng.choice([-1, 1]) * rng.uniform(0.5, 40)), 2)
    length = made.machine.tool_length + more
    changed = _posted(made, machine=made.machine.with_setup(tool_length=length)) if length > 0 else None
    said = f"^the program is made for a tool that is {abs(more):.2f} mm {'longer' if more > 0 else 'shorter'}"
    return None if changed is None else (changed, said)


def _origin_slip(rng, made):
    shift = np.round(rng.uniform(-20, 20, 3) * (rng.random(3) < 0.6), 2)
    moved = " ".join(f"{name}{value:+z.3f}" for name, value in zip("XYZ", shift, strict=True))
    said = "^the origin of the CL data is moved by " + re.escape(moved)
    changed = _posted(made, path=cl.from_arrays(made.path.points + shift, made.path.axes, feed=1000.0))
    return None if changed is None else (changed, said)


def _branch_slip(rng, made):
    kin, names = Kinematics(made.machine), made.machine.joint_names[3:]
    read = made.judged()
    both = kin.inverse(read.tips, read.axes, degrees=True)[..., 3:]
    now = np.degrees(read.joints[:, 3:])
    away = np.abs((both - now[:, None] + 180) % 360 - 180).sum(axis=2).argmax(axis=1)
    turns = np.unwrap(both[np.arange(len(now)), away], period=360, axis=0)
    other = dict(zip(read.program.lines.tolist(), turns.tolist(), strict=True))
    lines = made.text.splitlines()
    for number, angles in other.items():
        values = dict(zip(names, angles, strict=True))
        lines[number - 1] = _with_words(lines[number - 1], names, lambda name, _, to=values: to[name], _sign(made))
    return "\n".join(lines) + "\n", "other branch"


def _winding_slip(rng, made):
    rows = _rows(made.text)
    endless = [each.name for each in made.machine.rotary if not np.isfinite(each.limits).all()]
    if not endless:
        return None
    first = int(rng.integers(len(rows) // 3, len(rows)))
    text = _edited(made, [endless[0]], lambda _, value: value + 360, rows[first:])
    return text, f"^{endless[0]} turns by .* whole turn"


def _digit_slip(rng, made):
    lines, rows = made.text.splitlines(), _rows(made.text)
    n = int(rng.choice(rows))
    found = rng.choice(np.array(list(_word(made.machine.joint_names).finditer(lines[n])), dtype=object))
    places = [k for k, character in enumerate(found[3]) if character.isdigit()]
    place = int(rng.choice(places))
    digit = str(rng.choice([each for each in "0123456789" if each != found[3][place]]))
    number = found[3][:place] + digit + found[3][place + 1 :]
    if abs(float(number) - float(found[3])) < EFFECT:
        return None
    start, end = found.span(3)
    lines[n] = lines[n][:start] + number + lines[n][end:]
    return "\n".join(lines) + "\n", f"^line {n + 1}: {re.escape(found[1] + found[2] + number)} stands where"


def _lost_slip(rng, made):
    lines, rows = made.text.splitlines(), _rows(made.text)
    gone = int(rng.choice(rows))
    return "\n".join(lines[:gone] + lines[gone + 1 :]) + "\n", "left out|ends before|missing"


def _inch_slip(rng, made):
    """The word of the unit, or all numbers of X Y Z where no arcs and cycles have others."""
    if re.search(r"^C |[IJKR]-?\d|CYC", made.text, re.MULTILINE) or rng.random() < 0.5:
        return re.sub(r"\bG21\b|\bG710\b| MM$", _other_unit, made.text, flags=re.MULTILINE), "inch"
    factor = float(rng.choice([25.4, 1 / 25.4]))
    return _edited(made, "XYZ", lambda _, value: value * factor), "inch"


def _other_unit(found):
    return {" MM": " INCH", "G21": "G20", "G710": "G700"}[found[0]]


def _rapid_slip(rng, made):
    """A block in rapid traverse: by its word, G0 or FMAX, and the next one at its feed again."""
    lines, rows = made.text.splitlines(), _rows(made.text)
    n = int(rng.choice(rows[2:]))
    judged = made.judged()
    if n + 1 in [judged.line(block) for block, _ in judged.pace.slow]:
        return None  # the CL data are in rapid traverse there
    if made.control == "heidenhain":
        if not re.match(r"\d* ?L ", lines[n]):
            return None
        lines[n] = re.sub(r" F\d\S*|$", " FMAX", lines[n], count=1)
    else:
        stated = re.findall(r"\bG([0-3]|8\d)\b", "\n".join(lines[: n + 1]))
        if stated[-1:] != ["1"] or re.search(r"G(?!1\b)|MCALL|CYCLE", lines[n]):
            return None
        lines[n] = re.sub(r"^(N\d+ )?(G1 )?", r"\1G0 ", lines[n])
        for after in rows[rows.index(n) + 1 :][:1]:
            lines[after] = re.sub(r"^(N\d+ )?(?=[XYZABC])", r"\1G1 ", lines[after])
    return "\n".join(lines) + "\n", f"^rapid +line {n + 1},"


PLANTED = {
    "sign": _sign_slip, "pivot": _pivot_slip, "branch": _branch_slip, "winding": _winding_slip,
    "digit": _digit_slip, "lost": _lost_slip, "inch": _inch_slip, "length": _length_slip, "origin": _origin_slip,
    "rapid": _rapid_slip,
}  # fmt: skip
KINDS = tuple(PLANTED)


def names(judged: Verified) -> list[str]:
    """What is said of the slip, the likeliest first."""
    return [*judged.explained, *re.findall("^rapid +line.*", str(judged), re.MULTILINE)]

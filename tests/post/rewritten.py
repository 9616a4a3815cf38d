"""Right programs as another post would write them: the same motion in other words.

`rewritten(rng, job)` draws some of the ways in which posts differ: block numbers, blanks, small letters, zeros,
signs, the order of words, modal words that are stated again, increments, arcs by their radius, absolute centres,
planes by other angles, TCP by its other word. Nothing of the package writes or reads here.
"""

import re
from decimal import Decimal

import numpy as np

LETTERS = ("zeros", "order", "again", "split", "leading", "tight", "lower", "radius", "numbers", "remarks", "plus",
           "increments", "absolute")  # fmt: skip
KLARTEXT = ("zeros", "plus", "increments", "again", "R0", "tcpm", "plane", "lines", "M99", "CR", "remarks")
WORD = re.compile(r"([A-Z]+\d?(?==)=?|[A-Z])([-+]?(?:\d+\.?\d*|\.\d+))")
STRAIGHT = re.compile(r"(?:G0?[01] )?(?:[XYZABC]-?\d+\.\d+ ?)+(?:F[\d.]+)?")
ANEW = re.compile(
    r"G43|G49|G5[3-9]|G6[89]|G8|G28|G9[0-4]|G234|M6|M68|T\d|TRA|CYC|MCALL|SUPA|D\d|CALL|PLANE|M1|FUNC|CC|DEF"
)


def rewritten(rng, job) -> str:
    """The program of a job in other words."""
    if job.control != "heidenhain":
        lines = [re.sub(r"^N\d+ ", "", line) for line in job.text.splitlines()]
        return "\n".join(_letters(rng, lines, job.control)) + "\n"
    lines = _klartext(rng, [re.sub(r"^\d+ ", "", line) for line in job.text.splitlines()])
    first, step = int(rng.choice([0, 10])), int(rng.choice([1, 10]))
    number = rng.random() < 0.5
    return "".join(f"{first + step * n} {line}\n" if number else f"{line}\n" for n, line in enumerate(lines))


def _comment(line):
    return line.startswith(("(", ";", "%", "O0"))


def _number(rng, text, *, point):
    """The same number with other zeros and another sign of plus; `point` if it must keep its decimal point."""
    value = Decimal(text)
    plain = format(value.normalize(), "f")
    if value == 0:
        plain = "0"
    if rng.random() < 0.3 and plain.lstrip("-").startswith("0."):
        plain = plain.replace("0.", ".", 1)
    if point and "." not in plain:
        plain += "."
    return plain


def _letters(rng, lines, control):
    """A program of letters and numbers: Fanuc and its likes, Siemens."""
    named = control == "siemens"
    strict = control in ("fanuc", "haas", "mazak")
    style = {name: rng.random() < 0.5 for name in LETTERS}
    made = lines
    if style["increments"]:
        made = _increments(rng, made, named)
    if style["radius"]:
        made = _by_radius(made, named)
    elif style["absolute"] and named:
        made = _absolute_centres(made)
    if style["again"]:
        made = _motion_again(made)
    found = []
    for line in made:
        if _comment(line):
            found.append(line)
            continue
        if style["split"] and line.startswith(("G21 G17", "G710 G17")):
            found += line.split()
            continue
        if style["zeros"] and not re.search(r"CYCLE|MCALL|M68|M66|TRA", line):
            line = WORD.sub(lambda word: _zeros(rng, word, strict), line)
        if style["order"] and not re.search(r"CYCLE|MCALL|M68|M66|=I?C|G43", line):
            line = _ordered(rng, line)
        if style["leading"]:
            line = re.sub(r"(?<![A-Z\d.])([GM])(\d)(?![\d.])", r"\g<1>0\2", line)
        if style["plus"] and not re.search(r"CYCLE|MCALL|M68|G4 ", line):
            line = re.sub(r"(?<![A-Z])([XYZABC])(?=\d)", r"\1+", line)
        if style["tight"] and not re.search(r"CYCLE|MCALL|TRA|M6[68]|=", line):
            line = line.replace(" ", "")
        if style["remarks"] and rng.random() < 0.2:
            line += " ; X1 Y2" if named else " (X1 Y2)"
        if style["lower"] and not named:
            line = line.lower()
        found.append(line)
    if not style["numbers"]:
        return found
    step = int(rng.choice([1, 5, 10]))
    return [line if _comment(line) or not line else f"N{step * (n + 1)}{' ' * bool(rng.integers(2))}{line}"
            for n, line in enumerate(found)]  # fmt: skip


def _zeros(rng, word, strict):
    name, number = word[1], word[2]
    if name.rstrip("=") in ("G", "M", "N", "O", "S", "T", "H", "D", "P"):
        return word[0]
    return name + _number(rng, number, point=strict)


def _ordered(rng, line):
    """The positions of a block in another order; what is not a position stays in front or behind."""
    words = line.split()
    places = [n for n, word in enumerate(words) if re.match(r"[XYZABC]=?[-+.\d]", word)]
    for place, word in zip(places, rng.permutation([words[n] for n in places]), strict=True):
        words[place] = str(word)
    return " ".join(words)


def _motion_again(lines):
    """G0 and G1 in every block that moves straight."""
    found, motion = [], ""
    for line in lines:
        if stated := re.search(r"(?<![\dA-Z.])G[0-3](?![\d.])", line):
            motion = stated[0]
        if re.search(r"G8\d|G7[34]|MCALL|CYCLE", line):
            motion = ""
        plain = STRAIGHT.fullmatch(line) and not line.startswith("G")
        found.append(f"{motion} {line}" if plain and motion in ("G0", "G1") else line)
    return found


def _increments(rng, lines, named):
    """Some straight moves in increments: between G91 and G90, or with IC( ) of Siemens."""
    found, at, inside, holes = [], {}, False, False
    for line in lines:
        straight = STRAIGHT.fullmatch(line) and not holes
        words = dict(re.findall(r"([XYZABC])(-?\d+\.\d+)", line)) if straight else {}
        known = bool(words) and all(name in at for name in words)
        wanted = known and rng.random() < 0.7
        if named:
            if wanted:
                line = _relative(line, at, "{}=IC({})")
        else:
            if wanted != inside:
                found.append("G91" if wanted else "G90")
                inside = wanted
            if inside:
                line = _relative(line, at, "{}{}")
        found.append(line)
        if not _comment(line) and ANEW.search(line):
            at = {}
        if re.search(r"G8[1-9]|G7[34]|MCALL \w", line):
            holes = True
        elif re.search(r"G80|MCALL$", line):
            holes = False
        turning = re.search(r"(?<![\dA-Z.])G[23](?![\d.])", line)
        at |= {name: Decimal(value) for name, value in words.items()}
        if turning:
            at |= {name: Decimal(value) for name, value in re.findall(r"([XYZ])(-?\d+\.\d+)", line)}
    if inside:
        found.insert(len(found) - 1, "G90")
    return found


def _relative(line, at, form):
    """The positions of a line as steps from where the axes are."""
    words = re.compile(r"([XYZABC])(-?\d+\.\d+)")
    return words.sub(lambda word: form.format(word[1], Decimal(word[2]) - at[word[1]]), line)


def _by_radius(lines, named):
    """Arcs in XY of 20 to 150 degrees by their radius."""
    found, at = [], {}
    for line in lines:
        if not _comment(line) and ANEW.search(line):
            at = {}
        words = dict(re.findall(r"(?<![A-Z(])([XYZIJ])(-?\d+\.\d+)", line))
        if re.match("G[23] ", line) and {"X", "Y", "I", "J"} <= set(words) and {"X", "Y"} <= set(at):
            start, end = (np.array([float(each[n]) for n in "XY"]) for each in (at, words))
            offset = np.array([float(words["I"]), float(words["J"])])
            u, v = -offset, end - start - offset
            sweep = np.degrees(np.arctan2(u[0] * v[1] - u[1] * v[0], u @ v)) * (1 if line[1] == "3" else -1) % 360
            if 20 < sweep < 150:
                radius = f"{'CR=' if named else 'R'}{np.linalg.norm(offset):.5f}"
                line = re.sub(r"I-?[\d.]+ J-?[\d.]+", radius, line)
        found.append(line)
        at |= {name: value for name, value in words.items() if name in "XYZ"}
    return found


def _absolute_centres(lines):
    """Centres of arcs in the coordinates of the words, as Siemens may have them."""
    found, at = [], {}
    for line in lines:
        if not _comment(line) and ANEW.search(line):
            at = {}
        arc = re.search(r"I(-?[\d.]+) J(-?[\d.]+)", line)
        if arc and "X" in at and "Y" in at:
            where = f"I=AC({at['X'] + Decimal(arc[1])}) J=AC({at['Y'] + Decimal(arc[2])})"
            found.append(line.replace(arc[0], where))
        else:
            found.append(line)
        at |= {name: Decimal(value) for name, value in re.findall(r"(?<![A-Z(])([XYZ])(-?\d+\.\d+)", line)}
    return found


def _klartext(rng, lines):
    style = {name: rng.random() < 0.5 for name in KLARTEXT}
    found, at = [], {}
    for line in lines:
        if line.startswith(";"):
            found.append(line)
            continue
        words = dict(re.findall(r"(?<![A-Z])([XYZABC])([-+][\d.]+)", line)) if line.startswith("L ") else {}
        if ANEW.search(line) and not line.startswith("CC"):
            at = {} if not line.startswith("CYCL") else at
        if style["increments"] and words and set(words) <= set(at) and "M91" not in line and rng.random() < 0.5:
            for name, value in words.items():
                line = line.replace(f"{name}{value}", f"I{name}{Decimal(value) - at[name]:+}")
        elif style["again"] and words and set("XYZ") <= set(at) and "M91" not in line:
            line = re.sub("^L", "L " + " ".join(f"{n}{at[n]:+}" for n in "XYZ" if n not in words), line)
        at |= {name: Decimal(value) for name, value in words.items()}
        if line.startswith("CC "):
            pole = dict(re.findall(r"([XY])([-+][\d.]+)", line))
        arc = re.fullmatch(r"C X(\S+) Y(\S+) DR([-+])( F\S+)?", line)
        if arc and style["CR"] and {"X", "Y"} <= set(at) and found[-1].startswith("CC"):
            start = np.array([float(at["X"]), float(at["Y"])])
            end, centre = np.array([float(arc[1]), float(arc[2])]), np.array([float(pole["X"]), float(pole["Y"])])
            u, v = start - centre, end - centre
            sweep = np.degrees(np.arctan2(u[0] * v[1] - u[1] * v[0], u @ v)) * (1 if arc[3] == "+" else -1) % 360
            if 20 < sweep < 150 or 210 < sweep < 340:
                sign = "+" if sweep < 180 else "-"
                found.pop()
                line = f"CR X{arc[1]} Y{arc[2]} R{sign}{np.linalg.norm(u):.5f} DR{arc[3]}{arc[4] or ''}"
        if arc:
            at |= {"X": Decimal(arc[1]), "Y": Decimal(arc[2])}
        elif line.startswith("CP"):
            at = {}
        if re.match("M128", line) and style["tcpm"]:
            line = "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS"
        if re.match("M129", line) and style["tcpm"]:
            line = "FUNCTION RESET TCPM"
        if line.startswith("PLANE SPATIAL") and style["plane"]:
            line = _other_plane(rng, line)
        if line == "CYCL CALL":
            at.pop("Z", None)
            if style["M99"] and found[-1].startswith("L ") and ";" not in found[-1]:
                found[-1] += " M99"
                continue
        if line.startswith("CYCL DEF 200") and style["lines"]:
            head, *values = re.split(r" (?=Q\d)", line)
            line = " ~\n  ".join([head, *(f"{value} ;VALUE" for value in values)])
        if line.startswith(("L ", "C ", "CR ", "CC ")):
            if style["zeros"]:
                line = re.sub(
                    r"(?<=[XYZABCR])[-+]\d+\.\d+", lambda word: _signed(rng, word[0], not style["plus"]), line
                )
            elif not style["plus"] and "CR" not in line:
                line = re.sub(r"(?<=[XYZABC])\+", "", line)
            if style["R0"] and line.startswith("L ") and "M99" not in line:
                line = re.sub(r"( F\S+)?$", r" R0\1", line, count=1)
        if style["remarks"] and rng.random() < 0.2 and "~" not in line:
            line += " ; X+1"
        found.append(line)
    return found


def _signed(rng, text, bare):
    number = _number(rng, text.lstrip("+"), point=False)
    return number if number.startswith("-") or bare else f"+{number}"


def _other_plane(rng, line):
    """PLANE SPATIAL as PLANE EULER or PLANE VECTOR, by matrices that are written out here."""
    a, b, c = (np.radians(float(value)) for value in re.findall(r"SP[ABC]([-+][\d.]+)", line))
    rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    ry = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    turn, rest = rz @ ry @ rx, line[line.index("SPC") :].partition(" ")[2]
    if rng.random() < 0.5:
        names = ("BX", "BY", "BZ", "NX", "NY", "NZ")
        values = np.r_[turn[:, 0], turn[:, 2]]
        return "PLANE VECTOR " + " ".join(f"{n}{v:+.9f}" for n, v in zip(names, values, strict=True)) + f" {rest}"
    lean = np.degrees(np.arccos(np.clip(turn[2, 2], -1, 1)))
    if lean < 1e-6:
        return line
    first = np.degrees(np.arctan2(turn[0, 2], -turn[1, 2]))
    third = np.degrees(np.arctan2(turn[2, 0], turn[2, 1]))
    return f"PLANE EULER EULPR{first:+.7f} EULNU{lean:+.7f} EULROT{third % 360:+.7f} {rest}"

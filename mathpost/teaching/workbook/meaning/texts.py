"""What the texts of a sheet say that it was asked to do: sequence, convention, names of the angles."""

from __future__ import annotations

import re
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

from mathpost import euler
from mathpost.teaching.workbook.meaning.label import plain
from mathpost.teaching.workbook.meaning.vocabulary import wording

if TYPE_CHECKING:
    from mathpost.teaching.workbook.task import Task

BETWEEN = r"['’′]*[-–→·, ]*"
SEQUENCE = re.compile(rf"(?<![A-Za-z])([XYZ]){BETWEEN}([XYZ]){BETWEEN}([XYZ])['’′]*(?![A-Za-z])", re.I)
PRIMED = re.compile(r"(?<![A-Za-z])([XYZ])[-–, ]*([XYZ])['’′][-–, ]*([XYZ])(?:['’′]{2}|[\"”″])", re.I)
WXYZ = r"\bw[, ]*x[, ]*y[, ]*z\b|\bx[, ]*y[, ]*z[, ]*w\b"  # the parts of a quaternion
NUMBERED = re.compile(r"(?<![\d.])([123])-([123])-([123])(?![\d.])")
TURNS = rf"{wording('turning')}|\br_?[xyz]\b"
ONE_AXIS = rf"{wording('about')}(?:\s|\(|{wording('the')})*([xyz])(?![a-z])"
AXIS_OR_THEN = re.compile(rf"(?<![a-z])([xyz])(?![a-z])|({wording('then')})", re.I)
FACTOR = r"\bR_?([xyz123])\b\W?([^\s()*·×∙⋅+=;,]*)\W*?"
CHAIN = re.compile(r"[*·×∙⋅]\s*".join([FACTOR] * 3), re.I)
SPACED = re.compile("[=+] *" + " ".join([FACTOR] * 3), re.I)
# p′ᵀ = pᵀ·Rᵀ for rows is the same as p′ = R·p for columns.
BOTH_SIDES = r"\b([prvx])['’′]?(?:ᵀ|\^T) *= *\1(?:ᵀ|\^T) ?[·*×]? ?\w+(?:ᵀ|\^T)"
ROWS = rf"{wording('row vector')}|\brows?\b[^.;,\n]{{0,15}}[·*×]"
YAW_PITCH_ROLL = r"\w*\W+".join(wording(each) for each in ("yaw", "pitch", "roll"))
ORIGIN, CENTRE = rf"{wording('origin')}|\bp_?0\b", wording("centre")  # what is taken off before it
NUMBERS = str.maketrans("123", "XYZ")
UNDONE = rf"\^-1|⁻¹|ᵀ|\^t\b|{wording('undone')}"
OF_MATRICES = rf"(?!\w*\s*\w*(?:{wording('matrix')}|[xyz]\())"  # active matrices may make a passive rotation
SAID_ACTIVE = wording("active") + "(?![轴轮])"
ACTIVE = SAID_ACTIVE + OF_MATRICES
# T·R·p and p₀ + R·p, which take a point from its frame to another one.
ACTIVE += r"|\bT(?:rans(?:\([^)]*\))?)?\W?[*·×]\s*R|\b(?:o|t|p_?0|origin|nullpunkt|ursprung)\s*\+\s*\(?R"
ACTIVE += r"|(?P<c>\b\w+)\s*\+\s*R[\s·*×]*\(\w+ *[-–−] *(?P=c)\)"  # a point that turns about a centre
PASSIVE = rf"{wording('passive')}\w*{OF_MATRICES}|{wording('turned frame')}"
SPANISH = r"el|en|los|las|con|del|por|para|una|sistema|il|gli|della|nel|em|com|não"  # and Italian, Portuguese
FOREIGN = rf"[ぁ-ヿ가-힣]|[\u0400-\u04ff]{{3}}|(?:\b(?:{SPANISH})\b.*){{2}}"
CONVENTION = wording("convention")
OF_TURNS = rf"{wording('turning', 'convention', 'matrix', 'transformation', 'point')}|\bR_?[xyz]"
OF_TURNS += r"\b|[xyz]['’′-]|\b[xyz]{3}\b"
DENIED = rf"{wording('not')}[^.;,，。]{{0,20}}(?:acti|akti|主动)"
NOT_ASKED = wording("another task")
TURNED = rf"\bactive,? \(?[xyz]['’′]*[-– ]|['’′\"],? \(?active\b|{wording('a turned point')}"
TURNED += rf"|{wording('an active rotation')}{OF_MATRICES}"  # by words that no transposed matrix takes back
TRANSPOSED = rf"{wording('transposed')}|(?:\)|active|aktiv)\^?[Tᵀ]\b|(?<!R[·*×]R)ᵀ"
TRANSPOSED += r"|\bR(?:\^T|\^-1|⁻¹) ?[·*×]? ?\(?p\b(?!['’′])"  # what becomes of the point, not of what became of it


class Reading(NamedTuple):
    """What the task, else the texts of a sheet, else source 000 say that is asked for; `by` says which.

    `doubts` are why that is doubtful; `names` are those of the angles in the order of the sequence, if a product of
    matrices has them, a negated one with its minus; `also` are other sequences and conventions that the texts may
    mean, where they have words for both.
    """

    sequence: str
    active: bool
    by: str
    doubts: list[str]
    names: tuple[str, ...]
    also: list[tuple[str, bool]]
    axes: str  # "turned" or "fixed" if words say one of the two


def reading(task: Task, text: str) -> Reading:
    """Return the `Reading` of a task and a text."""
    text = "\n".join(line for line in text.splitlines() if not re.search(NOT_ASKED, line, re.I))
    turns = [re.sub(WXYZ, "", line, flags=re.I) for line in text.splitlines() if re.search(TURNS, line, re.I)]
    said = {"".join(f.groups()).upper() for f in PRIMED.finditer(text)}
    said |= {"".join(f.groups()).upper() for line in turns for f in SEQUENCE.finditer(line)}
    said |= {"".join("XYZ"[int(n) - 1] for n in f.groups()) for line in turns for f in NUMBERED.finditer(line)}
    in_words = [re.findall(ONE_AXIS, line, re.I) for line in text.splitlines()]
    said |= {"".join(axes).upper() for axes in in_words if len(axes) == 3}
    ways = ([f[1] or ">" for f in AXIS_OR_THEN.finditer(line)] for line in turns)
    parts = ["".join(part).upper() for part in ways if part.count(">") > 1 and part[0] != ">"]
    said |= {axes for part in parts if len(axes := part.replace(">", "")) == 3}
    said &= set(euler.SEQUENCES)
    if not said and re.search(PASSIVE + "|" + SAID_ACTIVE, text, re.I) and re.search(YAW_PITCH_ROLL, text, re.I):
        said = {"ZYX"}
    by_task = task.sequence or ("ZXZ" if task.kind == "zxz" else "")
    by_text = next(iter(said)) if len(said) == 1 else ""
    several, doubts = sorted(said - {"XYZ"}), []  # "XYZ" may be coordinates
    if len(several) > 1 and not by_task:
        doubts.append(f"the texts name {' and '.join(several)}: --sequence says which is asked for")
    fixed = re.search(wording("fixed axes"), text, re.I)
    by_text = by_text.lower() if fixed else by_text
    may = re.search(CONVENTION, text, re.I)  # beside which a cell may hold the word alone
    of_turns = [line for line in text.splitlines() if re.search(OF_TURNS, line, re.I) or (may and line.isalpha())]
    of_turns = [] if re.search(DENIED, text, re.I) else of_turns
    is_active, of_matrices = (any(re.search(p, line, re.I) for line in of_turns) for p in (ACTIVE, SAID_ACTIVE))
    own = re.sub(BOTH_SIDES, "", text)  # what is transposed by itself
    passive, transposed = bool(re.search(PASSIVE, text, re.I)), bool(re.search(TRANSPOSED, own, re.I))
    active = is_active and not passive and (not transposed or bool(re.search(TURNED, text, re.I)))
    active = task.convention == "active" if task.convention else active
    turning = re.search(wording("turned axes"), text, re.I) or PRIMED.search(text)
    # R_z(α)·R_x(β)·R_z(γ) is active unless that is denied, the other way not.
    names: tuple[str, ...] = ()
    chains = (*CHAIN.finditer(text), *SPACED.finditer(text))
    for chain in chains:
        axes, angles = "".join(chain.groups()[::2]).upper().translate(NUMBERS), [*chain.groups()[1::2]]
        in_order = all(angles) and angles == sorted(set(angles))
        in_order |= by_text == axes != axes[::-1]  # as the sequence is said
        minus = [angle[:1] in ("-", "−") for angle in angles]
        before = text[: chain.start()].rpartition("\n")[2]
        of_steps = chain[1].isdigit() and not all(angles)  # R₃·R₂·R₁, matrices of the first step, the second, …
        if of_steps or re.search(UNDONE, before, re.I):
            continue
        if axes in euler.SEQUENCES and by_text in ("", axes):
            denied = passive or transposed or task.convention
            active = (active or ((in_order or of_matrices) and not denied)) and not all(minus)
            order = 1 if active else -1
            if active or axes != axes[::-1]:
                names = tuple(plain(angle).replace("−", "-").lstrip("-" * all(minus)) for angle in angles)[::order]
            if fixed and not by_text:
                axes, names = axes[::-1].lower(), names[::-1]
            by_text = by_text or axes[::order]
            active &= not re.search(ROWS, text, re.I)  # p·R is of a row what Rᵀ·p is of a column
        elif active and by_text == axes[::-1] != axes and not turning:  # active matrices, about fixed axes
            by_text = by_text.lower()
    by = "the task" if by_task else "the text" if by_text else "source 000"
    sequence = by_task or by_text or "ZXZ"
    cases = [sequence, *[sequence.swapcase()] * bool(fixed and turning and not by_task)]
    is_plain = not chains  # a product says more than a word
    axes = "turned" if re.search(wording("about new axes"), text, re.I) and is_plain and not fixed else ""
    axes = "fixed" if fixed and is_plain and not turning else axes
    may_be_active = re.search(SAID_ACTIVE, text, re.I) and not re.search(DENIED, text, re.I)
    other = passive or transposed if active else may_be_active
    senses = [active, *[not active] * bool(other and not task.convention)]
    return Reading(sequence, active, by, doubts, () if by_task else names, [*product(cases, senses)][1:], axes)

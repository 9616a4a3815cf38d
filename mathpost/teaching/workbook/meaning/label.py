"""What a label in a worksheet says of a cell: an angle, a coordinate, its cosine, in many spellings."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache

from mathpost.teaching.workbook.meaning.vocabulary import wording

IN_RADIANS = wording("radians")
SPELLINGS = (  # brought to one: no blanks, one minus, one prime, Greek letters for their names
    ("[′’‘`´ʹ＇]", "'"),
    ("[−–—‐]|负|minus|negative|neg(?=_)", "-"),
    (r"[_\s]*prime", "'"),
    *(("alpha|ɑ|а|phi|φ|^al$", "α"), ("beta|ß|theta|θ|^be$", "β"), ("gamma|psi|ψ|^ga$", "γ")),
    (r"/?\(?(?:(?:in )?rad(?:ians)?|弧度)\)?|\[rad\]", "rad"),
    (r"\((?:deg|degrees?|°|度|mm)\)|\[(?:deg|°|mm)\]|(?:/|\sin)\s*(?:deg|°|grad|mm)$|[\s°_]", ""),
    *(("[，、]", ","), ("^[=:：]+|[=:：]+$", ""), (r"^\(([^()]*)\)$", r"\1")),
)
ANGLE = (
    r"(?:[^αβγ]{{0,4}}角度?|(?:euler)?angle|欧拉角|(?:dreh|euler)?winkel)?{}([αβγ])(?:角度?|deg|degrees|度|angle)?"
)
COORDINATE = r"(?:p|点|原|初始|原始)?([xyz])(?:coordinate|坐标|轴|0|1|alt|cl)?{}(?:coordinate|坐标)?"
SINGLE = {  # the last letter or digit that a group takes says which
    **{"cos": "cos-?([αβγ])", "sin": "sin-?([αβγ])", "radians": "rad-?([αβγ])|-?([αβγ])rad"},
    **{"negated": ANGLE.format("-"), "coordinate": COORDINATE.format("")},
    "angle": ANGLE.format("") + "|(?:旋转角|角|angle|winkel|drehwinkel)([123])",
    "outcome": r"([uvw])|\(([xyz])\)'|" + COORDINATE.format("(?:'+|new|neu|p|rot|rotated|2|nc|m)") + "|"
    "(?:新|new|result|ergebnis|结果|旋转后|最终点?)" + COORDINATE.format("(?:'+|new|neu|p|rot|rotated|2|nc|m)?"),
}
WHICH = "αβγxyzuvw123"
GREEK = {unicodedata.name(letter).split()[-1].lower(): letter for letter in "αβγθφψω"}


@dataclass(frozen=True, order=True)
class Role:
    """What a cell holds.

    `kind` is angle, negated, radians, cos, sin, coordinate or outcome; `which` says of which angle (0 = α) or
    coordinate (0 = x).
    """

    kind: str
    which: int

    def __str__(self) -> str:
        return f"{self.kind} {('xyz' if self.kind in ('coordinate', 'outcome') else 'αβγ')[self.which]}"


def plain(text: str) -> str:
    """Return a text with Greek letters for their names, and digits for small ones.

    Examples
    --------
    >>> plain("alpha, φ₁")
    'α, φ1'
    """
    return re.sub(
        "[A-Za-z]+", lambda name: GREEK.get(name[0].lower(), name[0]), unicodedata.normalize("NFKC", text)
    )


@lru_cache(10_000)
def read_label(text: str) -> Role | None:
    """Return the `Role` that a label, a name or a key says, or None.

    Examples
    --------
    >>> print(read_label("x′"), read_label("−α"), read_label("cos β"), read_label("φ [rad]"), sep=", ")
    outcome x, negated α, cos β, radians α
    """
    text = unicodedata.normalize("NFKC", str(text)).lower().strip()
    for pattern, plain in SPELLINGS:
        text = re.sub(pattern, plain, text)
    for kind, pattern in SINGLE.items():
        if found := re.fullmatch(pattern, text):
            *_, said = filter(None, found.groups())
            return Role(kind, WHICH.index(said) % 3)
    return None

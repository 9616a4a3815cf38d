"""What a label in a worksheet says: the roles of ranges, and the many spellings of their names.

A *role* says what a range holds: ``Role("angle", (0,))`` is α, ``Role("matrix", (2, 1))`` the product γβ.
"""

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
    (r"^(矩阵|matrix|m|total|product|产品|乘积|中间矩阵|最终矩阵|produkt|zwischenergebnis)\d$", "r"),
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
NOISE = re.compile(
    r"(?:(?:坐标变换|变换|旋转|转置)?矩阵|乘积|matrix|product)\d*|最终|elementary|passive|active|rotation|final|"
    r"transposed?|转置|method\d?|recipe\d?|方法[一二12]?|step\d*|步骤\d*|mat(?=[αβγ])|[\s()\[\]{}·*×⋅.∙_^:/&|]|^\d+"
)


@dataclass(frozen=True, order=True)
class Role:
    """What a range holds.

    `kind` is angle, negated, radians, cos, sin, coordinate or outcome of one cell; matrix or transposed of nine.
    `word` says which angle (0 = α) or coordinate (0 = x), of a matrix its product from left to right; it is empty
    for a matrix said to be the final one.
    """

    kind: str
    word: tuple[int, ...] = ()

    def __str__(self) -> str:
        letters = "xyz" if self.kind in ("coordinate", "outcome") else "αβγ"
        return f"{self.kind} {''.join(letters[n] for n in self.word)}"


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
    >>> read_label("矩阵γβ"), read_label("matrix gamma beta alpha =")
    (Role(kind='matrix', word=(2, 1)), Role(kind='matrix', word=(2, 1, 0)))
    >>> print(read_label("x′"), read_label("−α"), read_label("(αβγ)ᵀ"), read_label("cos β"), sep=", ")
    outcome x, negated α, transposed αβγ, cos β
    """
    text = unicodedata.normalize("NFKC", str(text).replace("ᵀ", "^t")).lower().strip()
    for pattern, plain in SPELLINGS:
        text = re.sub(pattern, plain, text)
    for kind, pattern in SINGLE.items():
        if found := re.fullmatch(pattern, text):
            *_, said = filter(None, found.groups())
            return Role(kind, (WHICH.index(said) % 3,))
    kind = "transposed" if re.search(r"转置|transpos|\)t|\^t|\)'|[αβγ]{2}[t']$|^[rm]t$", text) else "matrix"
    said = NOISE.sub("", next((part for part in text.split("=") if re.search("[αβγ]", part)), text))
    letters = re.sub("[^αβγ]", "", said)
    letters = re.sub(r"^(.+)\1$", r"\1", letters)
    if (not said and re.search("矩阵|matrix|转置|transpos", text)) or re.fullmatch("[rm]t?", said):
        return Role(kind)
    known = re.fullmatch(r"(?:[emr]?[xyz]?-?[αβγ])+[t']?", said)
    single = len(set(letters)) == len(letters)
    return Role(kind, tuple(map("αβγ".index, letters))) if known and single else None

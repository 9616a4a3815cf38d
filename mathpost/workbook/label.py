"""What a label in a worksheet says: the roles of ranges, and the many spellings of their names.

A *role* says what a range holds: ``Role("angle", (0,))`` is α, ``Role("matrix", (2, 1))`` the product γβ.
"""

import re
import unicodedata
from dataclasses import dataclass

VECTORS = {
    "angles": "angles angle 角度 欧拉角 eulerangles zxzangles zxz欧拉角 zxz givenangles α,β,γ",
    "point": "p point 点 点坐标 坐标 初始坐标 原坐标 初始点 原始点 原点坐标 初始坐标点 初始点坐标 原始坐标 p0 "
    "xyz x,y,z originalpoint coordinates givenpoint pointcoordinates",
    "result": "p' result 结果 新坐标 新点 新坐标点 点' 新点坐标 计算结果 最终坐标 变换后坐标 旋转后坐标 "
    "x'y'z' x',y',z' p1 point' newpoint newcoordinates rotatedpoint answer transformedpoint finalpoint output",
    "matrix": "r m",
    "transposed": "rt mt r^t m^t",
}
VECTORS = {name: kind for kind, names in VECTORS.items() for name in names.split()}
SINGLE = {"angles": "angle", "point": "coordinate", "result": "outcome"}  # what one cell of a vector is
UNIT_WORDS = {"=", ":", "°", "deg", "degree", "degrees", "度", "mm", "rad", "弧度", "->", "→", "："}
NOISE = re.compile(
    r"坐标变换矩阵|变换矩阵|旋转矩阵|转置矩阵|矩阵|乘积|最终|elementary|passive|active|rotation|matrix|product|final|"
    r"transposed?|转置|method\d?|recipe\d?|方法[一二12]?|step\d*|步骤\d*|mat(?=[αβγ])"
)
WORD = re.compile(r"(?:[emr]?[xyz]?-?[αβγ])+[t']?")
COORDINATE = re.compile(
    r"(新|new|result|ergebnis|结果|旋转后|最终点?)?(?:p|点|原|初始|原始)?([xyz])(?:coordinate|坐标|轴|0|1|alt|cl)?"
    r"('+|new|neu|p|rot|rotated|2|nc|m)?(?:coordinate|坐标)?"
)
NUMBERED = re.compile(r"(?:旋转角|角|angle|winkel|drehwinkel)([123])|(?:(φ|phi)|(θ|theta)|(ψ|psi))(?:rad)?")
SPELLINGS = (  # brought to one: no blanks, one minus, one prime, Greek letters for their names
    ("[′’‘`´ʹ＇]", "'"),
    ("[−–—‐]|负|minus|negative|neg(?=_)", "-"),
    (r"[_\s]*prime", "'"),
    (r"^(矩阵|matrix|m|total|product|产品|乘积|中间矩阵|最终矩阵|produkt|zwischenergebnis)\d$", "r"),
    *(("alpha|ɑ|а", "α"), ("beta|ß", "β"), ("gamma", "γ")),
    (r"\((?:rad(?:ians)?|弧度)\)|\[rad\]", "rad"),
    (r"\((?:deg|degrees?|°|度|mm)\)|\[(?:deg|°|mm)\]|[\s°_]", ""),
    *(("[，、]", ","), ("^[=:：]+|[=:：]+$", ""), (r"^\(([^()]*)\)$", r"\1")),
)


@dataclass(frozen=True, order=True)
class Role:
    """What a range holds.

    `kind` is angle, negated, radians, cos, sin, coordinate or outcome of one cell; angles, point or result of
    three; matrix or transposed of nine. `word` says which angles (0 = α) or coordinate (0 = x), of a matrix its
    product from left to right; it is empty for a whole vector and for a matrix said to be the final one.
    """

    kind: str
    word: tuple = ()

    def __str__(self):
        if self.kind in ("coordinate", "outcome"):
            return "xyz"[self.word[0]] + "'" * (self.kind == "outcome")
        name = "".join("αβγ"[n] for n in self.word)
        return {"angle": "", "negated": "−", "radians": "radians of "}.get(self.kind, f"{self.kind} ") + name


def read_label(text):
    """Return the `Role` that a label, a name or a key says, or None.

    Examples
    --------
    >>> read_label("矩阵γβ"), read_label("matrix gamma beta alpha =")
    (Role(kind='matrix', word=(2, 1)), Role(kind='matrix', word=(2, 1, 0)))
    >>> print(read_label("x′"), read_label("−α"), read_label("(αβγ)ᵀ"), read_label("cos β"), sep=", ")
    x', −α, transposed αβγ, cos β
    >>> read_label("ZXZ欧拉角α，β，γ的旋转") is None
    True
    """
    text = unicodedata.normalize("NFKC", str(text).replace("ᵀ", "^t")).lower().strip()
    for pattern, plain in SPELLINGS:
        text = re.sub(pattern, plain, text)
    if not text or len(text) > 40:
        return None
    if text in VECTORS:
        return Role(VECTORS[text])
    if found := re.fullmatch(r"(cos|sin)-?([αβγ])", text):
        return Role(found[1], ("αβγ".index(found[2]),))
    if found := re.fullmatch(r"(?:rad|弧度|radians)-?([αβγ])|-?([αβγ])(?:rad|弧度|inrad|radians)", text):
        return Role("radians", ("αβγ".index(found[1] or found[2]),))
    if found := re.fullmatch(r"(?:角度?|angle|eulerangle|欧拉角)?(-?)([αβγ])(?:角度?|deg|degrees|度|angle)?", text):
        return Role("negated" if found[1] else "angle", ("αβγ".index(found[2]),))
    if found := NUMBERED.fullmatch(text):
        return Role("angle", (int(found[1]) - 1 if found[1] else found.lastindex - 2,))
    if found := COORDINATE.fullmatch(text):
        return Role("outcome" if found[1] or found[3] else "coordinate", ("xyz".index(found[2]),))
    if found := re.fullmatch(r"([uvw])|\(([xyz])\)'", text):
        return Role("outcome", ("uvwxyz".index(found[found.lastindex]) % 3,))
    return _matrix_label(text)


def _matrix_label(text):
    transposed = re.search(r"转置|transpos|\)t|\^t|\)'|[αβγ]{2}[t']$", text)
    kind = "transposed" if transposed else "matrix"
    said = next((part for part in text.split("=") if re.search("[αβγ]", part)), text)
    if re.search(r"[,，、;]", said):
        return None
    said = re.sub(r"[\s()\[\]{}·*×⋅.∙_^:/&|]|^\d+", "", NOISE.sub("", said))
    if not said and re.search("矩阵|matrix|转置|transpos", text):
        return Role(kind)
    letters = re.sub("[^αβγ]", "", said)
    half = letters[: len(letters) // 2]
    letters = half if half and letters == half * 2 else letters
    if not WORD.fullmatch(said) or len(letters) > 3 or len(set(letters)) < len(letters):
        return None
    return Role(kind, tuple("αβγ".index(letter) for letter in letters))

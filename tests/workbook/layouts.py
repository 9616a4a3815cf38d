"""Right sheets as strangers make them: every arrangement, language and way to calculate, drawn at random.

`draw(rng)` returns a `Book`. Each author writes cells and registers what its results ought to be, from SciPy's
rotations; `verify` compares the sheet with it at random inputs. Angles are in degrees, passive means the
coordinates of a fixed point in the turned frame, and a sequence is written as SciPy does: "ZXZ" moving axes, "zxz"
fixed ones.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tests.workbook.cells import SAMPLES, Area, Array, Book, Values

SOURCE_ANGLES, SOURCE_POINT = (135, 54.7356, -90), (3, 4, 5)
LABELS = {
    "title": {
        "en": ("Coordinate transformation", "Homework 3", "Rotation of a point"),
        "de": ("Koordinatentransformation", "Übung 3", "Drehung eines Punktes"),
        "zh": ("坐标转换计算", "欧拉角旋转坐标转换", "作业三"),
    },
    "angles": {
        "en": (
            ("alpha", "beta", "gamma"),
            ("α", "β", "γ"),
            ("phi", "theta", "psi"),
            ("angle 1", "angle 2", "angle 3"),
        ),
        "de": (("Winkel 1", "Winkel 2", "Winkel 3"), ("α [°]", "β [°]", "γ [°]"), ("φ", "θ", "ψ")),
        "zh": (("旋转角1", "旋转角2", "旋转角3"), ("α角度", "β角度", "γ角度"), ("α", "β", "γ")),
    },
    "point": {
        "en": (("x", "y", "z"), ("Px", "Py", "Pz"), ("x0", "y0", "z0"), ("X", "Y", "Z"), ("X1", "Y1", "Z1")),
        "de": (("x", "y", "z"), ("Px", "Py", "Pz"), ("x_alt", "y_alt", "z_alt")),
        "zh": (("x", "y", "z"), ("原x", "原y", "原z"), ("点X", "点Y", "点Z")),
    },
    "origin": {
        "en": (("origin x", "origin y", "origin z"), ("Ox", "Oy", "Oz"), ("xc", "yc", "zc")),
        "de": (("Ursprung x", "Ursprung y", "Ursprung z"), ("Nullpunkt x", "Nullpunkt y", "Nullpunkt z")),
        "zh": (("原点x", "原点y", "原点z"), ("旋转中心x", "旋转中心y", "旋转中心z")),
    },
    "result": {
        "en": (
            ("x'", "y'", "z'"),
            ("x'''", "y'''", "z'''"),
            ("Result X", "Result Y", "Result Z"),
            ("x rotated", "y rotated", "z rotated"),
            ("u", "v", "w"),
            ("X2", "Y2", "Z2"),
        ),
        "de": (("x neu", "y neu", "z neu"), ("Ergebnis x", "Ergebnis y", "Ergebnis z"), ("x'", "y'", "z'")),
        "zh": (("旋转后x", "旋转后y", "旋转后z"), ("最终点x", "最终点y", "最终点z"), ("x'", "y'", "z'")),
    },
    "step": {
        "en": ("after turn {n}", "step {n}", "P{n}"),
        "de": ("nach Drehung {n}", "Schritt {n}", "P{n}"),
        "zh": ("第{n}次旋转后", "步骤{n}", "P{n}"),
    },
    "matrix": {
        "en": ("matrix {n}", "R{axis} ({n})", "M{n}", "{axis}{n}", "rotation about {axis}"),
        "de": ("Matrix {n}", "Drehmatrix {n}", "Drehung um {axis}", "M{n}"),
        "zh": ("矩阵{n}", "绕{axis}轴旋转", "绕{axis}轴的旋转矩阵", "{axis}{n}"),
    },
    "product": {
        "en": ("product {n}", "total {n}", "matrix product", "R"),
        "de": ("Produkt {n}", "Zwischenergebnis {n}", "Gesamtmatrix"),
        "zh": ("乘积{n}", "中间矩阵{n}", "最终矩阵"),
    },
    "transposed": {"en": ("transposed",), "de": ("transponiert",), "zh": ("转置矩阵",)},
    "translation": {"en": ("shift",), "de": ("Verschiebung",), "zh": ("平移矩阵",)},
    "negated": {"en": ("minus angle",), "de": ("negativer Winkel",), "zh": ("角度取反",)},
    "radians": {"en": ("rad",), "de": ("Bogenmaß",), "zh": ("弧度",)},
    "determinant": {"en": ("determinant", "det"), "de": ("Determinante",), "zh": ("行列式",)},
    "norm": {"en": ("length", "norm"), "de": ("Länge", "Betrag"), "zh": ("长度",)},
    "expected": {"en": ("expected",), "de": ("Sollwert",), "zh": ("期望值",)},
    "difference": {"en": ("difference",), "de": ("Differenz",), "zh": ("误差",)},
    "max": {"en": ("max. difference",), "de": ("größte Abweichung",), "zh": ("最大误差",)},
    "passive": {
        "en": ("coordinates of the fixed point in the turned frame (passive)",),
        "de": ("Koordinaten des festen Punktes im gedrehten System (passiv)",),
        "zh": ("固定点在旋转后坐标系中的坐标（被动旋转）",),
    },
    "active": {
        "en": ("the point is turned (active rotation)",),
        "de": ("der Punkt wird gedreht (aktive Drehung)",),
        "zh": ("旋转点本身（主动旋转）",),
    },
    "moving": {
        "en": ("Euler angles {seq}, about the turned axes (intrinsic)",),
        "de": ("Eulerwinkel {seq}, um die mitgedrehten Achsen (intrinsisch)",),
        "zh": ("欧拉角{seq}，绕旋转后的坐标轴（内旋）",),
    },
    "fixed": {
        "en": ("Rotations {seq} about the fixed axes (extrinsic)",),
        "de": ("Drehungen {seq} um die festen Achsen (extrinsisch)",),
        "zh": ("绕固定轴旋转{seq}（外旋）",),
    },
}


@dataclass
class Style:
    """How one person lays out a sheet."""

    language: str | None
    beside: bool  # labels before the cells, not above them
    stacked: bool
    product: str  # array, dynamic, sums, sumproduct, sum of an array
    unit: str  # RADIANS, PI, factor, helper, radians, alpha
    inline: bool  # COS(…) in the elements, not in cells of its own
    fixed: bool  # $ in references within the sheet
    names: bool
    sheets: int
    upright: bool  # vectors as columns


def draw_style(rng, **given):
    style = Style(
        language=rng.choice(["en", "de", "zh", None]),
        beside=bool(rng.integers(2)),
        stacked=bool(rng.integers(2)),
        product=str(rng.choice(["array", "dynamic", "sums", "sums", "sumproduct", "sum"])),
        unit=str(rng.choice(["RADIANS", "RADIANS", "PI", "factor", "helper", "radians", "alpha"])),
        inline=bool(rng.integers(2)),
        fixed=bool(rng.integers(2)),
        names=bool(rng.integers(4) == 0),
        sheets=int(rng.choice([1, 1, 1, 2, 3])),
        upright=bool(rng.integers(3)),
    )
    for name, value in given.items():
        setattr(style, name, value)
    return style


SHEET_NAMES = {
    "en": ("Input", "Matrices", "Result"),
    "de": ("Eingabe", "Matrizen", "Ergebnis 1"),
    "zh": ("输入", "矩阵", "结果"),
    None: ("Sheet1", "Sheet2", "Sheet3"),
}


class Pen:
    """Writes blocks of cells one after the other."""

    def __init__(self, rng, style, book=None):
        self.rng, self.style, self.book = rng, style, book or Book(shared=bool(rng.integers(2)))
        self.sheets = [str(name) for name in SHEET_NAMES[style.language]]
        self.sheet, self.used = self.sheets[0], []
        self.start()

    def start(self):
        self.left = int(self.rng.integers(1, 4))
        self.row, self.column, self.bottom = int(self.rng.integers(1, 4)), self.left, 0

    def turn_page(self):
        """Go on in the next sheet, if the style has one."""
        position = self.sheets.index(self.sheet) + 1
        if position < self.style.sheets:
            self.sheet = self.sheets[position]
            self.start()

    def word(self, kind, **values):
        if self.style.language is None:
            return None
        options = LABELS[kind][self.style.language]
        text = options[self.rng.integers(len(options))]
        return text.format(**values).strip() if isinstance(text, str) else text

    def line(self, text):
        """A text in a row of its own."""
        if text:
            self.new_band()
            self.book.cells[self.sheet, self.row, self.left] = text
            self.row += 2

    def new_band(self):
        self.row, self.column, self.bottom = (
            max(self.row, self.bottom + 2 if self.bottom else self.row),
            self.left,
            0,
        )

    def block(self, rows, columns, label=None):
        """Take room for a block of cells below or beside the last one, with its label; returns its area."""
        beside = bool(self.style.beside and label)
        if self.style.stacked or self.column > 14:
            self.new_band()
        top = self.row + (1 if label and not beside else 0)
        left = self.column + int(beside)
        if label:
            self.book.cells[self.sheet, self.row, self.column] = label
        self.column = left + columns + 1
        self.bottom = max(self.bottom, top + rows - 1)
        return Area(self.sheet, top, left, rows, columns)

    def put(self, area, contents):
        for key, content in zip(area.each(), np.ravel(np.array(contents, dtype=object)), strict=True):
            if content is not None:
                self.book.cells[key] = content.item() if isinstance(content, np.generic) else content
        return area

    def fill(self, contents, label=None):
        contents = np.array(contents, dtype=object)
        return self.put(self.block(*contents.shape, label), contents)

    def labelled(self, values, labels, *, upright=True):
        """A vector whose entries have their labels beside or above them; returns its area."""
        n = len(values)
        if upright:
            area = self.block(n, 2 if labels else 1)
            if labels:
                self.put(area.part(0, 0, n, 1), labels)
                area = area.part(0, 1, n, 1)
        else:
            area = self.block(2 if labels else 1, n)
            if labels:
                self.put(area.part(0, 0, 1, n), labels)
                area = area.part(1, 0, 1, n)
        return self.put(area, values)

    def ref(self, area, fixed=None):
        fixed = self.style.fixed if fixed is None else fixed
        return area.text(self.sheet, row_fixed=fixed, column_fixed=fixed)

    def entry(self, area, n):
        """The reference to the n-th cell of a vector or matrix."""
        row, column = divmod(n, area.columns)
        return self.ref(area.part(row, column))

    # Calculations.

    def radians(self, degrees):
        """The angles in radians, as fragments of formulas, from the area of angles in degrees."""
        cells = [degrees.part(*divmod(n, degrees.columns)) for n in range(3)]
        if self.style.names and self.style.unit in ("RADIANS", "PI"):
            for n, cell in enumerate(cells):
                self.book.names[("alpha", "beta", "gamma")[n]] = cell.key()
            refs = ["alpha", "beta", "gamma"]
        else:
            refs = [self.ref(cell) for cell in cells]
        if self.style.unit == "helper":
            area = (
                self.block(3, 1, self.word("radians"))
                if self.style.upright
                else self.block(1, 3, self.word("radians"))
            )
            self.put(area, [f"=RADIANS({ref})" for ref in refs])
            return [self.entry(area, n) for n in range(3)]
        form = {"RADIANS": "RADIANS({})", "PI": "{}*PI()/180", "factor": "{}/57.29577951308232"}.get(
            self.style.unit, "{}"
        )
        return [form.format(ref) for ref in refs]

    def trigonometry(self, radians):
        """(cosine, sine) of each angle as fragments of formulas."""
        if self.style.inline:
            return [(f"COS({angle})", f"SIN({angle})") for angle in radians]
        pairs = []
        labels = ["cos", "sin"] if self.style.language else None
        for angle in radians:
            area = self.labelled([f"=COS({angle})", f"=SIN({angle})"], labels, upright=self.style.upright)
            pairs.append((self.entry(area, 0), self.entry(area, 1)))
        return pairs

    def elementary(self, axis, pair, passive, n, size=3):
        """The elementary matrix about an axis, in cells."""
        label = self.word("matrix", n=n, axis=axis) if self.style.language else None
        area = self.block(size, size, label)
        entries, other = (texts(embed(elementary_terms(axis, *pair, p), size)) for p in (passive, not passive))
        self.put(area, entries)
        self.book.turned.append(dict(zip(area.each(), [entry for row in other for entry in row], strict=True)))
        return area

    def product(self, left, right, label=None, *, upright=True):
        """A product of two areas, in the form the style has; registers the slips that concern it as a whole."""
        form = self.style.product
        shape = (left.rows, right.columns)
        area = self.block(*shape, label)
        contents = self.product_formulas(area, left, right, form)
        self.put(area, contents)
        wrong = {}
        if left.rows == right.columns == left.columns:
            wrong["order of product"] = self.product_formulas(area, right, left, form)
        for n, factor in enumerate((left, right)):
            if factor.rows == factor.columns:
                wrong[f"transposed {n}"] = self.product_formulas(area, left, right, form, turned=n)
        self.book.products.append((area, {cause: np.ravel(cells).tolist() for cause, cells in wrong.items()}))
        return area

    def product_formulas(self, area, left, right, form, turned=None):
        a, b = self.ref(left), self.ref(right)
        contents = np.full((area.rows, area.columns), None, dtype=object)
        if form in ("array", "dynamic"):
            factors = [f"TRANSPOSE({ref})" if n == turned else ref for n, ref in enumerate((a, b))]
            contents[0, 0] = Array(area.rows, area.columns, f"=MMULT({factors[0]},{factors[1]})", form == "dynamic")
            return contents
        for r in range(area.rows):
            for c in range(area.columns):
                row = left.part(r, 0, 1, left.columns) if turned != 0 else left.part(0, r, left.rows, 1)
                column = right.part(0, c, right.rows, 1) if turned != 1 else right.part(c, 0, 1, right.columns)
                if form in ("sumproduct", "sum"):
                    x = self.ref(row) if turned != 0 else f"TRANSPOSE({self.ref(row)})"
                    y = f"TRANSPOSE({self.ref(column)})" if turned != 1 else self.ref(column)
                    formula = f"=SUMPRODUCT({x},{y})" if form == "sumproduct" else f"=SUM({x}*{y})"
                    contents[r, c] = Array(1, 1, formula)
                else:
                    terms = zip(range(left.columns), range(left.columns), strict=True)
                    contents[r, c] = "=" + "+".join(
                        f"{self.entry(row, k)}*{self.entry(column, k)}" for k, _ in terms
                    )
        return contents

    def transpose(self, area):
        label = self.word("transposed")
        result = self.block(area.columns, area.rows, label)
        if self.style.product != "sums":
            contents = np.full((area.columns, area.rows), None, dtype=object)
            contents[0, 0] = Array(
                area.columns, area.rows, f"=TRANSPOSE({self.ref(area)})", self.style.product == "dynamic"
            )
        else:
            contents = [[f"={self.ref(area.part(c, r))}" for c in range(area.rows)] for r in range(area.columns)]
        return self.put(result, contents)

    def sampled(self, area, sampler):
        self.book.inputs.append((area.each(), sampler))
        return area

    def angles(self, values, labels=None, upright=None):
        """Cells of angles, sampled at random; in degrees unless the style has radians."""
        labels = labels or self.word("angles")
        if self.style.unit == "radians":
            contents = [float(np.round(np.radians(value), 10)) for value in values]
        elif self.style.unit == "alpha":
            contents = [f"=RADIANS({value})" for value in values]
        else:
            contents = list(values)
        if labels and self.style.unit == "radians":
            labels = [f"{label.removesuffix(' [°]')} [rad]" for label in labels]
        area = self.labelled(contents, labels, upright=self.style.upright if upright is None else upright)
        in_radians = self.style.unit in ("radians", "alpha")
        return self.sampled(
            area, lambda rng, n: (np.radians if in_radians else np.asarray)(rng.uniform(-170, 170, (3, n)))
        )

    def vector(self, values, kind, upright=None):
        area = self.labelled(
            list(values), self.word(kind), upright=self.style.upright if upright is None else upright
        )
        return self.sampled(area, lengths)

    def degrees_of(self, area, values):
        found = np.array([values[key] for key in area.each()])
        return np.degrees(found) if self.style.unit in ("radians", "alpha") else found


def lengths(rng, samples):
    return rng.uniform(-60, 60, (3, samples))


# Elementary matrices as sums of products of fragments: an entry is a list of (sign, factors).


def elementary_terms(axis, cosine, sine, passive):
    c, s, minus = [(1, (cosine,))], [(1, (sine,))], [(-1, (sine,))]
    up, down = (s, minus) if passive else (minus, s)
    zero, one = [], [(1, ())]
    return {
        "X": [[one, zero, zero], [zero, c, up], [zero, down, c]],
        "Y": [[c, zero, down], [zero, one, zero], [up, zero, c]],
        "Z": [[c, up, zero], [down, c, zero], [zero, zero, one]],
    }[axis.upper()]


def embed(terms, size):
    if size == 3:
        return terms
    return [[*row, []] for row in terms] + [[[], [], [], [(1, ())]]]


def multiply(a, b):
    return [
        [[(s * t, f + g) for k in range(len(b)) for s, f in a[r][k] for t, g in b[k][c]] for c in range(len(b[0]))]
        for r in range(len(a))
    ]


def text_of(terms):
    """An entry as the content of a cell: a number or a formula."""
    if not terms:
        return 0
    if terms == [(1, ())]:
        return 1
    return "=" + expression(terms)


def expression(terms):
    text = "".join(("+" if sign > 0 else "-") + ("*".join(factors) or "1") for sign, factors in terms)
    return text.removeprefix("+")


def texts(matrix):
    return [[text_of(entry) for entry in row] for row in matrix]


def rotation(sequence, degrees, passive):
    """The matrix of a reading, from SciPy; degrees of shape (3, n) → (n, 3, 3)."""
    matrices = Rotation.from_euler(sequence, np.asarray(degrees).T, degrees=True).as_matrix()
    return np.swapaxes(matrices, -1, -2) if passive else matrices


# The authors.


def chain(sequence, passive, recipe):
    """The order in which the elementary matrices are multiplied, and how they are made.

    Returns the numbers of the angles from left to right, whether the elements are passive, whether the angles are
    negated, and whether the product is transposed.
    """
    leftmost_last = (2, 1, 0)
    intrinsic = sequence.isupper()
    if recipe == "negated":  # method two of the source: negated angles, the other order, transposed
        return (0, 1, 2) if intrinsic == passive else leftmost_last, passive, True, True
    if recipe == "row":  # a row vector from the left: everything transposed
        return (0, 1, 2) if intrinsic == passive else leftmost_last, not passive, False, False
    if recipe == "transposed":  # the opposite rotation, transposed
        return leftmost_last if intrinsic != passive else (0, 1, 2), not passive, False, True
    return leftmost_last if intrinsic == passive else (0, 1, 2), passive, False, False


def write_texts(pen, sequence, passive, always=False):
    """Say what is calculated, if it is not the task of the source; in the sheet, or as the task."""
    book = pen.book
    usual = sequence == "ZXZ" and passive
    if usual and not always:
        if pen.rng.integers(2):
            pen.line(pen.word("title"))
        return
    if pen.style.language and pen.rng.integers(2):
        pen.line(pen.word("moving" if sequence.isupper() else "fixed", seq=sequence.upper()))
        pen.line(pen.word("passive" if passive else "active"))
    else:
        book.task = {"kind": "sequence", "sequence": sequence, "convention": "passive" if passive else "active"}


def source_numbers(rng):
    """The source's own angles and point, or random ones."""
    if rng.integers(2):
        return SOURCE_ANGLES, SOURCE_POINT
    return tuple(np.round(rng.uniform(-170, 170, 3), 4)), tuple(np.round(rng.uniform(-80, 80, 3), 3))


def draw_sequence(rng):
    """The source's reading in most sheets."""
    if rng.integers(3):
        return "ZXZ", True
    sequence = str(rng.choice(["ZXZ", "ZYZ", "ZYX", "XYZ", "YXZ", "ZXY", "zyx", "xyz", "zxz"]))
    return sequence, bool(rng.integers(2))


def matrix_sheet(rng):
    """Angles, elementary matrices, products, one point: the sheet of the source in its many forms."""
    pen = Pen(rng, draw_style(rng))
    sequence, passive = draw_sequence(rng)
    recipe = str(rng.choice(["plain", "plain", "negated", "transposed", "row"]))
    pen.book.family = f"matrices {recipe}"
    write_texts(pen, sequence, passive)
    angles, point = source_numbers(rng)
    one_calculation(pen, sequence, passive, recipe, angles, point, origin=rng.integers(4) == 0)
    if rng.integers(4) == 0:  # the task gives the numbers, too
        pen.book.task |= {"angles": tuple(map(float, angles)), "point": tuple(map(float, point))}
    return pen.book


def unnamed_reading(rng):
    """Another reading than the source's, which neither a text nor the task names."""
    pen = Pen(rng, draw_style(rng, language=None))
    pen.book.family = "unnamed reading"
    readings = [("ZXZ", False), ("ZYX", True), ("XYZ", False), ("zyx", False), ("ZYZ", True)]
    sequence, passive = readings[rng.integers(len(readings))]
    one_calculation(pen, sequence, passive, "plain", *source_numbers(rng))
    return pen.book


def two_tables(rng):
    """The same calculation twice: a second table below, or on a second sheet."""
    pen = Pen(rng, draw_style(rng, sheets=1, names=False))
    pen.book.family = "two tables"
    numbers = source_numbers(rng)
    one_calculation(pen, "ZXZ", True, "plain", *numbers)
    if rng.integers(2):
        pen.sheet = pen.sheets[1]
        pen.start()
    else:
        pen.new_band()
        pen.row += 2
    other = tuple(np.round(rng.uniform(-90, 90, 3), 2)), tuple(np.round(rng.uniform(-20, 20, 3), 2))
    recipe = str(rng.choice(["plain", "negated"]))
    one_calculation(pen, "ZXZ", True, recipe, *(other if recipe == "plain" else numbers))
    return pen.book


def one_calculation(pen, sequence, passive, recipe, angles, point, origin=False, steps=None):
    rng, style, book = pen.rng, pen.style, pen.book
    order, elements_passive, negate, transposed = chain(sequence, passive, recipe)
    given = pen.angles(angles)
    upright = recipe != "row"
    start = pen.vector(point, "point", upright=upright)
    centre = pen.vector(np.round(rng.uniform(-30, 30, 3), 2), "origin", upright=upright) if origin else None
    pen.turn_page()
    source = given
    if negate:
        rows, columns = given.rows, given.columns
        source = pen.block(rows, columns, pen.word("negated"))
        pen.put(source, [f"=-{pen.entry(given, n)}" for n in range(3)])
    pairs = pen.trigonometry(pen.radians(source))
    matrices = [pen.elementary(sequence[n].upper(), pairs[n], elements_passive, n + 1) for n in range(3)]
    if centre:
        relative = pen.block(start.rows, start.columns, pen.word("difference"))
        pen.put(relative, [f"={pen.entry(start, n)}-{pen.entry(centre, n)}" for n in range(3)])
    else:
        relative = start
    steps = rng.integers(4) == 0 if steps is None else steps
    if steps and upright and not transposed:
        for k, n in enumerate(reversed(order)):
            label = (pen.word("result") or [None])[0] if k == 2 else pen.word("step", n=k + 1)
            relative = pen.product(matrices[n], relative, label)
        result = relative
        total = None
    else:
        left, middle, right = (matrices[n] for n in order)
        if rng.integers(3):
            total = pen.product(
                pen.product(left, middle, pen.word("product", n=1)), right, pen.word("product", n=2)
            )
        else:
            total = pen.product(
                left, pen.product(middle, right, pen.word("product", n=1)), pen.word("product", n=2)
            )
        pen.turn_page()
        if transposed and rng.integers(3) == 0 and style.product in ("array", "dynamic"):
            result = pen.block(3, 1, (pen.word("result") or [None])[0])
            inverse = ("TRANSPOSE", "MINVERSE")[rng.integers(2)]
            formula = f"=MMULT({inverse}({pen.ref(total)}),{pen.ref(relative)})"
            book.cells[result.key()] = Array(3, 1, formula, style.product == "dynamic")
        else:
            total = pen.transpose(total) if transposed else total
            labels = pen.word("result")
            if not upright:
                result = pen.product(relative, total, labels[0] if labels else None)
            elif labels and rng.integers(2):
                column = pen.block(3, 2)
                pen.put(column.part(0, 0, 3, 1), labels)
                result = column.part(0, 1, 3, 1)
                pen.put(result, pen.product_formulas(result, total, relative, style.product))
            else:
                result = pen.product(total, relative, labels[0] if labels else None)

    def truth(values):
        p = np.array([values[key] for key in start.each()])
        if centre:
            p = p - [values[key] for key in centre.each()]
        return np.einsum("sij,js->is", rotation(sequence, pen.degrees_of(given, values), passive), p)

    book.truths.append((result.each(), truth))
    if rng.integers(3) == 0:
        checks(pen, total, relative, result, truth)


def checks(pen, total, start, result, truth):
    """Determinant, lengths, difference to expected values, its maximum, and a message."""
    book = pen.book
    before = set(book.cells)
    if total is not None:
        area = pen.labelled([f"=MDETERM({pen.ref(total)})"], label_list(pen.word("determinant")))
        book.truths.append((area.each(), lambda values: np.ones((1, SAMPLES))))
    lengths_before = pen.labelled([f"=SQRT(SUMSQ({pen.ref(start)}))"], label_list(pen.word("norm")))
    lengths_after = pen.labelled([f"=SQRT(SUMSQ({pen.ref(result)}))"], label_list(pen.word("norm")))
    book.truths.append(
        (
            lengths_before.each() + lengths_after.each(),
            lambda v: np.linalg.norm(truth(v), axis=0)[None] * [[1], [1]],
        )
    )
    if pen.rng.integers(2):
        numbers = truth(Values(book).all())[:, 0]
        expected = pen.block(3, 1, pen.word("expected"))
        pen.put(expected, [float(value) for value in np.round(numbers, 6)])
        difference = pen.block(3, 1, pen.word("difference"))
        pen.put(difference, [f"={pen.entry(result, n)}-{pen.entry(expected, n)}" for n in range(3)])
        formula = f"=MAX({pen.ref(difference)})"
        largest = pen.labelled([formula], label_list(pen.word("max")))
        if pen.style.language:
            pen.fill([[f'=IF(ABS({pen.ref(largest)})<0.001,"OK","?")']])
    book.extras |= set(book.cells) - before


def label_list(word):
    return [word] if word else None


def many_points(rng):
    """One rotation, many points, one in each row."""
    pen = Pen(rng, draw_style(rng, upright=True, sheets=int(rng.choice([1, 1, 2]))))
    sequence, passive = draw_sequence(rng)
    pen.book.family = "many points"
    write_texts(pen, sequence, passive)
    book, style = pen.book, pen.style
    angles, _ = source_numbers(rng)
    given = pen.angles(angles)
    order, elements_passive, _, _ = chain(sequence, passive, "plain")
    pairs = pen.trigonometry(pen.radians(given))
    matrices = [pen.elementary(sequence[n].upper(), pairs[n], elements_passive, n + 1) for n in range(3)]
    left, middle, right = (matrices[n] for n in order)
    total = pen.product(pen.product(left, middle, pen.word("product", n=1)), right, pen.word("product", n=2))
    pen.turn_page()
    pen.new_band()
    with_origin = rng.integers(4) == 0
    centre = pen.vector(np.round(rng.uniform(-30, 30, 3), 2), "origin", upright=False) if with_origin else None
    pen.new_band()
    rows = int(rng.integers(3, 13))
    table = pen.block(rows + 1, 6)
    labels, results = pen.word("point"), pen.word("result")
    if labels:
        pen.put(table.part(0, 0, 1, 3), labels)
        pen.put(table.part(0, 3, 1, 3), results)
    points, formulas = table.part(1, 0, rows, 3), table.part(1, 3, rows, 3)
    pen.put(points, np.round(rng.uniform(-80, 80, (rows, 3)), 2))
    form = str(rng.choice(["sums", "sums", "sumproduct", "row"]))
    for r in range(rows):
        p = points.part(r, 0, 1, 3)
        book.inputs.append((p.each(), lengths))
        cells = []
        for c in range(3):
            line = total.part(c, 0, 1, 3)
            if form == "sums":
                terms = []
                for k in range(3):
                    x = p.part(0, k).text(pen.sheet)
                    if centre:
                        x = f"({x}-{pen.ref(centre.part(0, k), fixed=True)})"
                    terms.append(f"{pen.ref(line.part(0, k), fixed=True)}*{x}")
                cells.append("=" + "+".join(terms))
            else:
                x = p.text(pen.sheet)
                if centre:
                    x = (
                        f"({x}-{pen.ref(centre, fixed=True)})"
                        if form == "row"
                        else f"{x}-{pen.ref(centre, fixed=True)}"
                    )
                cells.append(f"=SUMPRODUCT({x},{pen.ref(line, fixed=True)})")
        if form == "row":
            x = p.text(pen.sheet)
            if centre:
                x = f"{x}-{pen.ref(centre, fixed=True)}"
            formula = f"=MMULT({x},TRANSPOSE({pen.ref(total, fixed=True)}))"
            cells = [Array(1, 3, formula, style.product == "dynamic"), None, None]
        elif centre and form == "sumproduct":
            cells = [Array(1, 1, cell) for cell in cells]
        pen.put(formulas.part(r, 0, 1, 3), cells)

    def truth(values):
        p = np.array([[values[points.key(r, c)] for c in range(3)] for r in range(rows)])
        if centre:
            p = p - np.array([values[key] for key in centre.each()])
        matrix = rotation(sequence, pen.degrees_of(given, values), passive)
        return np.einsum("sij,rjs->ris", matrix, p).reshape(3 * rows, -1)

    book.truths.append((formulas.each(), truth))
    for c in range(1 if form == "row" else 3):
        book.columns.append([formulas.key(r, c) for r in range(rows)])
    return book


def rotations_in_rows(rng):
    """One rotation and one point in each row: cosines and sines in columns, the products written out."""
    pen = Pen(
        rng,
        draw_style(rng, upright=False, sheets=1, names=False, unit=str(rng.choice(["RADIANS", "PI", "radians"]))),
    )
    sequence, passive = draw_sequence(rng)
    book, style = pen.book, pen.style
    book.family = "rotations in rows"
    write_texts(pen, sequence, passive)
    rows = int(rng.integers(2, 8))
    with_matrix = bool(rng.integers(2))
    widths = (3, 3, 0 if style.inline else 6, 9 if with_matrix else 0, 3)
    table = pen.block(rows + 1, sum(widths))
    starts = np.cumsum((0, *widths))
    headings = [
        pen.word("angles"),
        pen.word("point"),
        ["cos1", "sin1", "cos2", "sin2", "cos3", "sin3"],
        [f"m{r}{c}" for r in (1, 2, 3) for c in (1, 2, 3)],
        pen.word("result"),
    ]
    if style.language:
        for width, start, heading in zip(widths, starts, headings, strict=False):
            if width:
                pen.put(table.part(0, start, 1, width), heading)
    order, elements_passive, _, _ = chain(sequence, passive, "plain")
    form = {"RADIANS": "RADIANS({})", "PI": "{}*PI()/180", "radians": "{}"}[style.unit]
    for r in range(1, rows + 1):
        angles, point = table.part(r, 0, 1, 3), table.part(r, 3, 1, 3)
        values = np.round(rng.uniform(-170, 170, 3), 2)
        if style.unit == "radians":
            pen.put(angles, np.round(np.radians(values), 6))
            book.inputs.append((angles.each(), lambda rng, n: rng.uniform(-3, 3, (3, n))))
        else:
            pen.put(angles, values)
            book.inputs.append((angles.each(), lambda rng, n: rng.uniform(-170, 170, (3, n))))
        pen.put(point, np.round(rng.uniform(-50, 50, 3), 2))
        book.inputs.append((point.each(), lengths))
        pairs = [[f"{f}({form.format(angles.part(0, n).text())})" for f in ("COS", "SIN")] for n in range(3)]
        if not style.inline:
            area = table.part(r, 6, 1, 6)
            pen.put(area, [f"={text}" for pair in pairs for text in pair])
            pairs = [[area.part(0, 2 * n + k).text() for k in range(2)] for n in range(3)]
        factors = [elementary_terms(sequence[n], *pairs[n], elements_passive) for n in order]
        product = multiply(multiply(factors[0], factors[1]), factors[2])
        if with_matrix:
            area = table.part(r, starts[3], 1, 9)
            pen.put(area, texts(product))
            product = [[[(1, (area.part(0, 3 * i + j).text(),))] for j in range(3)] for i in range(3)]
        column = [[[(1, (point.part(0, k).text(),))]] for k in range(3)]
        pen.put(table.part(r, starts[4], 1, 3), texts(multiply(product, column)))

    def truth(values):
        found = []
        for r in range(1, rows + 1):
            p = np.array([values[key] for key in table.part(r, 3, 1, 3).each()])
            matrix = rotation(sequence, pen.degrees_of(table.part(r, 0, 1, 3), values), passive)
            found.append(np.einsum("sij,js->is", matrix, p))
        return np.concatenate(found)

    book.truths.append(([key for r in range(1, rows + 1) for key in table.part(r, starts[4], 1, 3).each()], truth))
    for c in range(6, sum(widths)):
        if isinstance(book.cells.get(table.key(1, c)), str):
            book.columns.append([table.key(r, c) for r in range(1, rows + 1)])
    return book


def direct_elements(rng):
    """Nine elements written out, then the point, as a column or as a row from the left."""
    pen = Pen(rng, draw_style(rng, sheets=1))
    sequence, passive = draw_sequence(rng)
    book = pen.book
    write_texts(pen, sequence, passive)
    angles, point = source_numbers(rng)
    given = pen.angles(angles)
    as_row = bool(rng.integers(2))
    book.family = "direct elements, row vector" if as_row else "direct elements"
    start = pen.vector(point, "point", upright=not as_row)
    pairs = pen.trigonometry(pen.radians(given))
    order, elements_passive, _, _ = chain(sequence, passive, "plain")
    factors = [elementary_terms(sequence[n], *pairs[n], elements_passive) for n in order]
    product = multiply(multiply(factors[0], factors[1]), factors[2])
    if as_row:
        product = [list(column) for column in zip(*product, strict=True)]
    total = pen.fill(texts(product), pen.word("product", n=""))
    book.whole = total.each()
    labels = pen.word("result")
    result = (
        pen.product(start, total, labels[0] if labels else None)
        if as_row
        else pen.product(total, start, labels[0] if labels else None)
    )

    def truth(values):
        p = np.array([values[key] for key in start.each()])
        return np.einsum("sij,js->is", rotation(sequence, pen.degrees_of(given, values), passive), p)

    book.truths.append((result.each(), truth))
    if rng.integers(3) == 0:
        checks(pen, total, start, result, truth)
    return book


def four_by_four(rng):
    """A chain of 4×4 matrices: three rotations and the shift to the origin."""
    pen = Pen(rng, draw_style(rng, sheets=int(rng.choice([1, 2]))))
    sequence, passive = draw_sequence(rng)
    book = pen.book
    book.family = "4×4 chain"
    write_texts(pen, sequence, passive)
    angles, point = source_numbers(rng)
    given = pen.angles(angles)
    start = pen.labelled([*point, 1], [*pen.word("point"), None] if pen.style.language else None)
    book.inputs.append((start.each()[:3], lengths))
    centre = pen.vector(np.round(rng.uniform(-30, 30, 3), 2), "origin")
    pairs = pen.trigonometry(pen.radians(given))
    order, elements_passive, _, _ = chain(sequence, passive, "plain")
    matrices = [pen.elementary(sequence[n].upper(), pairs[n], elements_passive, n + 1, size=4) for n in range(3)]
    shift = [[int(r == c) for c in range(4)] for r in range(4)]
    pen.turn_page()
    for n in range(3):
        shift[n][3] = f"=-{pen.entry(centre, n)}"
    total = pen.fill(shift, pen.word("translation"))
    for k, n in enumerate(reversed(order)):
        total = pen.product(matrices[n], total, pen.word("product", n=k + 1))
    result = pen.product(total, start, (pen.word("result") or [None])[0])

    def truth(values):
        p = np.array([values[a] - values[b] for a, b in zip(start.each()[:3], centre.each(), strict=True)])
        turned = np.einsum("sij,js->is", rotation(sequence, pen.degrees_of(given, values), passive), p)
        return np.vstack([turned, np.ones((1, turned.shape[1]))])

    book.truths.append((result.each(), truth))
    return book


def quaternions(rng):
    """Half angles, a quaternion product, its matrix, the point."""
    pen = Pen(rng, draw_style(rng, sheets=1, unit=str(rng.choice(["RADIANS", "PI", "radians"])), names=False))
    sequence, passive = draw_sequence(rng)
    book, style = pen.book, pen.style
    book.family = "quaternions"
    write_texts(pen, sequence, passive)
    pen.line(
        {"en": "unit quaternion w x y z", "de": "Einheitsquaternion w x y z", "zh": "单位四元数 w x y z"}.get(
            style.language
        )
    )
    angles, point = source_numbers(rng)
    given = pen.angles(angles)
    start = pen.vector(point, "point", upright=True)
    halves = pen.radians(given)
    singles = []
    for n, axis in enumerate(sequence.upper()):
        contents = [f"=COS({halves[n]}/2)", 0, 0, 0]
        contents[1 + "XYZ".index(axis)] = f"=SIN({halves[n]}/2)"
        singles.append(pen.fill([contents], f"q{n + 1}" if style.language else None))
    order = singles if sequence.isupper() else singles[::-1]
    total = hamilton(pen, hamilton(pen, order[0], order[1]), order[2])
    w, x, y, z = (pen.entry(total, n) for n in range(4))
    rows = [
        [f"=1-2*({y}^2+{z}^2)", f"=2*({x}*{y}-{w}*{z})", f"=2*({x}*{z}+{w}*{y})"],
        [f"=2*({x}*{y}+{w}*{z})", f"=1-2*({x}^2+{z}^2)", f"=2*({y}*{z}-{w}*{x})"],
        [f"=2*({x}*{z}-{w}*{y})", f"=2*({y}*{z}+{w}*{x})", f"=1-2*({x}^2+{y}^2)"],
    ]
    if passive:
        rows = [list(column) for column in zip(*rows, strict=True)]
    matrix = pen.fill(rows, pen.word("product", n=""))
    book.whole = matrix.each()
    result = pen.product(matrix, start, (pen.word("result") or [None])[0])

    def truth(values):
        p = np.array([values[key] for key in start.each()])
        return np.einsum("sij,js->is", rotation(sequence, pen.degrees_of(given, values), passive), p)

    book.truths.append((result.each(), truth))
    return book


def hamilton(pen, p, q):
    (a, b, c, d), (e, f, g, h) = ([pen.entry(area, n) for n in range(4)] for area in (p, q))
    return pen.fill(
        [
            [
                f"={a}*{e}-{b}*{f}-{c}*{g}-{d}*{h}",
                f"={a}*{f}+{b}*{e}+{c}*{h}-{d}*{g}",
                f"={a}*{g}-{b}*{h}+{c}*{e}+{d}*{f}",
                f"={a}*{h}+{b}*{g}-{c}*{f}+{d}*{e}",
            ]
        ]
    )


def unit_vectors(rng, samples):
    vectors = rng.normal(size=(3, samples))
    return vectors / np.linalg.norm(vectors, axis=0)


def axis_angle(rng):
    """The matrix of Rodrigues about an axis that is normalised first, and the point turned by it."""
    pen = Pen(rng, draw_style(rng, sheets=1, unit="RADIANS", names=False))
    book, style = pen.book, pen.style
    book.family = "axis and angle"
    pen.line(
        {
            "en": "Active rotation of a point about an axis by an angle (Rodrigues)",
            "de": "Aktive Drehung eines Punktes um eine Achse (Rodrigues)",
            "zh": "点绕任意轴旋转（罗德里格斯公式，主动旋转）",
        }.get(style.language, "Rodrigues: active rotation about an axis")
    )
    labels = ("ux", "uy", "uz") if style.language else None
    axis = pen.sampled(pen.labelled([1.0, -2.0, 2.0], labels), lambda rng, n: rng.uniform(0.5, 3, (3, n)))
    angle = pen.labelled(
        [40], ["angle" if style.language == "en" else "Winkel" if style.language == "de" else "角度"]
    )
    book.inputs.append((angle.each(), lambda rng, n: rng.uniform(-170, 170, (1, n))))
    start = pen.vector((3, 4, 5), "point", upright=True)
    length = pen.labelled([f"=SQRT(SUMSQ({pen.ref(axis)}))"], label_list(pen.word("norm")))
    unit = pen.fill(
        [[f"={pen.entry(axis, n)}/{pen.ref(length)}"] for n in range(3)], "u" if style.language else None
    )
    c, s = f"COS(RADIANS({pen.ref(angle)}))", f"SIN(RADIANS({pen.ref(angle)}))"
    if not style.inline:
        area = pen.labelled([f"={c}", f"={s}"], ["cos", "sin"] if style.language else None)
        c, s = pen.entry(area, 0), pen.entry(area, 1)
    u = [pen.entry(unit, n) for n in range(3)]
    rows = [[None] * 3 for _ in range(3)]
    for i in range(3):
        for j in range(3):
            k, sign = 3 - i - j, "-" if (j - i) % 3 == 1 else "+"
            rows[i][j] = f"={c}+{u[i]}^2*(1-{c})" if i == j else f"={u[i]}*{u[j]}*(1-{c}){sign}{u[k]}*{s}"
    matrix = pen.fill(rows, pen.word("product", n=""))
    book.whole = matrix.each()
    result = pen.product(matrix, start, (pen.word("result") or [None])[0])

    def truth(values):
        vector = np.array([values[key] for key in axis.each()])
        vector = vector / np.linalg.norm(vector, axis=0) * np.radians(values[angle.key()])
        p = np.array([values[key] for key in start.each()])
        return Rotation.from_rotvec(vector.T).apply(p.T).T

    book.truths.append((result.each(), truth))
    return book


def verify(book, values=None):
    """Raise AssertionError unless the sheet gives what SciPy gives, at random inputs."""
    found = (values or Values(book)).all()
    for keys, truth in book.truths:
        np.testing.assert_allclose([found[key] for key in keys], truth(found), atol=1e-8, err_msg=book.family)


def source_sheet(recipe=1):
    """The sheet of source 000 at its own angles: cosines and sines, elements that refer to them, sums."""
    rng = np.random.default_rng(0)
    style = Style("zh", False, True, "sums", "RADIANS", False, False, False, 1, True)
    pen = Pen(rng, style)
    pen.book.family = "source 000"
    one_calculation(pen, "ZXZ", True, {1: "plain", 2: "negated"}[recipe], SOURCE_ANGLES, SOURCE_POINT, steps=False)
    return pen.book

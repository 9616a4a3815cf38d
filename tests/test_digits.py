"""Numbers in and out of text in bulk: the same as `float` and ``%`` one by one, to the last bit and character."""

import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mathpost import digits

NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)", re.ASCII)


@pytest.fixture(autouse=True)
def every_shape(monkeypatch):
    monkeypatch.setattr(digits, "LEAST_LINES", 1)


def bits(values):
    """Floats as integers, which tell 0.0 from -0.0 and any two neighbours apart."""
    return np.asarray(values, dtype=float).view(np.int64).tolist()


def read(tokens):
    """For each token, what is read in bulk: a float, or None if it is left to others."""
    found = [None] * len(tokens)
    lines = digits.Lines("".join(f"X{token};\n" for token in tokens).encode())
    for table in lines.tables():
        if re.fullmatch(f"X{digits.NUMBER};", table.shape):
            values, plain = table.numbers([(1, len(table.shape) - 1)])
            for line in np.flatnonzero(plain).tolist():
                found[table.lines[line]] = float(values[0, line])
    return found


numbers = st.one_of(
    st.floats(-1e6, 1e6).map(lambda value: f"{value:.6f}"),
    st.tuples(st.integers(-(10**8), 10**8), st.integers(0, 17)).map(lambda pair: f"{pair[0] / 7:+.{pair[1]}f}"),
    st.from_regex(r"[-+]?([0-9]{1,10}\.?[0-9]{0,18}|\.[0-9]{1,18})", fullmatch=True),
    st.sampled_from(
        ["-0", "+0.0", "-.0", "00000001.50", "9007199254740993", "90071992.54740993", "12345678.12345678"]
    ),
)
tokens = st.one_of(
    numbers, st.text("0123456789+-.eE _,:/;", max_size=12), st.sampled_from(["-", ".", "-.", "+-1", "1-"])
)


@settings(max_examples=300, deadline=None)
@given(st.lists(tokens, min_size=1, max_size=40))
@example(["-", ".", "-.", "+.", "1.-", "1-.5", "--1", "1..5", ".5", "5.", "-5", "+.5", ""])
def test_what_is_read_is_what_float_reads(texts):
    for text, value in zip(texts, read(texts), strict=True):
        if value is not None:
            assert NUMBER.fullmatch(text) and bits(value) == bits(float(text))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.floats(-9e6, 9e6), st.integers(1, 9)), min_size=1, max_size=40))
def test_ordinary_numbers_are_all_read(pairs):
    """Up to six digits before the point and nine behind it, whatever stands in the other lines."""
    texts = [f"{value / (1 if places < 9 else 10):.{places}f}" for value, places in pairs]
    assert [bits(value) for value in read(texts)] == [bits(float(text)) for text in texts]


def test_lines_of_many_shapes(monkeypatch):
    texts = [b"X1\n", b"Y\xff-1.5\n", b"\n", b"X\xfe2\n", b"X-20\n", b"- 1\n"]
    lines = digits.Lines(b"".join(texts))
    assert [lines[n] for n in range(len(lines))] == texts
    shapes = {table.shape: table.lines.tolist() for table in lines.tables()}
    assert shapes == {"X0": [0, 4], "Y\x7f0.0": [1], "": [2], "X\x7f0": [3], "0 0": [5]}
    monkeypatch.setattr(digits, "LEAST_LINES", 2)
    assert [table.shape for table in lines.tables()] == ["X0"]


@pytest.mark.parametrize(("run", "plain"), [("12", True), ("12345678", True), ("123456789", False), ("-1", False)])
def test_runs_without_a_sign(run, plain):
    [table] = digits.Lines(f"N{run} X\n".encode()).tables()
    assert table.unsigned(1, 2).tolist() == [plain]


def test_as_many_shapes_as_lines():
    """Lines of one size but of all shapes, those of two kinds mixed, and far more marks than any shape has."""
    kinds = ["X0Y0", "Y0X0", "0X0Y", "XY00", "X:0Y"]
    order = np.random.default_rng(1).integers(len(kinds), size=500)
    lines = digits.Lines("".join(f"{kinds[kind]}\n{':' * 100}\n" for kind in order).encode())
    found = {table.shape: table.lines.tolist() for table in lines.tables()}
    shapes = {kind: re.sub("0+", "0", kinds[kind]) for kind in range(len(kinds))}
    assert found == {shape: (2 * np.flatnonzero(order == kind)).tolist() for kind, shape in shapes.items()}


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.one_of(
            st.floats(allow_nan=False, allow_infinity=False),
            st.floats(-1e5, 1e5),
            st.integers(-(10**9), 10**9).map(lambda n: n / 10000),
            st.integers(-(10**7), 10**7).map(lambda n: n / 32),  # ties of three and four decimals
            st.sampled_from([0.0, -0.0, 0.00005, -0.00005, 999.99995, -999.9996, 1e8, 99999999.99995]),
        ),
        min_size=1,
        max_size=30,
    ),
    st.integers(1, 4),
    st.sampled_from(["", "+"]),
    st.sampled_from(["", "X", " X", " C1=", " QUILL="]),
)
def test_what_is_written_is_what_formatting_writes(values, decimals, plus, before):
    expected = "".join(f"{before}%{plus}.{decimals}f" % value for value in values)
    for least in (1, 10**9):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(digits, "LEAST_ROWS", least)
            columns = digits.fixed(np.array(values), decimals, before=before, plus=plus)
            assert digits.text(columns) == expected


@settings(max_examples=100, deadline=None)
@given(st.lists(st.integers(0, 10**12) | st.integers(0, 10**5), min_size=1, max_size=30))
@example([0, 9, 10, 999, 1000, 1001, 9999, 10000, 10**7 - 1, 10**7, 10**7 + 5, 10**11])
def test_integers(values):
    assert digits.text(digits.integers(np.array(values))) == "".join(map(str, values))


def test_cells():
    assert digits.text(digits.cells(["G1", "", " G93 G1"])) == "G1 G93 G1"


def test_shapes_that_mix_to_the_same_are_not_confused(monkeypatch):
    monkeypatch.setattr(digits, "MIX", np.zeros_like(digits.MIX))
    assert list(digits.Lines(b"X1\nY1\nX2\n").tables()) == []

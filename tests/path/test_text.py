"""Numbers in and out of text in bulk: the same as `float` and ``%`` one by one, to the last bit and character."""

import logging
import re
import sys
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mathpost.errors import InputError
from mathpost.formula import compiled
from mathpost.path import text
from mathpost.path.text import Column, Item, Pattern
from tests.conftest import machine_code
from tests.test_startup import loaded_after

NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)", re.ASCII)


def bits(values):
    """Floats as integers, which tell 0.0 from -0.0 and any two neighbours apart."""
    return np.asarray(values, dtype=float).view(np.int64).tolist()


def match(pattern, lines):
    """For each line, the numbers that are read, or None if it is left to others: by machine code as by Python."""
    found = []
    for used in (True, False):
        with machine_code(used):
            values, plain = pattern.match("".join(f"{line}\n" for line in lines).encode())
        found.append([row if good else None for row, good in zip(values.T.tolist(), plain.tolist(), strict=True)])
    assert repr(found[0]) == repr(found[1])
    return found[0]


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
@example(["-", ".", "-.", "+.", "1.-", "1-.5", "--1", "1..5", ".5", "5.", "-5", "+.5", "", "9" * 18, "9" * 400])
def test_what_is_read_is_what_float_reads(texts):
    found = match(Pattern([Item("X", "number"), Item(";")]), [f"X{shown};" for shown in texts])
    for shown, row in zip(texts, found, strict=True):
        if row is not None:
            assert NUMBER.fullmatch(shown) and bits(row) == bits([float(shown), 0])


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.floats(-9e6, 9e6), st.integers(1, 9)), min_size=1, max_size=40))
def test_ordinary_numbers_are_all_read(pairs):
    """Up to six digits before the point and nine behind it."""
    texts = [f"{value / (1 if places < 9 else 10):.{places}f}" for value, places in pairs]
    found = match(Pattern([Item("", "number")]), texts)
    assert [bits(row) for row in found] == [bits([float(text)]) for text in texts]


CASES = [
    ("X1", [1, np.nan, np.nan]),
    ("X1 Y-2.5", [1, -2.5, np.nan]),
    ("X1 MAX", [1, np.nan, 0]),
    ("X1 Y2 MAX\r", [1, 2, 0]),
    ("X1 MAX Y2", None),
    ("X1 Y", None),
    ("X1 Y2 ", None),
    ("X1  Y2", None),
    ("x1", None),
    ("X-1", None),
    ("X1.0", None),
    ("X1 Y2 MAXX", None),
    ("X1\r\r", None),
    ("", None),
    ("X1 Yé", None),
]


@pytest.mark.parametrize(("line", "expected"), CASES)
def test_items_come_in_their_order_and_fill_the_line(line, expected):
    pattern = Pattern([Item("X", "count"), Item(" Y", "number", optional=True), Item(" MAX", optional=True)])
    for lines in ([line], ["X7", line, "X8 Y9"]):
        found = match(pattern, lines)[len(lines) // 2]
        assert found is None if expected is None else bits(found) == bits(expected)


@pytest.mark.parametrize(
    ("line", "good"),
    [
        ("GOTO/1,2", 1),
        ("GOTO  / 1 , 2  \r", 1),
        ("goto/1,2", 0),
        (" GOTO/1,2", 0),
        ("GOTO/1,2,", 0),
        ("GO TO/1,2", 0),
        ("GOTO1,2", 0),
    ],
)
def test_a_pattern_may_take_blanks(line, good):
    pattern = Pattern([Item("GOTO"), Item("/", "number"), Item(",", "number")], blanks=True)
    assert match(pattern, [line]) == ([[0, 1, 2]] if good else [None])


values = st.one_of(
    st.floats(-1e10, 1e10),
    st.floats(-1e5, 1e5),
    st.integers(-(10**9), 10**9).map(lambda n: n / 10000),
    st.sampled_from([0.0, -0.0, 0.0001, -0.0001, 999.9999, -999.9996, 1e8, 99999999.9999, 99999999999.9999]),
)


@settings(max_examples=500, deadline=None)
@given(
    st.lists(st.tuples(values, st.booleans(), st.integers(0, 10**12)), min_size=1, max_size=30),
    st.integers(0, 4),
    st.sampled_from(["", "+"]),
    st.sampled_from(["", "X", " C1=", " QUILL="]),
)
def test_what_is_written_is_what_formatting_writes(rows, decimals, plus, literal):
    rows = [(round(value, decimals), *others) for value, *others in rows]
    numbers, shown, counts = map(np.array, zip(*rows, strict=True))
    columns = [Column("N", counts), Column(literal, numbers, decimals, plus, shown), Column(";\n")]
    form = f"{{:{plus}z.{decimals}f}}"  # a zero has no sign but that
    expected = [f"N{count}{literal + form.format(value) if there else ''};\n" for value, there, count in rows]
    for used in (True, False):
        with machine_code(used):
            assert "".join(text.lines(columns, 0, len(rows))) == "".join(expected)
            assert "".join(text.lines(columns, 1, len(rows[:3]))) == "".join(expected[1:3])


@pytest.mark.parametrize("value", [1e11, -1e300, np.inf, np.nan])
def test_a_number_too_large_to_write_is_refused(value):
    for used in (True, False):
        with machine_code(used), pytest.raises(InputError, match="last digits"):
            "".join(text.lines([Column("X", np.array([1.0, value]), 4), Column("\n")], 0, 2))


def test_machine_code_is_made_even_if_there_is_no_folder_to_keep_it_in(monkeypatch):
    made = []

    def njit(*, cache=False, **options):
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return lambda function: made.append(function.__name__) or function

    monkeypatch.setattr(numba, "njit", njit)
    monkeypatch.setattr(text, "compiled", compiled.__wrapped__)
    text._compiled.__wrapped__()
    assert made == ["_match", "_write"]


def test_without_numba_the_loops_are_plain_python(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.setattr(text, "compiled", compiled.__wrapped__)
    assert text._compiled.__wrapped__() == (text._match, text._write)


def test_only_large_texts_and_long_paths_load_the_compiler():
    small = "from mathpost import load_machine, postprocess, read_cl; from mathpost.path import text\n"
    small += "postprocess(read_cl('data/cl/blade.cl'), load_machine('dmu50v'))"
    large = f"{small}; text.Pattern([text.Item('X')]).match(b'X\\n' * text.WORTH)"
    assert not loaded_after(small) & {"numba"} and loaded_after(large) >= {"numba"}


@pytest.mark.parametrize("kept", [False, True])
def test_what_is_compiled_is_said_unless_it_was_kept(monkeypatch, caplog, tmp_path, kept):
    numba = pytest.importorskip("numba")

    def loop():
        """Nothing."""

    made = SimpleNamespace(stats=SimpleNamespace(cache_path=str(tmp_path)))
    monkeypatch.setattr(numba, "njit", lambda **options: lambda loop: made)
    if kept:
        (tmp_path / f"test_text.{loop.__qualname__}-1.py311.nbi").touch()
    with caplog.at_level(logging.INFO, "mathpost"):
        assert compiled.__wrapped__(loop) is made
    assert caplog.messages == ([] if kept else ["compiling loop, once"])

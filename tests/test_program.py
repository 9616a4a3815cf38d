"""Programs written and read back, in every dialect; wrong words and mutated programs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mathpost import machine, program
from mathpost.errors import InputError
from tests.conftest import DATA
from tests.test_cldata import mutations

DMU = machine.load(DATA / "machines/dmu50v.toml")
DIALECTS = list(program.DIALECTS)


def blocks(count=12, *, tcp=False, seed=1):
    """A program with every kind of move: feed, rapid, inverse time, words that repeat."""
    rng = np.random.default_rng(seed)
    words = np.round(
        np.cumsum(rng.normal(size=(count, 5)) * (rng.random((count, 5)) < 0.6), axis=0) * 20
        + np.arange(count)[:, None] / 8,
        4,
    )
    feeds = np.where(np.arange(count) < 6, 500.0, 1234.5)
    rapid = np.isin(np.arange(count), [0, 7])
    inverse = np.isin(np.arange(count), [3, 4, 8]) & (not tcp)
    seconds = np.where(inverse, 2.5, np.nan)
    return program.Blocks(
        words,
        np.where(rapid | inverse, np.nan, feeds),
        np.where(rapid, np.nan, seconds),
        rapid,
        tcp,
        ((0, "SPINDL/3000 (CLW)"), (5, "COOLNT/ON"), (count, "FINI")),
    )


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_read_of_write(dialect, tcp):
    written = blocks(tcp=tcp)
    text = program.write(written, DMU, dialect, name="twisted blade")
    back = program.read(text, DMU, dialect)
    np.testing.assert_array_equal(back.words, written.words)
    np.testing.assert_array_equal(back.rapid, written.rapid)
    np.testing.assert_allclose(back.feeds, written.feeds)
    np.testing.assert_allclose(back.seconds, written.seconds, rtol=1e-4)
    assert back.tcp == tcp
    for remark in ("SPINDL/3000", "COOLNT/ON", "FINI"):
        assert remark in text
    np.testing.assert_allclose(np.degrees(back.joints[:, 3:]), written.words[:, 3:])


FIRST = "X1 Y2 Z3 B4 C5 "
TEXTS = {
    "heidenhain": """0 BEGIN PGM A MM
1 L X+1 Y+2 Z+3 B+4 C+5 FMAX
2 L X+2 F500
3 L C-7.5 FT0.25
4 END PGM A MM
""",
    "fanuc": """%
O0001 (A)
N10 G21 G17 G40 G90 G94
N20 G0 X1. Y2. Z3. B4. C5.
N30 G1 X2. F500
N40 G93 C-7.5 F240.
N50 M30
%
""",
    "siemens": """; A
N10 G710 G17 G40 G90 G94
N20 G0 X1 Y2 Z3 B4 C5
N30 G1 X2 F500
N40 G93 C=-7.5 F240
N50 M30
""",
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_programs_written_by_hand(dialect):
    read = program.read(TEXTS[dialect], DMU, dialect)
    np.testing.assert_array_equal(read.words, [[1, 2, 3, 4, 5], [2, 2, 3, 4, 5], [2, 2, 3, 4, -7.5]])
    assert read.rapid.tolist() == [True, False, False]
    np.testing.assert_array_equal(read.feeds, [np.nan, 500, np.nan])
    np.testing.assert_array_equal(read.seconds, [np.nan, np.nan, 0.25])


def test_modal_words_are_left_out():
    text = program.write(blocks(), DMU, "fanuc")
    moves = [line for line in text.splitlines() if " X" in line]
    assert sum("F500" in line for line in moves) == 2  # once, and again after inverse time
    assert sum("G1 " in line for line in moves) == 2  # at the beginning, and after the rapid move


def test_numbered_axis_names_take_an_equals_sign():
    rotary = replace(DMU.rotary[1], name="C1")
    siemens = replace(DMU, rotary=(DMU.rotary[0], rotary))
    text = program.write(blocks(), siemens, "siemens")
    assert "C1=" in text
    np.testing.assert_array_equal(program.read(text, siemens, "siemens").words, blocks().words)
    with pytest.raises(InputError, match="'C1'"):
        program.write(blocks(), siemens, "heidenhain")


@pytest.mark.parametrize(
    ("dialect", "line", "words"),
    [
        ("heidenhain", "L X+1 Y+2 Z+3 B+4 C+5 Q10", "'Q10'"),
        ("heidenhain", "L IX+1 Y+2 Z+3 B+4 C+5", "'IX+1'"),
        ("heidenhain", "CC X+1 Y+2", "'CC'"),
        ("heidenhain", "L X+1 X+2 Y+2 Z+3 B+4 C+5", "one X word"),
        ("heidenhain", "L X+1 Y+2 Z+3 B+4", "a C word"),
        ("heidenhain", "L X+1 Y+2 Z+3 B+4 C+5 F", "feed above 0"),
        ("heidenhain", "L X+1 Y+2 Z+3 B+4 C+5 F-5", "feed above 0"),
        ("fanuc", "G2 X1 Y2 Z3 B4 C5", "'G2'"),
        ("fanuc", "G20 X1 Y2 Z3 B4 C5", "'G20'"),
        ("fanuc", "G91 X1 Y2 Z3 B4 C5", "'G91'"),
        ("fanuc", "G17X1.2.3", "'.3'"),
        ("fanuc", "G93 X1 Y2 Z3 B4 C5", "an F word"),
        ("fanuc", "X1 Y2 Z3 B4 C5 FT1", "feed above 0"),
        ("siemens", "G64 X1 Y2 Z3 B4 C5", "'G64'"),
        ("siemens", "X=AC(1) Y2 Z3 B4 C5", "'X=AC(1)'"),
        ("siemens", "X1 Y2 Z3 B4 A5", "'A5'"),
    ],
)
def test_unknown_words_are_refused_with_their_line(dialect, line, words):
    with pytest.raises(InputError) as caught:
        program.read(f"\n{line}\n", DMU, dialect, name="part.nc")
    assert str(caught.value).startswith("part.nc, line 2: expected")
    assert words in str(caught.value)


def test_empty_and_mixed_programs():
    with pytest.raises(InputError, match="at least one move"):
        program.read("0 BEGIN PGM A MM\n1 END PGM A MM\n", DMU)
    with pytest.raises(InputError, match="line 3.*TCP"):
        program.read(f"G1 {FIRST}\nG43.4 H1\nX2\n", DMU, "fanuc")
    with pytest.raises(InputError, match="dialect"):
        program.read("", DMU, "mazak")


@pytest.mark.parametrize("dialect", DIALECTS)
@settings(max_examples=300, deadline=None)
@given(data=st.data())
def test_mutated_programs_are_read_or_refused(dialect, data):
    try:
        read = program.read(data.draw(mutations(TEXTS[dialect])), DMU, dialect)
    except InputError:
        return
    assert np.isfinite(read.words).all() and read.words.shape[1] == 5


@pytest.mark.parametrize("dialect", DIALECTS)
@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), tcp=st.booleans())
def test_read_of_write_on_random_programs(dialect, seed, tcp):
    written = blocks(20, tcp=tcp, seed=seed)
    back = program.read(program.write(written, DMU, dialect), DMU, dialect)
    np.testing.assert_array_equal(back.words, written.words)


@pytest.mark.parametrize("dialect", DIALECTS)
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_moves_read_together_are_read_as_one_by_one(dialect, data):
    """The same blocks or the same refusal, whatever stands in the text."""
    written = blocks(40, seed=data.draw(st.integers(0, 99)))
    text = data.draw(mutations(program.write(written, DMU, dialect)))
    outcomes = []
    for least in (1, 10**9):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(program, "LEAST_PLAIN", least)
            try:
                read = program.read(text, DMU, dialect)
                outcomes.append([getattr(read, name).tolist() for name in ("words", "feeds", "seconds", "rapid")])
            except InputError as error:
                outcomes.append(str(error))
    assert repr(outcomes[0]) == repr(outcomes[1])

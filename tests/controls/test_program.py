"""Programs written and read back, in every dialect; wrong words and mutated programs."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mathpost import load_machine
from mathpost.errors import InputError
from mathpost.path import text as bulk
from mathpost.path.modal import Command
from mathpost.shop.controls import reader, writer
from mathpost.shop.controls.blocks import Blocks
from tests.conftest import DATA, machine_code
from tests.path.test_cl import mutations

DMU = load_machine(DATA / "machines/dmu50v.toml")
DIALECTS = ["heidenhain", "fanuc", "siemens"]
FIELDS = ("words", "feeds", "seconds", "rapid")


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
    return Blocks(
        words,
        np.where(rapid | inverse, np.nan, feeds),
        np.where(rapid, np.nan, seconds),
        rapid,
        tcp,
        ((0, "SPINDL/3000 (CLW)"), (5, "COOLNT/ON"), (count, "FINI")),
    )


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
    read = reader.read(TEXTS[dialect], DMU, dialect)
    np.testing.assert_array_equal(read.words, [[1, 2, 3, 4, 5], [2, 2, 3, 4, 5], [2, 2, 3, 4, -7.5]])
    assert read.rapid.tolist() == [True, False, False]
    np.testing.assert_array_equal(read.feeds, [np.nan, 500, np.nan])
    np.testing.assert_array_equal(read.seconds, [np.nan, np.nan, 0.25])


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_program_without_head_and_foot_says_so_before_its_first_move(dialect):
    def before(machine):
        lines = writer.write(blocks(), machine, dialect).splitlines()
        return "\n".join(lines[: next(row for row, line in enumerate(lines) if " X" in line)])

    assert "MOTION ONLY" in before(DMU)
    assert "MOTION ONLY" not in before(replace(DMU, program_foot=("M9",)))
    assert "MOTION ONLY" not in before(replace(DMU, program_head=("M8",)))


def test_modal_words_are_left_out():
    text = writer.write(blocks(), DMU, "fanuc")
    moves = [line for line in text.splitlines() if " X" in line]
    assert sum("F500" in line for line in moves) == 2  # once, and again after inverse time
    assert sum("G1 " in line for line in moves) == 2  # at the beginning, and after the rapid move


def test_numbered_axis_names_take_an_equals_sign():
    rotary = replace(DMU.rotary[1], name="C1")
    siemens = replace(DMU, rotary=(DMU.rotary[0], rotary))
    text = writer.write(blocks(), siemens, "siemens")
    assert "C1=" in text
    np.testing.assert_array_equal(reader.read(text, siemens, "siemens").words, blocks().words)
    with pytest.raises(InputError, match="'C1'"):
        writer.write(blocks(), siemens, "heidenhain")


@pytest.mark.parametrize(
    ("dialect", "line", "words"),
    [
        ("heidenhain", "L X+1 Y+2 Z+3 B+4 C+5 Q10", "'Q10'"),
        (
            "heidenhain",
            "L IX+1 Y+2 Z+3 B+4 C+5",
            "an X word before or in the first move, or --start X0",
        ),
        ("heidenhain", "LP PR+1 PA+30", "'LP'"),
        ("heidenhain", "CALL LBL 1 REP 3", "from line to line"),
        ("heidenhain", "C X+1 Y+2", "the sense of the arc"),
        ("heidenhain", "L X+1 X+2 Y+2 Z+3 B+4 C+5", "one X word"),
        ("heidenhain", "L X+1 Y+2 Z+3 B+4", "a C word"),
        ("heidenhain", "L X+1 Y+2 Z+3 B+4 C+5 F", "feed above 0"),
        ("heidenhain", "L X+1 Y+2 Z+3 B+4 C+5 F-5", "feed above 0"),
        ("fanuc", "G2 X1 Y2 Z3 B4 C5", "X, Y and Z before an arc"),
        ("fanuc", "G91 X1 Y2 Z3 B4 C5", "words of X"),
        ("fanuc", "#1=SIN[5]", "an expression of numbers"),
        ("fanuc", "G10 L2 P1 X0", "'G10'"),
        ("fanuc", "X1 Y2 Z3 A4", "'A4'"),
        ("fanuc", "G53.1", "a tilted plane before it"),
        ("fanuc", "G17X1.2.3", "'.3'"),
        ("fanuc", "G93 X1 Y2 Z3 B4 C5", "an F word"),
        ("fanuc", "X1 Y2 Z3 B4 C5 FT1", "feed above 0"),
        ("siemens", "G63 X1 Y2 Z3 B4 C5", "'G63'"),
        ("siemens", "X=R1 Y2 Z3 B4 C5", "'X=R1'"),
        ("siemens", "A=AC(1) Y2 Z3 B4 C5", "one of the axes"),
        ("siemens", "X1 Y2 Z3 B4 A5", "'A5'"),
    ],
)
def test_unknown_words_are_refused_with_their_line(dialect, line, words):
    with pytest.raises(InputError) as caught:
        reader.read(f"\n{line}\n", DMU, dialect, name="part.nc")
    assert str(caught.value).startswith("part.nc, line 2: expected")
    assert words in str(caught.value)


def test_empty_and_mixed_programs():
    with pytest.raises(InputError, match="at least one move"):
        reader.read("0 BEGIN PGM A MM\n1 END PGM A MM\n", DMU)
    with pytest.raises(InputError, match="dialect"):
        reader.read("", DMU, "mazatrol")


@pytest.mark.parametrize("dialect", DIALECTS)
@settings(max_examples=300, deadline=None)
@given(data=st.data())
def test_mutated_programs_are_read_or_refused(dialect, data):
    try:
        read = reader.read(data.draw(mutations(TEXTS[dialect])), DMU, dialect)
    except InputError:
        return
    assert np.isfinite(read.words).all() and read.words.shape[1] == 5


def said(blocks):
    """All that blocks say, in which 0.0 and -0.0 differ."""
    return repr([getattr(blocks, name).tolist() for name in FIELDS] + [blocks.tcp.tolist()])


@pytest.mark.parametrize("dialect", DIALECTS)
@settings(max_examples=200, deadline=None)
@given(data=st.data())
def test_moves_read_together_are_read_as_one_by_one(dialect, data):
    """The same blocks or the same refusal, whatever stands in the text and wherever it is cut into blocks."""
    written = blocks(40, seed=data.draw(st.integers(0, 99)), tcp=data.draw(st.booleans()))
    text = writer.write(written, DMU, dialect)
    if data.draw(st.booleans()):
        text = text.replace("\n", "\r\n")
    text = data.draw(mutations(text))
    assert_the_same_however_read(text, dialect)


def assert_the_same_however_read(text, dialect):
    outcomes = set()
    for used, block in ((True, 2**17), (False, 2**17), (True, 400)):
        with machine_code(used) as patch:
            patch.setattr(bulk, "BLOCK", block)
            try:
                outcomes.add(said(reader.read(text, DMU, dialect)))
            except InputError as error:
                outcomes.add(str(error))
    assert len(outcomes) == 1


@pytest.mark.parametrize("dialect", DIALECTS)
def test_ordinary_moves_are_read_together(dialect, monkeypatch):
    """None of them is left to the way line by line, once all axes are known."""
    taken, one = [], reader.ProgramReader
    take = one.take_line
    monkeypatch.setattr(one, "take_line", lambda self, line: taken.append(line) or take(self, line))
    count = 200
    words = np.arange(5 * count).reshape(count, 5) / 8 - [[12.5, -200, 0, 3600, 0]]
    seconds = np.where(np.arange(count) < count // 2, 0.123, np.nan)
    text = writer.write(Blocks(words, np.full(count, 500.0), seconds, np.zeros(count, bool)), DMU, dialect)
    with machine_code(True):
        assert len(reader.read(text, DMU, dialect).words) == count and len(taken) < 10


WITHIN = {
    "heidenhain": ["-1 L X+9", "+1 L X+9", "1 L X+9 F0", "1 L X+9 F-5", "1 L X+9 FT0", "1 M128", "1 L X+9 FMAX",
                   "1 L F80"],
    "fanuc": ["N-1 X9", "X9", "N1 X9 F0", "N1 G93", "G93 F2", "N1 G0", "N1 G0 G93", "N1 G43.4 H1", "N1 X9 F-1",
              "(X9)", "N1 F80"],
    "siemens": ["N+1 X9", "N1 G93 X9 F1", "N1 G0", "TRAORI", "N1 X9 F.0", "; X9", "N1 C7=9", "N1 F80"],
}  # fmt: skip


@pytest.mark.parametrize(("dialect", "line"), [(dialect, line) for dialect in WITHIN for line in WITHIN[dialect]])
@pytest.mark.parametrize("feed", ["", " F500"])
def test_what_stands_between_plain_moves_holds_for_them(dialect, line, feed):
    """A mode, a wrong word or a word without a move, before and after moves that are read together."""
    first, start = ("1 L X+1 Y+2 Z+3 B+4 C+5", "2 L") if dialect == "heidenhain" else ("N1 G1 X1 Y2 Z3 B4 C5", "N2")
    moves = [f"{start} X{n}.5{feed if n % 2 else ''}" for n in range(40)]
    assert_the_same_however_read("\n".join([first, *moves, line, *moves, f"{start} X1 F700", *moves, ""]), dialect)


def test_names_with_digits_are_not_confused():
    siemens = replace(DMU, rotary=(DMU.rotary[0], replace(DMU.rotary[1], name="C0")))
    with machine_code(True), pytest.raises(InputError, match="line 2.*'C7=9'"):
        reader.read("N1 X1 Y2 Z3 B4 C0=5\nN2 X3 C7=9\n", siemens, "siemens")


def test_what_holds_for_a_heidenhain_control():
    """The feed outlasts a time; no time is shorter than the control takes."""
    words, seconds = np.arange(40)[:, None] * np.ones(5), np.where(np.arange(40) % 2, 1e-7, np.nan)
    lines = writer.write(Blocks(words, np.full(40, 500.0), seconds, np.zeros(40, bool)), DMU).splitlines()
    assert sum(" F500" in line for line in lines) == 1 and sum(" FT0.001" in line for line in lines) == 20


def varied(count, seed, tcp):
    """A program whose moves are of all kinds in any order."""
    rng = np.random.default_rng(seed)
    kind = rng.choice(["rapid", "timed", "feed", "none"], count, p=rng.dirichlet(np.ones(4)))
    words = np.round(np.cumsum(rng.integers(-1, 2, (count, 5)) / 8, axis=0), 4)
    words[:, 0] += np.arange(count)  # no move repeats the one before
    feeds = np.where((kind == "none") | (kind == "rapid"), np.nan, rng.choice([500, 1000 / 3], count))
    remarks = sorted((int(rng.integers(count + 1)), f"remark {n} {{x}}") for n in range(rng.integers(4)))
    seconds = np.where(kind == "timed", rng.random(count), np.nan)
    return Blocks(words, feeds, seconds, kind == "rapid", tcp, tuple(remarks))


@pytest.mark.parametrize("dialect", DIALECTS)
@settings(max_examples=100, deadline=None)
@given(st.integers(1, 60), st.integers(0, 10**6), st.booleans())
def test_moves_of_all_kinds_are_written_and_read(dialect, count, seed, tcp):
    """Whatever is left out because it holds already, reading finds it; in whatever portions the text is made."""
    written = varied(count, seed, tcp)
    whole = writer.write(written, DMU, dialect)
    for rows, used in ((4096, True), (7, True), (1, False)):
        with machine_code(used) as patch:
            patch.setattr(bulk, "ROWS", rows)
            assert writer.write(written, DMU, dialect) == whole
    back, timed = reader.read(whole, DMU, dialect), ~(written.rapid | np.isnan(written.seconds))
    np.testing.assert_array_equal(back.words, written.words)
    np.testing.assert_array_equal(back.rapid, written.rapid)
    longer = back.seconds[timed] / np.maximum(written.seconds[timed], 1e-3)  # no block is faster than it may be
    assert (longer > 1 - 1e-9).all() and (back.seconds[timed] - written.seconds[timed] < 1.1e-3).all()
    stated = ~(timed | np.isnan(written.feeds))
    np.testing.assert_allclose(back.feeds[stated], written.feeds[stated], atol=5e-4)
    assert all(f"{remark}" in whole for _, remark in written.remarks)
    assert (back.tcp == tcp).all()
    np.testing.assert_allclose(np.degrees(back.joints[:, 3:]), written.words[:, 3:])


@pytest.mark.parametrize("dialect", ["fanuc", "siemens"])
def test_block_numbers_begin_again(dialect):
    count = 12_000
    words = np.arange(count)[:, None] * np.ones(5)
    remarks = ((10_500, "here"),)
    nan = np.full(count, np.nan)
    text = writer.write(Blocks(words, nan, nan, np.zeros(count, bool), False, remarks), DMU, dialect)
    numbers = [int(line[1:].split()[0]) for line in text.splitlines() if line.startswith("N")]
    assert numbers == [10 * (n % 9999 + 1) for n in range(count + 2)]


def test_lines_of_a_heidenhain_program_are_all_numbered():
    text = writer.write(blocks(12_000), DMU)
    assert [int(line.split()[0]) for line in text.splitlines()] == list(range(12_000 + 6))


@pytest.mark.parametrize("dialect", ["fanuc", "siemens"])
def test_comments_and_names_of_programs_take_no_number(dialect):
    head = ("%", "O0007", "(BY HAND)", "; BY HAND", "M8")
    lines = writer.write(blocks(), replace(DMU, program_head=head), dialect).splitlines()
    assert {*head[:4]} < {*lines} and "M8" not in lines


@pytest.mark.parametrize("used", [True, False])
def test_numbers_of_any_size_are_written_or_refused(used):
    words = np.array([[1e9, -2.5, 0, 0, 0], [9e10, 123456789.12346, 0, 0, 1], [-9e10, 0.00004, 0, -0.00004, -1]])
    nan = np.full(3, np.nan)
    with machine_code(used):
        lines = writer.write(Blocks(words, nan, nan, np.zeros(3, bool)), DMU).splitlines()
    assert lines[2] == "2 L X+1000000000.0000 Y-2.5000 Z+0.0000 B+0.0000 C+0.0000"
    assert lines[3] == "3 L X+90000000000.0000 Y+123456789.1235 C+1.0000"
    assert lines[4] == "4 L X-90000000000.0000 Y+0.0000 C-1.0000"
    words[2, 0] = -1e300
    with machine_code(used), pytest.raises(InputError, match="last digits"):
        writer.write(Blocks(words, nan, nan, np.zeros(3, bool)), DMU)


def test_words_lie_axis_by_axis():
    words = reader.read(TEXTS["heidenhain"], DMU).words
    assert all(axis.flags.c_contiguous for axis in words.T)


@pytest.mark.parametrize(
    ("dialect", "own", "last"),
    [
        ("heidenhain", None, ["END PGM MATHPOST MM"]),
        ("heidenhain", (), ["M30", "END PGM MATHPOST MM"]),
        ("heidenhain", ("M9", "M2"), ["M9", "M2", "END PGM MATHPOST MM"]),
        ("heidenhain", ("M02 ; DONE",), ["M02 ; DONE", "END PGM MATHPOST MM"]),
        ("heidenhain", ("M5 ; THEN M30",), ["M5 ; THEN M30", "M30", "END PGM MATHPOST MM"]),
        ("fanuc", ("M9",), ["M9", "M30", "%"]),
        ("fanuc", ("M9 M30",), ["M9 M30", "%"]),
        ("linuxcnc", ("M30",), ["M30"]),
        ("siemens", ("M2",), ["M2"]),
    ],
)  # fmt: skip
def test_a_program_ends_once(dialect, own, last):
    """M30 before END PGM, but where there are moves only; not behind a foot that ends the program."""
    machine = DMU if own is None else replace(DMU, program_head=("M8",), program_foot=own)
    lines = writer.write(blocks(), machine, dialect).splitlines()
    assert [re.sub(r"^N?\d+ ", "", line).strip() for line in lines[-len(last) :]] == last


@pytest.mark.parametrize("tcp", [False, True])
def test_a_speed_is_stated_once_and_m128_is_off_at_a_tool_call(tcp):
    """Heidenhain, M128: reset it before a TOOL CALL. A spindle that turns back keeps its speed."""
    turns = [(3, 800.0, "CLW"), (5, 800.0, "CCLW"), (7, None, "CLW"), (9, 1500.0, "CLW")]
    remarks = tuple((row, Command("spindle", (speed, sense), "")) for row, speed, sense in turns)
    text = writer.write(replace(blocks(tcp=tcp), remarks=remarks), DMU, "heidenhain")
    lines = [re.sub(r"^\d+ ", "", line) for line in text.splitlines()]
    around = [["M129"], ["M128"]] if tcp else [[], []]
    for speed, sense in (("800", "M3"), ("1500", "M3")):
        at = lines.index(f"TOOL CALL S{speed}")
        assert lines[at - tcp : at + 2 + tcp] == [*around[0], f"TOOL CALL S{speed}", sense, *around[1]]
    assert lines.count("TOOL CALL S800") == 1 and lines.count("M4") == 1 and lines.count("M3") == 3
    assert text.count("M128") == 3 * tcp and text.count("M129") == 3 * tcp

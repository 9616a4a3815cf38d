"""CL files: every statement that is taken, every one that is refused with its line, and mutated files."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mathpost.errors import InputError
from mathpost.path import cl as cldata
from mathpost.path import cl_words
from mathpost.path import text as bulk
from mathpost.path.modal import Command
from tests.conftest import DATA, machine_code


def test_table_1(blade):
    assert len(blade) == 5
    assert blade.points[0].tolist() == [50.31991, 58.40925, 52.13969]
    printed = np.loadtxt(DATA / "tables/yu_dan_table_1.csv", delimiter=",", skiprows=2)
    np.testing.assert_array_equal(blade.points, printed[:, 1:4])
    np.testing.assert_allclose(blade.axes, printed[:, 4:], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(blade.axes, axis=1), 1, atol=1e-15)
    assert blade.lines.tolist() == [2, 3, 4, 5, 6]


FILE = """PARTNO/ A $ 100 BLADE
$$ comment
UNITS/MM\r
LOADTL/1,ADJUST,1
SPINDL/ 3000.0000, RPM, CLW
MULTAX/ON
FROM/ 0.0, 0.0, 100.0, 0.0, 0.6, 0.8
RAPID
GOTO/ 1.0, 2.0, 50.0
FEDRAT/ 1.5E+03, MMPM
TOOL PATH/VARIABLE_CONTOUR,TOOL,BALL_10
GOTO / 1.0, -2.5e-1, $
   3.0, 0.0, 0.0, $
   1.0
goto/4,5,6
END-OF-PATH
COOLNT/OFF
FINI
"""


def test_statements():
    cl = cldata.parse(FILE)
    np.testing.assert_allclose(cl.points, [[1, 2, 50], [1, -0.25, 3], [4, 5, 6]])
    np.testing.assert_allclose(cl.axes, [[0, 0.6, 0.8], [0, 0, 1], [0, 0, 1]])
    assert cl.rapid.tolist() == [True, False, False]
    assert np.isnan(cl.feeds[0]) and cl.feeds[1:].tolist() == [1500, 1500]
    assert cl.lines.tolist() == [9, 12, 15]
    first, tool, spindle, *_ = (remark for record, remark in cl.remarks if record == 0)
    assert first.startswith("PARTNO") and tool == Command("tool", (1, None, 1), "LOADTL/1,ADJUST,1")
    assert (spindle.kind, spindle.values) == ("spindle", (3000.0, "CLW"))
    assert cl.remarks[-1] == (3, "FINI")


def test_text_reads_back():
    cl = cldata.parse(FILE)
    back = cldata.parse(cldata.to_text(cl, title="again"))
    for field in ("points", "axes", "feeds", "rapid"):
        np.testing.assert_allclose(getattr(back, field), getattr(cl, field), atol=1e-8)
    assert back.remarks[1:] == cl.remarks[1:]  # of the name of the part, only what stands behind a $ is lost


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", None, "at least one GOTO"),
        ("$$ only a comment\n", None, "at least one GOTO"),
        ("GOTO/1,2,3,0,1\n", 1, "3, 6 or 9 numbers, found 5"),
        ("GOTO/1,2,3\nGOTO/1,2\n", 2, "found 2"),
        ("GOTO/1,2,3,0,0,0\n", 1, "unit tool axis"),
        ("GOTO/1,2,3,0,0,0.99\n", 1, "length 0.99"),
        ("GOTO/1,2,3,0,0,1\n\nGOTO/1,2,NaN,0,0,1\n", 3, "a number, found 'NAN'"),
        ("GOTO/1,2,inf\n", 1, "'INF'"),
        ("GOTO/1,2,1e999\n", 1, "finite"),
        ("GOTO/1,2,1_0\n", 1, "'1_0'"),
        ("GOTO/1,2,three\n", 1, "'THREE'"),
        ("GOTO/1,2,\n", 1, "a number, found ''"),
        ("GOTO/1,2,3,$\n", 1, "continuation"),
        ("GOTO 1,2,3\n", 1, "GOTO and a slash"),
        ("GOTP/1,2,3\n", 1, "'GOTP/1,2,3'"),
        ("FEDRAT/fast\n", 1, "a number, found 'FAST'"),
        ("FEDRAT/0\n", 1, "above 0"),
        ("FEDRAT/1,2\n", 1, "MMPM, IPM"),
        ("UNITS/FEET\n", 1, "FEET"),
        ("GOTO/1,2,3\nCIRCLE/0,0,0,0,0,1,5\n", 2, "CIRCLE"),
        ("TLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,1,1,1)\n", 1, "INDIRV"),
        ("GODLTA/1,2,3\n", 1, "GODLTA"),
        ("CYCLE/DRILL,10\n", 1, "CYCLE"),
    ],
)
def test_wrong_files_are_refused(text, line, words):
    with pytest.raises(InputError) as caught:
        cldata.parse(text, "part.cl")
    assert str(caught.value).startswith(f"part.cl, line {line}" if line else "part.cl:")
    assert words in str(caught.value)


def test_files_that_cannot_be_read(tmp_path):
    for name, content in (("none.cl", None), ("binary.cl", b"GOTO/1,2,3\nGOTO/\xff")):
        if content:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=name):
            cldata.read(tmp_path / name)
    with pytest.raises(InputError, match="line 2"):
        cldata.read(tmp_path / "binary.cl")


@pytest.mark.parametrize(
    ("points", "axes"), [([[1, 2]], [[0, 0, 1]]), ([[1, 2, 3]], [[0, 0, 0]]), ([1, 2, 3], [0, 0, 1])]
)
def test_arrays_are_checked(points, axes):
    with pytest.raises(InputError):
        cldata.from_arrays(points, axes)


def mutations(text):
    """A text with a few characters replaced, left out or put in."""
    edit = st.tuples(
        st.integers(0, len(text) - 1), st.integers(0, 3), st.sampled_from("0179.,-+eE$/ \n\tGOTNX;%('")
    )

    def apply(edits):
        characters = list(text)
        for at, length, character in edits:
            characters[at : at + length] = character
        return "".join(characters)

    return st.lists(edit, min_size=1, max_size=6).map(apply)


@settings(max_examples=500, deadline=None)
@given(mutations(FILE))
def test_mutated_files_are_read_or_refused(text):
    try:
        cl = cldata.parse(text)
    except InputError:
        return
    assert np.isfinite(cl.points).all() and np.allclose(np.linalg.norm(cl.axes, axis=1), 1)


def test_between_records(blade):
    tip, axis = blade.at([0, 0.5, 4])
    np.testing.assert_allclose(tip[[0, 2]], blade.points[[0, 4]])
    np.testing.assert_allclose(tip[1], blade.points[:2].mean(axis=0))
    middle = blade.axes[0] + blade.axes[1]
    np.testing.assert_allclose(axis[1], middle / np.linalg.norm(middle), atol=1e-15)


def fields(cl):
    """All that a `CLData` says, its floats to the last bit."""
    arrays = [getattr(cl, name) for name in ("points", "axes", "feeds", "rapid", "lines")]
    return [*(array.tolist() for array in arrays), cl.remarks, cl.name, cl.first]


def outcome(function):
    """What a call returns or how it refuses, as text, in which 0.0 and -0.0 differ."""
    try:
        return repr(function())
    except InputError as error:
        return str(error)


MANY = (
    FILE
    + "GOTO/1.5,-2,+3.,.5,0,0.8660254\n" * 12
    + "GOTO/-0.0,12.345678,100.000001,0.000000000,0.600000000,0.800000000\n" * 5
    + "GOTO/1,2,3\nRAPID\nGOTO/1,2,3,0,0,1\nGOTO/1,2,3,0,1,0\nGOTO/4,5,6\n"
    + "goto/1.5,-2,3.,.5,0,0.8660254037844387\nFEDRAT/100\n" * 3
    + "GOTO/1.5,-2,1E1,.5,0,0.8660254\n" * 3
    + "UNITS/INCH\nPPRINT é $\n"
    + "GOTO / 1 , 2, 3,0,0,1 \r\n" * 9
    + "TRNTYP/WORLD,0,0,0\nCSYS/0,0,1,0,1,0,0,0,0,1,0,0\n"
    + "GOTO/1,2,3\n" * 9
    + "GOTO/1,2,3,0,0.6,0.8\nGOTO/1,2,3\nMULTAX/OFF\n"
    + "GOTO/1,2,3\n" * 9
    + "OPSKIP/ON\nCOOLNT/ON\nOPSKIP/OFF\nFEDRAT/0.1,MMPR\n"
    + "GOTO/1,2,3\n" * 9
    + "SPINDL/100\n"
    + "GOTO/1,2,3\n" * 9
    + FILE
)


@settings(max_examples=500, deadline=None)
@given(mutations(MANY))
def test_records_read_together_are_read_as_one_by_one(text):
    """The same records or the same refusal, whatever stands in the text and wherever it is cut into blocks."""
    outcomes = set()
    for used, block in ((True, 2**17), (False, 2**17), (True, 300), (True, 1500), (False, 1)):
        with machine_code(used) as patch:
            patch.setattr(bulk, "BLOCK", block)
            outcomes.add(outcome(lambda: fields(cldata.parse(text))))
    assert len(outcomes) == 1


def test_ordinary_records_are_read_together(monkeypatch):
    """No line of a run is left to the way line by line, unless it must be."""
    taken = []
    monkeypatch.setattr(cl_words.Statements, "take_line", lambda self, raw: taken.append(raw))
    runs = "GOTO/1.5,-2,+3.,.5,0,0.8660254\nGOTO/1,2,3\n" * 30 + "GOTO / -10.123456789 , 2, 3,0,0,1 \r\n" * 30
    with machine_code(True):
        assert len(cldata.parse("FEDRAT/1\n".join([runs] * 3))) == 270 and taken == [b"FEDRAT/1"] * 2


def test_records_without_an_axis_keep_the_last_one():
    lines = "GOTO/1,2,3\nGOTO/4,5,6,1,0,0\nGOTO/7,8,9\nGOTO/1,2,3\nFROM/0,0,0,0,1,0\nGOTO/1,2,3\nGOTO/4,5,6,0,0,1\n"
    for used in (True, False):
        with machine_code(used):
            axes = cldata.parse(lines * 2).axes.tolist()
        x, y, z = np.eye(3).tolist()
        assert axes == [z, x, x, x, y, z] * 2


def test_of_two_wrong_lines_the_first_is_named(tmp_path):
    """Whatever is wrong with them."""
    good, path = "GOTO/1,2,3,0,0,1\n" * 50, tmp_path / "part.cl"
    wrong = [b"GOTO/1,2\n", b"GOTO/1,2,3,0,0,2\n", b"CIRCLE/1\n", b"NONSENSE\n"]
    for first in wrong:
        for second in wrong:
            path.write_bytes(b"\xef\xbb\xbf" + good.encode() + first + good.encode() + second)
            with pytest.raises(InputError, match="part.cl, line 51"):
                cldata.read(path)


def test_a_part_holds_the_remarks_before_its_records():
    whole = cldata.parse(MANY)
    part = whole.part(7, 20)
    assert len(part) == 13 and part.where(0) == whole.where(7)
    assert part.remarks == tuple((at - 7, text) for at, text in whole.remarks if 7 <= at < 20)
    assert whole.part(30, len(whole)).remarks[-1] == (len(whole) - 30, "FINI")


def test_arcs_and_holes_stand_at_their_own_records_in_a_part_and_behind_a_half_turn():
    """Records taken away or put in before them move both ends: by distances from axis and point."""
    whole = cldata.parse(
        "FEDRAT/100\nGOTO/0,0,50,0,0,1\nRAPID\nGOTO/0,0,50,0,0,-1\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0\n"
        "CYCLE/DRILL,DEPTH,8,MMPM,100,CLEAR,2\nGOTO/3,0,0\nCYCLE/OFF\nGOTO/0,0,-9"
    )
    assert "with a record half way: 1" in whole.notes[-1] and "holes of drilling cycles: 1" in whole.notes
    for cl in (whole, whole.part(2, len(whole)), whole.part(3, len(whole) - 1)):
        arc, hole = cl.pieces
        round_, drilled = (cl.points[piece.first : piece.last + 1] for piece in cl.pieces)
        np.testing.assert_allclose(np.linalg.norm(round_, axis=1), 10)
        np.testing.assert_allclose(round_[[0, -1]], [[10, 0, 0], [0, 10, 0]], atol=1e-9)
        np.testing.assert_allclose(drilled[:, :2], np.tile([3, 0], (len(drilled), 1)))
        assert drilled[0, 2] == drilled[-1, 2] == -2 and drilled[:, 2].max() == 8
        assert hole.first == arc.last + 1


def test_components_lie_one_after_the_other():
    points = np.arange(12.0).reshape(4, 3)
    for cl in (cldata.parse(FILE), cldata.from_arrays(points, points + 1)):
        assert all(component.flags.c_contiguous for component in (*cl.points.T, *cl.axes.T))
        assert not cl.points.flags.writeable and points.flags.writeable


def test_a_file_that_stops_within_a_record(tmp_path):
    """Cut anywhere in its last record, a file is refused, or its report says that it may be cut off."""
    path, whole = tmp_path / "cut.cl", "GOTO/1,2,3,0,0,1\nGOTO/50.31915,58.40925,52.14198,0,0,1.0000\n"
    refused = 0
    for length in range(whole.index("GOTO/50") + len("GOTO/5"), len(whole)):
        path.write_text(whole[:length], encoding="utf-8")
        try:
            assert "cut off" in cldata.read(path).notes[-1]
        except InputError as error:
            refused += "cut.cl, line 2" in str(error)
        else:
            assert whole[:length].count(",") == 10, "no number is missing"
    assert refused > 20
    for complete in (whole, whole + "FINI"):
        path.write_text(complete, encoding="utf-8")
        assert "cut off" not in str(cldata.read(path).notes)

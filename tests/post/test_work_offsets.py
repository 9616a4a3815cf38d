"""Several work offsets in a program: their words, and where the tool goes, by a reader written from manuals."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mathpost import load_machine, machine_file, postprocess
from mathpost.errors import InputError
from mathpost.files import read_toml
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.shop.controls.coordinates import Setup as Tables
from mathpost.shop.post.verify import verify
from tests.conftest import DATA
from tests.independent import judge
from tests.independent.machine_model import Model
from tests.independent.reader import Setup, read
from tests.post.test_own_words import numbers

CONTROLS = ("heidenhain", "fanuc", "siemens", "linuxcnc", "haas", "mazak")
MACHINES = ("ac_table", "bc_table", "head_b_table_c")
WORDS = {  # of the work offsets 2 and 4, as the controls' manuals have them
    "heidenhain": ("CYCL DEF 247 DATUM SETTING Q339=+2", "CYCL DEF 247 DATUM SETTING Q339=+4"),
    **dict.fromkeys(CONTROLS[1:], ("G55", "G57")),
}
LENGTHS = {1: 80.0, 3: 80.0, 5: 112.0}
OPERATIONS = ((4, 3), (2, 3), (4, 5), (2, 5), (4, 3))  # work offset and tool of each


def job(rng, setup, offsets, each=5):
    """CL data of `OPERATIONS`, and their records in the coordinates of work offset 4."""
    lines, records, loaded = ["UNITS/MM", "SPINDL/RPM,900,CLW", "FEDRAT/700,MMPM"], [], None
    for number, tool in OPERATIONS:
        lines.append(f"MCSYS/NUM,{number}")
        if tool != loaded:
            lines.append(f"LOAD/TOOL,{tool},LENGTH,{LENGTHS[tool]:g}")
        loaded, base = tool, rng.uniform(5, 25, 2)
        for n in range(each):
            angles = base + np.multiply(n, [0.3, 0.5]) * (number == 2)
            _, axis = Kinematics(setup).forward([0, 0, 0, *angles], degrees=True)
            tip = rng.uniform([-15, -15, -3], [15, 15, 6])
            lines.append(f"GOTO/{numbers(tip, axis)}")
            records.append((tip + offsets[number], axis))
    tips, axes = zip(*records, strict=True)
    return "\n".join(lines) + "\n", np.array(tips), np.array(axes)


@pytest.mark.parametrize("tcp", [False, True], ids=["joints", "tcp"])
@pytest.mark.parametrize("control", CONTROLS)
def test_each_operation_is_cut_at_its_origin(control, tcp, of):
    number = CONTROLS.index(control)
    for name in of([MACHINES[number % 3]], MACHINES):
        rng = np.random.default_rng(10 * number + tcp)
        shift = rng.uniform(-20, 20, 3).round(2)
        setup = load_machine(name)
        others = ((2, tuple((setup.origin + shift).tolist())),)
        head = ("; OURS",) if control == "heidenhain" else ("G40",)
        setup = replace(setup, offset=4, offsets=others, program_head=head)
        text, tips, axes = job(rng, setup, {4: np.zeros(3), 2: shift}, of(5, 10))
        result = postprocess(cldata.parse(text), setup, dialect=control, tcp=tcp)
        model = Model(DATA / "machines" / f"{name}.toml", origin=setup.origin)
        offsets = {"G55": shift, 2: shift, "G57": np.zeros(3), 4: np.zeros(3)}
        held = control not in ("fanuc", "haas", "mazak")  # by the tool call, not by G43
        moves = read(result.program, control, Setup(model, offsets=offsets, lengths=LENGTHS, length_on=held))
        samples = judge.sample(model, moves)
        assert judge.records_missed(samples.tip, samples.axis, tips, axes, 5e-4, 1e-3) == []
        assert judge.beyond_travel(model, moves, samples) == []
        assert all(word in result.program for word in WORDS[control])
        # Between two operations and behind the last the slide is at the safe position, length and offset counted.
        far = model.nose_of_slides([0, 0, setup.safe[2]])[2]
        is_far = np.isclose([move.nose(model, 1.0)[2] for move in moves], far, atol=1e-3)
        assert is_far[-1] and (np.diff(is_far.astype(int)) == -1).sum() == len(OPERATIONS)


def with_offsets(*lines, **changes):
    text = "\n".join(["UNITS/MM", "FEDRAT/500,MMPM", *lines]) + "\n"
    return cldata.parse(text), replace(load_machine("ac_table"), **changes)


def test_the_machine_file_says_which_offset_without_the_cl_data(blade):
    lines = postprocess(blade, replace(load_machine("dmu50v"), offset=3), dialect="fanuc").program.splitlines()
    assert [line.split()[-1] for line in lines if line.endswith("G56")] == ["G56"]
    moved = postprocess(blade, load_machine("dmu50v"), dialect="fanuc").program
    assert "G54" not in moved and "G56" not in moved


@pytest.mark.parametrize(
    ("control", "number", "word"),
    [("fanuc", 6, "G59"), ("fanuc", 7, "G54.1 P1"), ("mazak", 54, "G54.1 P48"), ("haas", 8, "G154 P2"),
     ("siemens", 5, "G505"), ("siemens", 99, "G599"), ("linuxcnc", 9, "G59.3"),
     ("heidenhain", 12, "CYCL DEF 247 DATUM SETTING Q339=+12")],
)  # fmt: skip
def test_the_words_of_high_numbers(control, number, word):
    cl, setup = with_offsets(f"MCSYS/NUM,{number}", "GOTO/1,2,3,0,0,1", "GOTO/5,2,3")
    assert any(line.endswith(word) for line in postprocess(cl, setup, dialect=control).program.splitlines())


@pytest.mark.parametrize(
    ("control", "lines", "changes", "words"),
    [
        ("fanuc", ["MCSYS/NUM,1", "GOTO/1,2,3", "MCSYS/NUM,2", "GOTO/1,2,3"], {}, ("line 6", "offsets = { 2")),
        ("fanuc", ["MCSYS/NUM,2", "GOTO/1,2,3"], {"offset": 1}, ("line 4", "work offset 2", "[workpiece]")),
        ("linuxcnc", ["MCSYS/NUM,10", "GOTO/1,2,3"], {}, ("line 4", "1 to 9", "10")),
        ("siemens", ["MCSYS/NUM,100", "GOTO/1,2,3"], {}, ("line 4", "1 to 99", "100")),
    ],
)  # fmt: skip
def test_an_offset_that_nobody_knows_is_refused_with_its_line(control, lines, changes, words):
    cl, setup = with_offsets(*lines, **changes)
    with pytest.raises(InputError) as caught:
        postprocess(cl, setup, dialect=control)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        ("GOTO/1,2,3\nMCSYS/NUM,1", "before the first move"),
        ("MCSYS/NUM,0", "from 1"),
        ("MCSYS/NUM", "MCSYS/NUM and the number"),
        ("MCSYS/NUM,1,POINT,0,0,0", "POINT, VECTOR and VECTOR"),
        ("MCSYS/NUM,1,POINT,0,0,0,VECTOR,1,0,0,VECTOR,0,2,0", "right-handed"),
        ("MCSYS/NUM,1\nGOTO/1,2,3\nCYCLE/DRILL,DEPTH,5,CLEAR,2\nMCSYS/NUM,2", "outside a cycle"),
    ],
)
def test_statements_that_say_nothing_sure(statements, expected):
    with pytest.raises(InputError, match=expected):
        cldata.parse(f"UNITS/MM\nFEDRAT/500,MMPM\n{statements}\nGOTO/1,2,3\n")


def test_a_plane_lies_in_the_coordinates_of_its_offset():
    plane = "MCSYS/NUM,1,POINT,10,20,30,VECTOR,0,1,0,VECTOR,-1,0,0"
    cl = cldata.parse(f"UNITS/MM\n{plane}\nGOTO/1,2,3\nMCSYS/NUM,1\nGOTO/1,2,3\n")
    assert np.allclose(cl.points, [(8, 21, 33), (1, 2, 3)])
    assert [len(part) for part, _, _ in cl.by_setup()] == [2]
    again = cldata.parse(cldata.to_text(cl))
    assert np.allclose(again.points, cl.points)


def test_numbers_of_a_machine_file():
    wrong = {"offset": 2, "offsets": {"2": [0, 0, 0]}}
    for content, key in ((wrong, "offsets"), ({"offset": 0}, "offset"), ({"offsets": {"0": [0, 0, 0]}}, "'0'")):
        with pytest.raises(InputError, match=key):
            machine_file.from_dict(content_of(**content))


def content_of(**workpiece):
    content = read_toml(DATA / "machines/ac_table.toml")
    content["workpiece"] |= workpiece
    return content


@pytest.mark.parametrize("tcp", [False, True], ids=["joints", "tcp"])
@pytest.mark.parametrize("control", CONTROLS)
def test_a_program_with_several_offsets_is_verified(control, tcp):
    rng = np.random.default_rng(7)
    setup = load_machine("ac_table")
    origin = tuple(np.add(setup.origin, [60, -40, 12]).tolist())
    setup = replace(setup, offset=4, offsets=((2, origin),))
    cl = cldata.parse(job(rng, setup, {4: np.zeros(3), 2: np.zeros(3)})[0])
    program = postprocess(cl, setup, dialect=control, tcp=tcp).program

    def verified(text, on, **tables):
        lengths = {str(tool): length for tool, length in LENGTHS.items()}
        return verify(text, on, control, cl=cl, setup=Tables(lengths=lengths, **tables))

    found = verified(program, setup)
    assert found.status == 0, str(found)
    two = "".join(WORDS[control][0].split())
    stated = replace(setup, offsets=())
    assert verified(program, stated, offsets={two: origin}).status == 0
    with pytest.raises(InputError, match=f"the origin of {re.escape(two)}"):
        verified(program, stated)
    another = program.replace(*WORDS[control])  # all that is at the second offset, at the first one
    assert verified(another, setup).status == 1


def test_an_offset_that_the_control_does_not_have_moves_no_record():
    """CL data of another system may number them as they like; with one origin there is nothing to shift."""
    setup = load_machine("ac_table")
    lines = ["UNITS/MM", "FEDRAT/500,MMPM", "GOTO/0,0,5,0,0,1", "GOTO/9,0,5,0,0,1"]
    program = postprocess(cldata.parse("\n".join(lines)), setup, dialect="haas").program
    named = cldata.parse("\n".join([*lines[:2], "MCSYS/NUM,4711", *lines[2:]]))
    assert verify(program, setup, "haas", cl=named).status == 0

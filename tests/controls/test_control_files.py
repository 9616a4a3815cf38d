"""Controls as files: what they may say, what a user's own may inherit, and what is refused with its line."""

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.errors import InputError
from mathpost.interface.shell.main import main
from mathpost.path import cl as cldata
from mathpost.shop.controls import control, reader
from tests.conftest import DATA
from tests.independent.machine_model import Model
from tests.independent.test_programs import spiral

OWN = """name = "grblhal"
inherits = "fanuc"
source = "its documentation of G codes"

[program]
head = ["G21 G17 G90 G94"]
foot = ["M30"]

[blocks]
number = "none"
decimals = 3
"""
GROUP = '[[geometry]]\ntitle = "P"\narrangement = "table-table"\n'
MACHINES = ["ac_table", "dmu50v", "head_b_table_c", "nutating_head"]


@pytest.fixture
def own(tmp_path):
    """A control of the user's, from a few lines."""
    path = tmp_path / "grblhal.toml"
    path.write_text(OWN, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", MACHINES)
def test_a_control_of_the_users_own(own, name):
    data, path = load_machine(name), cldata.read(DATA / "cl/blade.cl")
    result = postprocess(path, data, dialect=own, tolerance=0.05)
    lines = result.program.splitlines()
    assert lines[0] == "G21 G17 G90 G94" and lines[-1] == "M30" and not any(line[0] in "N%O " for line in lines)
    assert all(len(word.split(".")[1]) == 3 for line in lines for word in line.split() if word[0] in "XYZ")
    assert result.report.path_tip_error <= 0.05
    back = reader.read(result.program, data, own)
    np.testing.assert_array_equal(back.words, result.blocks.words)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("longst = 3", r"line 12, \[blocks\], key 'longst': expected no such key, found 3"),
        ("decimals = 1.5", r"a TOML file"),
        ("step = 0", r"line 12, \[blocks\], key 'step': expected a whole number above 0, found 0"),
        ('[motion]\nturning_feed = "fast"', r"line 1\d, \[motion\], key 'turning_feed': expected .* found 'fast'"),
        ('[commands]\n"tool" = ["T{number}"]', r"line 1\d, \[commands\], key 'tool': expected .*only"),
        ('[read]\nG7 = "fly"', r"line 1\d, \[read\], key 'G7': expected"),
        (
            '[[geometry]]\ntitle = "P"\narrangement = "table"',
            r"\[\[geometry\]\] 1, key 'arrangement': expected \"table-table",
        ),
        (GROUP + 'rows = [["P1", "third"]]', r"key 'rows': expected .*second - first.*found \['P1', 'third'\]"),
        (GROUP + 'rows = [["P1", "first", "A"]]', r"key 'rows': expected .*found \['P1', 'first', 'A'\]"),
        ('[commands]\n"jump" = ["G8"]', r"line 1\d, \[commands\], key 'jump': expected no such key"),
    ],
)
def test_a_wrong_key_is_refused_with_its_line(own, wrong, said):
    own.write_text(OWN + wrong + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=said):
        control.load(own)


def test_a_control_that_inherits_from_itself_is_refused(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(f'inherits = "{path}"\nname = "a"\n', encoding="utf-8")
    with pytest.raises(InputError, match="inherits"):
        control.load(path)


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("name", MACHINES)
def test_linuxcnc_states_a_time_wherever_an_axis_turns(name, tcp):
    """And TCP's slides keep their rates by it: of 200 parts of a move none is faster, by formulas of the tests."""
    path = cldata.from_arrays(*spiral(records=13, radius=10), feed=60_000)
    blocks = postprocess(path, load_machine(name), dialect="linuxcnc", tcp=tcp).blocks
    turning = (np.diff(blocks.words[:, 3:], axis=0) != 0).any(axis=1)
    assert turning.any() and not np.isnan(blocks.seconds[1:][turning]).any()
    model = Model(DATA / f"machines/{name}.toml")
    for start, end, seconds in zip(blocks.words[:-1], blocks.words[1:], blocks.seconds[1:], strict=True):
        if np.isnan(seconds):
            continue
        poses = start + np.linspace(0, 1, 201)[:, None] * (end - start)
        if tcp:
            noses = [model.nose_for(pose[:3], pose[3:]) for pose in poses]
            poses = np.column_stack([noses, poses[:, 3:]])
        rates = np.abs(np.diff(poses, axis=0)).max(axis=0) * 200 / seconds
        assert (rates <= 1.01 * np.array([*model.rates.values()])[[2, 3, 4, 0, 1]]).all()


@pytest.mark.parametrize("name", control.names())
def test_every_control_says_what_its_words_rest_on(name, capsys):
    assert main(["controls"]) == 0 and control.load(name).source in capsys.readouterr().out
    assert main(["controls", name]) == 0 and f'name = "{name}"' in capsys.readouterr().out


def test_a_comment_ends_no_transfer_and_stays_in_its_letters():
    found = control.load("fanuc").remark("50% ÄPFEL (刀具) " + "X" * 200)
    assert "%" not in "".join(found) and "".join(found).isascii() and all(len(line) <= 120 for line in found)
    assert all(line.startswith("(") and line.endswith(")") and line.count("(") == 1 for line in found)


def test_the_number_of_a_program_is_the_one_in_its_name():
    blade = cldata.read(DATA / "cl/blade.cl")
    for name, number in (("blade", "O0001"), ("part 4711", "O4711"), ("7", "O0007")):
        assert number in postprocess(blade, load_machine("dmu50v"), dialect="fanuc", name=name).program


@pytest.mark.parametrize("name", [*MACHINES, "ac_head", "bc_table", "nutating_head_table"])
def test_the_vectors_of_traori_lead_around_the_machine(name):
    """From the zero to the axes of the table and back, from the spindle nose to those of the head and back."""
    data = load_machine(name)
    groups = [group for group in control.load("siemens").geometry if group.fits(data)]
    assert len(groups) == 2
    for group in groups:
        vectors = np.reshape([number for _, number in group.numbers(data)], (-1, 3))
        np.testing.assert_allclose(vectors[:-2].sum(axis=0), 0, atol=1e-12)
        for direction, rotary in zip(
            vectors[-2:], sorted(data.rotary, key=lambda each: each.carries), strict=False
        ):
            expected = np.array(rotary.axis) / np.linalg.norm(rotary.axis)
            np.testing.assert_allclose(direction, -expected if rotary.carries == "workpiece" else expected)

"""What goes wrong between a tool and its words, computed by hand with SciPy's rotations for three machines."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.detective.causes import CAUSES, COST, Setup, causes
from mathpost.detective.explanation import misread
from mathpost.detective.positions import explain_linear, explain_tip
from mathpost.detective.rotary_axes import explain_joints
from mathpost.errors import InputError
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.machine_file import load

BC, HEAD, MIXED = (Kinematics(load(name)) for name in ("bc_table", "ac_head", "head_b_table_c"))
JOINTS = np.array([10.0, -20.0, 30.0, 40.0, 75.0])


def about(axis, degrees):
    return Rotation.from_euler(axis, degrees, degrees=True)


def trunnion(x, y, z, b, c, *, sense=(1, 1), tilting=(20, 0, -80), turning=(20, 0, 0), origin=(20, 0, 40)):
    """The tip of the B table that carries C, from the machine back to the workpiece."""
    tip = np.add((x, y, z), origin)
    tip = about("Y", sense[0] * b).apply(tip - tilting) + tilting
    tip = about("Z", sense[1] * c).apply(tip - turning) + turning
    return tip - origin


def fork(x, y, z, c, a, *, pivot=200.0, length=150.0, unturned=0.0):
    """The tip of the fork head: X Y Z name the pivot, the tool hangs below it."""
    arm = about("Z", c) * about("X", a)
    return np.array([x, y, z]) + arm.apply([0, 0, -pivot - length]) - [0, 0, unturned]


# How somebody computed the tip, and what is to be named first.
TIPS = {
    "right": (BC, lambda j: trunnion(*j)),
    "B turns the other way": (BC, lambda j: trunnion(*j, sense=(-1, 1))),
    "C turns the other way": (BC, lambda j: trunnion(*j, sense=(1, -1))),
    "B and C turn the other way": (BC, lambda j: trunnion(*j, sense=(-1, -1))),
    "B and C stand in each other's place": (BC, lambda j: trunnion(*j[:3], j[4], j[3])),
    "the word B is taken for mm and divided by 25.4": (BC, lambda j: trunnion(*j[:3], j[3] / 25.4, j[4])),
    "the words B and C are taken for inches and multiplied by 25.4": (
        BC,
        lambda j: trunnion(*j[:3], j[3] * 25.4, j[4] * 25.4),
    ),
    "the degrees of B and C are taken for radians": (BC, lambda j: trunnion(*j[:3], *np.degrees(j[3:]))),
    "the pivot of B is taken twice": (BC, lambda j: trunnion(*j, tilting=(20, 0, -200))),
    "the pivot of B is of the opposite sign": (BC, lambda j: trunnion(*j, tilting=(20, 0, 160))),
    "the pivot of B is left out": (BC, lambda j: trunnion(*j, tilting=(20, 0, 40))),
    "X and Y of the answer are exchanged": (BC, lambda j: trunnion(*j)[[1, 0, 2]]),
    "the sign of the answer's Y is lost": (BC, lambda j: trunnion(*j) * [1, -1, 1]),
    "the answer is in inches": (BC, lambda j: trunnion(*j) / 25.4),
    "the tool length is not turned with the head": (HEAD, lambda j: fork(*j, length=0, unturned=150)),
    "the tool length is left out": (HEAD, lambda j: fork(*j, length=0)),
    "the tool length is taken twice": (HEAD, lambda j: fork(*j, length=300)),
    "A is left out": (HEAD, lambda j: fork(*j[:4], 0)),
}


@pytest.mark.parametrize("sentence", TIPS)
def test_a_tip(sentence):
    kin, formula = TIPS[sentence]
    answer = formula(JOINTS).round(4)
    found = explain_tip(kin, JOINTS, answer, decimals=4)
    assert found.misreadings[0].sentence == sentence, str(found)
    assert found.right == (sentence == "right")
    np.testing.assert_allclose(found.misreadings[0].value, answer, atol=1e-4)


def test_the_whole_rotation_transposed():
    """From workpiece to machine A after C is made, where the way back was asked for."""
    kin = Kinematics(load("ac_table"))
    given = np.array([10, -20, 30, 40, 75.0])
    point, low = np.array([10, -20, 30.0]), np.array([0, 0, -50.0])
    # A about y = 0, z = −50: the pivot stays where it is, in the order in which the turns are then made.
    transposed = about("X", -40).apply(about("Z", -75).apply(point) - low) + low
    found = explain_tip(kin, given, transposed.round(4), decimals=4)
    assert found.misreadings[0].sentence == "the whole rotation is transposed", str(found)


def test_a_published_one():
    """LinuxCNC/linuxcnc#2435: a table without offsets, tip 1 0 2; B90 is to be −2 0 1, not 2 0 −1."""
    kin = Kinematics(load("bc_table").with_setup(origin=(20, 0, -80)))
    moved = [(-1, 0, 2), (-2, 0, 1), (2, 0, -1)]
    assert explain_linear(kin, [1, 0, 2], [90, 0], moved[1]).right
    found = explain_linear(kin, [1, 0, 2], [90, 0], moved[2])
    assert found.misreadings[0].sentence == "B turns the other way" and not found.right


@pytest.mark.parametrize("kin", [BC, HEAD, MIXED], ids=lambda kin: kin.machine.name)
def test_without_a_cause_the_chain_is_that_of_the_machine(kin):
    joints = np.random.default_rng(3).uniform(-100, 100, (20, 5))
    tip, axis = kin.forward(joints, degrees=True)
    right = Setup.right(kin.machine)
    np.testing.assert_allclose(right.pose(joints), np.c_[tip, axis], atol=1e-11)
    np.testing.assert_allclose(right.linear(np.c_[tip, joints[:, 3:]]), joints[:, :3], atol=1e-11)
    for cause in causes(kin.machine):  # what a wrong chain makes forward it takes back again
        wrong = misread(right, cause)
        if wrong.order == (0, 1, 2) and wrong.signs == (1, 1, 1):
            back = wrong.linear(np.c_[wrong.pose(joints)[:, :3], joints[:, 3:]])
            np.testing.assert_allclose(back, joints[:, :3], atol=1e-9)


def test_tip_and_tool_axis_together():
    tip, axis = MIXED.forward([0, 0, 0, 30, 50], degrees=True)
    found = explain_tip(MIXED, [0, 0, 0, 30, -50], [*tip.round(5), *axis.round(5)], decimals=5)
    assert found.misreadings[0].sentence == "B turns the other way"


def test_an_offset_is_named():
    joints = np.array([JOINTS, np.add(JOINTS, (5, 5, 5, -20, 30))])
    tips = np.add([trunnion(*row) for row in joints], (0.5, -12, 30))
    found = explain_tip(BC, joints, tips.round(4), decimals=4)
    assert found.misreadings[0].sentence == "a constant is added: +0.5 in X, -12 in Y, +30 in Z"


def test_the_catalogue_cites_its_threads_and_orders_by_them():
    for name, cause in CAUSES.items():
        assert all("/" in thread and thread.split("#")[1].isdigit() for thread in cause["seen"]), name
        assert len(set(cause["seen"])) == len(cause["seen"]), name
    assert min(COST, key=COST.get) == "reversed" and COST["reversed"] < COST["names"] < COST["zero"]


def test_the_experiment_decides():
    """Three causes give one number here; at the input that is proposed each gives its own."""
    answer = trunnion(1, 0, 2, 90, 0, sense=(-1, 1))
    found = explain_tip(BC, [1, 0, 2, 90, 0], answer.round(4), decimals=4)
    assert len(found.misreadings) > 1 and found.misreadings[0].sentence == "B turns the other way"
    asked, told = found.note.split("try ")[1].split(": ", 1)
    joints = [float(number) for number in asked.split()[1::2]]
    expected = trunnion(*joints, sense=(-1, 1))
    first = told.split("; ")[0].split()[-5::2]
    np.testing.assert_allclose([float(number) for number in first], expected, atol=6e-4)


def test_rotary_words(capsys):
    """Reversed comes before what is rarer; inches; travel is said although the angles are right."""
    found = explain_joints(BC, ("0.3", "0", "0.953939"), ("-17.4576", "0"))
    assert found.misreadings[0].sentence == "the sign of B is reversed"
    assert "try the tool axis" in found.note
    angles = BC.inverse([0, 0, 0], [0.3, 0.2, 0.9327379053], degrees=True)[0, 3:]
    found = explain_joints(BC, [0.3, 0.2, 0.9327379053], (angles / [25.4, 1]).round(4))
    assert found.misreadings[0].kinds == ("inch",) and "25.4" in found.misreadings[0].sentence
    found = explain_joints(BC, [0.3, 0.2, 0.9327379053], (angles * 25.4).round(4))
    assert found.misreadings[0].kinds == ("inch",) and "B and C" in found.misreadings[0].sentence
    assert main("explain --machine bc_table --axis .70710678 0 .70710678 --result -45 180".split()) == 1
    assert "B -45 is outside -35 … 110" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "status", "text"),
    [
        ("--machine bc_table --axis .6 0 .8", 2, "--result"),
        ("--machine bc_table --joints 1 0 2 40 30 --result -67.2504 -38.8270 -25.8998", 1, "B turns the other way"),
        (
            "--machine head_b_table_c --tip 0 0 0 --rotary 0 90 --result 180.0 0 -180.0",
            1,
            "not turned with the head",
        ),
        ("--machine ac_head --tip 0 0 0 --axis 0 0 1 --result 0 0 350 0 0", 0, "right"),
        ("--machine bc_table --joints 1 0 2 40 --result 1 2 3", 2, "shape"),
        ("--machine bc_table --tip 1 0 2 --axis 0 0 1 --result 1 2 3", 2, "all words"),
        ("--machine bc_table --joints 1 0 2 40 30 --joints 0 0 0 0 0 --result 1 2 3", 2, "--result"),
        ("--machine bc_table", 2, "--axis"),
    ],
)
def test_the_shell(arguments, status, text, capsys):
    assert main(["explain", *arguments.split()]) == status
    said = capsys.readouterr()
    assert text in said.out + said.err


def test_shapes_are_checked():
    with pytest.raises(InputError, match="shape"):
        explain_tip(BC, JOINTS, [1, 2])
    with pytest.raises(InputError, match="shape"):
        explain_linear(BC, [1, 2, 3], [[1, 2]], [1, 2, 3])


def _reversed(words):
    return words * [-1, -1, 1]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda words: np.add(words, (0, 0, 220)), "a constant is added: +220 in Z"),
        (lambda words: np.add(words, (5.5, 0, -3)), "a constant is added: +5.5 in X, -3 in Z"),
        (_reversed, "the slides X and Y are counted the other way"),
        (
            lambda words: np.add(_reversed(words), (0, 0, 220)),
            "the slides X and Y are counted the other way and a constant",
        ),
        (lambda words: words[:, [1, 2, 0]], "in a cycle: Y Z X"),
    ],
)
def test_constants_reversed_slides_and_cycles_of_a_table(change, said):
    """Five rows of a trunnion's words, by `trunnion`'s inverse: turned by hand, no chain of the package."""
    rng = np.random.default_rng(57)
    words, angles = rng.uniform(-60, 60, (5, 3)).round(4), rng.uniform(-30, 80, (5, 2)).round(4)
    tips = np.array([trunnion(*row)[:3] for row in np.c_[words, angles]])
    found = explain_linear(BC, tips, angles, change(words), decimals=4)
    assert said in found.misreadings[0].sentence
    assert not explain_linear(BC, tips[:1], angles[:1], np.add(words[:1], (0, 0, 220.37)), decimals=4).explained


def test_a_jump_of_atan2_is_right():
    """Around the pole of a trunnion at 30°: by atan2 C goes from 170 to −150."""
    turn = np.array([150, 170, -150, -130])
    axes = [about("Z", angle).apply(about("Y", 30).apply([0, 0, 1])) for angle in turn]
    angles = np.column_stack([np.full(4, 30.0), turn])
    found = explain_joints(BC, np.round(axes, 9), angles, decimals=1)
    assert found.right, str(found)
    assert "C jumps by -320° from row 2 to row 3: the way is +40°" in found.note

"""Machine files: what is read, and what is refused with the file, the key, what was expected and what was found."""

import copy
import math

import pytest

from mathpost import load_machine, machine_file
from mathpost.errors import InputError
from mathpost.machine import ENDLESS
from tests.conftest import DATA, MACHINE_FILES
from tests.machines import SIDES, content

GOOD = content((1, 0, 0), (0, 0, 1))


def test_every_file_states_its_source():
    assert len(MACHINE_FILES) >= 6
    for path in MACHINE_FILES:
        assert load_machine(path).source


def test_units_are_converted_once():
    dmu = load_machine(DATA / "machines/dmu50v.toml")
    assert dmu.rotary[0].limits == (0, math.pi)
    assert dmu.rotary[0].max_rate == pytest.approx(math.radians(36))
    assert dmu.max_accelerations == pytest.approx([2000, 2000, 2000, math.radians(200), math.radians(200)])
    assert dmu.rotary[1].limits == ENDLESS
    assert dmu.linear[0].limits == (-250, 250)
    assert dmu.limits.shape == (5, 2)


@pytest.mark.parametrize("sides", SIDES)
def test_arrangements(sides):
    arrangement = machine_file.from_dict(content((1, 0, 0), (0, 1, 0), sides, tool=(0, 0, 1))).arrangement
    assert arrangement == {0: "table-table", 1: "head-table", 2: "head-head"}[sides.count("tool")]


def edit(path, value):
    """GOOD with the value at `path` replaced, or left out if it is None."""
    data = copy.deepcopy(GOOD)
    *parents, key = path
    place = data
    for parent in parents:
        place = place[parent]
    if value is None:
        del place[key]
    else:
        place[key] = value
    return data


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (["name"], None, ["'name'", "nothing"]),
        (["source"], None, ["'source'"]),
        (["rotary"], [], ["one or two rotary axes", "0"]),
        (["rotary"], GOOD["rotary"] * 2, ["one or two rotary axes", "4"]),
        (["rotary"], None, ["'rotary'", "one or two"]),
        (["rotary"], "B", ["'rotary'", "'B'"]),
        (["rotary", 0, "name"], "X", ["'name'", "'X'"]),
        (["rotary", 1, "name"], "A", ["twice"]),
        (["rotary", 0, "carries"], "table", ["'carries'", '"workpiece" or "tool"', "'table'"]),
        (["rotary", 0, "carries"], "tool", ["workpiece side before the tool side"]),
        (["rotary", 0, "axis"], [0, 0, 0], ["'axis'", "not all zero"]),
        (["rotary", 0, "axis"], [1, 0], ["'axis'", "[1, 0]"]),
        (["rotary", 0, "axis"], [0, 0, -2], ["not parallel"]),
        (["rotary", 0, "axis"], [1, 0, math.nan], ["'axis'", "nan"]),
        (["rotary", 0, "point"], [1, "2", 3], ["'point'", "'2'"]),
        (["rotary", 0, "limits"], [10, -10], ["'limits'", "[10, -10]"]),
        (["rotary", 0, "limits"], 90, ["'limits'", "90"]),
        (["rotary", 0, "max_rate"], 0, ["'max_rate'", "above 0"]),
        (["rotary", 1, "max_acceleration"], -1, ["'max_acceleration'", "above 0"]),
        (["linear"], {"X": {"max_acceleration": "2"}}, ["'max_acceleration'", "mm per second squared"]),
        (["rotary", 0, "offset"], 1, ["'offset'", "no such key"]),
        (["workpiece"], None, ["[workpiece]"]),
        (["workpiece", "origin"], True, ["'origin'", "True"]),
        (["tool", "length"], -1, ["'length'", "-1"]),
        (["tool", "length"], "long", ["'length'", "'long'"]),
        (["tool", "axis"], [1, 0, 0], ["cannot tilt the tool"]),
        (["tool", "programmed_point"], "pivot", ["'programmed_point'", "'pivot'"]),
        (["linear"], {"X": {"limits": [1]}}, ["[linear], [X]", "'limits'"]),
        (["linear"], {"X": {"carries": "bed"}}, ["[linear], [X]", "'carries'"]),
        (["linear"], {"U": {}}, ["[linear]", "'U'", "no such key"]),
        (["colour"], "red", ["'colour'", "no such key"]),
    ],
)
def test_wrong_files_are_refused(path, value, words):
    with pytest.raises(InputError) as caught:
        machine_file.from_dict(edit(path, value), "file.toml")
    message = str(caught.value)
    assert message.startswith("file.toml")
    assert "expected" in message and "found" in message
    for word in words:
        assert word in message


def test_the_slides_stand_in_the_order_of_the_file():
    slides = {"Y": {"carries": "workpiece"}, "Z": {}, "X": {"carries": "workpiece"}}
    made = machine_file.from_dict(edit(["linear"], slides))
    assert made.slides_that_carry("workpiece") == ("Y", "X") and made.slides_that_carry("tool") == ("Z",)
    assert made.joint_names[:3] == ("X", "Y", "Z")
    assert machine_file.from_dict(edit(["linear"], {"Z": {}})).slide_order == ("Z", "X", "Y")


def test_unreadable_files_are_refused(tmp_path):
    path = tmp_path / "m.toml"
    for bytes_, words in ((b"name = ", "TOML"), (b"name = '\xff'", "line 1")):
        path.write_bytes(bytes_)
        with pytest.raises(InputError, match=words):
            load_machine(path)
    with pytest.raises(InputError, match="readable"):
        load_machine(tmp_path / "none.toml")


@pytest.mark.parametrize("change", [{"tool_length": -1}, {"tool_length": math.nan}, {"origin": [1, 2]}])
def test_setup_is_checked(change):
    with pytest.raises(InputError):
        machine_file.from_dict(GOOD).with_setup(**change)

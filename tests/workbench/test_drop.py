"""Files in pieces, as a browser sends them: what arrives, what is refused before anything is sent, what is lost."""

import random

import pytest

from mathpost.errors import InputError
from mathpost.workbench.drop import LARGEST, MOST, TOGETHER, Drop


@pytest.fixture
def drop():
    """A zone for several files, its answers in `drop.answers`."""
    made = Drop("path", several=True)
    made.answers = []
    made.send = made.answers.append
    return made


def asked(drop, **content):
    """The answer to a message of the browser; a `piece` goes beside it."""
    piece = content.pop("piece", None)
    drop._handle_custom_msg({"id": "7", **content}, [] if piece is None else [memoryview(piece)])
    answer = drop.answers.pop()
    assert answer.pop("id") == "7" and not drop.answers
    return answer


def sent(drop, files):
    """Send whole files, each in one piece; return their names."""
    names = drop.offer([(name, len(content)) for name, content in files])
    for name, (_, content) in zip(names, files, strict=True):
        if name:
            assert drop.piece(name, 0, content) == len(content)
    return names


@pytest.mark.parametrize("seed", range(5))
def test_pieces_that_are_lost_come_twice_or_out_of_order_make_the_file(drop, seed):
    """The sender of drop.js on a bad line: it goes on from what an answer says, and repeats what has none."""
    line = random.Random(seed)
    content = line.randbytes(1000)
    assert asked(drop, offer=[["a.bin", 1000]]) == {"names": ["a.bin"]}
    early = asked(drop, name="a.bin", start=500, piece=content[500:700])
    assert early == {"have": 0}, "out of order: passed over"
    have = 0
    while have < 1000:
        piece = {"name": "a.bin", "start": have, "piece": content[have : have + 90]}
        if line.random() < 0.7:  # the message arrives
            answers = [asked(drop, **piece) for _ in range(line.choice((1, 1, 2)))]  # once or twice
            assert answers == [{"have": min(have + 90, 1000)}] * len(answers)
            if line.random() < 0.7:  # and so does its answer
                have = answers[0]["have"]
    assert drop.whole() == {"a.bin": content} and drop.held == [["a.bin", 1000]]


@pytest.mark.parametrize(
    ("files", "found"),
    [
        ([["a.cl", LARGEST + 1]], "100.0 MB"),
        ([[f"{n}.cl", LARGEST] for n in range(3)], "4 files, 300.0 MB"),
        ([[f"{n}.cl", 1] for n in range(MOST + 1)], "more than 500 files"),
    ],
)
def test_too_much_is_refused_in_one_sentence_and_nothing_is_expected(drop, files, found):
    sent(drop, [("kept.cl", b"1")])
    refused = asked(drop, offer=files)["refused"]
    assert "expected at most 100 MB a file, 200 MB and 500 files together" in refused and refused.endswith(found)
    assert "\n" not in refused and drop.whole() == {"kept.cl": b"1"}
    assert "a.cl: expected a file that was offered" in asked(drop, name="a.cl", start=0, piece=b"1")["refused"]


def test_what_is_held_counts_towards_the_bound(drop):
    drop.put({"held.cl": bytes(2)})
    assert drop.offer([("a.cl", LARGEST), ("b.cl", TOGETHER - LARGEST - 2)]) == ["a.cl", "b.cl"]
    with pytest.raises(InputError, match="200 MB and 500 files together, found 3 files"):
        drop.offer([("a.cl", LARGEST), ("b.cl", TOGETHER - LARGEST - 1)])
    assert drop.offer([("held.cl", 5)]) == ["held.cl"], "one that is replaced does not"


def test_more_than_was_offered_is_refused(drop):
    drop.offer([("a.cl", 3)])
    with pytest.raises(InputError, match=r"a\.cl: expected 3 bytes, found more: it has changed"):
        drop.piece("a.cl", 0, b"1234")
    assert drop.files == {}


@pytest.mark.parametrize(
    ("name", "inside"),
    [
        ("../../evil.cl", "evil.cl"),
        ("/etc/passwd", "etc/passwd"),
        ("..\\..\\C:\\evil.cl", "C_/evil.cl"),
        ("class/./anna/../task.xlsx", "class/anna/task.xlsx"),
        ("a\nb\x00.cl", "a_b_.cl"),
        ("刀位.cl", "刀位.cl"),
        (" .. /...", "file"),
        ("", "file"),
    ],
)
def test_a_name_stays_inside_its_folder(drop, tmp_path, name, inside):
    assert sent(drop, [(name, b"1")]) == [inside]
    assert (tmp_path / inside).resolve().is_relative_to(tmp_path) and list(drop.files) == [inside]


def test_two_of_one_name_are_both_there_and_one_that_comes_later_replaces_the_first(drop):
    assert sent(drop, [("t.xlsx", b"1"), ("t.xlsx", b"2"), ("a/../t.xlsx", b"3")]) == [
        "t.xlsx", "t (2).xlsx", "a/t.xlsx",
    ]  # fmt: skip
    before = drop.changes
    sent(drop, [("t.xlsx", b"9")])
    assert drop.files == {"t.xlsx": b"9", "t (2).xlsx": b"2", "a/t.xlsx": b"3"} and drop.changes > before


def test_an_empty_file_arrives(drop):
    sent(drop, [("empty.cl", b"")])
    assert drop.whole() == {"empty.cl": b""} and drop.held == [["empty.cl", 0]]


def test_what_systems_leave_in_a_folder_is_passed_over(drop):
    files = [("c/.DS_Store", b"1"), ("c/~$a.xlsx", b"2"), ("__MACOSX/c/a.xlsx", b"3"), ("c/a.xlsx", b"4")]
    assert sent(drop, files) == ["", "", "", "c/a.xlsx"]
    assert sent(drop, [(".mine.cl", b"5")]) == [".mine.cl"], "chosen by itself"


def test_stopped_half_way_what_came_is_there_and_nothing_else_is_expected(drop):
    drop.offer([("a.cl", 1), ("b.cl", 10), ("c.cl", 1)])
    drop.piece("a.cl", 0, b"1")
    drop.piece("b.cl", 0, b"12345")
    with pytest.raises(InputError, match=r"b\.cl: expected a file that has arrived"):
        drop.whole()
    assert asked(drop, offer=[]) == {"names": []}
    assert drop.whole() == {"a.cl": b"1"}
    assert asked(drop, remove=["a.cl", "none.cl"]) == {} and drop.whole() == {} == dict(drop.held)


def test_a_zone_for_one_file_keeps_it_until_the_next_is_whole():
    drop = Drop("cl", several=False)
    sent(drop, [("a.cl", b"1")])
    with pytest.raises(InputError, match="cl: expected one file, found 2"):
        drop.offer([("b.cl", 1), ("c.cl", 1)])
    drop.offer([("b.cl", 2)])
    drop.piece("b.cl", 0, b"1")
    assert drop.files == {"a.cl": b"1"}
    drop.piece("b.cl", 1, b"2")
    assert drop.files == {"b.cl": b"12"}


def test_its_state_holds_no_content(drop):
    """Nothing of a file is in what a notebook could save."""
    drop.put({"a.cl": b"secret"})
    assert "secret" not in str(drop.get_state()) and drop.get_state()["held"] == [["a.cl", 6]]

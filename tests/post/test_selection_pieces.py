"""Selection over a path in pieces, and in blocks: the same as over the whole, and as a plain recursion finds."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mathpost.errors import InputError, ReachError
from mathpost.post import candidates as candidates_module
from mathpost.post import cl as cldata
from mathpost.post import selection
from tests.post.test_selection import limited, turning

KINDS = {
    "endless table": lambda: limited("ac_table"),
    "table that ends": lambda: limited("ac_table", outer=(-200, 200)),
    "table with windings": lambda: limited("dmu50v", outer=(-400, 380), inner=(-170, 190)),
    "head with windings": lambda: limited("ac_head", outer=(-360, 360)),
    "head without rates": lambda: limited("nutating_head", rates=False),
    "narrow head and table": lambda: limited("nutating_head_table", outer=(-100, 190), inner=(-120, 181)),
}
MACHINES = {name: make() for name, make in KINDS.items()}
seeds = st.integers(0, 2**32 - 1)


def random_path(kin, rng):
    """A path with steps of any size, often close to the pole, with rapid moves, and runs of records at the pole."""
    count, derived = int(rng.integers(1, 13)), kin.inverse_symbolic
    joints = np.cumsum(rng.normal(size=(count, 5)) * [5, 5, 5, *[rng.choice([0.02, 0.1, 0.5, 1.5])] * 2], axis=0)
    if rng.random() < 0.3:
        inner = float(sum(derived.solutions) / 2) + rng.normal(size=count) * 0.05
        joints[:, kin.symbols.index(derived.inner)] = inner
    cl = cldata.from_arrays(*kin.forward(joints))
    axes, rapid = cl.axes.copy(), rng.random(count) < rng.choice([0, 0.3])
    if kin.reach[0] == 0 and rng.random() < 0.6:
        for first, last in np.sort(rng.integers(0, count + 1, (2, 2))):
            axes[first:last] = np.array(derived.pole, float)
    return replace(cl, axes=axes, rapid=rapid)


def options(rng):
    return {
        "weights": rng.choice([None, "some"]) and rng.integers(0, 5, 5),
        "start": rng.choice([None, "some"]) and rng.uniform(-1, 1, 5),
        "prefer": rng.choice([None, 1, -1]),
        "sway": rng.choice([0.01, selection.SWAY, np.inf]),
    }


def cut(cl, places):
    """The path in pieces, cut before the records `places`."""
    return [cl.part(int(start), int(stop)) for start, stop in pairwise([0, *places, len(cl)])]


def anywhere(cl, rng):
    """Any places to cut a path at, now and then all of them."""
    inner = np.arange(1, len(cl))
    return inner[rng.random(len(inner)) < rng.choice([0.2, 0.5, 1.0])].tolist()


def together(chosen, pieces):
    """The selections of pieces as one."""
    starts = np.cumsum([0] + [len(piece) for piece in pieces])
    breaks = [int(first) + at for first, part in zip(starts[:-1], chosen, strict=True) for at in part.breaks]
    joints, branch = (np.concatenate([getattr(part, name) for part in chosen]) for name in ("joints", "branch"))
    return selection.Selection(joints, branch, sum(part.cost for part in chosen), tuple(breaks), chosen[0].strategy)


def outcome(choose):
    """What a choice gives, or what its error says."""
    try:
        return choose()
    except (ReachError, InputError) as error:
        return str(error)


def assert_same(found, expected):
    if isinstance(expected, str):
        assert found == expected
    else:
        np.testing.assert_allclose(found.joints, expected.joints, atol=1e-12)
        np.testing.assert_array_equal(found.branch, expected.branch)
        assert found.breaks == expected.breaks
        assert found.cost == pytest.approx(expected.cost, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("strategy", selection.STRATEGIES)
@pytest.mark.parametrize("name", MACHINES)
@settings(max_examples=50, deadline=None)
@given(seed=seeds)
def test_any_cut_gives_the_same_choice(name, strategy, seed):
    kin, rng = MACHINES[name], np.random.default_rng(seed)
    cl, chosen_by = random_path(kin, rng), options(rng) | {"split": bool(rng.random() < 0.8)}
    pieces = cut(cl, anywhere(cl, rng))
    whole = outcome(lambda: selection.choose(kin, cl, strategy, **chosen_by))
    parts = outcome(lambda: together([*selection.choose_pieces(kin, pieces, strategy, **chosen_by)], pieces))
    assert_same(parts, whole)


@settings(max_examples=100, deadline=None)
@given(seed=seeds, name=st.sampled_from(list(MACHINES)), strategy=st.sampled_from(["optimal", "shortest"]))
def test_the_size_of_blocks_does_not_matter(name, strategy, seed):
    kin, rng = MACHINES[name], np.random.default_rng(seed)
    cl, chosen_by = random_path(kin, rng), options(rng) | {"split": True}
    whole = outcome(lambda: selection.choose(kin, cl, strategy, **chosen_by))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(candidates_module, "BLOCK", int(rng.integers(1, 6)))
        patch.setattr(selection, "MOVES", int(rng.integers(1, 40)))
        patch.setattr(selection, "LEAST_RECORDS", 1)
        assert_same(outcome(lambda: selection.choose(kin, cl, strategy, **chosen_by)), whole)


def matrices(kin, cl, found, weights, sway):
    """Breaks and costs of all moves of a path, shape (n − 1, m, m), by the forward kinematics of three places."""
    joints = np.nan_to_num(found.joints)
    start = joints[:-1, :, None]
    steps = selection.short_way(kin.machine, joints[1:, None] - start)
    before, middle, after = (kin.forward(start + part * steps)[1] for part in (0, 0.5, 1))
    swing = np.linalg.norm(middle - (before + after) / 2, axis=-1)
    turned = np.abs(steps[..., 3:])
    over = swing > sway + np.linalg.norm(after - before, axis=-1) / 2
    over = (over & (turned.sum(axis=-1) > sway)) | (turned > selection.HALF_TURN).any(axis=-1)
    travel = np.abs(steps) @ [1, 1, 1, np.degrees(1), np.degrees(1)]
    return over & ~cl.rapid[1:, None, None], selection.move_costs(kin.machine, steps, weights) + 1e-9 * travel


def plain(over, costs, first, inside):
    """Least (breaks, cost) from the first record to each candidate, one by one, and from each to the last."""
    far = (np.inf, np.inf)
    to = [[(0, cost) if here else far for cost, here in zip(first, inside[0], strict=True)]]
    for record in range(1, len(inside)):
        ways = [
            [
                (to[-1][i][0] + over[record - 1, i, j], to[-1][i][1] + costs[record - 1, i, j])
                for i in range(len(first))
            ]
            for j in range(len(first))
        ]
        to.append([min(way) if inside[record, j] else far for j, way in enumerate(ways)])
    rest = [[(0, 0.0) if here else far for here in inside[-1]]]
    for record in range(len(inside) - 1, 0, -1):
        ways = [
            [
                (rest[0][j][0] + over[record - 1, i, j], rest[0][j][1] + costs[record - 1, i, j])
                for j in range(len(first))
            ]
            for i in range(len(first))
        ]
        rest.insert(0, [min(way) if inside[record - 1, i] else far for i, way in enumerate(ways)])
    return np.array(to), np.array(rest)


@pytest.mark.parametrize("name", MACHINES)
def test_optimal_is_what_a_plain_recursion_finds(name):
    """The fewest breaks, then the least cost; and the very candidates, where no others are as good."""
    kin, rng, compared = MACHINES[name], np.random.default_rng(3), 0
    for _ in range(100):
        cl, chosen_by = random_path(kin, rng), options(rng)
        chosen_by["start"] = rng.uniform(-1, 1, 5)
        found = selection.candidates(kin, cl.points, cl.axes)
        if not found.inside.any(axis=1).all():
            continue
        over, costs = matrices(kin, cl, found, chosen_by["weights"], chosen_by["sway"])
        steps = selection.short_way(kin.machine, found.joints[0] - chosen_by["start"])
        to, rest = plain(over, costs, selection.move_costs(kin.machine, steps, chosen_by["weights"]), found.inside)
        through = to + rest
        breaks, cost = min(map(tuple, through[-1]))
        chosen = selection.choose(kin, cl, **chosen_by, split=True)
        assert len(chosen.breaks) == breaks
        assert chosen.cost == pytest.approx(cost, rel=1e-6, abs=1e-5)
        best = (through[..., 0] == breaks) & (through[..., 1] < cost + 1e-8)
        for record in np.flatnonzero(best.sum(axis=1) == 1):
            turns = (chosen.joints[record] - found.joints[record, best[record].argmax()]) / selection.TURN
            endless = ~np.isfinite(kin.machine.limits).all(axis=1) & (np.arange(5) > 2)
            np.testing.assert_allclose(np.where(endless, turns - np.round(turns), turns), 0, atol=1e-9)
            compared += 1
    assert compared > 100


def test_many_windings():
    """More candidates than a byte counts."""
    kin, cl = limited("ac_table", outer=(-15000, 15000)), turning(3, count=100)
    chosen = selection.choose(kin, cl)
    assert (selection.candidates(kin, cl.points, cl.axes).inside.sum(axis=1) > 127).all()
    assert np.degrees(np.ptp(chosen.joints[:, 4])) == pytest.approx(1080)
    assert chosen.breaks == ()
    pieces = cut(cl, [1, 50, 51])
    assert_same(together([*selection.choose_pieces(kin, pieces)], pieces), chosen)


@pytest.mark.parametrize("beside", [-1, 0, 1])
def test_a_break_at_the_border_of_pieces(beside):
    kin, cl = limited("ac_table", outer=(-360, 360)), turning(3, count=61)
    (at,) = selection.choose(kin, cl, split=True).breaks
    first, second = selection.choose_pieces(kin, cut(cl, [at + beside]), split=True)
    assert (first.breaks, second.breaks) == (((), (-beside,)) if beside <= 0 else ((at,), ()))
    with pytest.raises(ReachError) as error:
        next(selection.choose_pieces(kin, cut(cl, [36 + beside])))
    with pytest.raises(ReachError) as expected:
        selection.choose(kin, cl)
    assert str(error.value) == str(expected.value)
    assert "line 37, record 37" in str(error.value)


def test_costs_are_not_lost_beside_breaks():
    """After many breaks a tiny difference of cost still decides."""
    kin = limited("ac_table", outer=(-100, 260), inner=(-50, 50))
    cl = turning(200, count=3000)
    chosen = selection.choose(kin, cl, split=True)
    found = selection.candidates(kin, cl.points, cl.axes)
    over, costs = matrices(kin, cl, found, None, selection.SWAY)

    def beginning(branch, joints):
        return 1e-6 * (branch != 0) + 1e-9 * np.degrees(np.abs(joints[..., 3:])).sum(axis=-1)

    to, _ = plain(over, costs, beginning(found.branch, found.joints[0]), found.inside)
    breaks, cost = min(map(tuple, to[-1]))
    assert len(chosen.breaks) == breaks > 100
    travel = np.abs(np.diff(chosen.joints, axis=0)).sum(axis=0) @ [1, 1, 1, np.degrees(1), np.degrees(1)]
    first = beginning(chosen.branch[0], chosen.joints[0])
    assert first + chosen.cost + 1e-9 * travel == pytest.approx(cost, abs=1e-8)


def test_a_tool_that_never_leaves_the_pole():
    """A three-axis path, whole or in pieces, keeps the outer axis still; pieces may lie at the pole altogether."""
    kin = limited("ac_table", outer=(-360, 360))
    points = np.random.default_rng(5).normal(size=(30, 3)) * 40
    still = cldata.from_arrays(points, np.tile([0.0, 0, 1], (30, 1)))
    pieces = cut(still, [1, 2, 15])
    assert_same(together([*selection.choose_pieces(kin, pieces)], pieces), selection.choose(kin, still))
    axes = still.axes.copy()
    axes[[3, 27]] = np.array([[0.3, 0.4, 1], [-0.4, 0.3, 1]]) / np.sqrt(1.25)
    leaning = replace(still, axes=axes)
    for places in ([4], [4, 5, 10, 20], [10, 27], [3, 28], list(range(1, 30))):
        pieces = cut(leaning, places)
        assert_same(together([*selection.choose_pieces(kin, pieces)], pieces), selection.choose(kin, leaning))


class Watched:
    """A sequence that has only a length and places, and counts what is taken from it."""

    def __init__(self, items):
        self.items, self.taken = list(items), []

    def __len__(self):
        return len(self.items)

    def __getitem__(self, place):
        assert 0 <= place < len(self.items)
        self.taken.append(place)
        return self.items[place]


class Spool(Watched):
    """A store that keeps bytes, as a file would."""

    def append(self, array):
        self.items.append((array.dtype, array.shape, array.tobytes()))

    def __getitem__(self, place):
        dtype, shape, content = super().__getitem__(place)
        return np.frombuffer(content, dtype).reshape(shape)


@pytest.mark.parametrize("strategy", ["optimal", "shortest"])
def test_little_is_kept_and_pieces_are_taken_in_turn(strategy):
    kin, cl, done, store = limited("ac_table"), turning(2, count=100), [], Spool([])
    pieces = Watched(cut(cl, [30, 60, 90]))
    chosen = selection.choose_pieces(kin, pieces, strategy, store=store, progress=done.append)
    first = next(chosen)
    assert done == [30, 60, 90, 100]
    assert pieces.taken == [0, 1, 2, 3, 0]
    assert sum(len(content) for _, _, content in store.items) == 2 * len(cl)
    assert_same(together([first, *chosen], pieces.items), selection.choose(kin, cl, strategy))
    assert pieces.taken == [0, 1, 2, 3, 0, 1, 2, 3]


def test_paper_tells_its_progress(dmu50v, blade):
    done = []
    assert len([*selection.choose_pieces(dmu50v, cut(blade, [2]), "paper", progress=done.append)]) == 2
    assert done == [2, 5]


def test_an_unreachable_record_counts_before_a_break():
    """Wherever it stands: the first pass looks at all records."""
    kin = limited("ac_table", outer=(-360, 360), inner=(-50, 50))
    cl = turning(3, count=61)
    axes = cl.axes.copy()
    axes[60] = [1, 0, 0]
    for places in ([], [30], [60]):
        with pytest.raises(ReachError, match="line 61, record 61: no solution inside travel"):
            next(selection.choose_pieces(kin, cut(replace(cl, axes=axes), places)))


def test_a_wrong_strategy_is_refused_at_once(dmu50v, blade):
    with pytest.raises(InputError, match="'best'"):
        selection.choose_pieces(dmu50v, [blade], "best")

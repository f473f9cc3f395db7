"""The cheapest parts of a chain are those that it was drawn with."""

from __future__ import annotations

import numpy as np
from chain_pictures import line, quarter, rounded_rectangle, split

from warpvec.flat.chains import choice
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.choice import Part, chosen_parts
from warpvec.flat.chains.parts import ARC, CUBIC, LINE
from warpvec.flat.chains.sketch import parted
from warpvec.flat.price import number_nats

NATS = number_nats(512)


def kinds_and_places(chain: Chain, parts: list[Part]) -> list[tuple[int, list[float]]]:
    return [(part.kind, chain.points[part.first].tolist()) for part in parts]


def test_halves_of_curves_become_the_lines_and_arcs_that_they_follow():
    curves = rounded_rectangle(40, 30, 200, 120, (40, 40, 40, 40))
    halves = np.concatenate([split(curve, 0.4) for curve in curves])

    chain, parts = parted(Chain.of(halves, is_closed=True), 0.05, NATS)

    assert sorted(part.kind for part in parts) == [LINE] * 4 + [ARC] * 4
    nodes = {tuple(np.round(curve[0]).astype(int).tolist()) for curve in curves}
    assert all(min(np.hypot(*(place - np.array(node))) for node in nodes) < 4.0
               for _, place in kinds_and_places(chain, parts))  # fmt: skip


def test_a_curve_that_turns_unevenly_stays_a_cubic():
    spiral = np.array([[[20.0, 100.0], [20.0, 20.0], [60.0, 20.0], [180.0, 60.0]]])
    parts = chosen_parts(Chain.of(spiral, is_closed=False), 0.05, NATS)
    assert [part.kind for part in parts] == [CUBIC]


def test_one_cubic_takes_the_place_of_two_that_follow_one():
    spiral = np.array([[20.0, 100.0], [20.0, 20.0], [60.0, 20.0], [180.0, 60.0]])
    parts = chosen_parts(Chain.of(split(spiral, 0.3), is_closed=False), 0.05, NATS)
    assert [part.kind for part in parts] == [CUBIC]


def test_a_corner_is_kept_and_a_hairpin_is_two_lines():
    bent = np.concatenate([line((10, 10), (90, 10)), line((90, 10), (50, 80))])
    back = np.concatenate([line((10, 10), (90, 10)), line((90, 10), (20, 10))])
    for curves in (bent, back):
        parts = chosen_parts(Chain.of(curves, is_closed=False), 0.05, NATS)
        assert [part.kind for part in parts] == [LINE, LINE]


def test_a_whole_circle_is_more_than_one_arc():
    places = [(60, 20), (100, 20), (100, 60), (100, 100), (60, 100), (20, 100), (20, 60), (20, 20), (60, 20)]
    curves = np.concatenate([quarter(*places[k : k + 3]) for k in range(0, 8, 2)])
    _, parts = parted(Chain.of(curves, is_closed=True), 0.05, NATS)
    assert len(parts) > 1 and all(part.kind == ARC for part in parts)


def test_firm_boxes_forbid_what_is_near_enough_elsewhere():
    flat = quarter((20, 60), (60, 57), (100, 60)) + np.array([0.0, 0.0])
    chain = Chain.of(flat, is_closed=False)
    assert [part.kind for part in chosen_parts(chain, 1.0, NATS)] == [LINE]
    firm = chain.firmer_in(np.array([[[0.0, 0.0], [200.0, 200.0]]] * 4))
    assert [part.kind for part in chosen_parts(firm, 1.0, NATS)] != [LINE]


def test_parts_that_are_never_priced_are_never_the_cheapest(monkeypatch):
    rough = rounded_rectangle(40, 30, 200, 120, (40, 10, 0, 40))
    rough = rough + np.random.default_rng(0).normal(0.0, 0.3, rough.shape)
    rough[:, 0] = np.roll(rough[:, 3], 1, axis=0)
    chain = Chain.of(rough, is_closed=False)
    few = {spread: chosen_parts(chain, spread, NATS) for spread in (0.02, 0.1, 0.5)}

    monkeypatch.setattr(choice, "ROUNDING", np.inf)

    for spread, parts in few.items():
        assert [part[:3] for part in chosen_parts(chain, spread, NATS)] == [part[:3] for part in parts]


def test_a_long_side_does_not_let_all_points_of_many_curves_look_far():
    places = np.stack([np.linspace(0.0, 40.0, 3001), np.zeros(3001)], 1)
    curves = np.concatenate([[places[k : k + 2]] for k in range(3000)])
    tiny = np.stack([curves[:, 0], curves[:, 0], curves[:, 1], curves[:, 1]], 1)
    chain = Chain.of(np.concatenate([line((-5000.0, 0.0), (0.0, 0.0)), tiny]), is_closed=False)

    first, last = choice._pairs(chain)

    assert len(first) <= 2 * choice.PAIRS_MAX
    assert (np.diff(first) >= 0).all() and (last > first).all()
    whole = np.flatnonzero(np.diff(chain.curve, prepend=-1))
    assert {*zip(whole[:-1].tolist(), whole[1:].tolist(), strict=True)} <= {
        *zip(first.tolist(), last.tolist(), strict=True)
    }

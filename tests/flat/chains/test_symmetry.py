"""Half of what is symmetric is solved, and the other half is its exact mirror image."""

from __future__ import annotations

import numpy as np
from chain_pictures import line, quarter, rounded_rectangle

from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.folded import hold_folds, image_of, unfolded
from warpvec.flat.chains.parts import ARC, CUBIC, LINE
from warpvec.flat.chains.sketch import parted, sketch_of
from warpvec.flat.chains.solve import solved
from warpvec.flat.chains.symmetry import folds_of
from warpvec.flat.price import number_nats

NONE = np.zeros((0, 2))


def house() -> np.ndarray:
    """A gable above two walls with feet, symmetric about x = 60; its crossings are a corner and a level line."""
    return np.concatenate([
        line((60, 20), (100, 50)), line((100, 50), (100, 80)), quarter((100, 80), (100, 90), (90, 90)),
        line((90, 90), (30, 90)), quarter((30, 90), (20, 90), (20, 80)), line((20, 80), (20, 50)),
        line((20, 50), (60, 20)),
    ])  # fmt: skip


def test_both_halves_are_exact_images_and_a_line_over_the_axis_is_one():
    rough = house()
    rough[1, 3, 0] += 0.06
    rough[2, 0, 0] += 0.06
    folds = folds_of({0: Chain.of(rough, is_closed=True)}, NONE, 0.1)
    fold = folds[0][0]
    sketch = sketch_of([parted(fold.chain, 0.1, number_nats(128))], 0.1)
    hold_folds(sketch, {0: fold}, 0.1, (64.0, 64.0))
    solved(sketch)

    words = unfolded(sketch, 0, fold)

    assert sorted(kind for kind, _ in words) == [LINE] * 5 + [ARC] * 2
    nodes = {tuple(np.round(numbers[:2], 6).tolist()) for _, numbers in words}
    assert {(round(2 * sketch.numbers[sketch.axes[0]] - x, 6), y) for x, y in nodes} == nodes
    ends = [numbers[2:4] for _, numbers in words]
    assert all(np.allclose(end, words[(k + 1) % len(words)][1][:2]) for k, end in enumerate(ends))


def test_an_axis_stays_where_lines_cross_it():
    fold = folds_of({0: Chain.of(rounded_rectangle(20, 20, 80, 40, (9, 9, 9, 9)), is_closed=True)}, NONE, 0.1)[0][0]
    sketch = sketch_of([parted(fold.chain, 0.1, number_nats(128))], 0.1)
    hold_folds(sketch, {0: fold}, 0.1, (64.0, 64.0))
    solved(sketch)
    assert abs(sketch.numbers[sketch.axes[0]] - 60.0) < 1e-4


def test_two_loops_may_be_images_of_each_other_and_a_third_spoils_it():
    left, right = line((20, 20), (30, 60)), line((100, 20), (90, 60))
    chains = {0: Chain.of(left, is_closed=False), 1: Chain.of(right, is_closed=False)}
    folds = folds_of(chains, NONE, 0.1)
    assert list(folds) == [0] and folds[0][0].twin == 1
    assert 1 not in {each[0].twin for each in folds_of(chains, np.array([[70.0, 30.0]]), 0.1).values()}


def test_what_is_not_symmetric_is_not_folded():
    other = rounded_rectangle(20, 20, 80, 40, (9, 20, 9, 12))
    assert folds_of({0: Chain.of(other, is_closed=True)}, NONE, 0.1) == {}


def test_the_image_of_an_image_is_the_same():
    numbers = np.array([10.0, 20.0, 50.0, 60.0, 10.0, 50.0, 40.0, 60.0])
    words = [(LINE, numbers[:4]), (ARC, np.append(numbers[:4], 0.3)), (CUBIC, numbers)]
    twice = image_of(image_of(words, 0, 64.0), 0, 64.0)
    assert all(a == b and np.allclose(x, y) for (a, x), (b, y) in zip(words, twice, strict=True))

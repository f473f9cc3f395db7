"""Numbers of parts are solved to those of the drawing, smooth joints and relations hold exactly."""

from __future__ import annotations

import numpy as np
from chain_pictures import line, quarter, rounded_rectangle
from sweep import sweep

from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.parts import ARC, CUBIC, LINE, drawn, radius_of, rows_of
from warpvec.flat.chains.relations import find_relations
from warpvec.flat.chains.sketch import parted, sketch_of
from warpvec.flat.chains.solve import Sketch, solved
from warpvec.flat.price import number_nats
from warpvec.flat.simplification.outline_samples import cubic_points

NATS = number_nats(512)


def sketched(curves: np.ndarray, is_closed: bool = True) -> Sketch:
    sketch = sketch_of([parted(Chain.of(curves, is_closed), 0.1, NATS)], 0.1)
    solved(sketch)
    return sketch


def radii(sketch: Sketch) -> np.ndarray:
    return np.array([abs(radius_of(sketch.of(part)[None])[0]) for part in sketch.rows_of_kind(ARC)])


@sweep(("kind", "numbers"), [
    (LINE, [10.0, 20.0, 50.0, 60.0]),
    (ARC, [10.0, 20.0, 50.0, 60.0, 0.3]), (ARC, [10.0, 20.0, 50.0, 60.0, -1.7]), (ARC, [10.0, 20.0, 50.0, 60.0, 1e-12]),
    (CUBIC, [10.0, 20.0, 50.0, 60.0, 10.0, 50.0, 40.0, 60.0]),
])  # fmt: skip
def test_rows_of_a_part_draw_what_the_solver_sees(kind, numbers):
    values = np.array(numbers)
    rows = rows_of(kind, values)
    curves = np.concatenate([rows, np.concatenate([rows[1:, :1], values[None, None, 2:4]])], 1)
    seen, _ = drawn(kind, values[None])
    points = cubic_points(curves, np.linspace(0.0, 1.0, 400)).reshape(-1, 2)
    away = np.linalg.norm(seen[0][:, None] - points, axis=2).min(1)
    assert away.max() < 0.15  # half of the distance of the points, and what a cubic is off a circle


def test_nodes_and_radii_are_found_from_a_rough_outline():
    curves = rounded_rectangle(40, 30, 200, 120, (40, 40, 40, 40))
    rough = curves + np.random.default_rng(0).normal(0.0, 0.05, curves.shape)
    rough[:, 0] = np.roll(rough[:, 3], 1, axis=0)

    sketch = sketched(rough)
    find_relations(sketch, 0.1)
    solved(sketch)

    found = radii(sketch)
    assert np.ptp(found) < 1e-3 and abs(found[0] - 40.0) < 0.1
    for part in sketch.rows_of_kind(LINE):
        start, end = sketch.of(part).reshape(2, 2)
        assert min(np.abs(end - start)) == 0.0
    for before, after in sketch.smooth.tolist():
        ways = [drawn(int(sketch.kind[part]), sketch.of(part)[None])[1][0] for part in (before, after)]
        assert abs(ways[0][1] @ ways[1][0] - 1.0) < 1e-8


def test_ends_of_an_open_line_stay():
    curves = np.concatenate([line((20, 80), (60, 80)), quarter((60, 80), (90, 80), (90, 50))])
    sketch = sketched(curves, is_closed=False)
    assert np.allclose(sketch.of(0)[:2], [20, 80], atol=0.01)
    assert np.allclose(sketch.of(len(sketch.kind) - 1)[2:4], [90, 50], atol=0.01)


def test_different_radii_and_tilted_lines_stay_so():
    curves = rounded_rectangle(40, 30, 200, 120, (40, 30, 40, 30))
    curves[..., 1] += 0.02 * curves[..., 0]

    sketch = sketched(curves)
    before = sketch.numbers.copy()
    find_relations(sketch, 0.1)
    solved(sketch)

    assert np.abs(sketch.numbers - before).max() < 0.1

"""Drawings are said as lines, arcs and cubics where the picture agrees, and stay as they are where it does not."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import torch
from chain_pictures import line, quarter, rounded_rectangle, split
from flat_drawings import BLACK, BLUE, RED, drawing, picture
from scenes import circle, rectangle, straight

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.arc_rounding import with_arcs
from warpvec.flat.chains.chains import with_chains
from warpvec.flat.simplification.critic import Critic
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import ROUND, Strokes
from warpvec.geometry.structure import Structure
from warpvec.svg.write import write_svg
from warpvec.watch.watch import Watch

CONFIG = FitConfig(threads=1)


def turned(points: torch.Tensor, degrees: float) -> torch.Tensor:
    """Return ``points`` [K, 2] turned about (32, 32)."""
    sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    matrix = torch.tensor([[cosine, sine], [-sine, cosine]], dtype=points.dtype)
    return (points - 32.0) @ matrix + 32.0


def edges(scene: Scene) -> torch.Tensor:
    """Return the vectors from each node to the next [R, 2]."""
    start = scene.segments[:, 0]
    return start[scene.structure.segment_next.long()] - start


def scene_of(curves: np.ndarray) -> Scene:
    return drawing((BLACK, [torch.from_numpy(curves[:, :3].reshape(-1, 2))]))


def regular(scene: Scene, image: torch.Tensor) -> Scene:
    return with_chains(scene, Critic(image, CONFIG), Watch())


def test_a_rough_rounded_rectangle_becomes_four_lines_and_four_arcs():
    exact = rounded_rectangle(9.3, 12.3, 44.0, 36.0, (8.0, 8.0, 8.0, 8.0))
    rough = np.concatenate([split(curve, 0.45) for curve in exact])
    found = regular(scene_of(rough), picture(scene_of(exact)))

    text = write_svg(with_arcs(round_nodes(found, 2), 2, 1.0), 64, 64)
    data = text.partition(' d="')[2].partition('"')[0]

    assert data.count("a") == 4 and data.count("c") == data.count("s") == 0
    lengths = sorted(map(float, torch.diff(found.segments[:, 0], dim=0).abs().amax(1).tolist()))
    assert abs(lengths[-1] - 28.0) < 0.1
    assert found.structure.segment_count == 8


def test_an_open_stroke_keeps_its_ends_and_gets_its_arc():
    curves = np.concatenate([line((10.2, 50.4), (30.2, 50.4)), quarter((30.2, 50.4), (50.2, 50.4), (50.2, 30.4))])
    rough = np.concatenate([split(curve, 0.3) for curve in curves])
    rows = np.concatenate([rough[:, :3], np.repeat(rough[-1:, 3:], 3, 1)])
    structure = Structure.of_loops([[len(rows)]], None, torch.tensor([True]))
    kind = torch.full((1,), ROUND, dtype=torch.int32)
    strokes = Strokes(torch.tensor([6.0]), kind, kind, torch.tensor([4.0]))
    values = (torch.zeros(1, 3), torch.ones(1), torch.ones(3), torch.zeros(1, dtype=torch.int64))
    scene = Scene(torch.from_numpy(rows).float(), structure, *values, strokes=strokes)

    found = regular(scene, picture(scene))

    assert found.structure.lines.tolist() == [True, False, True]  # the last row is the end
    assert torch.allclose(found.segments[[0, -1], 0], torch.tensor([[10.2, 50.4], [50.2, 30.4]]), atol=0.02)
    assert found.segments[0, 0, 1] == found.segments[1, 0, 1]


def test_what_the_picture_shows_otherwise_stays():
    exact = rounded_rectangle(9.3, 12.3, 44.0, 36.0, (8.0, 8.0, 8.0, 8.0))
    tilted = exact.copy()
    tilted[..., 1] += 0.02 * tilted[..., 0]
    scene = scene_of(tilted)
    found = regular(scene, picture(scene))
    before, after = (Critic(picture(scene), CONFIG).error(each).sum() for each in (scene, found))
    assert after <= 1.3 * before + 0.02
    assert (found.segments[found.structure.lines, 0, 1].diff().abs() > 0.1).any()


def test_forms_and_colours_stay_and_an_empty_drawing_too():
    scene = scene_of(rounded_rectangle(9.3, 12.3, 44.0, 36.0, (8.0, 8.0, 8.0, 8.0)))
    found = regular(scene, picture(scene))
    assert torch.equal(found.color, scene.color) and found.forms is None
    empty = replace(scene.select(torch.zeros(0, dtype=torch.int64)))
    assert len(regular(empty, torch.ones(64, 64, 3))) == 0


def test_lines_that_are_nearly_level_and_upright_become_so():
    scene = drawing((BLACK, [straight((10.05, 10.1), (50.1, 9.95), (49.95, 40.1), (9.95, 40.0))]))
    image = picture(drawing((BLACK, [rectangle(10, 10, 50, 40)])))

    found = edges(regular(scene, image))

    assert len(found) == 4 and (found == 0.0).any(1).all()


def test_a_line_that_the_picture_shows_tilted_stays_tilted():
    scene = drawing((BLACK, [straight((10, 10), (50, 10.6), (50, 40), (10, 40))]))

    found = regular(scene, picture(scene))

    heights = found.segments[:, 0, 1].sort().values
    torch.testing.assert_close(heights[:2], torch.tensor([10.0, 10.6]), atol=0.05, rtol=0)
    other = drawing((BLACK, [straight((10, 10.3), (50, 10.3), (50, 40), (10, 40))]))
    level = regular(scene, picture(other))  # the picture has no objection
    assert len(set(level.segments[:, 0, 1].tolist())) == 2


def test_a_turned_rectangle_gets_right_angles():
    corners = turned(torch.tensor([[14.0, 20.0], [50.0, 20.0], [50.0, 44.0], [14.0, 44.0]]), 20.0)
    image = picture(drawing((RED, [straight(*corners.tolist())])))
    noise = 0.06 * torch.tensor([[1.0, 0.5], [-1.0, 0.3], [0.4, -1.0], [0.2, 1.0]])
    scene = drawing((RED, [straight(*(corners + noise).tolist())]))

    found = edges(regular(scene, image))

    cosine = (found * found.roll(1, 0)).sum(1) / found.norm(dim=1) / found.roll(1, 0).norm(dim=1)
    assert cosine.abs().max() < 1e-4
    assert abs(math.degrees(math.atan2(found[0, 1], found[0, 0])) - 20.0) < 0.3


def test_bars_of_nearly_one_height_are_aligned():
    tops = (10.0, 10.12, 9.9)
    bars = [rectangle(8.0 + 16 * k, top, 18.3 + 16 * k, 50.0) for k, top in enumerate(tops)]
    scene = drawing(*((BLUE, [bar]) for bar in bars))
    image = picture(drawing(*((BLUE, [rectangle(8.0 + 16 * k, 10, 18.3 + 16 * k, 50)]) for k in range(3))))

    found = regular(scene, image)

    assert len(set(found.segments[:, 0, 1].tolist())) == 2


def test_an_ellipse_that_is_no_form_stays_one() -> None:
    """The picture shows it a little flat, as circles are that designers draw by hand."""
    exact, flat = circle(32.0, 32.0, 24.0), circle(32.0, 32.0, 24.0)
    flat[0::3] += 0.012 * (32.0 - flat[0::3])
    scene = drawing((BLACK, [exact]))

    found = regular(scene, picture(drawing((BLACK, [flat]))))

    torch.testing.assert_close(found.segments, scene.segments, atol=1e-4, rtol=0)


def test_a_sliver_does_not_become_a_point() -> None:
    lens = torch.tensor([[30.0, 32.0], [31.2, 32.06], [32.2, 32.12], [33.4, 32.17], [32.3, 32.11], [31.2, 32.05]])
    scene = drawing(((0.98, 0.98, 0.98), [lens]))

    found = regular(scene, picture(scene))

    assert (np.ptp(found.segments.numpy(), axis=(0, 1)) > 0.1).all()

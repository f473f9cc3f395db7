"""Test drawings without overlaps: areas, shared edges, lines, slivers and mixed colours."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from warpvec.flat.cutting import arrangement
from warpvec.flat.cutting.cutout import cut_out
from warpvec.flat.cutting.noding import Chords, noded
from warpvec.flat.drawing import watch_for_cutting
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg
from warpvec.watch.watch import Watch

SIDE = 64

STACK = """<rect x="-6" y="8" width="50" height="40" fill="#123456"/>
<circle cx="40" cy="30" r="18" fill="#fa0"/><circle cx="40" cy="30" r="7.5" fill="#0c8"/>
<path d="M10,20L58,36L30,61Z M24,30V50H34V44Z" fill="#c0f"/>"""


HALVES = """<rect x="-1" y="-1" width="33" height="66" fill="#eee"/>
<rect x="32" y="-1" width="33" height="66" fill="#eef"/>"""
"""Two paths that cover the canvas."""


def _scene(elements: str) -> Scene:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}">'
    return read_svg(f"{head}{elements}</svg>").scene


def _areas(scene: Scene) -> NDArray[np.float64]:
    """Return the area of each path, by Green's theorem; holes count less."""
    structure = scene.structure
    segments = scene.segments.double().numpy()
    ends = segments[structure.segment_next.long().numpy(), :1]
    x, y = np.moveaxis(np.concatenate([segments, ends], 1), 2, 0)
    # Integrals of a Bernstein polynomial times the derivative of another.
    weights = np.array([[-10, 6, 3, 1], [-6, 0, 3, 3], [-3, -3, 0, 6], [-1, -3, -6, 10]]) / 20
    parts = np.einsum("ni,ij,nj->n", x, weights, y)
    return np.abs(np.bincount(structure.segment_path.numpy(), parts, len(scene)))


def _drawn(scene: Scene, scale: int = 1, transparent: bool = False) -> NDArray[np.uint8]:
    text = write_svg(scene, SIDE, SIDE, precision=3)
    return draw(text, scale * SIDE, scale * SIDE, transparent=transparent)


def _edges(scene: Scene) -> tuple[set[bytes], set[bytes]]:
    """Return all segments as they run, and reversed, as bytes. The handles of lines do not count."""
    ends = scene.segments[scene.structure.segment_next.long(), :1]
    rows = torch.cat([scene.segments, ends], 1).numpy()
    assert scene.structure.is_line is not None
    rows[scene.structure.is_line.numpy(), 1:3] = 0
    return {row.tobytes() for row in rows}, {row[::-1].tobytes() for row in rows}


def _union(scene: Scene, pathops: Any) -> Any:
    """Return what the paths of ``scene`` cover of the canvas, by Skia."""
    union, canvas = pathops.Path(), pathops.Path()
    canvas.moveTo(0, 0)
    for corner in ((SIDE, 0), (SIDE, SIDE), (0, SIDE)):
        canvas.lineTo(*corner)
    canvas.close()
    for path in range(len(scene)):
        shape, alone = pathops.Path(), scene.select(torch.tensor([path]))
        for start, stop in pairwise(alone.structure.loop_first_segment.tolist()):
            rows = alone.segments[start:stop].tolist()
            shape.moveTo(*rows[0][0])
            for row, following in zip(rows, [*rows[1:], rows[0]], strict=True):
                shape.cubicTo(*row[1], *row[2], *following[0])
            shape.close()
        union = pathops.op(union, shape, pathops.PathOp.UNION)
    return pathops.op(union, canvas, pathops.PathOp.INTERSECTION)


def test_areas_add_up_and_nothing_overlaps() -> None:
    pathops = pytest.importorskip("pathops")
    stacked = _scene(STACK)
    cut = cut_out(stacked, SIDE, SIDE)
    whole = _union(stacked, pathops)
    assert _areas(cut.scene).sum() == pytest.approx(whole.area, rel=1e-4)
    alpha = sum(_drawn(cut.scene.select(torch.tensor([k])), 4, True)[..., 3].astype(int) for k in range(len(cut.scene)))
    assert np.abs(alpha - _drawn(stacked, 4, True)[..., 3]).mean() < 0.1
    assert alpha.max() <= 255 + 48  # resvg rounds the coverage of each part


def test_drawing_stays_the_same_inside_of_its_parts() -> None:
    stacked = _scene(STACK)
    before, after = _drawn(stacked, 4).astype(int), _drawn(cut_out(stacked, SIDE, SIDE).scene, 4).astype(int)
    windows = np.lib.stride_tricks.sliding_window_view(before, (3, 3), (0, 1))
    is_even = (windows.max((3, 4)) == windows.min((3, 4))).all(2)
    assert is_even.mean() > 0.8
    assert np.array_equal(before[1:-1, 1:-1][is_even], after[1:-1, 1:-1][is_even])


@pytest.mark.parametrize("is_written", [False, True])
def test_neighbours_share_the_very_same_edges(is_written: bool) -> None:
    # The canvas is covered, so that each edge but its border has a neighbour.
    stacked = _scene(HALVES + STACK)
    cut = cut_out(stacked, SIDE, SIDE, (0.01, 0.01) if is_written else None).scene
    if is_written:
        loaded = read_svg(write_svg(cut, SIDE, SIDE, precision=2))
        assert loaded.precision == 2
        cut = loaded.scene
    forward, backward = _edges(cut)
    alone = [np.frombuffer(edge, np.float32).reshape(4, 2) for edge in forward - backward]
    assert len(forward) - len(alone) > 20
    assert all(any((edge[[0, 3], axis] == side).all() for axis in (0, 1) for side in (0, SIDE)) for edge in alone)
    assert _areas(cut).sum() == pytest.approx(SIDE * SIDE, rel=1e-6)


@pytest.mark.parametrize(("page", "is_kept"), [("#fff", False), ("#fed", True)])
def test_the_page_is_no_path_and_a_white_one_is_left_out(page: str, is_kept: bool) -> None:
    stacked = _scene(f'<rect width="{SIDE}" height="{SIDE}" fill="{page}"/>' + STACK)
    cut = cut_out(stacked, SIDE, SIDE)
    assert _areas(cut.scene).sum() == pytest.approx(_areas(cut_out(_scene(STACK), SIDE, SIDE).scene).sum(), rel=1e-4)
    assert cut.scene.transparent == (not is_kept) and cut.hidden_count == 0
    assert np.abs(_drawn(cut.scene, 4).astype(int) - _drawn(stacked, 4)).mean() < 0.5  # of seams


def test_lines_stay_lines_and_few() -> None:
    cut = cut_out(_scene('<path d="M8,8H40V40H8Z"/><path d="M30,20H60V50H30Z" fill="#f00"/>'), SIDE, SIDE)
    is_line = cut.scene.structure.is_line
    assert is_line is not None
    assert bool(is_line.all())
    assert len(is_line) == 6 + 6  # an L, and a square with two more nodes where their outlines part


def test_outlines_that_nearly_coincide_leave_no_sliver() -> None:
    two = '<circle cx="32" cy="32" r="20.1" fill="#00f"/><circle cx="32" cy="32" r="20" fill="#f00"/>'
    cut = cut_out(_scene(two), SIDE, SIDE)
    assert len(cut.scene) == 1
    assert (cut.hidden_count, cut.sliver_count) == (1, 1)
    assert cut.scene.color[0].tolist() == [1.0, 0.0, 0.0]
    assert _areas(cut.scene)[0] == pytest.approx(np.pi * 20**2, rel=1e-3)


def test_translucent_paths_are_mixed_and_counted() -> None:
    below, above = (
        '<rect x="4" y="4" width="40" height="40" fill="#00f"/>',
        '<rect x="20" y="20" width="40" height="40"',
    )
    cut = cut_out(_scene(f'{below}{above} fill="#f00" opacity=".25"/>'), SIDE, SIDE)
    assert cut.blended_count == 1
    found = {tuple(np.round(color, 2)): round(opacity, 2) for color, opacity in
             zip(cut.scene.color.tolist(), cut.scene.opacity.tolist(), strict=True)}  # fmt: skip
    assert found == {(0.0, 0.0, 1.0): 1.0, (0.25, 0.0, 0.75): 1.0, (1.0, 0.0, 0.0): 0.25}


def test_cutting_takes_fewer_steps_once_the_time_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    counts, stacked = list[int](), _scene(HALVES + STACK)

    def noded_and_counted(chords: Chords) -> Chords:
        counts.append(len(chords))
        return noded(chords)

    monkeypatch.setattr(arrangement, "noded", noded_and_counted)
    cut_out(stacked, SIDE, SIDE)
    cut = cut_out(stacked, SIDE, SIDE, watch=Watch(time_budget=1e-9))
    in_time, late = counts[0], counts[-1]
    assert late < 0.5 * in_time
    assert _areas(cut.scene).sum() == pytest.approx(SIDE * SIDE, rel=1e-4)


def test_very_many_coordinates_are_cut_as_if_late_once_little_time_is_left() -> None:
    few = _scene(STACK)
    many = few.select(torch.zeros(1000, dtype=torch.int64))
    watch = Watch(time_budget=100.0)
    assert not watch_for_cutting(watch, many).is_over()
    watch.resume(70.0)
    assert watch_for_cutting(watch, many).is_over()
    assert not watch_for_cutting(watch, few).is_over()


def test_many_wild_paths_tile_the_canvas() -> None:
    generator = np.random.default_rng(3)
    blobs = []
    for _ in range(14):
        places = generator.uniform(-4, SIDE + 4, (7, 2)).round(1)
        x, y = (places + generator.normal(0, 12, (1, 2))).T
        curves = "".join(
            f"C{x[k]:.1f},{y[k]:.1f} {x[k + 1]:.1f},{y[k + 1]:.1f} {x[k + 2]:.1f},{y[k + 2]:.1f}" for k in (1, 4)
        )
        blobs.append(f'<path d="M{x[0]:.1f},{y[0]:.1f}{curves}Z" fill="#{generator.integers(1 << 24):06x}"/>')
    stacked = _scene(HALVES + "".join(blobs))
    cut = cut_out(stacked, SIDE, SIDE).scene
    assert _areas(cut).sum() == pytest.approx(SIDE * SIDE, rel=1e-4)
    before, after = _drawn(stacked, 4).astype(int), _drawn(cut, 4).astype(int)
    assert (np.abs(before - after).max(2) > 128).mean() < 2e-3


def test_soft_paths_are_cut_along_their_outlines_and_counted() -> None:
    scene = _scene(STACK)
    soft = replace(scene, softness=Softness(torch.tensor([2.0, *[0.0] * (len(scene) - 1)])))
    sharp, cut = cut_out(scene, SIDE, SIDE), cut_out(soft, SIDE, SIDE)
    assert (sharp.sharpened_count, cut.sharpened_count) == (0, 1)
    assert cut.scene.softness is None and torch.equal(cut.scene.segments, sharp.scene.segments)

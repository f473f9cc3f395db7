"""Splitting and merging segments, on random scenes of any structure."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from compound import compound_scene
from scenes import seeded
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.bezier import bernstein
from warpvec.geometry.nodes import Edit, merge, split
from warpvec.geometry.quick_merge import quick_merges
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.structure import Structure
from warpvec.rendering.operator import render

HEIGHT, WIDTH = 60, 80
SEEDS = range(3)


def mixed_scene(seed: int, dtype: torch.dtype = torch.float64) -> Scene:
    """Return paths of several loops, a third of whose rows are lines."""
    scene = compound_scene(seed, 15, HEIGHT, WIDTH)
    structure = scene.structure
    is_line = torch.rand(structure.segment_count, generator=seeded(seed)) < 1 / 3
    is_line &= structure.segment_next != torch.arange(structure.segment_count)
    structure = Structure(structure.loop_first_segment, structure.path_first_loop, is_line)
    values = (scene.color, scene.opacity, scene.background)
    segments = straightened(scene.segments, structure).to(dtype)
    return Scene(segments, structure, *(value.to(dtype) for value in values), scene.generation)


def some_rows(scene: Scene, seed: int) -> Tensor:
    """Return a third of the rows in random order."""
    count = scene.structure.segment_count
    return torch.randperm(count, generator=seeded(seed))[: count // 3]


def mergeable(scene: Scene, seed: int) -> Tensor:
    """Return random rows of which none is alone in its loop, and none follows another."""
    structure, chosen = scene.structure, set[int]()
    before, after = structure.segment_previous.tolist(), structure.segment_next.tolist()
    for row in some_rows(scene, seed).tolist():
        if before[row] != row and before[row] not in chosen and after[row] not in chosen:
            chosen.add(row)
    return torch.tensor(list(chosen))


def parameters(rows: Tensor, seed: int) -> Tensor:
    return 0.02 + 0.96 * torch.rand(len(rows), generator=seeded(seed), dtype=torch.float64)


def new_rows(rows: Tensor) -> Tensor:
    """Return the rows of the anchors that splitting each of ``rows`` once adds, in ascending order."""
    return rows.sort().values + torch.arange(1, len(rows) + 1)


def merged(scene: Scene, rows: Tensor) -> Edit:
    """Merge as a fit does, by weighted least squares."""
    found = quick_merges(scene)
    return merge(scene, rows, found.handles[rows], found.share[rows])


EVEN = torch.linspace(0, 1, 801, dtype=torch.float64)


def points_of(scene: Scene, row: int, t: Tensor = EVEN) -> Tensor:
    """Return the points of a segment at the parameters ``t`` [K]: [K, 2]."""
    following = int(scene.structure.segment_next[row])
    control = torch.cat([scene.segments[row], scene.segments[following, :1]]).double()
    return bernstein(3, t) @ control


def check_valid(edit: Edit, before: Scene) -> None:
    """Check the structure, that nothing is NaN, that lines are straight, and that rows outside the edit are kept."""
    scene, structure = edit.scene, edit.scene.structure
    count = structure.segment_count
    assert len(scene.segments) == len(edit.source) == len(edit.is_fresh) == len(edit.weights) == count
    assert structure.loop_count == before.structure.loop_count
    assert torch.equal(structure.path_first_loop, before.structure.path_first_loop)
    assert structure.loop_first_segment[0] == 0 and bool((structure.loop_first_segment.diff() > 0).all())
    assert structure.loop_first_segment.dtype == torch.int32
    assert scene.segments.dtype == before.segments.dtype and bool(scene.segments.isfinite().all())
    assert bool((edit.weights >= 0).all())
    source = edit.source[:, 0]
    assert torch.equal(structure.segment_path, before.structure.segment_path[source])
    kept = ~edit.is_fresh
    assert torch.equal(scene.segments[kept], before.segments[source[kept]])
    assert torch.equal(edit.weights[kept, 0], torch.eye(3).double().expand(int(kept.sum()), 3, 3))
    assert structure.is_line is None or len(structure.is_line) == count
    torch.testing.assert_close(straightened(scene.segments, structure), scene.segments, rtol=1e-5, atol=1e-5)
    assert torch.equal(scene.color, before.color) and torch.equal(scene.opacity, before.opacity)


def polygonal(scene: Scene, points: Tensor, counts: Tensor) -> Scene:
    """Return the scene with the outlines through ``points`` [V, 2], of which row r has ``counts[r]``, as lines."""
    ends = torch.nn.functional.pad(counts.cumsum(0), (1, 0)).int()
    loops = ends[scene.structure.loop_first_segment.long()]
    structure = Structure(loops, scene.structure.path_first_loop, torch.ones(len(points), dtype=torch.bool))
    segments = straightened(points[:, None].repeat(1, 3, 1), structure)
    return replace(scene, segments=segments, structure=structure)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_split_scene_is_the_same_picture(seed: int) -> None:
    scene = mixed_scene(seed)
    rows = torch.cat([some_rows(scene, seed), some_rows(scene, seed)[:5]])
    t = parameters(rows, seed)
    edit = split(scene, rows, t)
    check_valid(edit, scene)
    assert edit.scene.structure.segment_count == scene.structure.segment_count + len(rows)
    lines, now_lines = scene.structure.is_line, edit.scene.structure.is_line
    assert lines is not None and now_lines is not None and torch.equal(now_lines, lines[edit.source[:, 0]])
    # The same points of both outlines make the same polygons.
    chords = 8
    step = torch.linspace(0, 1, chords + 1, dtype=torch.float64)[:-1, None]
    old, new = [], []
    for row in range(scene.structure.segment_count):
        cuts = torch.cat([torch.zeros(1), t[rows == row].sort().values, torch.ones(1)]).double()
        parameter = (cuts[:-1] + step * cuts.diff()).T.flatten()
        old.append(points_of(scene, row, parameter))
    for row in range(edit.scene.structure.segment_count):
        new.append(points_of(edit.scene, row, step.flatten()))
    counts = torch.tensor([len(points) for points in old])
    images = [
        render(polygonal(scene, torch.cat(old), counts), HEIGHT, WIDTH),
        render(polygonal(edit.scene, torch.cat(new), torch.full((len(new),), chords)), HEIGHT, WIDTH),
    ]
    assert (images[1] - images[0]).abs().max() < 1e-12
    # The renderer itself draws other chords, which lie within a small part of a pixel of the curves.
    assert (render(edit.scene, HEIGHT, WIDTH) - render(scene, HEIGHT, WIDTH)).abs().mean() < 1e-3


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
@pytest.mark.parametrize("seed", SEEDS)
def test_merging_a_split_gives_the_first_segment_back(seed: int, dtype: torch.dtype) -> None:
    scene = mixed_scene(seed, dtype)
    if seed == 0:
        scene.segments[::3] = scene.segments[::3, :1]  # curves that look like lines
        scene = replace(scene, segments=straightened(scene.segments, scene.structure))
    rows = some_rows(scene, seed)
    order, t = rows.argsort(), parameters(rows, seed)
    there = split(scene, rows, t)
    back = merge(there.scene, new_rows(rows), scene.segments[rows[order], 1:], t[order])
    check_valid(back, there.scene)
    torch.testing.assert_close(back.scene.segments, scene.segments, rtol=0, atol=1e-5)
    assert torch.equal(back.scene.structure.loop_first_segment, scene.structure.loop_first_segment)
    assert back.scene.structure.is_line is not None and scene.structure.is_line is not None
    assert torch.equal(back.scene.structure.is_line, scene.structure.is_line)


@pytest.mark.parametrize("seed", SEEDS)
def test_merged_segments_keep_their_ends_and_get_the_given_handles(seed: int) -> None:
    scene = mixed_scene(seed)
    rows = mergeable(scene, seed)
    handles = torch.rand(len(rows), 2, 2, generator=seeded(seed), dtype=torch.float64) * HEIGHT
    edit = merge(scene, rows, handles, parameters(rows, seed))
    check_valid(edit, scene)
    assert edit.scene.structure.segment_count == scene.structure.segment_count - len(rows)
    assert edit.scene.structure.is_line is not None
    before = scene.structure.segment_previous.long()[rows]
    for k, (row, previous) in enumerate(zip(rows.tolist(), before.tolist(), strict=True)):
        new = int((edit.source == torch.tensor([previous, row])).all(1).nonzero())
        made = points_of(edit.scene, new)
        assert torch.equal(made[0], points_of(scene, previous)[0])
        torch.testing.assert_close(made[-1], points_of(scene, row)[-1])
        assert edit.scene.structure.is_line[new] or torch.equal(edit.scene.segments[new, 1:], handles[k])


def test_two_arcs_become_an_arc() -> None:
    eighth = math.pi / 4
    angle = torch.arange(8, dtype=torch.float64) * eighth
    anchor = torch.stack([angle.cos(), angle.sin()], -1)
    tangent = 4 / 3 * math.tan(eighth / 4) * torch.stack([-angle.sin(), angle.cos()], -1)
    segments = 100 * torch.stack([anchor, anchor + tangent, (anchor - tangent).roll(-1, 0)], 1)
    scene = Scene(
        segments, Structure.of_loops([[8]]), *(torch.ones(n).double() for n in ((1, 3), 1, 3)), torch.zeros(1)
    )
    edit = merged(scene, torch.arange(1, 8, 2))
    check_valid(edit, scene)
    # The best cubic for a quarter of a circle misses it by 0.02 to 0.03 % of the radius; one round finds nearly that.
    radius = torch.cat([points_of(edit.scene, row) for row in range(4)]).norm(dim=1)
    assert (radius - 100).abs().max() < 0.05
    # The first anchor of a loop is dropped too: its last segment then reaches the second one.
    first = merged(scene, torch.tensor([0]))
    check_valid(first, scene)
    assert torch.equal(first.scene.segments[0], scene.segments[1])
    assert first.source[-1].tolist() == [7, 0]


def test_two_lines_become_a_line() -> None:
    corners = torch.tensor([[0, 0], [10, 0], [10, 10], [0, 10.0]], dtype=torch.float64)
    structure = Structure.of_loops([[4]], torch.ones(4, dtype=torch.bool))
    segments = straightened(torch.stack([corners] * 3, 1), structure)
    square = Scene(segments, structure, *(torch.ones(n).double() for n in ((1, 3), 1, 3)), torch.zeros(1))
    edit = merged(square, torch.tensor([1]))
    check_valid(edit, square)
    assert edit.scene.structure.is_line is not None and edit.scene.structure.is_line.tolist() == [True] * 3


def test_uniform_scenes_of_one_segment_a_loop_can_be_split() -> None:
    points = torch.rand(3, 3, 2, generator=seeded(0), dtype=torch.float64) * 50
    scene = Scene.uniform(points, torch.rand(3, 3), torch.rand(3), torch.rand(3), torch.zeros(3).long())
    edit = split(scene, torch.tensor([1, 1]), torch.tensor([0.75, 0.25]))
    check_valid(edit, scene)
    assert edit.scene.structure.loop_first_segment.tolist() == [0, 1, 4, 5]
    assert edit.source[:, 0].tolist() == [0, 1, 1, 1, 2]
    torch.testing.assert_close(edit.scene.segments[2, 0], points_of(scene, 1)[200])
    assert len(split(scene, torch.zeros(0, dtype=torch.int64)).scene.segments) == 3
    assert len(merged(scene, torch.zeros(0, dtype=torch.int64)).scene.segments) == 3


def test_two_lines_that_close_a_loop_become_a_curve() -> None:
    structure = Structure.of_loops([[2]], torch.ones(2, dtype=torch.bool))
    segments = straightened(torch.tensor([[[0.0, 0]] * 3, [[9.0, 6]] * 3]).double(), structure)
    scene = Scene(segments, structure, *(torch.ones(n).double() for n in ((1, 3), 1, 3)), torch.zeros(1))
    edit = merged(scene, torch.tensor([0]))
    check_valid(edit, scene)
    assert edit.scene.structure.is_line is not None and edit.scene.structure.is_line.tolist() == [False]
    assert torch.equal(edit.scene.segments[0, 0], scene.segments[1, 0])


def test_points_that_coincide_make_no_nan() -> None:
    scene = mixed_scene(0, torch.float32)
    scene.segments[:] = scene.segments[0, 0]
    for edit in (split(scene, torch.arange(9)), merged(scene, mergeable(scene, 0))):
        check_valid(edit, scene)
        assert bool(edit.weights.isfinite().all())


LOOPS = Structure.of_loops([[3, 1], [2]])
RANDOM = torch.rand(6, 3, 2, generator=seeded(1), dtype=torch.float64)
SMALL = Scene(RANDOM, LOOPS, *(torch.ones(n).double() for n in ((2, 3), 2, 3)), torch.zeros(2))
QUARTIC = Scene.uniform(torch.rand(1, 4, 2), torch.ones(1, 3), torch.ones(1), torch.ones(3), torch.zeros(1), 4)


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda: split(SMALL, torch.tensor([6])), "rows must be a list of numbers from 0 to 5"),
        (lambda: split(SMALL, torch.tensor([0]), 1.0), "t must be between 0 and 1"),
        (lambda: split(SMALL, torch.tensor([0]), torch.tensor([math.nan])), "t must be between 0 and 1"),
        (lambda: split(SMALL, torch.tensor([0, 0]), 0.5), "t must differ"),
        (lambda: merged(SMALL, torch.tensor([1, 2])), "rows must not follow each other"),
        (lambda: merged(SMALL, torch.tensor([0, 2])), "rows must not follow each other"),
        (lambda: merged(SMALL, torch.tensor([4, 5])), "rows must not follow each other"),
        (lambda: merged(SMALL, torch.tensor([3])), "nor be alone in their loop, got 3"),
        (lambda: merged(SMALL, torch.tensor([0, 0])), "rows must occur once"),
        (lambda: split(QUARTIC, torch.tensor([0])), "degree"),
    ],
)
def test_what_cannot_be_done_is_refused(act, words: str) -> None:
    with pytest.raises(InputError, match="must") as caught:
        act()
    assert words in str(caught.value)

"""Structures against lists of lists."""

from __future__ import annotations

import random
from itertools import accumulate

import pytest
import torch
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

Rows = list[list[list[int]]]
"""The rows of each loop of each path."""


def random_counts(seed: int, path_count: int) -> list[list[int]]:
    draw = random.Random(seed)
    return [[draw.randint(1, 5) for _ in range(draw.randint(1, 4))] for _ in range(path_count)]


def rows_of(counts: list[list[int]]) -> Rows:
    """Number the segments of loops with these counts."""
    row, paths = 0, []
    for path in counts:
        loops = []
        for count in path:
            loops.append(list(range(row, row + count)))
            row += count
        paths.append(loops)
    return paths


def counts_of(paths: Rows) -> list[list[int]]:
    return [[len(loop) for loop in path] for path in paths]


def is_line_of(seed: int, counts: list[list[int]]) -> Tensor:
    draw = random.Random(seed)
    return torch.tensor([draw.random() < 0.5 for path in counts for count in path for _ in range(count)])


def check(structure: Structure, paths: Rows) -> None:
    """Check everything that ``structure`` tells against the rows of ``paths``, which are numbered in order."""
    loops = [loop for path in paths for loop in path]
    size = sum(map(len, loops))
    assert [row for loop in loops for row in loop] == list(range(size))
    assert structure.path_count == len(paths) and structure.loop_count == len(loops)
    assert structure.segment_count == size
    assert structure.loop_first_segment.tolist() == [0, *accumulate(len(loop) for loop in loops)]
    assert structure.path_first_loop.tolist() == [0, *accumulate(len(path) for path in paths)]
    assert structure.path_first_segment.tolist() == [0, *accumulate(sum(map(len, path)) for path in paths)]
    assert structure.segment_path.tolist() == [k for k, path in enumerate(paths) for loop in path for _ in loop]
    after = {row: loop[(k + 1) % len(loop)] for loop in loops for k, row in enumerate(loop)}
    assert structure.segment_next.tolist() == [after[row] for row in range(size)]
    before = {following: row for row, following in after.items()}
    assert structure.segment_previous.tolist() == [before[row] for row in range(size)]
    names = ("loop_first_segment", "path_first_loop", "path_first_segment", "segment_path", "segment_next")
    assert {getattr(structure, name).dtype for name in (*names, "segment_previous")} == {torch.int32}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("path_count", [0, 1, 9])
def test_loops_are_those_of_the_lists(seed: int, path_count: int) -> None:
    counts = random_counts(seed, path_count)
    check(Structure.of_loops(counts), rows_of(counts))


@pytest.mark.parametrize(("path_count", "segment_count"), [(0, 2), (1, 1), (5, 4)])
def test_uniform_paths_have_one_loop_each(path_count: int, segment_count: int) -> None:
    structure = Structure.uniform(path_count, segment_count)
    check(structure, rows_of([[segment_count]] * path_count))
    assert structure.uniform_count == segment_count and structure.is_line is None


def selections(count: int) -> list[Tensor]:
    draw = random.Random(count)
    mask = torch.tensor([draw.random() < 0.5 for _ in range(count)], dtype=torch.bool)
    repeated = torch.tensor([draw.randrange(count) for _ in range(2 * count)])
    reordered = torch.tensor(draw.sample(range(count), count - 1), dtype=torch.int64)
    empty = torch.zeros(0, dtype=torch.int64)
    return [mask, torch.zeros(count, dtype=torch.bool), mask | True, repeated, reordered, empty]


@pytest.mark.parametrize("case", range(6))
@pytest.mark.parametrize("kind", ["uniform", "loops", "lines"])
def test_selected_paths_keep_their_loops(case: int, kind: str) -> None:
    counts = [[4]] * 7 if kind == "uniform" else random_counts(case, 7)
    is_line = is_line_of(case, counts) if kind == "lines" else None
    structure = Structure.uniform(7, 4) if kind == "uniform" else Structure.of_loops(counts, is_line)
    chosen = selections(7)[case]
    rows = chosen.nonzero().flatten().tolist() if chosen.dtype == torch.bool else chosen.tolist()
    picked, segments = structure.select(chosen)
    check(picked, rows_of([counts[row] for row in rows]))
    paths = rows_of(counts)
    want = [segment for row in rows for loop in paths[row] for segment in loop]
    assert segments.tolist() == want and segments.dtype == torch.int64
    assert picked.uniform_count == structure.uniform_count
    assert is_line is None or (picked.is_line is not None and torch.equal(picked.is_line, is_line[want]))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lines", [(False, False), (True, False), (False, True), (True, True)])
def test_joined_paths_follow_each_other(seed: int, lines: tuple[bool, bool]) -> None:
    counts = [random_counts(seed, 5), random_counts(seed + 10, seed)]
    masks = [is_line_of(k, each) if has else None for k, (each, has) in enumerate(zip(counts, lines, strict=True))]
    first, second = (Structure.of_loops(each, mask) for each, mask in zip(counts, masks, strict=True))
    joined = first.joined(second)
    check(joined, rows_of(counts[0] + counts[1]))
    if not any(lines):
        assert joined.is_line is None
        return
    parts = [
        torch.zeros(each.segment_count).bool() if mask is None else mask
        for each, mask in zip((first, second), masks, strict=True)
    ]
    assert joined.is_line is not None and torch.equal(joined.is_line, torch.cat(parts))


def test_only_equal_counts_stay_uniform() -> None:
    four, five, mixed = Structure.uniform(2, 4), Structure.uniform(3, 5), Structure.of_loops([[4, 4]])
    check(four.joined(Structure.uniform(3, 4)), rows_of([[4]] * 5))
    assert four.joined(Structure.uniform(3, 4)).uniform_count == 4
    for left, right, counts in (
        (four, five, [[4], [4], [5], [5], [5]]),
        (four, mixed, [[4], [4], [4, 4]]),
        (mixed, four, [[4, 4], [4], [4]]),
    ):
        check(left.joined(right), rows_of(counts))
        assert left.joined(right).uniform_count is None


@pytest.mark.parametrize(
    ("counts", "found"),
    [([[3], []], "[3]"), ([[3, 0]], "[3, 0]"), ([[]], "[]"), ([[2], [-1]], "[2, -1]")],
)
def test_empty_paths_and_loops_are_refused(counts: list[list[int]], found: str) -> None:
    with pytest.raises(InputError) as caught:
        Structure.of_loops(counts)
    assert str(caught.value).startswith("structure must have a loop in each path and a segment in each loop")
    assert found in str(caught.value)


def test_a_mask_of_lines_of_another_length_is_refused() -> None:
    with pytest.raises(InputError, match="is_line must have an entry for each segment, got 4 for 5 segments; check"):
        Structure.of_loops([[3, 2]], torch.zeros(4, dtype=torch.bool))


def test_scenes_of_loops_are_selected_joined_and_stored_by_path(device: str) -> None:
    counts = [[3, 2], [1], [4, 1, 2]]
    structure = Structure.of_loops(counts, is_line_of(0, counts))
    values = (torch.rand(3, 3), torch.rand(3), torch.rand(3), torch.arange(3))
    scene = Scene(torch.rand(13, 3, 2), structure, *values).to(device)
    assert not scene.is_uniform
    with pytest.raises(InputError, match="scene must have paths of one loop"):
        _ = scene.points
    picked = scene.select(torch.tensor([2, 0], device=device))
    assert torch.equal(picked.segments, torch.cat([scene.segments[6:], scene.segments[:5]]))
    both = picked.joined(scene.select(torch.tensor([1], device=device))).cpu()
    check(both.structure, rows_of([counts[2], counts[0], counts[1]]))
    assert torch.equal(both.segments[-1:], scene.segments.cpu()[5:6])
    assert both.generation.tolist() == [2, 0, 1]
    back = Scene.from_dict(both.to_dict())
    check(back.structure, rows_of([counts[2], counts[0], counts[1]]))
    assert back.structure.is_line is not None and both.structure.is_line is not None
    assert torch.equal(back.structure.is_line, both.structure.is_line)
    assert torch.equal(back.segments, both.segments) and torch.equal(back.color, both.color)


def starts(*values: int) -> Tensor:
    return torch.tensor(values, dtype=torch.int32)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((starts(0, 4).long(), starts(0, 1)), "loop_first_segment must be a list of int32 .* got \\[2\\] of int64"),
        ((starts(), starts(0)), "loop_first_segment must be a list of int32"),
        ((starts(0, 4), starts(0, 1)[None]), "path_first_loop must be a list of int32"),
        ((starts(1, 4), starts(0, 1)), "loop_first_segment must begin with 0 and increase, got 1, 4"),
        ((starts(0, 4, 4), starts(0, 2)), "loop_first_segment must begin with 0 and increase, got 0, 4, 4"),
        ((starts(0, 4, 7), starts(0, 2, 1)), "path_first_loop must begin with 0 and increase, got 0, 2, 1"),
        ((starts(0, 4, 7), starts(0, 1)), "path_first_loop must end with the number of loops, 2, got 1"),
        ((starts(0, 4), starts(0, 1), torch.zeros(3, dtype=torch.bool)), "is_line must be 4 entries of bool, got"),
        ((starts(0, 4), starts(0, 1), torch.zeros(4)), "is_line must be 4 entries of bool, got \\[4\\] of float32"),
        ((starts(0, 4, 7), starts(0, 1, 2), None, 4), "uniform_count must be that of the one loop of every path"),
        ((starts(0, 4, 8), starts(0, 2), None, 4), "uniform_count must be that of the one loop of every path"),
    ],
)
def test_a_structure_that_does_not_divide_its_rows_is_refused(arguments: tuple, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        Structure(*arguments)
    assert "\n" not in str(caught.value)


def test_the_lowest_paths_of_one_count_share_a_structure(device: str) -> None:
    counts = [[3, 2], [1], [4, 1, 2]]
    structure = Structure.of_loops(counts, is_line_of(0, counts))
    scene = Scene(torch.rand(13, 3, 2), structure, torch.rand(3, 3), torch.rand(3), torch.rand(3), torch.arange(3))
    scene = scene.to(device)
    low, selected = scene.prefix(2), scene.select(torch.arange(2, device=device))
    check(low.structure, rows_of(counts[:2]))
    assert low.structure.is_line is not None and selected.structure.is_line is not None
    assert torch.equal(low.structure.is_line, selected.structure.is_line)
    for name in ("segments", "color", "opacity", "generation"):
        assert torch.equal(getattr(low, name), getattr(selected, name))
    assert scene.prefix(2).structure is low.structure
    assert low.color.data_ptr() != scene.color.data_ptr()


def test_a_structure_follows_the_segments_to_their_device() -> None:
    values = (torch.zeros(1, 3), torch.zeros(1), torch.zeros(3), torch.zeros(1, dtype=torch.int64))
    scene = Scene(torch.zeros(4, 3, 2, device="meta"), Structure.of_loops([[4]]), *(v.to("meta") for v in values))
    assert scene.structure.loop_first_segment.device.type == "meta"

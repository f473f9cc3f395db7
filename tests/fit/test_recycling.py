"""The kernels that take paths out of an arena and put others in, against lists of paths."""

from __future__ import annotations

import pytest
import torch
from reference.recycling import changed

from warpvec.fit.arena import OFF_CANVAS, Arena, Held
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

ROOM = (9, 40)


def held(counts: list[int], base: float, device: str) -> Held:
    """Return paths of so many segments, all of whose values tell which path or segment they belong to."""
    rows, paths = sum(counts), len(counts)
    structure = Structure.of_loops([[count] for count in counts])
    if len(set(counts)) == 1:
        structure = Structure.uniform(paths, counts[0])
    values = base + torch.arange(rows, dtype=torch.float32)
    looks = base + torch.arange(paths, dtype=torch.float32)
    background, generation = torch.zeros(3), torch.zeros(paths, dtype=torch.int64)
    segments = values[:, None, None].repeat(1, 3, 2)
    scene = Scene(segments, structure, looks[:, None].repeat(1, 3), looks, background, generation).to(device)
    planes = [values[None, :, None].repeat(5, 1, 6), *(looks[None, :, None].repeat(5, 1, width) for width in (3, 1))]
    age = torch.cat([looks.long(), torch.tensor([777])])
    return Held(scene, tuple(plane.to(device) for plane in planes), values.long().to(device), age.to(device))


def check(arena: Arena, counts: list[int], paths: list[float], segments: list[list[float]]) -> None:
    """Check that the arena has these paths and segments, and the tables of a new arena that takes them."""
    flat = torch.tensor([row for path in segments for row in path])
    padded, rows = arena.padded, len(flat)
    assert arena.counts.tolist() == [len(paths)] and [len(path) for path in segments] == counts
    assert padded.segments[:rows, 1, 0].tolist() == flat.tolist() and bool((padded.segments[rows:] == OFF_CANVAS).all())
    assert arena.segment_age[:rows].tolist() == flat.tolist() and arena.rows[0][3, :rows, 5].tolist() == flat.tolist()
    for values in (padded.color[:, 2], padded.opacity, arena.rows[1][4, :, 1], arena.rows[2][1, :, 0], arena.age):
        assert values[: len(paths)].tolist() == paths
    assert arena.age[-1] == 777
    anew = Arena(held(counts, 0.0, str(arena.counts.device)), *ROOM)
    anew.take(held(counts, 0.0, str(arena.counts.device)))
    if padded.structure.uniform_count is None:
        for name in ("path_first_segment", "segment_path", "segment_next", "segment_previous"):
            assert torch.equal(getattr(padded.structure, name), getattr(anew.padded.structure, name)), name


@pytest.mark.parametrize("counts", [[4, 2, 7, 3, 5, 2], [4, 4, 4, 4, 4, 4], [1, 30, 2]])
@pytest.mark.parametrize("is_equal", [False, True])
def test_paths_go_and_come(counts: list[int], is_equal: bool, device: str) -> None:
    if is_equal and len(set(counts)) > 1:
        pytest.skip("only equal paths lie in an arena of these")
    old = held(counts, 0.0, device)
    arena = Arena.of_equal_paths(old, ROOM[0]) if is_equal else Arena(old, *ROOM)
    arena.take(old)
    starts = torch.tensor([0, *counts]).cumsum(0).tolist()
    segments = [list(map(float, range(start, start + count))) for start, count in zip(starts, counts, strict=False)]
    cost = torch.tensor([0.5, -1.0, 0.5, 0.0, -torch.inf, 0.5][: len(counts)])
    drop = len(counts) // 2 + 1
    if len(counts) > 4:
        cost[3] = torch.nan  # as high as any
    paths, left = changed(segments, cost.nan_to_num(torch.inf, neginf=-torch.inf).tolist(), drop, [])
    arena.drop(drop, cost.to(device))
    check(arena, [len(path) for path in left], list(map(float, paths)), left)

    size = counts[0] if is_equal else 3
    new = held([size] * 3, 100.0, device)
    assert arena.can_add(new.scene, len(left), sum(map(len, left)))
    arena.add(new._replace(age=new.age[:-1]))
    more = [[100.0 + size * path + k for k in range(size)] for path in range(3)]
    both = [*left, *more]
    check(arena, [len(path) for path in both], [*map(float, paths), 100.0, 101.0, 102.0], both)


def test_what_does_not_fit_is_refused(device: str) -> None:
    old = held([4, 2, 7], 0.0, device)
    arena = Arena(old, *ROOM)
    scene = held([4] * 3, 0.0, device).scene
    assert arena.can_add(scene, 6, 28)
    assert not arena.can_add(scene, 7, 28) and not arena.can_add(scene, 6, 29)
    assert not arena.can_add(old.scene, 0, 0)  # paths of other lengths

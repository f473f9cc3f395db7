"""Flattening: chords stay within the tolerance and are not many more than needed; the adjoint is the transpose."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
import torch
import warp as wp
from assertions import assert_grad_close, assert_grad_present
from backends import Backend
from oracles import Stages, precisions, run_stages
from reference.flattening import flatten
from scenes import circle, random_scene, straight
from sweep import sweep
from torch import Tensor

from warpvec.kernels.constants import CHORD_TOLERANCE, SEGMENT_CHORDS_MAX

SAMPLES = 32
"""Points of the curve compared per chord; the distance has a flat maximum near the middle."""

SCALES = [0.1, 1.0, 10.0, 100.0, 1000.0]


def random_cubics(count: int, scale: float) -> Tensor:
    """Return paths [count, 6, 2] of two random cubics each, of ``scale`` pixels."""
    return scale * torch.rand(count, 6, 2, generator=torch.Generator().manual_seed(7), dtype=torch.float64)


def segments(points: Tensor) -> Tensor:
    """Return the control points [N S, 4, 2] of each segment."""
    closed = torch.cat([points, points[:, :1]], 1)
    return torch.stack([closed[:, s : s + 4] for s in range(0, points.shape[1], 3)], 1).reshape(-1, 4, 2)


def curve(control: Tensor, t: Tensor) -> Tensor:
    """Return the points [..., 2] of one cubic at ``t``, by de Casteljau."""
    t, row = t[..., None], list(control)
    while len(row) > 1:
        row = [a + t * (b - a) for a, b in pairwise(row)]
    return row[0]


def chord_error(control: Tensor, vertices: Tensor) -> float:
    """Return the largest distance in pixels between a piece of the curve and its chord, at equal steps of t."""
    chord_count = len(vertices) - 1
    inside = (torch.arange(SAMPLES, dtype=torch.float64) + 0.5) / SAMPLES
    point = curve(control, (torch.arange(chord_count, dtype=torch.float64)[:, None] + inside) / chord_count)
    a, along = vertices[:-1, None], vertices.diff(dim=0)[:, None]
    nearest = ((point - a) * along).sum(-1, keepdim=True) / along.square().sum(-1, keepdim=True).clamp(min=1e-300)
    return (point - a - nearest.clamp(0, 1) * along).norm(dim=-1).max().item()


def on_curve(control: Tensor, chord_count: int) -> Tensor:
    return curve(control, torch.linspace(0, 1, chord_count + 1, dtype=torch.float64))


def polylines(stages: Stages) -> list[Tensor]:
    """Return the vertices of each segment, including its end."""
    ends = segments(stages.points)[:, 3:]
    parts = stages.vertices.split(stages.chord_counts.flatten().tolist())
    return [torch.cat([part, end]) for part, end in zip(parts, ends, strict=True)]


def signed_area(loop: Tensor) -> Tensor:
    following = loop.roll(-1, 0)
    return 0.5 * (loop[:, 0] * following[:, 1] - loop[:, 1] * following[:, 0]).sum()


def chords_needed(control: Tensor) -> int:
    return next(
        count
        for count in range(1, SEGMENT_CHORDS_MAX)
        if chord_error(control, on_curve(control, count)) <= CHORD_TOLERANCE
    )


@sweep("scale", SCALES)
def test_chords_stay_within_the_tolerance_of_the_curve(scale: float) -> None:
    stages = run_stages(random_cubics(20, scale), 8, 8)
    errors = [chord_error(*pair) for pair in zip(segments(stages.points), polylines(stages), strict=True)]
    assert stages.chord_counts.max() < SEGMENT_CHORDS_MAX
    assert max(errors) <= CHORD_TOLERANCE


@sweep("radius", [3.0, 20.0, 150.0])
@sweep("turns", [1, -1])
def test_polygons_have_the_area_of_the_curve(radius: float, turns: int) -> None:
    # With vertices on the curve the polygon of a convex outline is too small. With vertices moved out its area is right
    # up to terms of higher order.
    stages = run_stages(circle(200.0, 200.0, radius, turns=turns)[None], 8, 8)
    count = int(stages.chord_counts[0, 0])
    fine, plain = (torch.cat([on_curve(s, n)[:-1] for s in segments(stages.points)]) for n in (4000, count))
    area, dropped_steps = signed_area(fine), signed_area(fine) - signed_area(plain)
    assert (signed_area(stages.vertices) - area).abs() < 0.2 * dropped_steps.abs()
    assert abs(area.item()) == pytest.approx(torch.pi * radius**2, rel=1e-3)


@sweep("scale", [10.0, 100.0, 1000.0])
def test_chords_are_not_many_more_than_the_tolerance_takes(scale: float) -> None:
    # Wang's bound uses the largest second difference for the whole cubic, and counts changes of speed as bend. It gives
    # 1.4 times the chords needed in total, and 3 times for a cubic whose handles are nearly in line with it.
    points = random_cubics(20, scale)
    counts = run_stages(points, 8, 8).chord_counts.flatten().tolist()
    needed = [chords_needed(control) for control in segments(points)]
    assert sum(counts) <= 1.5 * sum(needed)
    assert sorted(count / least for count, least in zip(counts, needed, strict=True))[len(needed) // 2] <= 1.5


@precisions
def test_chord_count_follows_wang(backend: Backend, dtype: torch.dtype) -> None:
    # None of these is at a whole number of chords, where rounding would decide.
    bend = CHORD_TOLERANCE * torch.tensor([0.0, 1.0, 1.4, 21.0, 613.0, 20011.0], dtype=torch.float64)
    points = torch.zeros(len(bend), 6, 2, dtype=torch.float64)
    # The second differences of both segments are bend and 0.
    points[:, 1, 1], points[:, 2, 1] = -bend, -bend
    points[:, 1, 1] *= 2 / 3
    points[:, 2, 1] *= 1 / 3
    points[:, 3], points[:, 4], points[:, 5] = points[:, 0], points[:, 0], points[:, 0]
    want = [max(1, math.ceil(math.sqrt(0.75 * b / CHORD_TOLERANCE))) for b in bend.tolist()]
    counts = run_stages(points, 8, 8, backend, dtype).chord_counts
    assert counts[:, 0].tolist() == want
    assert counts[:, 1].tolist() == [1] * len(bend)


@precisions
def test_lines_take_one_chord_and_wild_paths_the_most_there_may_be(dtype: torch.dtype) -> None:
    line = straight((1.0, 2.0), (30.0, 2.5), (4.0, 29.0))
    wild = random_cubics(1, 1e6)[0].repeat(2, 1)[:9]
    nowhere = torch.full_like(line, torch.nan)
    counts = run_stages(torch.stack([line, wild, nowhere]), 8, 8, dtype=dtype).chord_counts.tolist()
    assert counts == [[1] * 3, [SEGMENT_CHORDS_MAX] * 3, [3] * 3]


@precisions
@sweep("segment_count", [2, 3, 4, 7])
def test_vertices_are_those_of_the_reference(backend: Backend, dtype: torch.dtype, segment_count: int) -> None:
    points = random_scene(1, 9, 200, 300, segment_count).points
    stages = run_stages(points, 200, 300, backend, dtype)
    want = torch.cat(flatten(points, stages.chord_counts))
    # Rounding error of a sum of four products of numbers of canvas size.
    tolerance = 4 * torch.finfo(dtype).eps * points.abs().max().item()
    torch.testing.assert_close(stages.vertices.double(), want, rtol=0, atol=tolerance)


@sweep("path_count", [0, 1, 2, 63, 64, 65, 200])
@sweep("threads", [1, 3])
def test_paths_shared_among_threads_are_flattened_once_each(path_count: int, threads: int) -> None:
    points = random_scene(path_count, path_count, 64, 64, 3).points
    stages = run_stages(points, 64, 64, threads=threads)
    assert stages.flattening.vertex_count == stages.chord_counts.sum()
    want = torch.cat([points.new_zeros(0, 2), *flatten(points, stages.chord_counts)])
    torch.testing.assert_close(stages.vertices[: len(want)], want, rtol=0, atol=1e-12)


@sweep("segment_count", [2, 3, 4, 7])
def test_adjoint_is_the_transpose(backend: Backend, segment_count: int) -> None:
    points = random_scene(2, 66, 50, 50, segment_count).points
    stages = run_stages(points, 50, 50, backend)
    edge_adjoint = torch.randn(stages.flattening.vertex_count, 4, dtype=torch.float64)
    leaf = points.clone().requires_grad_()
    polygons = flatten(leaf, stages.chord_counts)
    ends = torch.cat([torch.cat([polygon, polygon.roll(-1, 0)], 1) for polygon in polygons])
    (want,) = torch.autograd.grad((ends * edge_adjoint).sum(), leaf)
    got = points_adjoint(stages, edge_adjoint, backend)
    assert_grad_close(got, want, rtol=1e-14, atol=0.0, name="points")
    assert_grad_present(got, want, "points")


def points_adjoint(stages: Stages, edge_adjoint: Tensor, backend: Backend) -> Tensor:
    adj_points = torch.full_like(stages.points, torch.nan, device=backend.device)
    edges = wp.from_torch(edge_adjoint.to(backend.device), dtype=stages.flattening._lanes.vec4)
    stages.flattening.adjoint(edges, adj_points.view(-1, 3, 2))
    return adj_points.cpu()

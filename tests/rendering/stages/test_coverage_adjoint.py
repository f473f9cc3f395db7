"""The boundary integral against autograd through the clipping reference, closed forms, and finite differences."""

from __future__ import annotations

import torch
import warp as wp
from assertions import assert_grad_close, assert_grad_present, assert_same_direction, finite_difference
from backends import Backend
from oracles import Stages, precisions, run_stages
from reference.coverage import signed_coverage
from reference.flattening import flatten
from scenes import ZOO, ZooCase, circle, random_scene, rectangle
from sweep import sweep
from torch import Tensor

from warpvec.kernels.constants import TILE

SIZES = [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (33, 31), (16, 130), (130, 16)]

DIFFERENTIABLE = [case for case in ZOO if case.differentiable and len(case.scene.points)]


def random_adjoint(stages: Stages) -> Tensor:
    """Return a random dL/d(winding) [N, h, w]."""
    generator = torch.Generator().manual_seed(5)
    shape = (len(stages.points), stages.grid.height, stages.grid.width)
    return torch.randn(shape, generator=generator, dtype=torch.float64)


def edge_adjoint(stages: Stages, adj_winding: Tensor) -> Tensor:
    """Return dL/d(start), dL/d(end) of each edge [V, 4] for ``adj_winding`` [N, h, w], which replaces the winding.

    ``adj_winding`` refers to ``Stages.winding``, which has the opposite sign of the kernels' winding.
    """
    grid = stages.grid
    padded = adj_winding.new_zeros(len(adj_winding), grid.rows * TILE, grid.columns * TILE)
    padded[:, : grid.height, : grid.width] = adj_winding
    tiles = padded.reshape(-1, grid.rows, TILE, grid.columns, TILE).transpose(2, 3).reshape(-1, grid.count, TILE, TILE)
    # The column for the next tile must not be read.
    slots = stages.slots.fill_(torch.nan)
    for path, tile, slot in stages.partial_pairs():
        slots[slot, :TILE] = -tiles[path, tile].T.to(slots)
    edges = stages.coverage.adjoint(stages.flattening, stages.binning, stages.chord_counts.numel())
    return torch.from_numpy(edges.numpy()[: stages.flattening.vertex_count].copy()).double()


def vertex_sums(stages: Stages, edges: Tensor) -> Tensor:
    """Return dL/d(vertex) [V, 2]: as the start of its edge plus as the end of the edge before."""
    lengths = stages.chord_counts.sum(1).tolist()
    return torch.cat([part[:, :2] + part[:, 2:].roll(1, 0) for part in edges.split(lengths)])


def check(stages: Stages, rtol: float) -> None:
    adjoint = random_adjoint(stages)
    polygons = [p.clone().requires_grad_() for p in flatten(stages.points, stages.chord_counts)]
    windings = [signed_coverage(p, stages.grid.height, stages.grid.width) for p in polygons]
    total = sum((winding * a).sum() for winding, a in zip(windings, adjoint, strict=True))
    want = torch.cat(torch.autograd.grad(total, polygons))
    got = vertex_sums(stages, edge_adjoint(stages, adjoint))
    assert_grad_close(got, want, rtol=rtol, atol=0.0, name="vertices")
    assert_grad_present(got, want, "vertices")
    assert_same_direction(got, want, 1 - rtol, "vertices")


@sweep(("height", "width"), SIZES)
def test_random_paths(height: int, width: int, backend: Backend) -> None:
    check(run_stages(random_scene(height * width, 9, height, width).points, height, width, backend), 1e-12)


@sweep("segment_count", [2, 3, 7])
def test_any_number_of_segments(segment_count: int, backend: Backend) -> None:
    check(run_stages(random_scene(3, 9, 40, 50, segment_count).points, 40, 50, backend), 1e-12)


@sweep("case", DIFFERENTIABLE)
def test_the_zoo(case: ZooCase, backend: Backend) -> None:
    # An edge with ends at 1e6 px crosses the canvas with an error of 1e-10 px.
    reach = case.scene.points.abs().max().item()
    check(run_stages(case.scene.points, case.scene.height, case.scene.width, backend), 1e-12 * max(1.0, reach / 1e3))


@sweep("case", [c for c in ZOO if not c.differentiable])
@precisions
def test_where_there_is_no_gradient_it_is_finite_and_bounded(
    case: ZooCase, backend: Backend, dtype: torch.dtype
) -> None:
    stages = run_stages(case.scene.points, case.scene.height, case.scene.width, backend, dtype)
    adjoint = random_adjoint(stages)
    got = vertex_sums(stages, edge_adjoint(stages, adjoint))
    assert got.isfinite().all()
    # Moving the end of an edge of length l by 1 px sweeps at most l / 2 square pixels.
    polygons = flatten(stages.points, stages.chord_counts)
    length = torch.cat([(p.roll(-1, 0) - p).norm(dim=1) + (p - p.roll(1, 0)).norm(dim=1) for p in polygons])
    assert (got.norm(dim=1) <= 0.51 * length * adjoint.abs().max() + 1e-6).all()


@precisions
def test_a_side_gains_its_length(backend: Backend, dtype: torch.dtype) -> None:
    # Clockwise on the screen: moving the right side right by 1 px adds its height, 20 px, to the winding.
    stages = run_stages(rectangle(5.25, 3.5, 37.1, 23.5)[None], 33, 50, backend, dtype)
    edges = edge_adjoint(stages, torch.ones(1, 33, 50, dtype=torch.float64))
    want = torch.tensor([[0, -1, 0, -1], [1, 0, 1, 0], [0, 1, 0, 1], [-1, 0, -1, 0]], dtype=torch.float64)
    half_length = torch.tensor([31.85, 20.0, 31.85, 20.0], dtype=torch.float64)[:, None] / 2
    torch.testing.assert_close(edges, want * half_length, rtol=1e-5, atol=1e-5)


def test_moving_a_whole_path_within_the_canvas_changes_no_area(backend: Backend) -> None:
    stages = run_stages(circle(20.3, 16.9, 11.7)[None], 33, 50, backend)
    edges = edge_adjoint(stages, torch.ones(1, 33, 50, dtype=torch.float64))
    assert vertex_sums(stages, edges).sum(0).abs().max() < 1e-12


def test_finite_differences_of_the_kernels(backend: Backend) -> None:
    points = random_scene(21, 3, 33, 40).points
    stages = run_stages(points, 33, 40, backend)
    adjoint = random_adjoint(stages)
    counts = stages.chord_counts

    def functional(moved: Tensor) -> Tensor:
        again = run_stages(moved, 33, 40, backend)
        assert torch.equal(again.chord_counts, counts)
        return (winding_images(again) * adjoint).sum()

    adj_points = torch.empty_like(points, device=backend.device)
    edges = edge_adjoint(stages, adjoint).to(backend.device).contiguous()
    stages.flattening.adjoint(wp.from_torch(edges, dtype=stages.flattening._lanes.vec4), adj_points.view(-1, 3, 2))
    entries = list(range(0, points.numel(), 5))
    want = finite_difference(functional, points, 1e-6, entries)
    # The winding is piecewise quadratic in an edge's move; the rounding error is about 1e-10 / 1e-6.
    assert_grad_close(adj_points.cpu().flatten()[entries], want, rtol=1e-6, atol=1e-7, name="points")


def winding_images(stages: Stages) -> Tensor:
    """Return the winding [N, h, w], 0 outside partial pairs: a small step does not change full pairs."""
    grid = stages.grid
    tiles = stages.winding().nan_to_num().reshape(-1, grid.rows, grid.columns, TILE, TILE).transpose(2, 3)
    return tiles.reshape(-1, grid.rows * TILE, grid.columns * TILE)[:, : grid.height, : grid.width]


def test_strips_shared_among_threads_give_the_same_bits() -> None:
    found = []
    for threads in (1, 2, 3):
        stages = run_stages(random_scene(6, 65, 100, 40).points, 100, 40, dtype=torch.float32, threads=threads)
        found.append(edge_adjoint(stages, random_adjoint(stages)))
    assert torch.equal(found[0], found[1]) and torch.equal(found[0], found[2])

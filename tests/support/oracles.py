"""The kernels beside the reference: one scene through both, on every instantiation of the kernels."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
import reference
import torch
import warp as wp
from scenes import SceneTensors
from torch import Tensor

from warpvec.kernels.constants import COLUMNS, PARTIAL, TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.launch import Launcher, start_warp
from warpvec.rendering.stages.binning import Binning, TileGrid
from warpvec.rendering.stages.coverage import Coverage
from warpvec.rendering.stages.flattening import Flattening
from warpvec.rendering.tile_renderer import Adjoints

GRADIENTS = ("points", "color", "opacity", "background")

lane_widths = pytest.mark.parametrize("lane_width", [16, 1], ids=["vector", "scalar"])
"""Both forms of the kernels on the CPU; the scalar one is what a GPU runs."""

precisions = pytest.mark.parametrize("dtype", [torch.float32, torch.float64], ids=["float32", "float64"])


@dataclass(frozen=True)
class Stages:
    """The geometric stages, run on one set of paths."""

    points: Tensor
    grid: TileGrid
    flattening: Flattening
    binning: Binning
    coverage: Coverage

    @property
    def chord_counts(self) -> Tensor:
        """Chords per segment [N, S]."""
        return chord_counts(self.flattening, self.points)

    @property
    def vertices(self) -> Tensor:
        """[V, 2]."""
        return torch.from_numpy(self.flattening.vertices.numpy()[: self.flattening.vertex_count].copy())

    @property
    def slots(self) -> Tensor:
        """What is stored for the partial pairs [slots, COLUMNS, TILE rows], sharing its memory."""
        values = torch.from_numpy(self.coverage.slot_winding.numpy()).flatten()
        return values[: self.binning.slot_count * COLUMNS * TILE].reshape(-1, COLUMNS, TILE)

    def partial_pairs(self) -> list[tuple[int, int, int]]:
        """Path, tile and slot of each partial pair."""
        hits = range(int(self.binning.tile_first_hit.numpy()[self.grid.count]))
        slot, pair_class = self.binning.pair_slot.numpy(), self.binning.pair_class.numpy()
        found = map(self.hit, hits)
        return [(path, tile, int(slot[pair])) for path, tile, pair in found if pair_class[pair] == PARTIAL]

    def winding(self) -> Tensor:
        """Winding of the pixels [N, tiles, TILE rows, TILE columns] of partial pairs; NaN elsewhere.

        With the reference's sign: positive inside a path that runs clockwise on the screen. The kernels count the
        other way round, which the non-zero rule does not see.
        """
        slots = self.slots
        tiles = torch.full((len(self.points), self.grid.count, TILE, TILE), torch.nan, dtype=slots.dtype)
        for path, tile, slot in self.partial_pairs():
            tiles[path, tile] = -slots[slot, :TILE].T
        return tiles

    def hit(self, hit: int) -> tuple[int, int, int]:
        """Path, tile and pair of a position among the sorted pairs."""
        pair = int(self.binning.hit_pair.numpy()[hit])
        return int(self.binning.pair_path.numpy()[pair]), int(self.binning.hit_tile.numpy()[hit]), pair


def run_stages(
    points: Tensor, height: int, width: int, lane_width: int = 16, dtype: torch.dtype = torch.float64, threads: int = 2
) -> Stages:
    """Flattening, binning and coverage of paths with control points [N, 3 S, 2]."""
    start_warp()
    launch, grid = Launcher("cpu", threads), TileGrid(height, width)
    lanes = make_lanes(lane_width, wp.dtype_from_torch(dtype))
    stages = Stages(points, grid, Flattening(launch, lanes), Binning(launch, lanes, grid), Coverage(launch, lanes))
    path_count, segment_count = points.shape[0], points.shape[1] // 3
    stages.flattening.run(wp.from_torch(points.to(dtype).contiguous(), dtype=lanes.vec2))
    stages.binning.run(stages.flattening, path_count, segment_count)
    stages.coverage.run(stages.flattening, stages.binning, segment_count)
    return stages


def chord_counts(flattening: Flattening, points: Tensor) -> Tensor:
    """Chords per segment [N, S] of the paths [N, 3 S, 2] that were flattened last."""
    path_count, segment_count = points.shape[0], points.shape[1] // 3
    first = torch.from_numpy(flattening.segment_first_vertex.numpy()[: path_count * segment_count + 1]).long()
    return first.diff().reshape(path_count, segment_count)


def make_renderer(
    scene: SceneTensors,
    lane_width: int | None = 16,
    dtype: torch.dtype = torch.float64,
    *,
    threads: int = 2,
    device: str = "cpu",
    transmittance_min: float = 0.0,
) -> ExactRenderer:
    """A renderer for the scene's canvas; nothing hidden is skipped unless asked for."""
    return ExactRenderer(
        scene.height,
        scene.width,
        device=device,
        threads=threads,
        dtype=dtype,
        lane_width=lane_width,
        transmittance_min=transmittance_min,
    )


def inputs(scene: SceneTensors, renderer: ExactRenderer) -> list[Tensor]:
    """Points, colour, opacity and background in the renderer's precision, on its device."""
    return [tensor.to(renderer.device, renderer.dtype) for tensor in scene[:4]]


def render(scene: SceneTensors, renderer: ExactRenderer) -> Tensor:
    return renderer.render(*inputs(scene, renderer))


def adjoint(scene: SceneTensors, renderer: ExactRenderer, adj_image: Tensor) -> Adjoints:
    return renderer.adjoint(*inputs(scene, renderer), adj_image.to(renderer.device, renderer.dtype))


def reference_image(scene: SceneTensors, renderer: ExactRenderer) -> Tensor:
    """What the reference draws from the chords that ``renderer`` has just drawn."""
    return reference.render(*scene, chord_counts(renderer._flattening, scene.points))


def reference_gradients(scene: SceneTensors, renderer: ExactRenderer, adj_image: Tensor) -> dict[str, Tensor]:
    """dL/d(each input) by autograd through the reference, with the chords that ``renderer`` has just drawn."""
    leaves = [tensor.clone().requires_grad_() for tensor in scene[:4]]
    counts = chord_counts(renderer._flattening, scene.points)
    image = reference.render(*leaves, scene.height, scene.width, counts)
    gradients = torch.autograd.grad((image * adj_image).sum(), leaves, materialize_grads=True)
    return dict(zip(GRADIENTS, gradients, strict=True))


def cotangent(scene: SceneTensors, seed: int = 1) -> Tensor:
    """A random dL/d(image) [h, w, 3]."""
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(scene.height, scene.width, 3, generator=generator, dtype=torch.float64)


def target_image(scene: SceneTensors, seed: int = 2) -> Tensor:
    """A random image [h, w, 3] to fit."""
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(scene.height, scene.width, 3, generator=generator, dtype=torch.float64)

"""Run the exact renderer or its stages, and the float64 reference, on the same scene. Results are on the CPU."""

from __future__ import annotations

from dataclasses import dataclass

import reference
import torch
import warp as wp
from backends import VECTOR, Backend
from scenes import SceneTensors
from sweep import sweep
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.kernels.constants import COLUMNS, PARTIAL, TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.launch import Launcher, start_warp
from warpvec.rendering.stages.binning import Binning, TileGrid
from warpvec.rendering.stages.coverage import Coverage
from warpvec.rendering.stages.flattening import Flattening
from warpvec.rendering.tile_renderer import Adjoints, TileRenderer

GRADIENTS = ("points", "color", "opacity", "background")

precisions = sweep("dtype", [torch.float32, torch.float64])


@dataclass(frozen=True)
class PathAdjoints:
    """`Adjoints` of a uniform scene on the CPU; ``points`` [N, P, 2] are those of the control points."""

    points: Tensor
    color: Tensor
    opacity: Tensor
    canvas_sums: Tensor
    removal_cost: Tensor | None

    @property
    def background(self) -> Tensor:
        return self.canvas_sums[:3]

    @property
    def loss(self) -> Tensor:
        return self.canvas_sums[3]


@dataclass(frozen=True)
class Stages:
    """The stages before compositing, run on one set of paths."""

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
        """[V, 2] px."""
        return torch.from_numpy(self.flattening.vertices.numpy()[: self.flattening.vertex_count].copy())

    @property
    def slots(self) -> Tensor:
        """Values stored for the partial pairs [slots, COLUMNS, TILE rows]: a view of the memory on the device."""
        values = wp.to_torch(self.coverage.slot_winding).flatten()
        return values[: self.binning.slot_count * COLUMNS * TILE].reshape(-1, COLUMNS, TILE)

    def partial_pairs(self) -> list[tuple[int, int, int]]:
        """Return path, tile and slot of each partial pair."""
        hits = range(int(self.binning.tile_first_hit.numpy()[self.grid.count]))
        slot, pair_class = self.binning.pair_slot.numpy(), self.binning.pair_class.numpy()
        found = map(self.hit, hits)
        return [(path, tile, int(slot[pair])) for path, tile, pair in found if pair_class[pair] == PARTIAL]

    def winding(self) -> Tensor:
        """Return the winding of the pixels [N, tiles, TILE rows, TILE columns] of partial pairs; NaN elsewhere.

        It has the reference's sign: positive inside a path that runs clockwise on the screen. The kernels use the
        opposite sign, which makes no difference to the non-zero rule.
        """
        slots = self.slots.cpu()
        tiles = torch.full((len(self.points), self.grid.count, TILE, TILE), torch.nan, dtype=slots.dtype)
        for path, tile, slot in self.partial_pairs():
            tiles[path, tile] = -slots[slot, :TILE].T
        return tiles

    def hit(self, hit: int) -> tuple[int, int, int]:
        """Return path, tile and pair of a hit."""
        pair = int(self.binning.hit_pair.numpy()[hit])
        return int(self.binning.pair_path.numpy()[pair]), int(self.binning.hit_tile.numpy()[hit]), pair


def run_stages(
    points: Tensor,
    height: int,
    width: int,
    backend: Backend = VECTOR,
    dtype: torch.dtype = torch.float64,
    threads: int = 2,
) -> Stages:
    """Run flattening, binning and coverage on paths with control points [N, 3 S, 2]."""
    start_warp()
    launch, grid = Launcher(backend.device, threads), TileGrid(height, width)
    lanes = make_lanes(backend.lane_width, wp.dtype_from_torch(dtype))
    stages = Stages(points, grid, Flattening(launch, lanes), Binning(launch, lanes, grid), Coverage(launch, lanes))
    structure = Structure.uniform(points.shape[0], points.shape[1] // 3, backend.device)
    stages.flattening.run(points.to(backend.device, dtype).reshape(-1, 3, 2).contiguous(), structure)
    stages.binning.run(stages.flattening, len(points))
    stages.coverage.run(stages.flattening, stages.binning)
    return stages


def chord_counts(flattening: Flattening, points: Tensor) -> Tensor:
    """Return the chords per segment [N, S] of the paths [N, 3 S, 2] that were flattened last."""
    path_count, segment_count = points.shape[0], points.shape[1] // 3
    first = torch.from_numpy(flattening.segment_first_vertex.numpy()[: path_count * segment_count + 1]).long()
    return first.diff().reshape(path_count, segment_count)


def make_renderer(
    scene: SceneTensors,
    backend: Backend = VECTOR,
    dtype: torch.dtype = torch.float64,
    *,
    threads: int = 2,
    transmittance_min: float = 0.0,
) -> ExactRenderer:
    """Make a renderer for the scene's canvas; with the default ``transmittance_min`` it skips no hidden path."""
    return ExactRenderer(
        scene.height,
        scene.width,
        device=backend.device,
        threads=threads,
        dtype=dtype,
        lane_width=backend.lane_width,
        transmittance_min=transmittance_min,
    )


def inputs(scene: SceneTensors, renderer: TileRenderer) -> Scene:
    """Return the scene in the renderer's precision, on its device."""
    tensors = [tensor.to(renderer.device, renderer.dtype) for tensor in scene[:4]]
    generation = torch.zeros(len(scene.points), dtype=torch.int64, device=renderer.device)
    return Scene.uniform(*tensors, generation, renderer.degree)


def painted(paths: tuple[Tensor, ...], color: Tensor) -> Scene:
    """Return a scene of ``paths``, points and opacities, in the colours [N + 1, 3]; the last is the background's."""
    points, opacity = paths
    return Scene.uniform(points, color[:-1], opacity, color[-1], torch.zeros(len(points), dtype=torch.int64))


def render(scene: SceneTensors, renderer: TileRenderer) -> Tensor:
    return renderer.render(inputs(scene, renderer)).cpu()


def adjoint(scene: SceneTensors, renderer: TileRenderer, adj_image: Tensor) -> PathAdjoints:
    adj_image = adj_image.to(renderer.device, renderer.dtype)
    return path_adjoints(renderer.adjoint(inputs(scene, renderer), adj_image), scene)


def fit_step(scene: SceneTensors, renderer: TileRenderer, want_removal_cost: bool = False) -> PathAdjoints:
    target = renderer.prepare_target(target_image(scene))
    return path_adjoints(renderer.fit_step(inputs(scene, renderer), target, want_removal_cost), scene)


def path_adjoints(adjoints: Adjoints, scene: SceneTensors) -> PathAdjoints:
    """Return ``adjoints`` on the CPU, with those of the control points in the shape of the scene's."""
    cost = adjoints.removal_cost
    points = adjoints.segments.cpu().reshape(scene.points.shape)
    values = (value.cpu() for value in (adjoints.color, adjoints.opacity, adjoints.canvas_sums))
    return PathAdjoints(points, *values, None if cost is None else cost.cpu())


def reference_image(scene: SceneTensors, renderer: ExactRenderer) -> Tensor:
    """Return the reference's image, with the chords of the renderer's last call."""
    return reference.render(*scene, chord_counts(renderer._flattening, scene.points))


def reference_gradients(scene: SceneTensors, renderer: ExactRenderer, adj_image: Tensor) -> dict[str, Tensor]:
    """Return dL/d(each input) by autograd through the reference, with the chords of the renderer's last call."""
    leaves = [tensor.clone().requires_grad_() for tensor in scene[:4]]
    counts = chord_counts(renderer._flattening, scene.points)
    image = reference.render(*leaves, scene.height, scene.width, counts)
    gradients = torch.autograd.grad((image * adj_image).sum(), leaves, materialize_grads=True)
    return dict(zip(GRADIENTS, gradients, strict=True))


def cotangent(scene: SceneTensors, seed: int = 1) -> Tensor:
    """Return a random dL/d(image) [h, w, 3]."""
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(scene.height, scene.width, 3, generator=generator, dtype=torch.float64)


def target_image(scene: SceneTensors, seed: int = 2) -> Tensor:
    """Return a random image [h, w, 3] to fit."""
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(scene.height, scene.width, 3, generator=generator, dtype=torch.float64)

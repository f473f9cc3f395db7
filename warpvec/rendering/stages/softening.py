"""Host side of stage 3b, softening: the blurred coverage of soft paths in place of their winding, and the adjoint."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import torch
import warp as wp
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.bezier import outline_boxes
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import LAYERS_MAX, SIGMA_MAX
from warpvec.geometry.structure import Structure
from warpvec.kernels import softening as kernels
from warpvec.kernels import softening_adjoint as adjoint_kernels
from warpvec.kernels.constants import GAUSSIAN_REACH, TILE
from warpvec.kernels.lanes import Lanes
from warpvec.rendering.launch import Launcher, as_warp
from warpvec.rendering.stages.binning import Binning, TileGrid
from warpvec.rendering.stages.coverage import Coverage
from warpvec.rendering.stages.flattening import Flattening


class _Taps(NamedTuple):
    """The Gaussians of S soft paths.

    Attributes:
        reach: pixels [S] (int32) that a pixel is blurred over, to each side.
        weights: share [S, taps] that a pixel gives to one so many pixels away, 0 beyond the reach: at least
            ``AT_ONCE`` - 1 zeros follow.
        slopes: derivative of the weights by the standard deviation [S, taps].
    """

    reach: Tensor
    weights: Tensor
    slopes: Tensor


def gaussian_taps(sigma: Tensor) -> _Taps:
    """Return the sampled Gaussians of standard deviation ``sigma`` [S] in pixels, each with a sum of 1."""
    wide = sigma.double()[:, None]
    reach = torch.ceil(GAUSSIAN_REACH * wide)
    # On a GPU this waits for its work, as a step with soft paths does anyway.
    count = int(reach.max()) + kernels.AT_ONCE
    away = torch.arange(count, dtype=torch.float64, device=sigma.device)
    weights = torch.where(away <= reach, torch.exp(-0.5 * (away / wide) ** 2), 0.0)
    slopes = weights * away**2 / wide**3
    total, change = (2.0 * each.sum(1, keepdim=True) - each[:, :1] for each in (weights, slopes))
    weights = weights / total
    slopes = slopes / total - weights * change / total
    return _Taps(reach[:, 0].int(), weights.to(sigma.dtype), slopes.to(sigma.dtype))


class _Stages:
    """The stages before this one, for layers with a ``margin`` of tiles."""

    def __init__(self, launch: Launcher, lanes: Lanes, grid: TileGrid, margin: int) -> None:
        self.margin = margin
        rim = 2 * margin * TILE
        self.flattening = Flattening(launch, lanes)
        self.binning = Binning(launch, lanes, TileGrid(grid.height + rim, grid.width + rim))
        self.coverage = Coverage(launch, lanes)


class Softening:
    """The layers of the soft paths of a scene. `begin` takes the scene; without soft paths `run` does nothing."""

    def __init__(self, launch: Launcher, lanes: Lanes, grid: TileGrid) -> None:
        self._launch, self._lanes, self._grid = launch, lanes, grid
        self._buffers = launch.make_buffers()
        self._kept: dict[int, _Stages] = {}
        self._stages: _Stages | None = None
        self._scene: Scene | None = None
        self._whole: Structure | None = None
        self._paths: Tensor

    def begin(self, scene: Scene) -> wp.array | None:
        """Take the soft paths of ``scene``, and return how far each path reaches [N]; None if none is soft.

        Raises:
            InputError: their layers have more than ``LAYERS_MAX`` pixels.
        """
        self._scene = None
        paths = _soft_paths(scene)
        if paths is None or scene.softness is None:
            return None
        self._select(scene.structure, paths)
        self._taps = gaussian_taps(scene.softness.sigma.detach()[paths].clamp_max(SIGMA_MAX))
        strokes, rows = scene.strokes, scene.segments.detach()[self._rows]
        self._strokes = None if strokes is None else strokes.map(lambda values: values.detach()[paths])
        self._check_layers(rows)
        self._segments, self._scene = rows, scene
        reach = torch.zeros(len(scene), dtype=torch.int32, device=paths.device)
        reach[paths] = self._taps.reach
        return as_warp(reach, wp.int32)

    def _select(self, structure: Structure, paths: Tensor) -> None:
        """Take the structure of the ``paths`` [S], unless it is the present one: to make it anew takes a while."""
        if structure is self._whole and torch.equal(paths, self._paths):
            return
        self._whole, self._paths = structure, paths
        self._structure, self._rows = structure.select(paths)

    def _check_layers(self, segments: Tensor) -> None:
        """Refuse soft paths of ``segments`` whose layers take too much memory: a short file can ask for that."""
        canvas = torch.tensor([self._grid.width, self._grid.height], device=segments.device)
        boxes = outline_boxes(segments, self._structure)
        reach = self._taps.reach if self._strokes is None else self._taps.reach + self._strokes.reach
        sides = (boxes[:, 2:] - boxes[:, :2]).nan_to_num(torch.inf)
        sides = torch.minimum(sides, canvas.to(sides)) + 2.0 * reach[:, None] + 2.0 * TILE
        pixels = float(sides.double().prod(1).sum())
        if not pixels <= LAYERS_MAX:
            rule = f"must have layers of at most {LAYERS_MAX:,} pixels together"
            raise InputError("soft paths", rule, f"{pixels:,.0f}", "make fewer paths soft, or the drawing smaller")

    def run(self, binning: Binning, slot_winding: wp.array) -> None:
        """Replace the windings of soft paths in ``slot_winding`` by their blurred coverage."""
        if self._scene is None:
            return
        stages = self._prepared_stages()
        stages.flattening.run(self._segments + float(stages.margin * TILE), self._structure, self._strokes)
        stages.binning.run(stages.flattening, self._structure.path_count, as_warp(self._taps.reach, wp.int32))
        stages.coverage.run(stages.flattening, stages.binning)
        self._set_arrays(stages.binning)
        run, layer = self._kernels, [self._layer(f"layer_{index}") for index in range(4)]
        self._each(run.cover_layers, [stages.coverage.slot_winding, layer[0]])
        self._each(run.blur, [layer[0], 0, *self._order, *self._weights[:2], layer[1]])
        self._each(run.turn, [layer[1], 0, *self._order, layer[2]])
        self._each(run.blur, [layer[2], 1, *self._order, *self._weights[:2], layer[3]])
        self._each(run.place_layers, [layer[3], *self._canvas(binning), slot_winding])

    def adjoint(
        self,
        binning: Binning,
        slot_winding: wp.array,
        adj_segments: Tensor,
        adj_width: Tensor | None = None,
        adj_sigma: Tensor | None = None,
    ) -> None:
        """Overwrite what belongs to soft paths: of ``adj_segments`` [R, 3, 2], ``adj_width`` and ``adj_sigma`` [N].

        ``slot_winding`` must hold dL/d(blurred coverage). It may be called again after the same `run`.
        """
        if adj_sigma is not None:
            adj_sigma.zero_()
        if self._scene is None:
            return
        assert self._stages is not None
        stages, run, turn = self._stages, self._adjoint_kernels, self._kernels.turn
        adj = [self._layer(f"adj_layer_{index}") for index in range(2)]
        upright, turned = self._layer("layer_0"), self._layer("layer_2")
        share = [self._share(f"sigma_share_{index}") for index in range(2)]
        self._each(run.take_layers, [slot_winding, *self._canvas(binning), adj[0]])
        self._each(run.blur_adjoint, [turned, adj[0], 1, *self._order, *self._weights, adj[1], share[0]])
        self._each(turn, [adj[1], 1, *self._order, adj[0]])
        self._each(run.blur_adjoint, [upright, adj[0], 0, *self._order, *self._weights, adj[1], share[1]])
        winding = stages.coverage.slot_winding
        size = self._pair_count * self._slot_values
        kept = wp.to_torch(winding).flatten()[:size].clone()
        self._each(run.uncover_layers, [adj[1], winding])
        adj_edges = stages.coverage.adjoint(stages.flattening, stages.binning, len(self._rows))
        found = torch.empty((len(self._rows), 3, 2), dtype=adj_segments.dtype, device=adj_segments.device)
        stages.flattening.adjoint(adj_edges, found)
        adj_segments[self._rows] = found
        if adj_width is not None:
            of_soft = adj_width.new_empty(len(self._paths))
            stages.flattening.widths_adjoint(of_soft)
            adj_width[self._paths] = of_soft
        wp.to_torch(winding).flatten()[:size] = kept
        if adj_sigma is not None:
            adj_sigma[self._paths] = self._sums(share)

    @property
    def _kernels(self) -> Any:
        return kernels.make_kernels(self._lanes)

    @property
    def _adjoint_kernels(self) -> Any:
        return adjoint_kernels.make_kernels(self._lanes)

    def _prepared_stages(self) -> _Stages:
        """Return the stages with just the margin needed: layers at another place would be rounded otherwise."""
        needed = math.ceil((self._taps.weights.shape[1] - kernels.AT_ONCE + 1) / TILE)
        if needed not in self._kept:
            self._kept[needed] = _Stages(self._launch, self._lanes, self._grid, needed)
        self._stages = self._kept[needed]
        return self._stages

    def _set_arrays(self, binning: Binning) -> None:
        # All pairs of the layers are partial, so that there are as many slots.
        self._pair_count = binning.slot_count
        self._order = [binning.pair_path, binning.path_tile_box, binning.path_first_pair]
        taps = self._taps
        tables = (as_warp(each, self._lanes.dtype) for each in (taps.weights, taps.slopes))
        self._weights: list[Any] = [as_warp(taps.reach, wp.int32), *tables]

    def _canvas(self, binning: Binning) -> list[Any]:
        assert self._stages is not None
        canvas = [binning.path_tile_box, binning.path_first_pair, binning.pair_slot]
        return [self._stages.margin, *self._order, as_warp(self._paths.int(), wp.int32), *canvas]

    def _layer(self, name: str) -> wp.array:
        return self._buffers.get(name, self._pair_count * TILE * self._lanes.blocks, self._lanes.vector)

    def _share(self, name: str) -> wp.array:
        return self._buffers.get(name, self._pair_count * self._lanes.tile_threads, self._lanes.dtype)

    @property
    def _slot_values(self) -> int:
        return (TILE + 1) * TILE

    def _each(self, kernel: Any, arguments: list[Any]) -> None:
        """Run ``kernel`` on every tile of the layers."""
        threads = self._lanes.tile_threads
        chunk = self._launch.chunk_items(self._pair_count) * threads
        self._launch.shared(kernel, self._pair_count * threads, arguments, chunk)

    def _sums(self, shares: list[wp.array]) -> Tensor:
        """Return the sum of ``shares`` over the tiles of each soft path [S], in a fixed order."""
        size = self._pair_count * self._lanes.tile_threads
        first, second = (wp.to_torch(share)[:size].double() for share in shares)
        running = torch.nn.functional.pad((first + second).reshape(self._pair_count, -1).sum(1).cumsum(0), (1, 0))
        assert self._stages is not None
        bounds = wp.to_torch(self._stages.binning.path_first_pair)[: len(self._paths) + 1].long()
        return running[bounds].diff().to(self._taps.weights.dtype)


def _soft_paths(scene: Scene) -> Tensor | None:
    """Return the soft paths of ``scene`` [S] (int64); None if there are none."""
    if scene.softness is None:
        return None
    paths = scene.softness.is_soft.detach().nonzero().flatten()
    return paths if len(paths) else None

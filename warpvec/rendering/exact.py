"""The exact renderer: a path covers its area, as SVG renderers draw it up to anti-aliasing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import torch
import warp as wp
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.kernels.constants import COLUMNS, PARTIAL, TILE
from warpvec.rendering.capacity import Counts
from warpvec.rendering.outline_adjoint import OutlineAdjoint
from warpvec.rendering.stages.binning import Binning
from warpvec.rendering.stages.compositing import Paint, planes_from_tiles
from warpvec.rendering.stages.coverage import Coverage
from warpvec.rendering.stages.flattening import Flattening
from warpvec.rendering.tile_renderer import Adjoints, Hits, TileRenderer


class ExactRenderer(TileRenderer):
    """Renderer of scenes of cubics; its arguments are those of every `TileRenderer`.

    Raises:
        InputError: ``degree`` is not 3.
    """

    def __init__(self, height: int, width: int, **machine: Any) -> None:
        super().__init__(height, width, **machine)
        if self.degree != 3:
            remedy = "convert it with warpvec.geometry.cubics.to_cubics"
            raise InputError("scene", "must have degree 3 for the renderer exact", str(self.degree), remedy)
        self._flattening = Flattening(self._launch, self._lanes)
        self._binning = Binning(self._launch, self._lanes, self.grid)
        self._coverage = Coverage(self._launch, self._lanes)

    def _cover(self, scene: Scene) -> Hits:
        self._flattening.run(scene.segments, scene.structure, scene.strokes)
        self._binning.run(self._flattening, len(scene))
        self._coverage.run(self._flattening, self._binning)
        paint = Paint(scene.color, scene.opacity, scene.background, self._lanes, scene.gradients)
        visible = self._compositing.find_visible(self._binning, paint)
        return self._binning, visible, self._coverage.slot_winding, paint

    def _collect(self, scene: Scene, adjoints: Adjoints) -> None:
        adj_edges = self._coverage.adjoint(self._flattening, self._binning, len(scene.segments))
        self._flattening.adjoint(adj_edges, adjoints.segments)
        if adjoints.width is not None:
            self._flattening.widths_adjoint(adjoints.width)
        self._adj_edges = adj_edges

    def outline_adjoint(self, scene: Scene) -> OutlineAdjoint:
        """Return a copy of the adjoint of the outlines of ``scene``, whose adjoints were computed last."""
        count = self._flattening.vertex_count
        first = wp.to_torch(self._flattening.segment_first_vertex)[: scene.structure.segment_count + 1]
        arrays = (self._flattening.vertices, self._adj_edges)
        vertices, adj_edges = (wp.to_torch(array)[:count].cpu().double() for array in arrays)
        return OutlineAdjoint(first.cpu().long(), vertices.reshape(count, 2), adj_edges.reshape(count, 4))

    def winding_slopes(self, scene: Scene, path: Tensor, x: Tensor, y: Tensor, channels: int = 3) -> Tensor:
        """Return how the pixel ``x`` [M], ``y`` [M] changes with the winding of ``path`` [M]: its first C ``channels``.

        These are [M, C], 0 where no edge of the path lies, and outside of the canvas. The indices are int64.
        """
        hits = self._cover(scene)
        binning, into = hits[0], self.make_adjoints(scene)
        place, is_inside = self._slot_places(binning, path, x, y)
        values = wp.to_torch(hits[2])
        winding, slopes = values.clone(), []
        tiles = torch.empty((self.grid.count, 3, TILE, TILE), dtype=self.dtype, device=self.device)
        for channel in range(channels):
            tiles.zero_()[:, channel] = 1.0
            values.copy_(winding)
            paint = self._paint_adjoints(into, into.opacity)
            self._compositing.adjoint(*hits, tiles, paint)
            slopes.append(torch.where(is_inside, values.reshape(-1)[place], 0.0))
        return torch.stack(slopes, 1)

    def shares(self, scene: Scene) -> Iterator[Tensor]:
        """Yield the visible share of each path in each pixel: three paths at a time, [3, h, w], the last one padded."""
        hits = self._cover(scene)
        tiles = torch.empty((self.grid.count, 3, TILE, TILE), dtype=self.dtype, device=self.device)
        for first in range(0, len(scene), 3):
            color = torch.zeros_like(scene.color)
            rows = torch.arange(first, min(first + 3, len(scene)), device=self.device)
            color[rows, rows - first] = 1.0
            gradients = None if scene.gradients is None else scene.gradients.of_one_color(color)
            paint = Paint(color, scene.opacity, torch.zeros_like(scene.background), self._lanes, gradients)
            self._compositing.run(*hits[:3], paint, tiles)
            yield planes_from_tiles(tiles, self.grid)

    def covered_tiles(self, scene: Scene) -> tuple[Tensor, Tensor]:
        """Return the pairs [K] of a path and a tile, counted by rows, of which the path covers a part or all."""
        self._flattening.run(scene.segments, scene.structure, scene.strokes)
        self._binning.run(self._flattening, len(scene))
        count = int(wp.to_torch(self._binning.tile_first_hit)[self.grid.count])
        hits = (wp.to_torch(each)[:count].long().cpu() for each in (self._binning.hit_pair, self._binning.hit_tile))
        pair, tile = hits
        return wp.to_torch(self._binning.pair_path).cpu()[pair].long(), tile

    def _slot_places(self, binning: Binning, path: Tensor, x: Tensor, y: Tensor) -> tuple[Tensor, Tensor]:
        """Return where the winding of ``path`` at each pixel lies in ``slot_winding``, and whether it lies there."""
        arrays = (binning.path_tile_box, binning.path_first_pair, binning.pair_class, binning.pair_slot)
        box, first, kinds, slots = (wp.to_torch(each).long() for each in arrays)
        left, top, right, bottom = box[path].unbind(1)
        column, row = x.div(TILE, rounding_mode="floor"), y.div(TILE, rounding_mode="floor")
        is_inside = (column >= left) & (column < right) & (row >= top) & (row < bottom)
        pair = torch.where(is_inside, first[path] + (row - top) * (right - left) + column - left, 0)
        is_inside &= kinds[pair] == PARTIAL
        place = (slots[pair] * COLUMNS + x % TILE) * TILE + y % TILE
        return torch.where(is_inside, place, 0), is_inside

    @property
    def counts(self) -> Counts:
        """Sizes of the last step."""
        binning = self._binning
        return Counts(self._flattening.vertex_count, binning.strip_count, binning.pair_count, binning.slot_count)

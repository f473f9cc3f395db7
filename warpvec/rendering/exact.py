"""The exact renderer: a path covers its area, as SVG renderers draw it up to anti-aliasing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import torch
import warp as wp
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.kernels.constants import COLUMNS, TILE
from warpvec.kernels.pixel_slopes import SLOPE_PLANES
from warpvec.rendering.capacity import Counts
from warpvec.rendering.outline_adjoint import OutlineAdjoint
from warpvec.rendering.stages.binning import Binning
from warpvec.rendering.stages.coverage import Coverage
from warpvec.rendering.stages.flattening import Flattening
from warpvec.rendering.stages.pixel_slopes import HitSlopes, PixelSlopes
from warpvec.rendering.stages.softening import Softening
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
        self._slopes = PixelSlopes(self._launch, self._lanes, self.grid)
        self._softening = Softening(self._launch, self._lanes, self.grid)

    def _cover(self, scene: Scene) -> Hits:
        self._kept = None
        self._flattening.run(scene.segments, scene.structure, scene.strokes)
        self._bin(scene)
        self._coverage.run(self._flattening, self._binning)
        self._softening.run(self._binning, self._coverage.slot_winding)
        paint = self._compositing.paint(scene.color, scene.opacity, scene.background, scene.gradients)
        visible = self._compositing.find_visible(self._binning, paint)
        return self._binning, visible, self._coverage.slot_winding, paint

    def _bin(self, scene: Scene) -> None:
        reach = self._softening.begin(scene)
        self._binning.run(self._flattening, len(scene), reach)

    def _collect(self, scene: Scene, adjoints: Adjoints) -> None:
        adj_edges = self._coverage.adjoint(self._flattening, self._binning, len(scene.segments))
        self._flattening.adjoint(adj_edges, adjoints.segments)
        if adjoints.width is not None:
            self._flattening.widths_adjoint(adjoints.width)
        winding = self._coverage.slot_winding
        self._softening.adjoint(self._binning, winding, adjoints.segments, adjoints.width, adjoints.softness)
        self._adj_edges = adj_edges

    def outline_adjoint(self, scene: Scene) -> OutlineAdjoint:
        """Return a copy of the adjoint of the outlines of ``scene``, whose adjoints were computed last.

        Those of soft paths are as if these were sharp.
        """
        count = self._flattening.vertex_count
        first = wp.to_torch(self._flattening.segment_first_vertex)[: scene.structure.segment_count + 1]
        arrays = (self._flattening.vertices, self._adj_edges)
        vertices, adj_edges = (wp.to_torch(array)[:count].cpu().double() for array in arrays)
        return OutlineAdjoint(first.cpu().long(), vertices.reshape(count, 2), adj_edges.reshape(count, 4))

    def pixel_slopes(self, scene: Scene) -> Iterator[HitSlopes]:
        """Yield how the pixels of ``scene`` change with paints and windings of its paths, some tiles at a time."""
        yield from self._slopes.run(*self._cover_again(scene))

    def outline_slopes(self, scene: Scene) -> Tensor:
        """Return how sums over all pixels change with the segments of ``scene``: [4, R, 3, 2].

        These are the sums of red, green and blue, and that of the transmittance of all paths.
        """
        hits = self._cover(scene)
        size = self._binning.slot_count * COLUMNS * TILE
        by_winding = np.zeros((SLOPE_PLANES, self._binning.slot_count, COLUMNS * TILE), np.float32)
        for part in self._slopes.run(*hits):
            slots = part.slot[part.is_partial]
            by_winding[:, slots, : TILE * TILE] = part.slopes[part.is_partial].swapaxes(0, 1)
        found = torch.empty((SLOPE_PLANES, *scene.segments.shape), dtype=self.dtype, device=self.device)
        winding = wp.to_torch(hits[2]).reshape(-1)[:size]
        for plane, out in zip(torch.from_numpy(by_winding), found, strict=True):
            winding.copy_(plane.reshape(-1))
            adj_edges = self._coverage.adjoint(self._flattening, self._binning, len(scene.segments))
            self._flattening.adjoint(adj_edges, out)
            self._softening.adjoint(self._binning, self._coverage.slot_winding, out)
        return found

    def covered_tiles(self, scene: Scene) -> tuple[Tensor, Tensor]:
        """Return the pairs [K] of a path and a tile, counted by rows, of which the path covers a part or all."""
        self._flattening.run(scene.segments, scene.structure, scene.strokes)
        self._bin(scene)
        count = int(wp.to_torch(self._binning.tile_first_hit)[self.grid.count])
        hits = (wp.to_torch(each)[:count].long().cpu() for each in (self._binning.hit_pair, self._binning.hit_tile))
        pair, tile = hits
        return wp.to_torch(self._binning.pair_path).cpu()[pair].long(), tile

    @property
    def counts(self) -> Counts:
        """Sizes of the last step."""
        binning = self._binning
        return Counts(self._flattening.vertex_count, binning.strip_count, binning.pair_count, binning.slot_count)

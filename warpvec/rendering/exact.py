"""The exact renderer: a path covers its area, as SVG renderers draw it up to anti-aliasing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import warp as wp

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.rendering.capacity import Counts
from warpvec.rendering.outline_adjoint import OutlineAdjoint
from warpvec.rendering.stages.binning import Binning
from warpvec.rendering.stages.compositing import Paint
from warpvec.rendering.stages.coverage import Coverage
from warpvec.rendering.stages.flattening import Flattening
from warpvec.rendering.stages.pixel_slopes import HitSlopes, PixelSlopes
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

    def pixel_slopes(self, scene: Scene) -> Iterator[HitSlopes]:
        """Yield how the pixels of ``scene`` change with paints and windings of its paths, some tiles at a time."""
        yield from self._slopes.run(*self._cover(scene))

    @property
    def counts(self) -> Counts:
        """Sizes of the last step."""
        binning = self._binning
        return Counts(self._flattening.vertex_count, binning.strip_count, binning.pair_count, binning.slot_count)

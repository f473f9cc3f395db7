"""The exact renderer: a path covers its area, as SVG renderers draw it up to anti-aliasing."""

from __future__ import annotations

import torch

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.kernels.constants import TRANSMITTANCE_MIN
from warpvec.rendering.capacity import Counts
from warpvec.rendering.stages.binning import Binning
from warpvec.rendering.stages.compositing import Paint
from warpvec.rendering.stages.coverage import Coverage
from warpvec.rendering.stages.flattening import Flattening
from warpvec.rendering.tile_renderer import Adjoints, Hits, TileRenderer


class ExactRenderer(TileRenderer):
    """Renderer of scenes of cubics.

    Raises:
        InputError: ``degree`` is not 3.
    """

    def __init__(
        self,
        height: int,
        width: int,
        *,
        device: str = "cpu",
        threads: int | None = None,
        dtype: torch.dtype = torch.float32,
        degree: int = 3,
        lane_width: int | None = None,
        transmittance_min: float = TRANSMITTANCE_MIN,
    ) -> None:
        if degree != 3:
            remedy = "convert it with warpvec.geometry.cubics.to_cubics"
            raise InputError("scene", "must have degree 3 for the renderer exact", str(degree), remedy)
        super().__init__(height, width, degree, device, threads, dtype, lane_width, transmittance_min)
        self._flattening = Flattening(self._launch, self._lanes)
        self._binning = Binning(self._launch, self._lanes, self.grid)
        self._coverage = Coverage(self._launch, self._lanes)

    def _cover(self, scene: Scene) -> Hits:
        self._flattening.run(scene.segments, scene.structure)
        self._binning.run(self._flattening, len(scene))
        self._coverage.run(self._flattening, self._binning)
        paint = Paint(scene.color, scene.opacity, scene.background, self._lanes, scene.gradients)
        visible = self._compositing.find_visible(self._binning, paint)
        return self._binning, visible, self._coverage.slot_winding, paint

    def _collect(self, scene: Scene, adjoints: Adjoints) -> None:
        adj_edges = self._coverage.adjoint(self._flattening, self._binning, len(scene.segments))
        self._flattening.adjoint(adj_edges, adjoints.segments)

    @property
    def counts(self) -> Counts:
        binning = self._binning
        return Counts(self._flattening.vertex_count, binning.strip_count, binning.pair_count, binning.slot_count)

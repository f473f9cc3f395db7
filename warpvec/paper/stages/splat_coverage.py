"""Host side of stage 3 of the splat renderer: the coverage of each pair's pixels, and its adjoint."""

from __future__ import annotations

import torch
import warp as wp
from torch import Tensor

from warpvec.kernels import splat_coverage as kernels
from warpvec.kernels import splat_coverage_adjoint as adjoint_kernels
from warpvec.kernels.constants import (
    COLOR_FALLOFF,
    COLUMNS,
    RELEASED_ALPHA_MAX,
    SPLAT_ALPHA_MAX,
    TRANSMITTANCE_MIN,
)
from warpvec.kernels.lanes import Lanes
from warpvec.paper.stages.splat_binning import SplatBinning
from warpvec.paper.stages.splatting import Splatting
from warpvec.rendering.launch import Launcher
from warpvec.rendering.stages.binning import TileGrid


class SplatCoverage:
    """The coverage of the pairs by the Gaussians of their paths.

    Attributes:
        slot_coverage: [slots, COLUMNS, TILE] as lane values; the compositing adjoint overwrites it with dL/d(coverage).
        slot_share: for which share of those pixels the path's colour answers, in the same layout; None where that is
            what it covers.
        tile_first_visible: [tiles] lowest visible hit of each tile.
    """

    slot_coverage: wp.array
    slot_share: wp.array | None

    def __init__(
        self,
        launch: Launcher,
        lanes: Lanes,
        grid: TileGrid,
        covariance: bool,
        transmittance_min: float = TRANSMITTANCE_MIN,
        released_adjoint: bool = False,
        color_weight: Tensor | None = None,
    ) -> None:
        self._launch, self._lanes, self._grid = launch, lanes, grid
        self._covariance, self._transmittance_min = covariance, lanes.dtype(transmittance_min)
        # An opacity is at most 1, so no alpha is 2.
        limits = (2.0, RELEASED_ALPHA_MAX) if released_adjoint else (SPLAT_ALPHA_MAX, SPLAT_ALPHA_MAX)
        self._adjoint_limits = [lanes.dtype(limit) for limit in limits]
        self._color_weight: wp.array | None = None
        if color_weight is not None:
            self._color_weight = wp.array(color_weight.numpy(), dtype=lanes.dtype, device=launch.device)
        self._buffers = launch.make_buffers()
        self.tile_first_visible = self._buffers.get("tile_first_visible", grid.count, wp.int32)

    def run(self, splatting: Splatting, binning: SplatBinning, row_opacity: wp.array) -> None:
        """Cover the pixels of each pair that is not hidden."""
        lanes, get = self._lanes, self._buffers.get
        value_count = (binning.slot_count + 1) * COLUMNS * lanes.blocks
        self.slot_coverage = get("slot_coverage", value_count, lanes.vector)
        self._slot_transmittance = get("slot_transmittance", value_count, lanes.vector)
        has_shares = self._color_weight is not None
        self.slot_share = get("slot_share", value_count, lanes.vector) if has_shares else None
        self._pair_is_visible = get("pair_is_visible", binning.pair_count, wp.int32)
        hits = [binning.tile_first_hit, binning.hit_pair, binning.pair_path, binning.pair_slot]
        counts = [splatting.row_count, splatting.sample_count, splatting.sample_stride, binning.group_count]
        size = [self._grid.columns, self._grid.height, self._grid.width]
        scene = [splatting.splats, binning.group_box, row_opacity]
        inputs = [*hits, *scene, *counts, *size, self._transmittance_min, self._color_weight]
        slots = [self.slot_coverage, self._slot_transmittance, self.slot_share]
        outputs = [*slots, self._pair_is_visible, self.tile_first_visible]
        cover = kernels.make_kernels(lanes, has_shares).cover_splats
        self._launch.shared(cover, self._grid.count * lanes.tile_threads, [*inputs, *outputs])

    def adjoint(self, splatting: Splatting, binning: SplatBinning, row_opacity: wp.array, path_count: int) -> wp.array:
        """Return the sums [N, rows, terms, sample_stride] of each Gaussian; ``slot_coverage`` must hold its adjoint."""
        lanes = self._lanes
        splat_count = path_count * splatting.row_count * splatting.sample_stride
        splat_sums = self._buffers.get("splat_sums", splat_count * splatting.term_count, lanes.dtype)
        pairs = [binning.path_tile_box, binning.path_first_pair, binning.pair_class, binning.pair_slot]
        inputs = [self._pair_is_visible, splatting.splats, row_opacity]
        counts = [splatting.row_count, splatting.sample_stride, self._grid.height, self._grid.width]
        pixels = [*self._adjoint_limits, self.slot_coverage, self._slot_transmittance]
        arguments = [*pairs, *inputs, *counts, *pixels, splat_sums]
        stage = adjoint_kernels.make_kernels(lanes, self._covariance)
        self._launch.shared(stage.cover_splats_adjoint, splat_count, arguments)
        return splat_sums


def color_weights(lines: int, samples: int) -> Tensor:
    """Return the weights [lines + 2, samples], float64, of Gaussians in the gradient of a path's colour: 1 on sides."""
    along = torch.linspace(-1.0, 1.0, samples, dtype=torch.float64).abs()
    across = torch.linspace(-1.0, 1.0, lines, dtype=torch.float64).abs()
    inside = 1.0 - torch.exp(-COLOR_FALLOFF * (across[:, None] + along))
    side = torch.ones(1, samples, dtype=torch.float64)
    return torch.cat([side, inside, side])

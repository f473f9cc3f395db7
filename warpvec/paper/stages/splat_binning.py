"""Host side of stage 2 of the splat renderer: Gaussians -> (path, tile) pairs and each tile's list of pairs."""

from __future__ import annotations

import warp as wp

from warpvec.kernels import splat_binning as kernels
from warpvec.kernels.constants import SPLAT_GROUP
from warpvec.kernels.lanes import Lanes
from warpvec.paper.stages.splatting import Splatting
from warpvec.rendering.launch import Launcher
from warpvec.rendering.stages.binning import Binning, TileGrid


class SplatBinning(Binning):
    """The (path, tile) pairs of a scene of Gaussians; ``kernels/splat_binning.py`` describes the arrays.

    Attributes:
        group_count: number of groups of Gaussians in a row.
        group_box: [N rows, group_count + 1] boxes in pixels; the last one of a row is that of the whole row.
    """

    group_box: wp.array

    def __init__(self, launch: Launcher, lanes: Lanes, grid: TileGrid, sample_count: int) -> None:
        super().__init__(launch, lanes, grid)
        self._needs_strips = True
        self._splat_kernels = kernels.make_kernels(lanes)
        self.group_count = -(-sample_count // SPLAT_GROUP)

    def bin_splats(self, splatting: Splatting, path_count: int) -> None:
        """Bin the Gaussians of ``path_count`` paths."""
        rows = [splatting.row_count, self.group_count]
        self._bound_groups(splatting, path_count)
        arrays = self._bound(path_count, self._splat_kernels.bound_splats, [self.group_box, *rows])
        del arrays["winding"]
        grid = [self._grid.columns, self._grid.count]
        arguments = [self.group_box, *rows, *grid, *self._boxes(), *arrays.values()]
        self._launch.shared(self._splat_kernels.classify_splats, self.strip_count, arguments)
        self._number_slots(arrays["is_partial"])
        self._sort()

    def _bound_groups(self, splatting: Splatting, path_count: int) -> None:
        row_count = path_count * splatting.row_count
        self.group_box = self._buffers.get("group_box", row_count * (self.group_count + 1), wp.vec4i)
        counts = [splatting.sample_count, splatting.sample_stride, self.group_count]
        arguments = [splatting.splats, *counts, self._grid.height, self._grid.width, self.group_box]
        self._launch.shared(self._splat_kernels.bound_groups, row_count, arguments)

"""Host side of stage 0 of the splat renderer: opacities of paths -> opacities of their rows, and the adjoint."""

from __future__ import annotations

import torch
import warp as wp
from torch import Tensor

from warpvec.geometry.side_opacity import SideOpacity
from warpvec.kernels import row_opacity as kernels
from warpvec.kernels import row_opacity_adjoint as adjoint_kernels
from warpvec.kernels.lanes import Lanes
from warpvec.paper.stages.splatting import Splatting, lane_view
from warpvec.rendering.launch import Launcher, as_warp


class RowOpacity:
    """The opacities of the rows of Gaussians of each path, of which there are ``lines`` and the two sides.

    Attributes:
        values: [N, rows].
    """

    values: wp.array

    def __init__(self, launch: Launcher, lanes: Lanes, lines: int) -> None:
        self._launch, self._lanes, self._row_count = launch, lanes, lines + 2
        self._share: wp.array = wp.array(row_shares(lines).numpy(), dtype=lanes.dtype, device=launch.device)
        self._buffers = launch.make_buffers()

    def run(self, opacity: Tensor, sides: SideOpacity | None) -> None:
        """Blend ``opacity`` [N] in the middle with that at the ``sides``; None: it is the same everywhere."""
        count = len(opacity) * self._row_count
        self.values = self._buffers.get("row_opacity", count, self._lanes.dtype)
        spread = kernels.make_kernels(self._lanes, sides is not None).spread_opacity
        self._launch(spread, count, [*self._inputs(opacity, sides), self.values])

    def adjoint(
        self, opacity: Tensor, sides: SideOpacity, splatting: Splatting, splat_sums: wp.array, adjoints: list[Tensor]
    ) -> None:
        """Fill ``adjoints``, of opacities [N] and of sides [N, 2], from the sums [N, rows, terms, sample_stride]."""
        lanes, count = self._lanes, len(opacity) * self._row_count
        stage = adjoint_kernels.make_kernels(lanes)
        adj_logit = self._buffers.get("adj_logit", count, lanes.dtype)
        blocks = splatting.sample_stride // lanes.width
        sums = [splatting.term_count, blocks, lane_view(splat_sums, lanes)]
        self._launch.shared(stage.sum_rows, count, [self.values, *sums, adj_logit])
        outputs = [as_warp(values, lanes.dtype) for values in adjoints]
        arguments = [*self._inputs(opacity, sides), adj_logit, *outputs]
        self._launch(stage.gather_opacities_adjoint, len(opacity), arguments)

    def _inputs(self, opacity: Tensor, sides: SideOpacity | None) -> list[object]:
        dtype = self._lanes.dtype
        value = None if sides is None else as_warp(sides.value, dtype)
        return [as_warp(opacity, dtype), value, None if sides is None else self._share, self._row_count]


def row_shares(lines: int) -> Tensor:
    """Return the shares [lines + 2, 3], float64, of the middle, side A and side B in the logit of each row.

    The lines of the first half, rounded down, lead from side A to the middle, the others from there to side B. As in
    Bezier Splatting's code two lines have the opacity of the middle.
    """
    first = torch.linspace(0.0, 1.0, lines // 2, dtype=torch.float64)
    second = torch.linspace(0.0, 1.0, lines - lines // 2, dtype=torch.float64)
    zeros = torch.zeros
    to_middle = torch.stack([first, 1.0 - first, zeros(len(first))], 1)
    to_side = torch.stack([1.0 - second, zeros(len(second)), second], 1)
    side_a, side_b = torch.tensor([[0.0, 1.0, 0.0]]), torch.tensor([[0.0, 0.0, 1.0]])
    return torch.cat([side_a, to_middle, to_side, side_b])

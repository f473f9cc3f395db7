"""Host side of `kernels/places.py`: places of new paths, drawn where their error is."""

from __future__ import annotations

import torch
import warp as wp
from torch import Tensor

from warpvec.fit.placement import BLOCK, blur_weights, sample_positions, uniform_numbers
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.places import make_kernels
from warpvec.rendering.launch import Launcher, as_warp, read_total, start_warp


class Places:
    """Draws what `sample_positions` does, by kernels on ``device``; the host waits once."""

    def __init__(self, device: str) -> None:
        start_warp()
        self._launch = Launcher(device, threads=1)
        self._buffers = self._launch.make_buffers()

    def draw(self, residual: Tensor, count: int, generator: torch.Generator) -> Tensor:
        """Return ``count`` positions [count, 2] in pixels for the squared errors ``residual`` [h, w].

        The arguments are those of `sample_positions`, which draws them if a pixel is drawn twice.
        """
        if not 0 < count <= residual.numel():
            return sample_positions(residual, count, generator)
        before = generator.get_state()
        center, redraw = self._drawn(residual.contiguous(), _numbers(count, generator).to(residual.device))
        if not read_total(redraw, 0):
            return center
        generator.set_state(before)
        return sample_positions(residual, count, generator)

    def _drawn(self, residual: Tensor, numbers: Tensor) -> tuple[Tensor, wp.array]:
        """Return positions for the random ``numbers`` [count, 5], and whether they must be drawn anew [1]."""
        lanes = make_lanes(1, wp.dtype_from_torch(residual.dtype))
        kernels, count, pixel_count = make_kernels(lanes), len(numbers), residual.numel()
        blurred = as_warp(self._blur(residual, kernels.blur_rows).flatten(), lanes.dtype)
        uniform, block_count = as_warp(numbers, wp.float64), -(-pixel_count // BLOCK)
        ends = self._buffers.front("ends", self._buffers.get("ends", block_count, wp.float64), block_count)
        pixels = self._buffers.front("pixels", self._buffers.get("pixels", count, wp.int32), count)
        redraw = self._buffers.get("redraw", 1, wp.int32)
        center = residual.new_empty(count, 2)
        self._launch(kernels.sum_blocks, block_count, [BLOCK, blurred, ends])
        self._launch(kernels.end_blocks, 1, [ends])
        self._launch(kernels.draw_pixels, count, [BLOCK, blurred, ends, uniform, pixels, redraw])
        outputs = [as_warp(center, lanes.dtype), redraw]
        self._launch(kernels.order_places, count, [residual.shape[1], pixels, uniform, *outputs])
        return center, redraw

    def _blur(self, residual: Tensor, kernel: object) -> Tensor:
        dtype = wp.dtype_from_torch(residual.dtype)
        weights = as_warp(residual.new_tensor(blur_weights()), dtype)
        for _ in range(2):
            blurred = residual.new_empty(residual.shape[::-1])
            self._launch(kernel, residual.numel(), [as_warp(residual, dtype), weights, as_warp(blurred, dtype)])
            residual = blurred
        return residual


def _numbers(count: int, generator: torch.Generator) -> Tensor:
    """Return the random numbers [count, 5] (float64) of places, in the order in which `sample_positions` draws them.

    They are for a block, for a pixel in it, the order of the place of this rank, and for both coordinates in the pixel.
    """
    block, pixel = uniform_numbers((count,), generator)[:, None], uniform_numbers((count, 1), generator)
    order = torch.randperm(count, generator=generator, device=generator.device).argsort()[:, None]
    return torch.cat([block, pixel, order.to(torch.float64), uniform_numbers((count, 2), generator)], 1)

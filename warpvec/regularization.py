"""Host side of the regularizers' adjoint; the regularizers themselves are in ``loss.py``."""

from __future__ import annotations

import warp as wp
from torch import Tensor

from warpvec.config import FitConfig
from warpvec.kernels import regularization as kernels
from warpvec.kernels.constants import TILE, XING_SCALE
from warpvec.kernels.lanes import make_lanes
from warpvec.launch import Launcher, as_warp


class Regularization:
    """The regularizers of a canvas, with the weights of ``config``."""

    def __init__(self, height: int, width: int, config: FitConfig, device: str) -> None:
        self._pixel = (2.0 / width, 2.0 / height)
        self._weights = (config.xing_weight * XING_SCALE, config.bezier_weight, config.opacity_weight)
        self._launch = Launcher(device, threads=1)

    def add_adjoint(self, points: Tensor, opacity: Tensor, adj_points: Tensor, adj_opacity: Tensor) -> None:
        """Add dL/dpoints [N, 3 S, 2] and dL/dopacity [N] of :func:`warpvec.loss.regularization`, in place."""
        lanes = make_lanes(1 if self._launch.device.is_cuda else TILE, wp.dtype_from_torch(points.dtype))
        path_count, segment_count = points.shape[0], points.shape[1] // 3
        inputs = [as_warp(points, lanes.vec2), as_warp(opacity, lanes.dtype), segment_count, path_count]
        settings = [lanes.vec2(*self._pixel), *(lanes.dtype(weight) for weight in self._weights)]
        outputs = [as_warp(adj_points, lanes.vec2), as_warp(adj_opacity, lanes.dtype)]
        kernel = kernels.make_kernels(lanes).add_regularizers
        self._launch(kernel, path_count, [*inputs, *settings, *outputs])

"""Host side of the regularizers' adjoint; the regularizers themselves are in ``loss.py``."""

from __future__ import annotations

import torch
import warp as wp
from torch import Tensor

from warpvec import loss
from warpvec.config import FitConfig
from warpvec.kernels import regularization as kernels
from warpvec.kernels.constants import TILE, XING_SCALE
from warpvec.kernels.lanes import make_lanes
from warpvec.launch import Launcher, as_warp


class Regularization:
    """The regularizers of a canvas, with the weights of ``config``, for curves of one degree."""

    def __init__(self, height: int, width: int, config: FitConfig, device: str, degree: int = 3) -> None:
        self._height, self._width, self._config, self._degree = height, width, config, degree
        self._pixel = (2.0 / width, 2.0 / height)
        self._weights = (config.xing_weight * XING_SCALE, config.bezier_weight, config.opacity_weight)
        self._launch = Launcher(device, threads=1)

    def add_adjoint(self, points: Tensor, opacity: Tensor, adj_points: Tensor, adj_opacity: Tensor) -> None:
        """Add dL/dpoints [N, M S, 2] and dL/dopacity [N] of :func:`warpvec.loss.regularization`, in place.

        By a kernel for cubics, by autograd for curves of another degree.
        """
        if self._degree == 3:
            self._add_of_cubics(points, opacity, adj_points, adj_opacity)
        else:
            self._add_by_autograd(points, opacity, adj_points, adj_opacity)

    def _add_of_cubics(self, points: Tensor, opacity: Tensor, adj_points: Tensor, adj_opacity: Tensor) -> None:
        lanes = make_lanes(1 if self._launch.device.is_cuda else TILE, wp.dtype_from_torch(points.dtype))
        path_count, segment_count = points.shape[0], points.shape[1] // 3
        inputs = [as_warp(points, lanes.vec2), as_warp(opacity, lanes.dtype), segment_count, path_count]
        settings = [lanes.vec2(*self._pixel), *(lanes.dtype(weight) for weight in self._weights)]
        outputs = [as_warp(adj_points, lanes.vec2), as_warp(adj_opacity, lanes.dtype)]
        kernel = kernels.make_kernels(lanes).add_regularizers
        self._launch(kernel, path_count, [*inputs, *settings, *outputs])

    @torch.enable_grad()
    def _add_by_autograd(self, points: Tensor, opacity: Tensor, adj_points: Tensor, adj_opacity: Tensor) -> None:
        points, opacity = points.detach().requires_grad_(), opacity.detach().requires_grad_()
        value = loss.regularization(points, opacity, self._width, self._height, self._config, self._degree)
        gradients = torch.autograd.grad(value, (points, opacity))
        adj_points += gradients[0]
        adj_opacity += gradients[1]

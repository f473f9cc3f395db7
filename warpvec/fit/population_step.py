"""One optimizer step of all paths: the launch of its kernel, with arguments that are prepared once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import torch
import warp as wp
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.parametrization import Parametrization
from warpvec.geometry.scene import Scene
from warpvec.kernels.adan import BETAS, CLAMPED, EPS, SIGMOID
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.population import make_kernels, threads_per_path
from warpvec.rendering.launch import Launcher, as_warp, start_warp


class PopulationStep:
    """The kernel that steps parameters by Adan and writes the resulting scene.

    Attributes:
        factor: what learning rates are multiplied by [1] (float64), in memory that the kernel reads. If it is not
            positive, a step changes nothing.
    """

    def __init__(self, config: FitConfig, parameters: Parametrization, device: torch.device) -> None:
        start_warp()
        self._rates = (config.lr_points, config.lr_color, config.lr_opacity)
        self._parameters = parameters
        self._launch = Launcher(str(device), threads=1)
        self.factor = torch.ones(1, dtype=torch.float64, device=device)

    def prepare(self, scene: Scene, planes: Sequence[Tensor], ages: Sequence[Tensor]) -> None:
        """Prepare the arguments for the present memory, which the coming steps read and overwrite.

        Args:
            scene: what the parameters stand for.
            planes: those of segments, colours, opacities and background.
            ages: steps taken by the segments [R], and by the paths and the background [N + 1] (int64).
        """
        dtype = wp.dtype_from_torch(scene.segments.dtype)
        lanes = make_lanes(1 if self._launch.device.is_cuda else TILE, dtype)
        unit, by_axis = self._parameters.unit, self._parameters.by_axis
        self._kernel = make_kernels(lanes, by_axis).step_population
        self._threads_per_path = threads_per_path(lanes, by_axis)
        color_form = SIGMOID if self._parameters.logit_color else CLAMPED
        log_betas = lanes.vec3(*(math.log(beta) for beta in BETAS))
        rates = [wp.vec3d(*self._rates), as_warp(self.factor, wp.float64)]
        betas = [lanes.vec3(*BETAS), log_betas, lanes.dtype(EPS)]
        age_arrays = [as_warp(age, wp.int64) for age in ages]
        first_segment = as_warp(scene.structure.path_first_segment, wp.int32)
        self._settings = [len(scene), lanes.vec2(*unit), color_form, *rates, *betas, first_segment, *age_arrays]
        outputs = (scene.segments.flatten(1), scene.color, scene.opacity[:, None], scene.background[None])
        self._arrays = [as_warp(values, dtype) for values in (*planes, *outputs)]

    def __call__(self, adjoints: Sequence[Tensor], row_count: int) -> None:
        """Step the first ``row_count`` paths, the background counting as one more.

        ``adjoints`` are those of the segments [R, 2 M], colours [N, 3], opacities [N, 1] and background [1, 3].
        """
        arrays = [_strided(values) for values in adjoints]
        self._launch(self._kernel, row_count * self._threads_per_path, [*self._settings, *arrays, *self._arrays])


def _strided(values: Tensor) -> Any:
    """Return ``values`` as a Warp array. Rows may be any stride apart, since adjoints are columns of wider sums."""
    dense = values.shape[1] == 1 or values.stride(1) == 1
    return wp.from_torch(values if dense else values.contiguous(), return_ctype=True)

"""One optimizer step of all paths: the launch of its kernel, with arguments that are prepared once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import torch
import warp as wp
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.opacity_columns import OpacityColumns
from warpvec.fit.parametrization import Parametrization, all_opacities
from warpvec.geometry.scene import Scene
from warpvec.kernels.adan import BETAS, CLAMPED, EPS, SIGMOID
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.population import make_kernels, threads_per_path
from warpvec.rendering.launch import Launcher, as_warp, is_recording, start_warp

CHAIN_MAX = 64
"""Most steps that follow each other without a look of the host: a chain of twelve, between two changes of the paths, is
usual. 64 steps of an H200 take 30 ms, so that the host sees a wish to stop in time."""


class PopulationStep:
    """The kernel that steps parameters by Adan and writes the resulting scene.

    Attributes:
        factor: what learning rates are multiplied by [1] (float64), in memory that the kernel reads. If it is not
            positive, a step changes nothing.
        factors: the same of the coming steps [CHAIN_MAX] (float64), of which `begin` takes one after the other.
        position: steps begun [1] (int32), on the device.
    """

    def __init__(self, config: FitConfig, parameters: Parametrization, device: torch.device) -> None:
        start_warp()
        self._rates = (config.lr_points, config.lr_color, config.lr_opacity)
        self._parameters = parameters
        self._launch, self._columns = Launcher(str(device), threads=1), OpacityColumns(str(device))
        self.factor = torch.ones(1, dtype=torch.float64, device=device)
        self.factors = torch.ones(CHAIN_MAX, dtype=torch.float64, device=device)
        self.position = torch.zeros(1, dtype=torch.int32, device=device)

    def prepare(self, scene: Scene, planes: Sequence[Tensor], ages: Sequence[Tensor], counts: Tensor) -> None:
        """Prepare the arguments for the present memory, which the coming steps read and overwrite.

        Args:
            scene: what the parameters stand for; it may have room for more paths.
            planes: those of segments, colours, opacities and background.
            ages: steps taken by the segments [R], and by the paths and the background [N + 1] (int64).
            counts: number of paths that there are [1] (int32).
        """
        dtype = wp.dtype_from_torch(scene.segments.dtype)
        lanes = make_lanes(1 if self._launch.device.is_cuda else TILE, dtype)
        unit, by_axis = self._parameters.unit, self._parameters.by_axis
        stage = make_kernels(lanes, by_axis)
        self._kernel, self._begin = stage.step_population, stage.begin_step
        self._threads_per_path = threads_per_path(lanes, by_axis)
        color_form = SIGMOID if self._parameters.logit_color else CLAMPED
        log_betas = lanes.vec3(*(math.log(beta) for beta in BETAS))
        rates = [wp.vec3d(*self._rates), as_warp(self.factor, wp.float64, whole=True)]
        betas = [lanes.vec3(*BETAS), log_betas, lanes.dtype(EPS)]
        age_arrays = [as_warp(age, wp.int64, whole=True) for age in ages]
        first_segment = as_warp(scene.structure.path_first_segment, wp.int32, whole=True)
        self._path_count, self._segment_count, self._ages = len(scene), scene.structure.segment_count, age_arrays
        count = as_warp(counts, wp.int32, whole=True)
        self._settings = [len(scene), count, lanes.vec2(*unit), color_form, *rates, *betas, first_segment, *age_arrays]
        # Three opacities a path are written to memory of their own, and from there to the scene.
        self._opacities, self._scene = all_opacities(scene), scene
        outputs = (scene.segments.flatten(1), scene.color, self._opacities, scene.background[None])
        self._arrays = [as_warp(values, dtype, whole=True) for values in (*planes, *outputs)]

    def begin(self, step_fits: Tensor, fits: Tensor) -> None:
        """Take the next of ``factors`` and age what is stepped, in one launch.

        Nothing changes if ``step_fits`` or ``fits`` [1] is -1 and not 1; the lower one becomes ``fits``.
        """
        flags = [as_warp(values, wp.float64) for values in (step_fits, self.factors, fits)]
        sizes, position = [self._path_count, self._segment_count], as_warp(self.position, wp.int32)
        arguments = [*sizes, *flags, position, *self._ages, as_warp(self.factor, wp.float64)]
        self._launch(self._begin, max(self._path_count + 1, self._segment_count), arguments)

    def __call__(self, adjoints: Sequence[Tensor], has_background: bool) -> None:
        """Step the paths, and the background if it is a parameter.

        ``adjoints`` are those of the segments [R, 2 M], colours [N, 3], opacities [N] or [N, 3] and
        background [1, 3].
        """
        arrays = [_strided(values) for values in adjoints]
        count = self._path_count + has_background
        self._launch(self._kernel, count * self._threads_per_path, [*self._settings, *arrays, *self._arrays])
        if self._scene.side_opacity is not None:
            self._columns.part(self._opacities, self._scene.opacity, self._scene.side_opacity)


def _strided(values: Tensor) -> Any:
    """Return ``values`` as a Warp array. Rows may be any stride apart, since adjoints are columns of wider sums."""
    values = values if values.dim() == 2 else values[:, None]
    dense = values.shape[1] == 1 or values.stride(1) == 1
    return wp.from_torch(values if dense else values.contiguous(), return_ctype=not is_recording())

"""Draw black and white art: outline the dark areas by one black path."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.fit.loop import single_torch_thread
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.mono import MONO
from warpvec.flat.mono import mono_tracing
from warpvec.modes.flat import drawn, finished, reduced_settings
from warpvec.modes.request import Request


@dataclass(frozen=True)
class Mono:
    """The mode of black and white art."""

    def draw(self, request: Request) -> Drawing:
        """Return the drawing of black and white art. A goal decides the detail.

        With the default detail the tolerance follows the noise of the picture; else it is proportional to the detail.
        """
        settings, threshold = reduced_settings(request), request.settings.threshold

        def draw(detail: float) -> Drawing:
            tracing = mono_tracing(
                request.picture.reduced,
                "auto" if threshold == "auto" else float(threshold),
                tolerance=None if detail == FitConfig.detail else CURVES.tolerance * detail / FitConfig.detail,
                min_area=max(MONO.area_min, settings.min_area),
                watch=request.watch,
            )
            return finished(request, tracing.scene, detail, {"speck": tracing.speck_count})

        with single_torch_thread(), torch.no_grad():
            return drawn(request, draw)

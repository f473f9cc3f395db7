"""What a fit draws on: a target at one size, and its renderer. Scenes and adjoints are in pixels of the full size."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from typing import Any

from torch import Tensor
from torch.nn.functional import avg_pool2d

from warpvec.config import FitConfig
from warpvec.scene import Scene


class Canvas:
    """``target`` [h, w, 3], or its average over squares of ``reduction`` x ``reduction`` pixels, on ``device``."""

    def __init__(self, target: Tensor, config: FitConfig, device: str, reduction: int = 1) -> None:
        self._target = reduced(target, reduction)
        self._scale = 1.0 / reduction
        height, width = self._target.shape[:2]
        module = import_module(f"warpvec.{config.renderer}")
        settings = config.renderer_settings
        self._renderer = module.Renderer(height, width, device=device, threads=config.threads, **settings)
        self._prepared_target = self._renderer.prepare_target(self._target)

    def fit_step(self, scene: Scene, removal: bool) -> Any:
        """Adjoints of the mean squared error of ``scene``; ``removal`` asks for each path's importance."""
        points = scene.points if self._scale == 1.0 else scene.points * self._scale
        adjoints = self._renderer.fit_step(
            points, scene.color, scene.opacity, scene.background, self._prepared_target, removal
        )
        return adjoints if self._scale == 1.0 else replace(adjoints, points=adjoints.points * self._scale)

    def squared_error(self, scene: Scene) -> Tensor:
        """The squared error of ``scene``, summed over the channels, in each pixel of the target."""
        image = self._renderer.render(scene.points * self._scale, scene.color, scene.opacity, scene.background)
        error: Tensor = (image - self._target).square().sum(-1)
        return error


def reduced(image: Tensor, reduction: int) -> Tensor:
    """Averages over squares of pixels of ``image`` [h, w, 3]; those at the right and bottom may be cut."""
    if reduction == 1:
        return image
    planes = avg_pool2d(image.permute(2, 0, 1)[None], reduction, ceil_mode=True, count_include_pad=False)
    return planes[0].permute(1, 2, 0).contiguous()

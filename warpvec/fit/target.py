"""What a fit draws on: a target at one size, and its renderer. Scenes and adjoints are in pixels of the full size."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d

from warpvec.config.fit_config import FitConfig
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import ALPHA_MIN, MATTES, is_transparent, over, premultiplied
from warpvec.rendering.graph import RecordedStep
from warpvec.rendering.registry import make_renderer


class Target:
    """``target`` [h, w, 3 or 4], or its average over squares of ``reduction`` x ``reduction`` pixels, on ``device``.

    A target with alpha, which is straight, is compared on a black and on a white page, in place of the scene's
    background. One renderer does for both, at twice the time: what is under the paths shows by what they let through.

    Attributes:
        fits: [1] float64 on the device, 1, or -1 if the last step had too little room: its adjoints are zero, and the
            paths, and what is known of their gradients, are to stay as they are.
    """

    def __init__(self, target: Tensor, config: FitConfig, device: str, reduction: int = 1) -> None:
        self._pages = [(reduced(shown, reduction), page) for shown, page in _pages(target)]
        self._scale = 1.0 / reduction
        height, width = self._pages[0][0].shape[:2]
        self._renderer = make_renderer(
            height=height, width=width, device=device, degree=config.point_degree, **config.render_settings
        )
        self._prepared = [(self._renderer.prepare_target(shown), page) for shown, page in self._pages]
        self._steps = [RecordedStep(self._renderer) for _ in self._pages]
        self._points = torch.empty(0, device=target.device)
        self.fits = self._renderer.fits

    def fit_step(self, scene: Scene, removal_cost: bool) -> Any:
        """Adjoints of the mean squared error of ``scene``; ``removal_cost`` asks for each path's importance.

        All but the loss lie in memory that the next step overwrites.
        """
        paths = (self._reduced_points(scene.points), scene.color, scene.opacity)
        adjoints = _mean_adjoints(
            [
                step.take(*paths, scene.background if page is None else page, prepared, removal_cost)
                for step, (prepared, page) in zip(self._steps, self._prepared, strict=True)
            ]
        )
        if self._scale != 1.0:
            adjoints.points.mul_(self._scale)
        return replace(adjoints, canvas=adjoints.canvas.clone())

    def pause_recording(self, is_paused: bool) -> None:
        """Have the next steps launch each of their kernels, as a stopwatch around the stages needs it, or no longer."""
        for step in self._steps:
            step.is_paused = is_paused

    def _reduced_points(self, points: Tensor) -> Tensor:
        if self._scale == 1.0:
            return points
        if self._points.shape != points.shape:
            self._points = torch.empty_like(points)
        return torch.mul(points, self._scale, out=self._points)

    def visible_areas(self, scene: Scene) -> Tensor:
        """What is seen of each path, and last of the canvas [N + 1]: coverage times all that is let through, summed
        over the pixels of the full size."""
        points = scene.points * self._scale
        ones = torch.ones_like(self._pages[0][0])
        adjoints = self._renderer.adjoint(points, scene.color, scene.opacity, scene.background, ones)
        shown: Tensor = torch.cat([adjoints.color[:, 0], adjoints.background[:1]])
        return shown / self._scale**2

    def squared_error(self, scene: Scene) -> Tensor:
        """The squared error of ``scene``, summed over the channels, in each pixel of the target."""
        paths = (scene.points * self._scale, scene.color, scene.opacity)
        errors = [
            (self._renderer.render(*paths, scene.background if page is None else page) - shown).square().sum(-1)
            for shown, page in self._pages
        ]
        return torch.stack(errors).mean(0)


def blank_error(target: Tensor, background: Tensor) -> Tensor:
    """The squared error [h, w] of nothing on ``background`` [3], or on the pages that ``target`` has in its place."""
    errors = [(shown - (background if page is None else page)).square().sum(-1) for shown, page in _pages(target)]
    return torch.stack(errors).mean(0)


def paint_colors(target: Tensor) -> Tensor:
    """The colours [h, w, 3] of ``target`` [h, w, 3 or 4]; where nothing is to be seen, those of what is around."""
    if not is_transparent(target):
        return target
    return _seen_colors(premultiplied(target) * (target[..., 3:] >= ALPHA_MIN))


def reduced(image: Tensor, reduction: int) -> Tensor:
    """Averages over squares of pixels of ``image`` [h, w, c]; those at the right and bottom may be cut."""
    if reduction == 1:
        return image
    planes = avg_pool2d(image.permute(2, 0, 1)[None], reduction, ceil_mode=True, count_include_pad=False)
    return planes[0].permute(1, 2, 0).contiguous()


def _pages(target: Tensor) -> Iterator[tuple[Tensor, Tensor | None]]:
    """What ``target`` shows [h, w, 3], and the colour [3] of the page it is on, if that is not the scene's to say."""
    if not is_transparent(target):
        yield target, None
        return
    for page in MATTES:
        yield over(target, page), target.new_full((3,), page)


def _mean_adjoints(adjoints: list[Any]) -> Any:
    if len(adjoints) == 1:
        return adjoints[0]
    names = [name for name, value in vars(adjoints[0]).items() if value is not None]
    return replace(adjoints[0], **{n: torch.stack([getattr(a, n) for a in adjoints]).mean(0) for n in names})


def _seen_colors(image: Tensor) -> Tensor:
    """Straight colours of ``image`` [h, w, 4], premultiplied; where there are none, those of its reduction by half."""
    alpha = image[..., 3:]
    color = (image[..., :3] / alpha).nan_to_num(0.0)
    if bool((alpha > 0.0).all()) or alpha.numel() == 1:
        return color
    around = _seen_colors(reduced(image, 2)).repeat_interleave(2, 0).repeat_interleave(2, 1)
    return torch.where(alpha > 0.0, color, around[: image.shape[0], : image.shape[1]])

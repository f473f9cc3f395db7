"""What a fit gives a user: the file's scene, its text, its picture, and figures measured on the file."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import MACHINE_SETTINGS, FitConfig
from warpvec.errors import InputError
from warpvec.files import check_writable, encode_svg, gzip_bytes, write_atomic
from warpvec.fit.progress import FitResult
from warpvec.fit.target import Target
from warpvec.fit.visibility import canvas_areas, changes_alone, visible_areas, without_invisible
from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr
from warpvec.image.resize import reduce_image
from warpvec.image.write import round_to_8_bits
from warpvec.rendering.draw import draw_exactly, draw_pixels
from warpvec.svg.layers import prefixes, read_layers
from warpvec.svg.measure import draw, evaluate, file_facts, measure_psnr
from warpvec.svg.write import quantize, write_svg
from warpvec.vectorization.goal import Goal, Trial


@dataclass(frozen=True, eq=False)
class Result:
    """A fitted photo.

    Attributes:
        photo: the photo [h, w, 3], sRGB-encoded in [0, 1], as it was read, or [h, w, 4] with straight alpha.
        fitted_size: height and width in pixels of the reduced photo that was fitted.
        config: every setting of the fit.
        fitted: what the fit returned, in pixels of the reduced photo.
        title: title of the SVG, None for none.
        goal_facts: what was asked of the file and what became of it, if there was a goal.
    """

    photo: NDArray[np.float32]
    fitted_size: tuple[int, int]
    config: FitConfig
    fitted: FitResult
    title: str | None = None
    goal_facts: dict[str, Any] | None = None

    @cached_property
    def scene(self) -> Scene:
        """The scene as the file says it: cubics in pixels of the photo, rounded to the file's precision."""
        scene = quantize(self._cubics[0], self.config.precision)
        return self._without_small(self._without_invisible(scene))

    @cached_property
    def _cubics(self) -> tuple[Scene, float]:
        """The fitted scene as cubics in pixels of the photo, and how far they are from it at most, in these pixels."""
        height, width = self.photo.shape[:2]
        fitted_height, fitted_width = self.fitted_size
        return to_cubics(self.fitted.scene.scaled(width / fitted_width, height / fitted_height))

    @property
    def history(self) -> list[dict[str, float]]:
        """Records along the fit: iteration, curves, psnr (internal, dB), seconds since the start."""
        return self.fitted.history

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the fit early; the result is then the best until that moment."""
        return self.fitted.interrupted

    def svg(self) -> str:
        """The text of the SVG; its user units are the photo's pixels."""
        return self._text

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the SVG to ``path``, whole or not at all; gzipped if the name ends in ``.svgz``.

        Raises:
            InputError: ``path`` cannot be written.
        """
        check_writable(path, "path")
        write_atomic(path, encode_svg(self.svg(), path))

    def render(self, scale: float = 1.0) -> NDArray[np.float32]:
        """The file's scene drawn with exact coverage, [h, w, 3] with h and w ``scale`` times the photo's, rounded.

        Where the photo has alpha, so has the image: [h, w, 4], straight.
        That is so whatever the fit was rendered with; what the renderer "splat" makes of it is `soft_image`.

        Raises:
            InputError: ``scale`` is not above 0.
        """
        if not 0 < scale < float("inf"):
            raise InputError(f"scale must be above 0 and finite, got {scale!r}; 1 gives the photo's size")
        height, width = (max(1, round(side * scale)) for side in self.photo.shape[:2])
        x_factor, y_factor = width / self.photo.shape[1], height / self.photo.shape[0]
        return draw_exactly(self.scene.scaled(x_factor, y_factor), height, width, self.config.threads)

    def soft_image(self) -> NDArray[np.float32]:
        """The fitted scene, neither converted nor rounded, as the fit saw it: [h, w, 3 or 4], in the `fitted_size`."""
        return draw_pixels(self.fitted.scene, *self.fitted_size, **self.config.render_settings)

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """Plain values that describe the result; computed at the first use.

        ``psnr`` (dB) and ``ssim`` compare the photo with the file as resvg draws it: over black and over white, if the
        photo is ``transparent``, the mean of the errors on both. ``internal_psnr`` is that of the renderer of the fit,
        clamped and rounded to 8 bits as the drawing is (0.01 dB at 32 dB): with "exact" of `render`, against the photo;
        with "splat" of `soft_image`, against the reduced photo. ``conversion_px`` is how far the cubics of the file are
        from the fitted curves at most, in pixels of the photo, before rounding. ``bytes`` and ``gzip_bytes`` are
        sizes of the SVG text, plain and gzipped. ``levels``, of a fit with ``lod``: of each prefix of the layers its
        ``curves`` and ``psnr``. ``goal``: what was asked and what came of it.
        """
        height, width = self.photo.shape[:2]
        opacity = self.scene.opacity
        return {
            **evaluate(self.svg(), self.photo),
            "renderer": self.config.renderer,
            "internal_psnr": self._internal_psnr(),
            "degree": self.fitted.scene.degree,
            "conversion_px": self._cubics[1],
            "mean_opacity": opacity.mean().item() if len(opacity) else 0.0,
            "width": width,
            "height": height,
            "fitted_width": self.fitted_size[1],
            "fitted_height": self.fitted_size[0],
            "iterations": self.fitted.iterations,
            "seconds": self.fitted.seconds,
            "device": self.fitted.device,
            "interrupted": self.interrupted,
            "goal": self.goal_facts,
            "levels": self._levels() if self.config.lod else None,
        }

    def trial(self, goal: Goal) -> Trial:
        """The figures of the file that ``goal`` asks for."""
        svg = self.svg().encode()
        size = len(gzip_bytes(svg)) if goal.gzip else len(svg)
        return Trial(self.config.curves, len(self.scene), size, measure_psnr(svg, self.photo))

    def without(self, count: int) -> Result:
        """The same without the ``count`` paths that are missed least; the others stay as they are."""
        scene = self.fitted.scene
        canvas = Target(torch.from_numpy(reduce_image(self.photo, self.config.fit_size)), self.config, "cpu")
        with torch.no_grad():
            removal_cost = canvas.fit_step(scene, True).removal_cost
        rows = removal_cost.topk(len(scene) - count).indices.sort().values
        return replace(self, fitted=replace(self.fitted, scene=scene.select(rows)))

    def _without_invisible(self, scene: Scene) -> Scene:
        height, width = self.photo.shape[:2]

        def pixels(some: Scene) -> bytes:
            return draw(
                write_svg(some, width, height, precision=self.config.precision),
                width,
                height,
                transparent=some.transparent,
            ).tobytes()

        shown, changes = self._areas(visible_areas, scene), self._areas(changes_alone, scene)
        return without_invisible(scene, shown, changes, pixels)

    def _without_small(self, scene: Scene) -> Scene:
        if self.config.min_area == 0:
            return scene
        return scene.select(self._areas(canvas_areas, scene) >= self.config.min_area)

    def _areas(self, measured: Callable[..., Tensor], scene: Scene) -> Tensor:
        """Areas [N] in square pixels of the photo, measured at the size of the fit."""
        (height, width), (rows, columns) = self.photo.shape[:2], self.fitted_size
        x_factor, y_factor = columns / width, rows / height
        areas = measured(scene.scaled(x_factor, y_factor), rows, columns, self.config.threads)
        return areas / (x_factor * y_factor)

    def _levels(self) -> list[dict[str, Any]]:
        """Curves and PSNR of each prefix of the layers, a picture of its own."""
        if not read_layers(self.svg()):  # where no path is left
            return []
        found = ((level, text, file_facts(text)["paths"]) for level, text in prefixes(self.svg()))
        return [{"level": k, "curves": n, "psnr": measure_psnr(text, self.photo)} for k, text, n in found]

    def _internal_psnr(self) -> float:
        if self.config.renderer == "exact":
            return psnr(round_to_8_bits(self.render()), self.photo)
        return psnr(round_to_8_bits(self.soft_image()), reduce_image(self.photo, self.config.fit_size))

    @cached_property
    def _text(self) -> str:
        height, width = self.photo.shape[:2]
        settings = {name: value for name, value in self.config.to_dict().items() if name not in MACHINE_SETTINGS}
        precision = self.config.precision
        return write_svg(self.scene, width, height, precision=precision, title=self.title, metadata=settings)

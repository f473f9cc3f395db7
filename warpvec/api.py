"""The Python interface: an image in, a `Result` out."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.autograd import render
from warpvec.config import FitConfig, make_config
from warpvec.config_rules import RENDERER_SETTINGS
from warpvec.cubics import to_cubics
from warpvec.errors import InputError
from warpvec.files import check_writable, encode_svg, write_atomic
from warpvec.fit import FitResult, Progress, fit
from warpvec.image import ImageSource, fit_image, read_image
from warpvec.launch import resolve_device
from warpvec.scene import Scene
from warpvec.svg import quantize, write_svg
from warpvec.transparency import is_transparent, straight
from warpvec.verify import file_facts, measure, psnr

OnProgress = Callable[[Progress], None]

BAND_PIXELS = 4_000_000
"""Pixels drawn at a time outside the fit: the renderer's working memory, some 100 bytes a pixel, stays under a GB."""

# Settings that leave the fit's result alone; the file must not depend on them either.
_UNRECORDED = ("threads", "device")


@dataclass(frozen=True, eq=False)
class Result:
    """A fitted photo.

    Attributes:
        photo: the photo [h, w, 3], sRGB-encoded in [0, 1], as it was read, or [h, w, 4] with straight alpha.
        fitted_size: height and width in pixels of the reduced photo that was fitted.
        config: every setting of the fit.
        fitted: what the fit returned, in pixels of the reduced photo.
        title: title of the SVG, None for none.
    """

    photo: NDArray[np.float32]
    fitted_size: tuple[int, int]
    config: FitConfig
    fitted: FitResult
    title: str | None = None

    @cached_property
    def scene(self) -> Scene:
        """The scene as the file says it: cubics in pixels of the photo, rounded to the file's precision."""
        return quantize(self._cubics[0], self.config.precision)

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
        return _draw_exactly(self.scene.scaled(x_factor, y_factor), height, width, self.config.threads)

    def soft_image(self) -> NDArray[np.float32]:
        """The fitted scene, neither converted nor rounded, as the fit saw it: [h, w, 3 or 4], in the `fitted_size`."""
        return draw_as_fitted(self.fitted.scene, *self.fitted_size, self.config)

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """Plain values that describe the result; computed at the first use.

        ``psnr`` (dB) and ``ssim`` compare the photo with the file as resvg draws it: over black and over white, if the
        photo is ``transparent``, the mean of the errors on both. ``internal_psnr`` is that of the renderer of the fit,
        clamped and rounded to 8 bits as the drawing is (0.01 dB at 32 dB): with "exact" of `render`, against the photo;
        with "splat" of `soft_image`, against the reduced photo. ``conversion_px`` is how far the cubics of the file are
        from the fitted curves at most, in pixels of the photo, before rounding. ``bytes`` and ``gzip_bytes`` are
        sizes of the SVG text, plain and gzipped.
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
        }

    def _internal_psnr(self) -> float:
        if self.config.renderer == "exact":
            return psnr(_eight_bits(self.render()), self.photo)
        return psnr(_eight_bits(self.soft_image()), fit_image(self.photo, self.config.fit_size))

    @cached_property
    def _text(self) -> str:
        height, width = self.photo.shape[:2]
        settings = {name: value for name, value in self.config.to_dict().items() if name not in _UNRECORDED}
        precision = self.config.precision
        return write_svg(self.scene, width, height, precision=precision, title=self.title, metadata=settings)


def vectorize(
    image: ImageSource,
    curves: int = 512,
    *,
    preset: str = "default",
    background: str | None = None,
    on_progress: OnProgress | None = None,
    **settings: Any,
) -> Result:
    """Turns ``image`` into ``curves`` closed Bezier paths.

    Args:
        image: a path, the bytes of an image file, a PIL image, or an array as `warpvec.image.read_image` takes.
        curves: number of paths.
        preset: one of `warpvec.PRESETS`: "draft", "default", "best", "paper" or "bezier-splatting".
        background: colour behind a transparent image; None keeps it transparent.
        on_progress: called after every iteration; keep it cheap.
        settings: fields of `warpvec.FitConfig` that replace those of the preset.

    Raises:
        InputError: the image cannot be read, or a setting is wrong.
    """
    config = make_config(preset, curves=curves, **settings)
    resolve_device(config.device)  # an unknown one is found before the photo is read
    photo = read_image(image, background, name="image")
    title = Path(image).stem if isinstance(image, str | os.PathLike) else None
    return fit_photo(photo, config, title=title, on_progress=on_progress)


def fit_photo(
    photo: NDArray[np.float32],
    config: FitConfig,
    *,
    title: str | None = None,
    on_progress: OnProgress | None = None,
) -> Result:
    """Fits ``photo`` [h, w, 3 or 4], reduced to ``config.fit_size``, as `read_image` gives it."""
    target = fit_image(photo, config.fit_size)
    fitted = fit(torch.from_numpy(target), config, on_progress)
    height, width = target.shape[:2]
    return Result(photo, (height, width), config, fitted, title)


def evaluate(svg: str | bytes, photo: NDArray[Any]) -> dict[str, Any]:
    """Counts, sizes, PSNR (dB) and SSIM of any SVG, drawn by resvg at the size of ``photo`` [h, w, 3].

    Keys: curves (its <path> elements), segments, bytes, gzip_bytes, psnr, ssim, transparent: whether the photo is
    [h, w, 4], with straight alpha, and PSNR and SSIM are those over black and over white.

    Raises:
        InputError: not an SVG, refused as unsafe, or not of the photo's proportions.
    """
    facts = file_facts(svg)
    sizes = {"curves": facts["paths"], "segments": facts["segments"], "bytes": facts["bytes"]}
    quality = {**measure(svg, photo), "transparent": is_transparent(photo)}
    return {**sizes, "gzip_bytes": facts["gzip_bytes"], **quality}


def draw_as_fitted(scene: Scene, height: int, width: int, config: FitConfig) -> NDArray[np.float32]:
    """The image [h, w, 3] of ``scene``, or [h, w, 4], straight, by the renderer of ``config`` with its settings."""
    settings = {name: getattr(config, name) for name in RENDERER_SETTINGS[config.renderer]}
    return _draw(scene, height, width, renderer=config.renderer, threads=config.threads, **settings)


def _eight_bits(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """``image`` clamped and rounded, in place, to what an 8-bit file can say."""
    np.clip(image, 0.0, 1.0, out=image)
    np.rint(np.multiply(image, 255.0, out=image), out=image)
    return np.divide(image, 255.0, out=image)


def _draw_exactly(scene: Scene, height: int, width: int, threads: int | None) -> NDArray[np.float32]:
    """The exact image [h, w, 3 or 4], drawn in bands of rows so that memory does not grow with the photo."""
    row_count = max(1, BAND_PIXELS // width)
    image = np.empty((height, width, 4 if scene.transparent else 3), np.float32)
    for top in range(0, height, row_count):
        bottom = min(top + row_count, height)
        band = replace(scene, points=scene.points - scene.points.new_tensor([0.0, top]))
        image[top:bottom] = _draw(band, bottom - top, width, threads=threads)
    return image


def _draw(scene: Scene, height: int, width: int, **settings: Any) -> NDArray[np.float32]:
    image = render(scene, height, width, alpha=scene.transparent, **settings).detach()
    pixels: NDArray[np.float32] = (straight(image) if scene.transparent else image).cpu().numpy()
    return pixels

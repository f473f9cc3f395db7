"""The result of a fit: the scene in the file, its text, its picture, and figures measured on the file."""

from __future__ import annotations

import os
from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.files import check_writable, gzip_count, write_atomic
from warpvec.fit.progress import FitResult
from warpvec.fit.target import Target
from warpvec.fit.visibility import canvas_areas, removal_changes, visible_areas, without_invisible
from warpvec.flat.classify import Choice
from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene, over_white
from warpvec.geometry.trim import trim
from warpvec.image.metrics import psnr
from warpvec.image.resize import reduce_image
from warpvec.image.write import round_to_8_bits, write_png
from warpvec.rendering.draw import draw_8_bits, draw_exactly, draw_pixels
from warpvec.rendering.thread_pool import usable_threads
from warpvec.svg.layers import prefixes, read_layers
from warpvec.svg.measure import draw, draw_like, evaluate, file_facts
from warpvec.svg.minify import write_minified
from warpvec.svg.print_formats import PRINT_SUFFIXES, encode_drawing
from warpvec.svg.quantize import at_ticks, quantize
from warpvec.svg.units import sides_of
from warpvec.svg.write import write_svg
from warpvec.vectorization.file_form import FileForm, stated_settings
from warpvec.vectorization.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.vectorization.goal import Goal, Trial

__all__ = ["FileOptions", "Result"]


@dataclass(frozen=True, eq=False)
class Result:
    """A fitted photo.

    Attributes:
        photo: the photo [h, w, 3], sRGB-encoded in [0, 1], as it was read, or [h, w, 4] with straight alpha.
        fitted_size: height and width in pixels of the reduced photo that was fitted.
        config: every setting of the fit.
        fitted: the scene and the history of the fit, in pixels of the reduced photo.
        title: title of the SVG, None for none.
        goal_facts: the goal, if there was one, and whether the file meets it; see `warpvec.vectorization.goal`.
        file_options: choices about the file.
        form: what the file keeps of the file of a drawing; None for units of a pixel and the settings of the fit.
        keeps_paths: whether paths that cannot be seen stay.
        start_psnr: PSNR in dB of the drawing that the fit began with, None without one.
        layer_names: names of the layers by generation; None for numbers.
        choice: the mode that the picture asked for, and why; None if a setting decided it.
        left_out: number of parts of a drawing of flat art that its file leaves out, by their name, for the summary.
        unchanged: text of the given file, if the result is that file as it came in; None if the file shows `scene`.
    """

    photo: NDArray[np.float32]
    fitted_size: tuple[int, int]
    config: FitConfig
    fitted: FitResult
    title: str | None = None
    goal_facts: dict[str, Any] | None = None
    file_options: FileOptions = DEFAULT_FILE_OPTIONS
    form: FileForm | None = None
    keeps_paths: bool = False
    start_psnr: float | None = None
    layer_names: dict[int, str] | None = None
    choice: Choice | None = None
    unchanged: str | None = None
    left_out: dict[str, int] = field(default_factory=dict)

    def __repr__(self) -> str:
        height, width = self.photo.shape[:2]
        parts = [f"{width} x {height}", f"{len(self.scene)} paths", f"{len(self.svg().encode()):,} bytes"]
        if "metrics" in self.__dict__:  # measuring takes a while
            parts.append(f"PSNR {self.metrics['psnr']:.2f} dB")
        return f"<Result: {', '.join(parts)}>"

    def _repr_svg_(self) -> str:
        """Show the picture in a notebook."""
        return self.svg()

    def _repr_html_(self) -> str:
        """Show the picture in a notebook, no wider than its page, with a caption."""
        data = b64encode(self.svg().encode()).decode()
        picture = f'<img src="data:image/svg+xml;base64,{data}" width="{self.photo.shape[1]}" style="max-width:100%">'
        return f"{picture}<br><small>{escape(repr(self))}</small>"

    @cached_property
    def scene(self) -> Scene:
        """The scene in the file: cubics in pixels of the photo, rounded to the file's precision."""
        scene = self._rounded(self._cubics[0])
        if not self.keeps_paths:
            scene = self._without_small(self._without_invisible(scene))
        if not self.file_options.trim:
            return scene
        return self._rounded(trim(scene, *self.photo.shape[:2]))

    def _rounded(self, scene: Scene) -> Scene:
        if self.form is None:
            return quantize(scene, self.config.precision)
        across, down = self._units
        scene = scene.scaled(across, down)
        if self.keeps_paths and not scene.is_uniform:
            rounded = round_nodes(scene, self.form.precision)
            if self.form.minified:  # its ticks are coarse: directions of rounded handles would not stay
                stays = at_ticks(scene.segments.double() * 10**self.form.precision, scene.structure)
                segments = torch.where(stays[:, None, None], scene.segments, rounded.segments)
                rounded = replace(rounded, segments=segments)
            scene = rounded
        return quantize(scene, self.form.precision).scaled(1.0 / across, 1.0 / down)

    @property
    def _units(self) -> tuple[float, float]:
        """The file's units per pixel of the photo, across and down."""
        (height, width) = self.photo.shape[:2]
        rows, columns = (height, width) if self.form is None else self.form.size
        return columns / width, rows / height

    @cached_property
    def _cubics(self) -> tuple[Scene, float]:
        """The fitted scene as cubics in pixels of the photo, and their largest distance from it in these pixels."""
        height, width = self.photo.shape[:2]
        fitted_height, fitted_width = self.fitted_size
        return to_cubics(self.fitted.scene.scaled(width / fitted_width, height / fitted_height))

    @property
    def history(self) -> list[dict[str, float]]:
        """Records along the fit: iteration, curves, psnr (internal, dB), seconds since the start."""
        return self.fitted.history

    @property
    def interrupted(self) -> bool:
        """True if Ctrl-C ended the fit early; the result is then the best until that moment."""
        return self.fitted.interrupted

    def svg(self) -> str:
        """Return the text of the SVG. Its user units are the photo's pixels."""
        return self._text

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the SVG, or a PNG of it, to ``path``, whole or not at all.

        A name that ends in ``.svgz`` gets a gzipped SVG, one that ends in ``.png`` the picture as resvg draws it, in
        the photo's size, and ``.pdf`` and ``.eps`` get files for print.

        Raises:
            InputError: ``path`` has another suffix, cannot be written, or is for print without the extra "print".
        """
        suffix = Path(path).suffix.lower()
        if suffix not in (".svg", ".svgz", ".png", *PRINT_SUFFIXES):
            raise InputError("path", "must end in .svg, .svgz, .png, .pdf or .eps", repr(os.fspath(path)), "rename it")
        check_writable(path, "path")
        if suffix == ".png":
            write_png(path, draw_like(self.svg(), self.photo) / 255.0, "path")
        else:
            write_atomic(path, encode_drawing(self.svg(), path))

    def render(self, scale: float = 1.0) -> NDArray[np.float32]:
        """Return the file's scene drawn with exact coverage, [h, w, 3], at ``scale`` times the photo's size, rounded.

        If the photo has alpha, the image has it too: [h, w, 4], straight. The renderer of the fit does not matter
        here; `soft_image` is what the renderer "splat" draws.

        Raises:
            InputError: ``scale`` is not above 0.
        """
        if not 0 < scale < float("inf"):
            raise InputError("scale", "must be above 0 and finite", repr(scale), "1 gives the photo's size")
        height, width = (max(1, round(side * scale)) for side in self.photo.shape[:2])
        x_factor, y_factor = width / self.photo.shape[1], height / self.photo.shape[0]
        return draw_exactly(self.scene.scaled(x_factor, y_factor), height, width, self.config.threads)

    def soft_image(self) -> NDArray[np.float32]:
        """Return the fitted scene, neither converted nor rounded, as the fit drew it: [h, w, 3 or 4], `fitted_size`."""
        return draw_pixels(self.fitted.scene, *self.fitted_size, **self.config.render_settings)

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """Plain values that describe the result, computed at the first use.

        ``psnr`` (dB) and ``ssim`` compare the photo with the file as resvg draws it. If the photo is ``transparent``,
        both are compared over black and over white, and the two errors are averaged. ``internal_psnr`` is the PSNR of
        the fit's own renderer: for "exact" that of `render` against the photo, for "splat" that of `soft_image` against
        the reduced photo. The image is first clamped and rounded to 8 bits, which changes the PSNR by 0.01 dB at 32 dB.
        ``conversion_px`` is the largest distance of the file's cubics from the fitted curves, in pixels of the photo,
        before rounding. ``threads`` is the largest number of CPU threads, None on a GPU. ``unchanged`` tells if the
        file is the given one as it came in. ``bytes`` and ``gzip_bytes`` are sizes of the SVG text, plain and gzipped.
        ``levels`` lists ``curves`` and ``psnr`` of each prefix of the layers, after a fit with ``lod``. ``goal`` holds
        the `goal_facts`.
        """
        height, width = self.photo.shape[:2]
        opacity = self.scene.opacity
        return {
            **evaluate(self.svg(), self.photo),
            "mode": self.config.mode,
            "mode_reason": None if self.choice is None else self.choice.reason,
            "renderer": self.config.renderer,
            "start_psnr": self.start_psnr,
            "unchanged": self.unchanged is not None,
            "left_out": self.left_out,
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
            "threads": usable_threads(self.config.threads) if self.fitted.device == "cpu" else None,
            "interrupted": self.interrupted,
            "goal": self.goal_facts,
            "levels": self._levels() if self.config.lod else None,
        }

    def trial(self, goal: Goal) -> Trial:
        """Return the figures of the file for a search: paths, bytes as ``goal`` counts them, and PSNR."""
        svg = self.svg().encode()
        size = gzip_count(svg) if goal.gzip else len(svg)
        return Trial(self.config.curves, len(self.scene), size, self._file_psnr(svg))

    def without(self, count: int) -> Result:
        """Return the result without the ``count`` paths of lowest removal cost; the others stay as they are."""
        scene = self.fitted.scene
        target = Target(torch.from_numpy(reduce_image(self.photo, self.config.fit_size)), self.config, "cpu")
        with torch.no_grad():
            removal_cost = target.fit_step(scene, True).removal_cost
        rows = removal_cost.topk(len(scene) - count).indices.sort().values
        return replace(self, fitted=replace(self.fitted, scene=scene.select(rows)))

    def _without_invisible(self, scene: Scene) -> Scene:
        height, width = self.photo.shape[:2]

        def draw_pixels_of(some: Scene) -> bytes:
            is_minified = self.form is not None and self.form.minified
            own = partial(write_svg, width=width, height=height, precision=self.config.precision)
            text = self._text_of(some) if is_minified else own(some)
            return draw(text, width, height, transparent=some.transparent).tobytes()

        visible, changes = self._areas(visible_areas, scene), self._areas(removal_changes, scene)
        return without_invisible(scene, visible, changes, draw_pixels_of)

    def _without_small(self, scene: Scene) -> Scene:
        if self.config.min_area == 0:
            return scene
        return scene.select(self._areas(canvas_areas, scene) >= self.config.min_area)

    def _areas(self, measure: Callable[..., Tensor], scene: Scene) -> Tensor:
        """Return the areas [N] that ``measure`` finds at the size of the fit, in square pixels of the photo."""
        (height, width), (rows, columns) = self.photo.shape[:2], self.fitted_size
        x_factor, y_factor = columns / width, rows / height
        areas = measure(scene.scaled(x_factor, y_factor), rows, columns, self.config.threads)
        return areas / (x_factor * y_factor)

    def _levels(self) -> list[dict[str, Any]]:
        """Return the number of curves and the PSNR of each prefix of the layers as a picture of its own."""
        if not read_layers(self.svg()):  # no path is left
            return []
        found = ((level, text, file_facts(text)["paths"]) for level, text in prefixes(self.svg()))
        return [{"level": k, "curves": n, "psnr": self._file_psnr(text)} for k, text, n in found]

    def _file_psnr(self, svg: str | bytes) -> float:
        """Return the PSNR of ``svg`` against the photo, without the SSIM, which takes longer than drawing the file."""
        return psnr(draw_like(svg, self.photo), self.photo)

    def _internal_psnr(self) -> float:
        if self.config.renderer == "exact":
            height, width = self.photo.shape[:2]
            scene = self.scene if self.photo.shape[2] == 4 else over_white(self.scene)
            return psnr(draw_8_bits(scene, height, width, self.config.threads), self.photo)
        return psnr(round_to_8_bits(self.soft_image()), reduce_image(self.photo, self.config.fit_size))

    @cached_property
    def file_psnr(self) -> float:
        """PSNR in dB of the file against the photo, as resvg draws it."""
        return self._file_psnr(self.svg())

    @cached_property
    def _text(self) -> str:
        return self._text_of(self.scene) if self.unchanged is None else self.unchanged

    def count_bytes(self, scene: Scene, *, gzip: bool = False) -> int:
        """Return the bytes of the file, after gzip if asked, that would show all paths of a fit's ``scene`` of cubics.

        It is in pixels of the reduced photo.
        """
        (height, width), (rows, columns) = self.photo.shape[:2], self.fitted_size
        data = self._text_of(scene.scaled(width / columns, height / rows)).encode()
        return gzip_count(data) if gzip else len(data)

    def psnr_of(self, scene: Scene) -> float:
        """Return the PSNR in dB of the file that would show all paths of a fit's ``scene``, in its pixels."""
        (height, width), (rows, columns) = self.photo.shape[:2], self.fitted_size
        return self._file_psnr(self._text_of(to_cubics(scene.cpu().scaled(width / columns, height / rows))[0]))

    def _text_of(self, scene: Scene) -> str:
        """Return the text of the file that shows ``scene``, in pixels of the photo."""
        form = self.form or FileForm((self.photo.shape[0], self.photo.shape[1]), self.config.precision, self.title)
        rows, columns = form.size
        size, scene = self.file_options.size, scene.scaled(*self._units)
        if form.minified:
            true = form.sides or (str(columns), str(rows))
            true = true if size is None else sides_of(size, self.photo.shape[1], self.photo.shape[0])
            keeps_layers = form.keeps_layers or self.config.lod
            return write_minified(scene, columns, rows, true, precision=form.precision, keeps_layers=keeps_layers)
        sides = form.sides if size is None else sides_of(size, columns, rows)
        metadata = (form.metadata or self._settings()) if self.file_options.metadata else None
        return write_svg(
            scene, columns, rows, precision=form.precision, title=form.title, metadata=metadata, sides=sides,
            layer_names=self.layer_names or form.layer_names,
        )  # fmt: skip

    @property
    def grid_step(self) -> tuple[float, float] | None:
        """Step of the coordinates of a minified file in pixels of the reduced photo, across and down; else None."""
        if self.form is None or not self.form.minified:
            return None
        (height, width), (rows, columns) = self.fitted_size, self.form.size
        per_unit = 10**self.form.precision
        return width / columns / per_unit, height / rows / per_unit

    def _settings(self) -> dict[str, Any]:
        """Return the settings that the file states."""
        return stated_settings(self.config)

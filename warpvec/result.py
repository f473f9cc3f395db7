"""The result of a run: the picture, its drawing, how the drawing becomes a file, and figures of the file."""

from __future__ import annotations

import os
import warnings
from base64 import b64encode
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.checks import counted
from warpvec.config.fit_config import FitConfig
from warpvec.config.world_file import placing
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.drawing.not_kept import not_kept
from warpvec.errors import InputError
from warpvec.files import check_writable, text_bytes, write_atomic
from warpvec.geometry.scene import Scene, over_white
from warpvec.image.metrics import psnr
from warpvec.image.picture import Picture
from warpvec.image.write import round_to_8_bits
from warpvec.rendering.draw import draw_8_bits, draw_exactly, draw_pixels
from warpvec.rendering.thread_pool import usable_threads
from warpvec.svg.layers import prefixes, read_layers
from warpvec.svg.measure import evaluate, file_facts
from warpvec.svg.on_pages import as_symbol, with_current_color
from warpvec.svg.write import hex_colors
from warpvec.watch.progress import HistoryEntry
from warpvec.watch.watch import RunFacts
from warpvec.writers.registry import PAGE_SUFFIXES, SVG_SUFFIXES, check_suffix, encode, writer_of
from warpvec.writers.saved import Saved, losses, saved
from warpvec.writers.writer import Canvas, Target

__all__ = ["Result"]


_WIDTH_ERROR = 0.005
"""Pixels by which a stroke may be thinner than wanted: half of the last decimal of its width."""


@dataclass(frozen=True, eq=False)
class Result:
    """The drawing of a picture: a photo, flat art, black and white art or lines.

    `save` writes it as SVG, PNG, PDF and more. `svg` is its text, `scene` its paths as tensors, and `metrics` are the
    figures of its file, measured on what resvg draws.

    Attributes:
        drawing: the drawing, in the mode that made it.
        run: history, iterations, seconds and interruption of the run.
    """

    drawing: Drawing
    run: RunFacts

    def __repr__(self) -> str:
        picture = self.picture
        size = f"{picture.width} x {picture.height}"
        parts = [size, counted(len(self.scene), "path"), f"{len(self.svg().encode()):,} bytes"]
        if "metrics" in self.__dict__:  # measuring takes a while
            parts.append(f"PSNR {self.metrics['psnr']:.2f} dB")
        return f"<Result: {', '.join(parts)}>"

    def _repr_svg_(self) -> str:
        """Show the picture in a notebook."""
        return self.svg()

    def _repr_html_(self) -> str:
        """Show the picture in a notebook, no wider than its page, with a caption."""
        data = b64encode(self.svg().encode()).decode()
        picture = f'<img src="data:image/svg+xml;base64,{data}" width="{self.picture.width}" style="max-width:100%">'
        return f"{picture}<br><small>{escape(repr(self))}</small>"

    def with_drawing(self, drawing: Drawing) -> Result:
        """Return the result with another ``drawing`` of the same picture, such as one of `warpvec.edit`."""
        return replace(self, drawing=drawing)

    @property
    def encoding(self) -> Encoding:
        """How the drawing becomes a file."""
        return self.drawing.encoding

    @property
    def picture(self) -> Picture:
        """The picture, at full size and reduced to the size of the fit."""
        return self.encoding.picture

    @property
    def config(self) -> FitConfig:
        """Every setting of the run."""
        return self.encoding.settings

    @property
    def scene(self) -> Scene:
        """The scene in the file: cubics in pixels of the picture, rounded to the file's precision."""
        return self.drawing.scene

    @property
    def history(self) -> list[HistoryEntry]:
        """Records along the run: iteration, curves (the number of paths), psnr (internal, dB), seconds since the start.

        Drawings of flat art have one for each round of their fits.
        """
        return self.run.history

    @property
    def interrupted(self) -> bool:
        """True if the user ended the run early; the result is then the best until that moment."""
        return self.run.interrupted

    @property
    def goal_facts(self) -> dict[str, Any] | None:
        """The goal, and whether the file meets it; None without one."""
        return self.drawing.goal_facts

    @property
    def file_psnr(self) -> float:
        """PSNR in dB of the file against the picture, as resvg draws it."""
        return self.drawing.psnr

    def svg(self) -> str:
        """Return the text of the SVG. Its user units are the picture's pixels."""
        symbol, text = self.encoding.options.symbol, self._text_for_pages()
        return text if symbol is None else as_symbol(text, symbol)

    def _text_for_pages(self) -> str:
        color = self.encoding.options.current_color
        return self.drawing.text if color is None else with_current_color(self.drawing.text, color)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the drawing to ``path``, whole or not at all; the suffix names the kind of file.

        ``.svg`` and ``.svgz`` hold the SVG, plain or gzipped. ``.png`` is the picture as resvg draws it, in the size of
        the given picture. ``.pdf`` and ``.eps`` are for print, ``.dxf`` is for cutters,
        and ``.jsx`` is a React component.

        ``.pdf`` and ``.eps`` have rings of sharp paths in place of a soft path, and ``.dxf`` draws it sharp. A warning
        says so, as for all that the file draws by other means or not at all. A drawing that was made with ``soft=0``
        has no soft path. ``.dxf`` has both edges of a stroke, or its centre line (``dxf_strokes``).

        Raises:
            InputError: ``path`` has another suffix, cannot be written, or needs an extra that is missing.
        """
        for loss in self.write(path, "path"):
            warnings.warn(loss, stacklevel=2)

    def write(self, path: str | os.PathLike[str], name: str) -> list[str]:
        """Write the drawing to ``path`` as `save` does, and return what the file draws by other means or not at all.

        Raises:
            InputError: as `save`; messages call the path ``name``.
        """
        check_suffix(path, name)
        check_writable(path, name)
        made = self.file(path)
        write_atomic(path, made.data)
        return made.losses

    def encoded(self, path: str | os.PathLike[str]) -> bytes:
        """Return the bytes of the drawing as a file called ``path``.

        Raises:
            InputError: what the kind of file needs is missing.
        """
        return self.file(path).data

    def file(self, path: str | os.PathLike[str]) -> Saved:
        """Return the bytes of the drawing as a file called ``path``, and what this file draws by other means or not.

        Raises:
            InputError: what the kind of file needs is missing.
        """
        name, options = os.fspath(path), self.encoding.options
        if options.purpose == "web":
            return saved(self._text_of(name), name, self.target)
        words = losses(name, options.purpose, self.drawing.replaced, self.scene.soft_count)
        return Saved(encode(self._text_of(name), name, self.target), words)

    def _text_of(self, path: str) -> str:
        suffix = writer_of(path).suffix
        if suffix in SVG_SUFFIXES:
            return self.svg()
        return self._text_for_pages() if suffix in PAGE_SUFFIXES else self.drawing.text

    @property
    def canvas(self) -> Canvas:
        """The pixels of the picture, for writers of pictures."""
        return Canvas(self.picture.width, self.picture.height, self.picture.is_transparent)

    @property
    def target(self) -> Target:
        """What writers need to know beside the SVG."""
        options = self.encoding.options
        world = None if options.world_file is None else placing("world_file", options.world_file)
        per_inch = options.per_inch or 96.0
        return Target(self.canvas, options.dxf_splines, self.has_center_lines, per_inch=per_inch, world=world)

    @property
    def has_center_lines(self) -> bool:
        """Whether files for cutters have strokes as their centre lines, which pens follow, and not as both edges."""
        chosen = self.encoding.options.dxf_strokes
        is_for_pen = self.config.mode == "lines" or self.encoding.options.purpose == "pen"
        return chosen == "center" or (chosen == "auto" and is_for_pen)

    def render(self, scale: float = 1.0) -> NDArray[np.float32]:
        """Return the file's scene drawn with exact coverage, [h, w, 3], at ``scale`` times the picture's size, rounded.

        If the picture has alpha, the image has it too: [h, w, 4], straight. The renderer of the fit does not matter
        here; `soft_image` is what the renderer of the fit draws.

        Raises:
            InputError: ``scale`` is not above 0.
        """
        if not 0 < scale < float("inf"):
            raise InputError("scale", "must be above 0 and finite", repr(scale), "1 gives the picture's size")
        picture = self.picture
        height, width = (max(1, round(side * scale)) for side in (picture.height, picture.width))
        scene = self.scene.scaled(width / picture.width, height / picture.height)
        return draw_exactly(scene, height, width, self.config.threads)

    def soft_image(self) -> NDArray[np.float32]:
        """Return the scene as the fit drew it, neither converted nor rounded: [h, w, 3 or 4], at the size of the fit.

        The renderer "splat" draws soft edges; others draw nearly what the file shows.
        """
        return draw_pixels(self.drawing.fitted, *self.picture.reduced_size, **self.config.render_settings)

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """Plain values that describe the result, computed at the first use.

        ``psnr`` (dB) and ``ssim`` compare the picture with the file as resvg draws it. If the picture is
        ``transparent``, both are compared over black and over white, and the two errors are averaged. ``internal_psnr``
        is the PSNR of the fit's own renderer: for "exact" that of `render` against the picture, for others that of
        `soft_image` against the reduced picture. The image is first clamped and rounded to 8 bits, which changes the
        PSNR by 0.01 dB at 32 dB. ``conversion_px`` is the largest distance of the file's cubics from the fitted curves,
        in pixels of the picture, before rounding. ``colors`` lists the colours if their number or a palette is given.
        ``threads`` is the largest number of CPU threads, None on a GPU. ``unchanged`` tells if the file is the given
        one as it came in. ``bytes`` and ``gzip_bytes`` are sizes of the SVG text, plain and gzipped. ``levels`` lists
        ``curves`` and ``psnr`` of each prefix of the layers, after a fit with ``lod``. ``goal`` holds the facts about
        the goal. ``thin_strokes`` counts those below ``line_width_min``, and ``thinnest_stroke`` is the width of the
        thinnest, if there are any. Drawings in the mode lines also have ``lines``, ``line_widths``, ``wide_areas`` and
        ``pen_up``: see `warpvec.modes.lines`. ``condition`` has what had happened to the picture, and
        ``condition_words`` says it; they are None if nobody looked, and the words also if nothing had. ``not_kept``
        says what of the picture the drawing could not keep, by names such as "noise" and "shades". ``replaced`` lists
        in words what the file draws by other means, because it may not use more for its ``purpose``. ``psnr_as_fitted``
        compares the file with the picture as it was before its enlargement, if that was fitted. If the picture is
        blurred, and its drawing is not, ``blur_undone`` is the deviation in pixels, and ``psnr_as_fitted`` blurs the
        file as the picture is.
        """
        drawing, opacity, picture = self.drawing, self.scene.opacity, self.picture
        rows, columns = picture.reduced_size
        return {
            **evaluate(drawing.text, picture.pixels),
            **self._sizes(),
            "mode": self.config.mode,
            "mode_reason": drawing.mode_reason,
            "renderer": self.config.renderer,
            "start_psnr": drawing.start_psnr,
            "unchanged": drawing.given is not None,
            "left_out": drawing.left_out,
            **(drawing.line_facts or {}),
            **self._grid(),
            **self._thin_strokes(),
            "internal_psnr": self._internal_psnr(),
            "degree": drawing.fitted.degree,
            "conversion_px": drawing.conversion_px,
            "colors": self._colors() if self.config.colors or self.config.palette else None,
            "mean_opacity": opacity.mean().item() if len(opacity) else 0.0,
            "width": picture.width,
            "height": picture.height,
            "fitted_width": columns,
            "fitted_height": rows,
            "iterations": self.run.iterations,
            "seconds": self.run.seconds,
            "device": drawing.device,
            "threads": usable_threads(self.config.threads) if drawing.device == "cpu" else None,
            "interrupted": self.interrupted,
            "goal": drawing.goal_facts,
            "not_kept": not_kept(drawing),
            "purpose": self.encoding.options.purpose,
            "replaced": drawing.replaced,
            "condition": None if drawing.condition is None else drawing.condition.facts,
            "condition_words": None if drawing.condition is None else drawing.condition.words,
            "psnr_as_fitted": drawing.psnr_as_fitted if picture.is_damage_undone else None,
            "blur_undone": picture.blur / picture.reduction[0],
            "levels": self._levels() if self.config.lod else None,
        }

    def _sizes(self) -> dict[str, int]:
        """Return the sizes of the SVG text, in which a page's colour may stand for one that was measured."""
        return {"bytes": text_bytes(self.svg()), "gzip_bytes": text_bytes(self.svg(), gzip=True)}

    def _colors(self) -> list[str]:
        """Return the colours of the file, the canvas first and then from bottom to top."""
        scene = self.scene.cpu()
        canvas = [] if scene.transparent else hex_colors(scene.background[None])
        return list(dict.fromkeys([*canvas, *hex_colors(scene.color)]))

    def _levels(self) -> list[dict[str, Any]]:
        """Return the number of paths and the PSNR of each prefix of the layers as a picture of its own."""
        drawn = self.drawing.text
        if not read_layers(drawn):  # no path is left
            return []
        found = ((level, text, file_facts(text)["paths"]) for level, text in prefixes(drawn))
        return [{"level": k, "curves": n, "psnr": self.encoding.text_psnr(text)} for k, text, n in found]

    def _grid(self) -> dict[str, Any]:
        """Return the units along the longer side of the grid of the drawing, and the share of numbers on half units."""
        encoding = self.encoding
        if not encoding.grid:
            return {}
        from warpvec.flat.chains.grid import share_on_halves, stated_numbers  # it loads SciPy

        picture = encoding.picture
        share = share_on_halves(stated_numbers(self.scene), max(picture.width, picture.height) / encoding.grid)
        return {"grid": encoding.grid, "grid_share": round(share, 3)}

    def _thin_strokes(self) -> dict[str, Any]:
        """Return the number of strokes that are thinner than wanted, and the width in pixels of the thinnest."""
        strokes = self.scene.strokes
        if strokes is None:
            return {}
        width = strokes.width[strokes.is_stroked].double()
        thin = width[width < self.encoding.options.line_width_min - _WIDTH_ERROR]
        return {"thin_strokes": len(thin), "thinnest_stroke": round(float(thin.min()), 2)} if len(thin) else {}

    def _internal_psnr(self) -> float:
        picture = self.picture
        if self.config.renderer == "exact":
            scene = self.scene if picture.is_transparent else over_white(self.scene)
            return psnr(draw_8_bits(scene, picture.height, picture.width, self.config.threads), picture.pixels)
        return psnr(round_to_8_bits(self.soft_image()), picture.reduced)

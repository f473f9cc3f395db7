"""Encode scenes of one picture as SVG files, and measure these files."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.config.stated import stated_settings
from warpvec.drawing.arc_rounding import with_arcs
from warpvec.drawing.dash_rounding import with_dashes
from warpvec.drawing.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene
from warpvec.geometry.trim import trim
from warpvec.image.alpha import is_transparent, premultiplied, straight
from warpvec.image.gaussian_blur import GaussianBlur
from warpvec.image.metrics import psnr
from warpvec.image.picture import Picture
from warpvec.purposes.replaced import Replaced, replaced
from warpvec.purposes.table import PURPOSES, WEB, Purpose
from warpvec.svg.measure import draw_like
from warpvec.svg.minify import write_minified
from warpvec.svg.quantize import at_ticks, quantize
from warpvec.svg.units import more_decimals
from warpvec.svg.write import write_svg

STEP_SHARE = 1.0 / 40.0
"""Step of the coordinates of a minified photo over the side of a square of a path's share of the canvas: 2/3 px for 540
paths on 768 x 512, 1/3 px for 2000. A finer one costs bytes, a coarser one quality, most where the error is small.
kodim07, 05 and 23 with 50 KB: 1/70 gives 30.22, 22.98 and 32.58 dB, 1/55 30.27, 23.12 and 32.79, 1/35 30.36, 23.22 and
32.74. kodim23 with 150 KB: 1/70 gives 36.45 dB, 1/56 36.52, 1/45 36.65, 1/35 36.36."""

GZIP_STEP_SHARE = 1.0 / 30.0
"""The same for files whose gzipped bytes count. Numbers are a larger part of these: with 20 KB, 1/45 gives kodim23
32.85 dB and 1/30 32.98."""

STEP_MAX = 3.0
"""Largest step in pixels of the fitted image. With 10 KB, 1 in its place loses 0.2 dB (kodim23) and 0.1
dB (kodim05)."""

UNITS_CHANGE_MAX = 0.02
"""Largest change of the units per pixel, as a share of them, for a whole height, which saves three bytes. No height of
4000 x 2667 px is whole; its units would be a quarter of the wanted ones."""

FLAT_UNITS = 20
"""Most units per pixel of a minified drawing of flat art, whose outlines are exact to a few hundredths of a pixel."""


@dataclass(frozen=True, eq=False)
class Encoding:
    """How scenes of a picture become a file. Scenes are in pixels of the picture.

    Attributes:
        picture: the picture that is drawn.
        settings: the settings of its drawing, which the file states.
        options: choices about the file alone.
        size: height and width of the file in its units; the height may be a fraction.
        precision: decimals of the coordinates in these units.
        title: title of the file; None for none.
        metadata: settings that the file states in place of ``settings``; None for none.
        sides: width and height with their units; None for the size in units.
        layer_names: names of the layers by generation; None for numbers.
        is_minified: whether the file has the shortest form; see `warpvec.svg.minify`.
        keeps_layers: whether the shortest form has a group for each layer.
        keeps_paths: whether paths that cannot be seen stay, and smooth nodes stay smooth.
        closes_exactly: whether loops come back to their start also where a reader's sums are rounded.
        grid: units along the longer side of the grid that the drawing was made on; 0 for none.
        simplify: returns a rounded scene without outlines that cross themselves, given the distance of the file's
            coordinates in pixels, across and down; None for drawings that may have some.
    """

    picture: Picture
    settings: FitConfig
    options: FileOptions
    size: tuple[float, int]
    precision: int
    title: str | None = None
    metadata: dict[str, Any] | None = None
    sides: tuple[str, str] | None = None
    layer_names: dict[int, str] | None = None
    is_minified: bool = False
    keeps_layers: bool = False
    keeps_paths: bool = False
    closes_exactly: bool = False
    grid: int = 0
    simplify: Callable[[Scene, tuple[float, float]], Scene] | None = None

    @staticmethod
    def of(picture: Picture, settings: FitConfig, options: FileOptions = DEFAULT_FILE_OPTIONS) -> Encoding:
        """Return the usual encoding of a drawing of ``picture``: one unit is a pixel."""
        size = (picture.height, picture.width)
        return Encoding(picture, settings, options, size, settings.precision, picture.title)

    # Variants

    def of_photo(self, settings: FitConfig, *, gzip: bool = False) -> Encoding:
        """Return the encoding of a fit of a photo with ``settings``, in units as fine as its paths need.

        ``gzip`` tells whether the bytes after gzip count.
        """
        encoding = replace(self, settings=settings)
        if not settings.minify:
            return encoding
        encoding = replace(encoding, keeps_layers=settings.lod)
        rows, columns = self.picture.reduced_size
        side = math.sqrt(rows * columns / settings.curves)
        step = min(side * (GZIP_STEP_SHARE if gzip else STEP_SHARE), STEP_MAX)
        if settings.units:
            return encoding.finer(settings.units)
        return encoding._in_proportion(self.picture.reduction[0] / step)

    def of_drawing(self) -> Encoding:
        """Return the encoding of a drawing of flat art, whose paths and smooth nodes stay."""
        encoding = replace(self, keeps_paths=True, closes_exactly=True)
        if not self.settings.minify:
            return encoding
        if self._purpose.has_units or self.settings.units:
            return encoding.finer(flat_units(self.settings))
        return replace(encoding, precision=more_decimals(flat_units(self.settings)), is_minified=True)

    def finer(self, units: int) -> Encoding:
        """Return the shortest form with units that are divided by ``units``. The size stays."""
        rows, columns = self.size
        size, sides = (rows * units, columns * units), self.sides or (str(columns), str(rows))
        return self._shortest(size, sides)

    def on_grid(self, side: int) -> Encoding:
        """Return the encoding in units of which the longer side has ``side``, where its purpose allows such.

        No number gets coarser.
        """
        if not self._purpose.has_units:
            return self
        height, width = self.picture.height, self.picture.width
        unit = max(height, width) / side
        size = (round(height / unit), round(width / unit))
        sides = self.sides or (str(width), str(height))
        return replace(self, size=size, precision=self.settings.precision + more_decimals(unit), sides=sides, grid=side)

    def _in_proportion(self, units: float) -> Encoding:
        """Return the shortest form with about ``units`` per pixel, in the proportions of the picture.

        The height is a whole number if the units need hardly change for it.
        """
        rows, columns = self.picture.height, self.picture.width
        divisor = math.gcd(rows, columns)
        count = round(units * divisor) * columns // divisor
        if abs(count - units * columns) > UNITS_CHANGE_MAX * units * columns:
            count = max(1, round(units * columns))
        height = round(rows * count / columns, 2)
        size = (int(height) if height.is_integer() else height, count)
        return self._shortest(size, self.sides or (str(columns), str(rows)))

    def _shortest(self, size: tuple[float, int], sides: tuple[str, str]) -> Encoding:
        return replace(self, size=size, precision=0, sides=sides, is_minified=True)

    # Scenes

    def round(self, scene: Scene) -> Scene:
        """Return ``scene`` with the values that the file states; smooth nodes stay smooth if ``keeps_paths``."""
        across, down = self._units
        scene = scene.scaled(across, down)
        if self.options.plain_paths:
            scene = scene.outlined()
        if self.keeps_paths and not scene.is_uniform:
            rounded = round_nodes(scene, self.precision)
            if self.is_minified:  # its ticks are coarse: directions of rounded handles would not stay
                stays = at_ticks(scene.segments.double() * 10**self.precision, scene.structure)
                segments = torch.where(stays[:, None, None], scene.segments, rounded.segments)
                rounded = replace(rounded, segments=segments)
            scene = with_arcs(rounded, self.precision, min(across, down))
            if self._has_dashes:
                scene = with_dashes(scene, self.precision, min(across, down))
        rounded = quantize(scene, self.precision).scaled(1.0 / across, 1.0 / down)
        if self.simplify is None:
            return rounded
        per_unit = 10**self.precision
        return self.simplify(rounded, (1.0 / across / per_unit, 1.0 / down / per_unit))

    def trim(self, scene: Scene) -> Scene:
        """Return ``scene`` cut off at the edges of the canvas if the options ask for it."""
        if not self.options.trim:
            return scene
        return self.round(trim(scene, self.picture.height, self.picture.width))

    @property
    def _units(self) -> tuple[float, float]:
        """The file's units per pixel of the picture, across and down."""
        rows, columns = self.size
        return columns / self.picture.width, rows / self.picture.height

    @property
    def _has_dashes(self) -> bool:
        """Whether the file states dashed lines as such. Other programs than browsers may not draw them."""
        return self._purpose == WEB and not self.is_minified and not self.options.no_dashes

    @property
    def grid_step(self) -> tuple[float, float] | None:
        """Step of a minified file's coordinates in pixels of the reduced picture, across and down; else None."""
        if not self.is_minified:
            return None
        (height, width), (rows, columns) = self.picture.reduced_size, self.size
        per_unit = 10**self.precision
        return width / columns / per_unit, height / rows / per_unit

    # Files

    def shown(self, scene: Scene) -> Replaced:
        """Return ``scene`` with what a file for its purpose may use."""
        return replaced(scene, self._purpose, self.picture.width, self.picture.height, self.settings.threads)

    @property
    def _purpose(self) -> Purpose:
        return PURPOSES[self.options.purpose]

    def text(self, scene: Scene) -> str:
        """Return the SVG text of ``scene``."""
        purpose, picture = self._purpose, self.picture
        scene = scene if purpose == WEB else self.shown(scene).scene
        (rows, columns), scene = self.size, scene.scaled(*self._units)
        if self.is_minified:
            sides = self.sides or (str(columns), str(rows))
            sides = self.options.sides(picture.width, picture.height) or sides
            return write_minified(
                scene, columns, rows, sides, precision=self.precision, keeps_layers=self.keeps_layers,
                has_groups=purpose.has_groups, has_arcs=purpose.has_arcs, profile=purpose.profile,
                closes_exactly=self.closes_exactly,
            )  # fmt: skip
        metadata = None if self.options.no_metadata else self.metadata or stated_settings(self.settings)
        return write_svg(
            scene, columns, rows, precision=self.precision, title=self.title, metadata=metadata,
            sides=self.options.sides(picture.width, picture.height) or self.sides, layer_names=self.layer_names,
            has_arcs=purpose.has_arcs, has_dashes=self._has_dashes, profile=purpose.profile,
            closes_exactly=self.closes_exactly,
        )  # fmt: skip

    def least_text(self) -> str:
        """Return a text shorter than that of any drawing: one path in a view box of the fewest digits."""
        width, height = self.picture.width, self.picture.height
        sides = self.options.sides(width, height) or self.sides or (str(width), str(height))
        black, generation = torch.zeros(1, 3), torch.zeros(1, dtype=torch.int64)
        points = torch.zeros(1, 3, 2)
        path = Scene.uniform(points, black, torch.ones(1), black[0], generation, transparent=True)
        return write_minified(path, 1, 1, sides)

    def psnr_as_fitted(self, text: str) -> float:
        """Return the PSNR in dB of the SVG ``text``, as resvg draws it, against what was fitted.

        That is the picture, or a small copy of it as it was before it was enlarged. If it is blurred, so is the file.
        """
        picture = self.picture
        image = picture.reduced if picture.is_damage_undone else picture.pixels
        drawn = draw_like(text, image)
        return psnr(_blurred(drawn, picture.blur) if picture.blur else drawn, image)

    def text_psnr(self, text: str) -> float:
        """Return the PSNR in dB of the SVG ``text`` against the picture, as resvg draws it."""
        return psnr(draw_like(text, self.picture.pixels), self.picture.pixels)


def _blurred(drawn: NDArray[np.uint8], deviation: float) -> NDArray[np.float32]:
    """Return ``drawn`` [h, w, 3 or 4], with straight alpha if four, blurred by ``deviation`` pixels, in [0, 1]."""
    image, has_alpha = torch.from_numpy(drawn) / 255.0, is_transparent(drawn)
    blurred: NDArray[np.float32] = GaussianBlur(deviation)(premultiplied(image) if has_alpha else image).numpy()
    return straight(blurred) if has_alpha else blurred


def flat_units(settings: FitConfig) -> int:
    """Return the units per pixel of a minified drawing of flat art."""
    return settings.units or min(10**settings.precision, FLAT_UNITS)

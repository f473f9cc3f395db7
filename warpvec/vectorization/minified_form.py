"""The form of a minified file: how fine its viewBox is."""

from __future__ import annotations

import math

from warpvec.config.fit_config import FitConfig
from warpvec.vectorization.file_form import FileForm

STEP_SHARE = 1.0 / 70.0
"""Step of the coordinates over the side of a square of a path's share of the canvas: 1/3 px for 700 paths on 768 x 512,
1/5 px for 2000. Half the step costs 5 % of the bytes; twice the step costs as much in PSNR (kodim07, kodim23)."""

GZIP_STEP_SHARE = 1.0 / 45.0
"""The same for files whose gzipped bytes count. Numbers are a larger part of these: twice the step gains 0.14 dB at
384 x 256, 10 KB."""

STEP_MAX = 1.0
"""Largest step in pixels of the fitted image. A large photo, which is reduced for the fit, can have steps of several of
its own pixels."""

FLAT_UNITS = 20
"""Most units per pixel of a drawing of flat art, whose outlines are exact to a few hundredths of a pixel."""


def minified_form(
    config: FitConfig, photo_size: tuple[int, int], fit_size: tuple[int, int], *, gzip: bool = False
) -> FileForm:
    """Return the form of a minified file of a fit.

    Args:
        config: gives the number of paths, and the units per pixel if these are not 0.
        photo_size, fit_size: height and width of the photo and of the fitted image.
        gzip: whether the bytes after gzip count.
    """
    side = math.sqrt(fit_size[0] * fit_size[1] / config.curves)
    step = min(side * (GZIP_STEP_SHARE if gzip else STEP_SHARE), STEP_MAX)
    units = fit_size[1] / photo_size[1] / step
    if units < 1.0 and not config.grid:
        return _coarser_form(photo_size, units)
    return finer_form(FileForm(photo_size, 0), config.grid or round(units))


def _coarser_form(photo_size: tuple[int, int], units: float) -> FileForm:
    """Return the form with about ``units`` per pixel, fewer than one; the viewBox keeps the exact proportions."""
    rows, columns = photo_size
    divisor = math.gcd(rows, columns)
    count = max(1, round(units * divisor))
    size = (rows // divisor * count, columns // divisor * count)
    return FileForm(size, 0, sides=(str(columns), str(rows)), minified=True)


def finer_form(form: FileForm, units: int) -> FileForm:
    """Return the minified form of ``form``, whose units are divided by ``units``; it keeps its size."""
    rows, columns = form.size
    sides = form.sides or (str(columns), str(rows))
    return FileForm((rows * units, columns * units), 0, sides=sides, minified=True)


def flat_units(config: FitConfig) -> int:
    """Return the units per pixel of a minified drawing of flat art."""
    return config.grid or min(10**config.precision, FLAT_UNITS)

"""All that was measured of what has happened to a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats32
from warpvec.condition.blur import SHARP, EdgeBlur, measure_blur
from warpvec.condition.constants import CONDITION
from warpvec.condition.enlargement import Enlargement, find_enlargement
from warpvec.condition.even_colors import find_even_areas
from warpvec.condition.jpeg import Jpeg, find_jpeg
from warpvec.condition.levels import Palette, find_palette
from warpvec.condition.light import Light, find_uneven_light
from warpvec.condition.noise import measure_noise
from warpvec.condition.reduction import find_reduction
from warpvec.condition.restoration import before_enlargement
from warpvec.condition.unrimming import unrimmed_pixels
from warpvec.image.alpha import is_transparent, over, premultiplied
from warpvec.image.luma import LUMA


@dataclass(frozen=True, eq=False)
class Condition:
    """What has happened to a picture; as it stands, nothing.

    Attributes:
        enlargement: how it was enlarged; None if it was not.
        edge_blur: the blur of its edges, in pixels before the enlargement.
        noise: standard deviation of the noise of each channel, in levels of 255; zeros for none.
        jpeg: what it was saved as; None for no JPEG.
        palette: its few colours; None for many.
        light: the light on its paper; None if it is even, or no paper.
        reduction: the kernel that it was reduced with, before it was enlarged if it was, if this has left rims at edges
            that can be undone; None if not.
    """

    enlargement: Enlargement | None = None
    edge_blur: EdgeBlur = SHARP
    noise: tuple[float, ...] = (0.0, 0.0, 0.0)
    jpeg: Jpeg | None = None
    palette: Palette | None = None
    light: Light | None = None
    reduction: str | None = None

    @property
    def blur(self) -> float:
        """Standard deviation of the blur, in pixels before the enlargement; 0 for none."""
        return self.edge_blur.deviation

    @property
    def facts(self) -> dict[str, Any]:
        """Plain values for JSON."""
        found, jpeg, palette = self.enlargement, self.jpeg, self.palette
        return {
            "enlarged": None
            if found is None
            else {"factor": found.factor, "width": found.width, "height": found.height, "kernel": found.kernel},
            "reduced": self.reduction,
            "blur": self.blur,
            "noise": list(self.noise),
            "jpeg": None if jpeg is None else {"quality": jpeg.quality, "subsampled": jpeg.is_subsampled},
            "colors": None if palette is None else palette.color_count,
            "dithered": palette is not None and palette.is_dithered,
            "uneven_light": 0.0 if self.light is None else self.light.range,
        }

    @property
    def words(self) -> str | None:
        """What has happened, in a few words; None if nothing has."""
        found, jpeg, parts = self.enlargement, self.jpeg, list[str]()
        if found is not None:
            size = f"{found.width} x {found.height} px"
            parts.append(f"enlarged {found.factor:.3g} times from {size} ({found.kernel})")
        if self.reduction is not None:
            parts.append(f"reduced{'' if found is None else ' before that'} ({self.reduction})")
        if self.blur:
            parts.append(f"blur {self.blur:.1f} px")
        if any(self.noise):
            parts.append(f"noise {np.mean(self.noise):.1f} levels")
        if jpeg is not None:
            parts.append(f"JPEG about {jpeg.quality}{', colours at half size' if jpeg.is_subsampled else ''}")
        if self.palette is not None and self.palette.is_dithered:
            parts.append(f"dithered in {self.palette.color_count} colours")
        if self.light is not None:
            parts.append(f"light uneven by {self.light.range:.0f} levels")
        return "; ".join(parts) or None


_ROWS = 256
"""Rows of a picture that are looked at over white at a time."""


def measure_condition(pixels: Floats32) -> Condition:
    """Measure what has happened to ``pixels`` [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if four.

    Very large pictures are measured in a window in their middle, apart from their enlargement.
    """
    enlargement = find_enlargement(_gray(pixels))
    part = _seen(_window(pixels))
    levels = 255.0 * part.astype(np.float64)
    restored = pixels if enlargement is None else before_enlargement(pixels, enlargement)
    small = levels if enlargement is None else 255.0 * _seen(_window(restored)).astype(np.float64)
    noise, jpeg = measure_noise(small), find_jpeg(levels)
    palette = find_palette(np.rint(small))
    # JPEG leaves ringing at thin parts, which looks like the rims of a kernel; few colours have none.
    has_few = palette is not None and palette.color_count <= CONDITION.rimless_colors_max
    may_be_rimmed = jpeg is None and not (has_few or any(noise))
    return Condition(
        enlargement,
        measure_blur(small @ LUMA, max(noise)),
        noise,
        jpeg,
        palette,
        find_uneven_light(levels) if part.shape[:2] == pixels.shape[:2] else None,
        _undone_reduction(_window(restored), enlargement is not None) if may_be_rimmed else None,
    )


def _undone_reduction(pixels: Floats32, is_enlarged: bool) -> str | None:
    """Return the kernel that ``pixels`` [h, w, 3 or 4] in [0, 1] were reduced with, if that is to be undone.

    That costs gradients some of their smoothness, which only an enlargement makes up for.
    """
    seen = premultiplied(pixels) if is_transparent(pixels) else pixels
    found = find_reduction(255.0 * seen.astype(np.float64))
    if found is None:
        return None
    areas = find_even_areas(seen)
    is_drawing = areas.is_still.mean() >= CONDITION.still_share_min
    is_plain = is_enlarged or areas.gradient_share <= CONDITION.gradient_max
    if not (is_drawing and is_plain) or unrimmed_pixels(areas) > CONDITION.unrimmed_pixels_max:
        return None
    return found


def _seen(pixels: Floats32) -> Floats32:
    """Return ``pixels`` [h, w, 3 or 4] over white."""
    return over(pixels, 1.0) if is_transparent(pixels) else pixels


def _gray(pixels: Floats32) -> NDArray[np.floating[Any]]:
    """Return the levels [h, w] in [0, 255] of ``pixels`` over white, or those of alpha if these are even."""
    weights, gray = 255.0 * np.array(LUMA, np.float32), np.empty(pixels.shape[:2], np.float32)
    for row in range(0, len(pixels), _ROWS):  # a copy of a whole picture takes 450 MB
        gray[row : row + _ROWS] = _seen(pixels[row : row + _ROWS]) @ weights
    return 255.0 * pixels[..., 3] if is_transparent(pixels) and np.ptp(gray) < 1.0 else gray


def _window(pixels: Floats32) -> Floats32:
    """Return the middle of ``pixels`` [h, w, 3], on the grid of JPEG."""
    sides = [
        slice(start := max(0, side - CONDITION.window) // 16 * 8, start + CONDITION.window) for side in pixels.shape[:2]
    ]
    return pixels[sides[0], sides[1]]

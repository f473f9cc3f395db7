"""How noisy a picture is, and the differences of colours that count in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

LUMA = np.array([0.299, 0.587, 0.114], np.float32)
"""Weights of red, green and blue in the brightness that JPEG stores at full resolution."""

EDGE_STEP = 24 / 255
"""Difference in brightness of two neighbours that counts as an edge, around which JPEG leaves ringing."""

BAND_NEAR, BAND_FAR = 3, 8
"""Distances in pixels from edges between which noise is measured: past the mixed pixels, within a block of JPEG."""

BAND_AREA_MIN = 64
"""Fewer pixels in this band say nothing; then the noise is measured in the whole picture."""

QUIET_SHARE, LOUD_SHARE = 0.75, 0.9
"""Quantiles of the second difference: clean pictures are below ``QUIET`` at the first; the second is their noise.
Of the sixteen pictures of the tests, clean ones have 0 to 0.3 levels at the first, those of JPEG quality 80 have 1.0 to
1.8, and 2 to 5 at the second, those of quality 60 up to 7."""

QUIET = 0.35 / 255
"""Second difference that rounding to 8 bits leaves in a gradient."""

MURMUR, MURMUR_SHARE, MURMUR_SIDE = (1.2 / 255, 12 / 255), 0.08, 200
"""Second differences that are more than rounding and less than an edge, and the share of pixels with such from which a
picture of at least this longer side in pixels is noisy though most of it is quiet: white clips the noise on one side of
a dark mark. Of 96 drawings at 256 and 512 px, clean ones have up to 0.07, those of JPEG quality 80 from 0.125 on, but
for one. Smaller clean ones have details of such contrast."""

NOISE_MIN = 1.2 / 255
"""Less noise than this is none: small clean pictures with ramps have 0.9 levels."""

NOISE_MAX = 12 / 255
"""The noisiest pictures are taken for this noisy, so that the tolerances stay below the contrast of drawings."""

SHARP_WIDTH = 2.05
"""Median width in pixels of the edges of sharp pictures at most. On the sixteen pictures of the tests it is 1.3 to 1.5,
and up to 2.0 after JPEG of quality 60; blurred by one pixel or enlarged twice it is 2.1 to 3.1."""

SHARP_REACH, REACH_MAX = 3, 8
"""Distances in pixels that regions reach into sharp edges, and into the softest ones that are looked at."""

EDGE_WINDOW, EDGE_SLOPE_MIN, EDGE_RISE_MIN, EDGE_COUNT_MIN = 9, 0.04, 0.15, 20
"""Edges whose widths are measured: their length in pixels, the least step and rise, and how many say something."""

CHROMA_WEIGHT = 0.4
"""Weight of colour beside brightness in noisy pictures. JPEG stores colour at half the resolution, so that it bleeds
over edges."""

THIN_CHROMA = 0.4
"""Weight of colour in thin parts of noisy pictures, as a part of that elsewhere: where a line is narrower than the
double pixels of colour, it takes on the colour around it."""


@dataclass(frozen=True, eq=False)
class Tolerances:
    """Differences of colours, in [0, 1], that do not count.

    Attributes:
        noise: noise of the picture; 0 if it is clean.
        step: between neighbours in one area.
        paint: between a pure pixel and its paint.
        mix: between a mixed pixel and the best mix of two paints.
        pool: between colours that were the same in the drawing.
        reach: distance in pixels, along each axis, of a region that can have a share in a pixel.
        metric: matrix [4, 4] from premultiplied RGBA to the space in which differences are measured.
    """

    noise: float
    step: float
    paint: float
    mix: float
    pool: float
    reach: int
    metric: Floats

    def thin_metric(self) -> Floats:
        """Return the metric [4, 4] for thin parts: in noisy pictures, these lose more of their colour than others."""
        weights = np.array([1, THIN_CHROMA, THIN_CHROMA, 1] if self.noise > 0 else [1, 1, 1, 1], np.float32)
        return self.metric * weights


def measure_tolerances(picture: Floats) -> Tolerances:
    """Return the tolerances for a picture [h, w, 4] of premultiplied RGBA."""
    noise = min(measure_noise(picture), NOISE_MAX)
    level, reach = 1 / 255, measure_reach(picture)
    if noise == 0:
        return Tolerances(0.0, 2.5 * level, 2 * level, 4 * level, 2 * level, reach, np.eye(4, dtype=np.float32))
    step, paint = 2 * level + 0.25 * noise, 3 * level + 1.0 * noise
    return Tolerances(noise, step, paint, 6 * level + 2 * noise, 4 * level + 0.5 * noise, reach, luma_and_color())


def luma_and_color() -> Floats:
    """Return the matrix [4, 4] from premultiplied RGBA to brightness, two weighted colour differences and alpha."""
    metric = np.zeros((4, 4), np.float32)
    metric[:3, 0] = LUMA
    metric[:3, 1] = CHROMA_WEIGHT * (np.array([0, 0, 1]) - LUMA)
    metric[:3, 2] = CHROMA_WEIGHT * (np.array([1, 0, 0]) - LUMA)
    metric[3, 3] = 1.0
    return metric


def measure_noise(picture: Floats) -> float:
    """Return the noise of a picture [h, w, 4] of premultiplied RGBA over white, or 0 if it is clean."""
    from scipy import ndimage

    luma = luma_over_white(picture)
    edge = np.zeros(luma.shape, bool)
    edge[:, 1:] |= np.abs(np.diff(luma, axis=1)) > EDGE_STEP
    edge[1:] |= np.abs(np.diff(luma, axis=0)) > EDGE_STEP
    distance_of_band = (2 * BAND_NEAR + 1, 2 * BAND_FAR + 1)
    near, far = (ndimage.maximum_filter(edge, size) for size in distance_of_band)
    band = far & ~near
    if band.sum() < BAND_AREA_MIN:
        band = ~near
    if not band.any():
        return 0.0
    difference = second_difference(luma)[band]
    quiet, loud = np.quantile(difference, [QUIET_SHARE, LOUD_SHARE])
    murmurs = (difference > MURMUR[0]) & (difference < MURMUR[1])
    is_noisy = quiet > QUIET or (max(luma.shape) >= MURMUR_SIDE and murmurs.mean() > MURMUR_SHARE)
    return float(loud) if is_noisy and loud > NOISE_MIN else 0.0


def luma_over_white(picture: Floats) -> Floats:
    """Return the brightness [h, w] of a picture [h, w, 4] of premultiplied RGBA over white."""
    luma: Floats = picture[..., :3] @ LUMA + 1 - picture[..., 3]
    return luma


def measure_reach(picture: Floats) -> int:
    """Return how far regions reach into the edges of a picture [h, w, 4]: farther if it is blurred or enlarged."""
    luma = luma_over_white(picture)[:-1, :-1]
    if luma.size == 0:
        return SHARP_REACH
    below, right = (np.abs(np.diff(luma_over_white(picture), axis=axis)) for axis in (0, 1))
    widths = np.concatenate([
        _edge_widths(luma, right[:-1], below[:, :-1], 1), _edge_widths(luma, below[:, :-1], right[:-1], 0)
    ])  # fmt: skip
    if len(widths) < EDGE_COUNT_MIN or np.median(widths) <= SHARP_WIDTH:
        return SHARP_REACH
    return min(int(np.ceil(2 * np.median(widths))), REACH_MAX)


def _edge_widths(luma: Floats, along: Floats, across: Floats, axis: int) -> Floats:
    """Return the widths [N] in pixels, rise over slope, of the edges that are steepest ``along`` the axis."""
    from scipy import ndimage

    size = [1, 1]
    size[axis] = EDGE_WINDOW
    rise = ndimage.maximum_filter(luma, size) - ndimage.minimum_filter(luma, size)
    is_top = (along == ndimage.maximum_filter(along, size)) & (along >= across)
    chosen = is_top & (along > EDGE_SLOPE_MIN) & (rise > EDGE_RISE_MIN)
    widths: Floats = rise[chosen] / along[chosen]
    return widths


def second_difference(luma: Floats) -> Floats:
    """Return the larger of the second differences along the two axes [h, w]; 0 at the border."""
    result = np.zeros_like(luma)
    result[:, 1:-1] = np.abs(np.diff(luma, 2, axis=1))
    result[1:-1] = np.maximum(result[1:-1], np.abs(np.diff(luma, 2, axis=0)))
    return result

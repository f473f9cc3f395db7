"""How noisy a picture is, and the differences of colours that count in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats32, Mask
from warpvec.flat.constants.regions import REGIONS
from warpvec.image import luma

LUMA = np.array(luma.LUMA, np.float32)
"""Weights of red, green and blue in the brightness that JPEG stores at full resolution."""


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
    metric: Floats32

    def thin_metric(self) -> Floats32:
        """Return the metric [4, 4] for thin parts: in noisy pictures, these lose more of their colour than others."""
        weights = np.array(
            [1, REGIONS.thin_chroma, REGIONS.thin_chroma, 1] if self.noise > 0 else [1, 1, 1, 1], np.float32
        )
        return self.metric * weights


def measure_tolerances(picture: Floats32, noise_min: float = 0.0, may_be_shaded: bool = True) -> Tolerances:
    """Return the tolerances for a picture [h, w, 4] of premultiplied RGBA with a noise of at least ``noise_min``.

    Shading that bends is no noise if it ``may_be_shaded``: slow ringing of a JPEG bends as much.
    """
    noise = min(max(measure_noise(picture, may_be_shaded), noise_min), REGIONS.noise_max)
    metric = luma_and_color() if noise else np.eye(4, dtype=np.float32)

    def tolerance(clean: float, noisy: float, factor: float) -> float:
        level = 1 / 255
        return noisy * level + factor * noise if noise else clean * level

    step, paint, mix, pool = (tolerance(*each) for each in (REGIONS.step, REGIONS.paint, REGIONS.mix, REGIONS.pool))
    return Tolerances(noise, step, paint, mix, pool, measure_reach(picture), metric)


def luma_and_color() -> Floats32:
    """Return the matrix [4, 4] from premultiplied RGBA to brightness, two weighted colour differences and alpha."""
    metric = np.zeros((4, 4), np.float32)
    metric[:3, 0] = LUMA
    metric[:3, 1] = REGIONS.chroma_weight * (np.array([0, 0, 1]) - LUMA)
    metric[:3, 2] = REGIONS.chroma_weight * (np.array([1, 0, 0]) - LUMA)
    metric[3, 3] = 1.0
    return metric


def measure_noise(picture: Floats32, may_be_shaded: bool = True) -> float:
    """Return the noise of a picture [h, w, 4] of premultiplied RGBA over white, or 0 if it is clean.

    Steep shading of an icon is no noise if it ``may_be_shaded``.
    """
    luma = luma_over_white(picture)
    edge = np.zeros(luma.shape, bool)
    edge[:, 1:] |= np.abs(np.diff(luma, axis=1)) > REGIONS.noise_edge_step
    edge[1:] |= np.abs(np.diff(luma, axis=0)) > REGIONS.noise_edge_step
    distances = (REGIONS.mixed_reach, REGIONS.noise_band_near, REGIONS.noise_band_far)
    mixed, near, far = (ndimage.maximum_filter(edge, 2 * distance + 1) for distance in distances)
    band = far & ~near
    if band.sum() < REGIONS.noise_band_area_min:
        band = ~near
    if not band.any():
        return 0.0
    difference, is_murmur = _murmurs(luma, band)
    quiet, loud = np.quantile(difference[band], [REGIONS.quiet_share, REGIONS.loud_share])
    murmurs = float(is_murmur[band].mean())
    if max(luma.shape) < REGIONS.murmur_side:
        is_loud = quiet > REGIONS.quiet and loud > REGIONS.noise_min_small
        is_rough = not may_be_shaded or max(luma.shape) > REGIONS.shaded_side or _is_rough(luma, band)
        return float(loud) if is_loud and is_rough else 0.0
    ring = near & ~mixed
    in_ring = float(is_murmur[ring].mean()) if ring.any() else murmurs
    is_noisy = quiet > REGIONS.quiet or min(murmurs, in_ring) > REGIONS.murmur_share
    if is_noisy and loud > REGIONS.noise_min:
        return float(loud)
    rings = ring.any() and in_ring > REGIONS.ring_share
    return REGIONS.noise_min if rings and murmurs > REGIONS.ring_murmur_share else 0.0


def _is_rough(luma: Floats32, band: Mask) -> bool:
    """Return whether ``luma`` [h, w] is noisy in the ``band`` [h, w]. Shading is not, however much it bends."""
    return bool(np.quantile(_largest_difference(luma, 4)[band], REGIONS.quiet_share) > REGIONS.rough_min)


def _murmurs(luma: Floats32, band: Mask) -> tuple[Floats32, Mask]:
    """Return the second differences of ``luma`` [h, w], and where they murmur: more than rounding, less than an edge.

    If nearly all that murmur in the ``band`` [h, w] are those of dithered ramps, these are taken for 0.
    """
    difference = second_difference(luma)
    is_murmur = (difference > REGIONS.murmur[0]) & (difference < REGIONS.murmur[1])
    is_dither = is_murmur & (_largest_step(luma) <= REGIONS.dither)
    if is_dither[band].sum() > REGIONS.dither_share * is_murmur[band].sum():
        is_murmur &= ~is_dither
        difference[is_dither] = 0.0
    return difference, is_murmur


def luma_over_white(picture: Floats32) -> Floats32:
    """Return the brightness [h, w] of a picture [h, w, 4] of premultiplied RGBA over white."""
    return picture[..., :3] @ LUMA + 1 - picture[..., 3]


def measure_reach(picture: Floats32) -> int:
    """Return how far regions reach into the edges of a picture [h, w, 4]: farther if it is blurred or enlarged."""
    luma = luma_over_white(picture)[:-1, :-1]
    if luma.size == 0:
        return REGIONS.sharp_reach
    below, right = (np.abs(np.diff(luma_over_white(picture), axis=axis)) for axis in (0, 1))
    widths = np.concatenate([
        _edge_widths(luma, right[:-1], below[:, :-1], 1), _edge_widths(luma, below[:, :-1], right[:-1], 0)
    ])  # fmt: skip
    if len(widths) < REGIONS.edge_count_min or np.median(widths) <= REGIONS.sharp_width:
        return REGIONS.sharp_reach
    return min(int(np.ceil(2 * np.median(widths))), REGIONS.reach_max)


def _edge_widths(luma: Floats32, along: Floats32, across: Floats32, axis: int) -> Floats32:
    """Return the widths [N] in pixels, rise over slope, of the edges that are steepest ``along`` the axis."""
    size = [1, 1]
    size[axis] = REGIONS.edge_window
    rise = ndimage.maximum_filter(luma, size) - ndimage.minimum_filter(luma, size)
    is_top = (along == ndimage.maximum_filter(along, size)) & (along >= across)
    chosen = is_top & (along > REGIONS.edge_slope_min) & (rise > REGIONS.edge_rise_min)
    return rise[chosen] / along[chosen]


def second_difference(luma: Floats32) -> Floats32:
    """Return the larger of the second differences along the two axes [h, w]; 0 at the border."""
    return _largest_difference(luma, 2)


def _largest_difference(luma: Floats32, order: int) -> Floats32:
    """Return the larger of the differences of an even ``order`` along the two axes [h, w]; 0 at the border."""
    result, margin = np.zeros_like(luma), order // 2
    result[:, margin:-margin] = np.abs(np.diff(luma, order, axis=1))
    result[margin:-margin] = np.maximum(result[margin:-margin], np.abs(np.diff(luma, order, axis=0)))
    return result


def _largest_step(luma: Floats32) -> Floats32:
    """Return the largest difference from one of the four neighbours [h, w]."""
    result = np.zeros_like(luma)
    for axis in (0, 1):
        step, along = np.abs(np.diff(luma, axis=axis)), np.moveaxis(result, axis, 0)
        step = np.moveaxis(step, axis, 0)
        along[1:] = np.maximum(along[1:], step)
        along[:-1] = np.maximum(along[:-1], step)
    return result

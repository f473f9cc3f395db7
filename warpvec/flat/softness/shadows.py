"""Find the shadow or glow of what lies on the flat ground of a picture.

The *casters* are the plateaus of one colour with sharp edges. The *soft zone* is what is neither ground nor caster. A
shadow is the mask of the casters, moved by (dx, dy) and blurred by sigma, times an amplitude in each channel. Moves and
blur are fitted by damped Gauss-Newton steps; the amplitude follows by least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.optimize import least_squares

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.flat.constants.softness import SOFTNESS

_SIGMAS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Standard deviations from which the fit begins, each a factor of two apart."""


_Found = tuple[tuple[float, float], float, Floats, float]
"""Offset, standard deviation, amplitude [3] and the unexplained share of the energy of a shadow."""


@dataclass(frozen=True)
class Shadow:
    """A shadow or glow.

    Attributes:
        casters: coverage of what casts it [h, w], in [0, 1].
        ground: colour of what it lies on [3], sRGB-encoded in [0, 1].
        amplitude: what it adds to the ground in each channel [3]; negative for a shadow.
        offset: how far it is moved to the right and down, in pixels.
        sigma: its standard deviation in pixels.
        clean: the picture without it [h, w, 3].
    """

    casters: Floats
    ground: Floats
    amplitude: Floats
    offset: tuple[float, float]
    sigma: float
    clean: Floats32

    @property
    def paint(self) -> tuple[Floats, float]:
        """The colour [3] and the opacity that look like this on the ground: the most extreme colour that can be."""
        room = np.where(self.amplitude < 0.0, self.ground, 1.0 - self.ground)
        opacity = float(np.clip((np.abs(self.amplitude) / np.maximum(room, 1e-6)).max(), 0.0, 1.0))
        return np.clip(self.ground + self.amplitude / max(opacity, 1e-6), 0.0, 1.0), opacity


def find_shadow(image: Floats32) -> Shadow | None:
    """Return the shadow of an opaque picture ``image`` [h, w, 3], sRGB-encoded in [0, 1]; None if it has none."""
    levels = 255.0 * image.astype(np.float64)
    plateaus, count = _plateaus(levels)
    ground = _ground(levels, plateaus, count)
    if ground is None or count > SOFTNESS.plateaus_max:
        return None
    color = np.median(levels[plateaus == ground], axis=0)
    is_ground = np.abs(levels - color).max(2) <= SOFTNESS.alike
    casters = _casters(levels, plateaus, count, ground, is_ground)
    if casters is None:
        return None
    found = _refitted(levels, casters, plateaus, color, is_ground)
    if found is None:
        return None
    casters, cast, (offset, sigma, amplitude, unexplained) = found
    is_soft = sigma >= SOFTNESS.sigma_min and np.abs(amplitude).max() >= SOFTNESS.amplitude_min
    if not is_soft or unexplained > SOFTNESS.unexplained:
        return None
    near = ndimage.binary_dilation(casters, iterations=2)
    shade = _shade(cast, found[2])
    covered = _coverage(levels, casters, near, color + shade)
    # Nothing else is on the ground, or it is no part of the shadow and stays.
    clean = levels - (1.0 - covered[..., None]) * shade
    edge = near & ~casters
    clean[edge] = _unshaded(levels, color, shade, casters & (plateaus > 0), edge)
    clean[~near & (np.abs(clean - color).max(2) <= 3.0 * SOFTNESS.alike)] = color
    cleaned: Floats32 = (np.clip(clean, 0.0, 255.0) / 255.0).astype(np.float32)
    return Shadow(cast, color / 255.0, amplitude / 255.0, offset, sigma, cleaned)


def _refitted(
    levels: Floats, casters: Mask, plateaus: NDArray[np.int32], color: Floats, is_ground: Mask
) -> tuple[Mask, Floats, _Found] | None:
    """Return what casts a shadow [h, w], its coverage [h, w] and the shadow, fitted in rounds; None without one."""
    found = _cast(levels, casters, color, is_ground)
    for _ in range(SOFTNESS.rounds):
        if found is None:
            return None
        # Even parts of a shadow that lie between two shapes look like a shape with sharp edges.
        real = _without_shaded(levels - color, casters, plateaus, found)
        again = _cast(levels, casters if real is None else real, color, is_ground, found)
        if real is not None and (again is None or again[1][3] > SOFTNESS.unexplained):
            # A shape has the colour of the shadow below it, by chance.
            real, again = None, _cast(levels, casters, color, is_ground, found)
        casters = casters if real is None else real
        # The edges of the shapes are known better with the shadow.
        is_settled = again is not None and abs(np.log(again[1][1] / found[1][1])) < SOFTNESS.settled
        found = again
        if real is None and is_settled:
            break
    return None if found is None else (casters, *found)


def _cast(
    levels: Floats, casters: Mask, color: Floats, is_ground: Mask, rough: tuple[Floats, _Found] | None = None
) -> tuple[Floats, _Found] | None:
    """Return the coverage [h, w] of what casts a shadow, and the shadow that fits best; None without a soft zone.

    Args:
        levels: the picture [h, w, 3].
        casters: pixels of shapes with sharp edges [h, w].
        color: the ground [3], in levels.
        is_ground: where the picture shows it [h, w].
        rough: a shadow that is nearly right; None to look for it in a small copy alone.
    """
    near = ndimage.binary_dilation(casters, iterations=2)
    if (~is_ground & ~near).sum() < SOFTNESS.zone_area:
        return None
    covered = _coverage(levels, casters, near, None if rough is None else color + _shade(*rough))
    # A hole in the colour of the ground may be painted, and then casts a shadow too.
    whole: Mask = ndimage.binary_fill_holes(casters)
    masks = [(covered, ~near)]
    if (whole & ~casters).any():
        masks.append((np.where(whole, 1.0, covered), ~near & ~whole))
    begin = None if rough is None else rough[1]
    tried = [(mask, _fitted(levels - color, mask, is_seen, begin)) for mask, is_seen in masks]
    fits = [(mask, fit) for mask, fit in tried if fit is not None]
    return min(fits, key=lambda each: each[1][3]) if fits else None


def _without_shaded(
    change: Floats, casters: Mask, plateaus: NDArray[np.int32], found: tuple[Floats, _Found]
) -> Mask | None:
    """Return the ``casters`` [h, w] without the plateaus that are as dark as the shadow there; None if all are real."""
    rest = np.abs(change - _shade(*found)).max(2)
    numbers = np.unique(plateaus[casters & (plateaus > 0)])
    medians = ndimage.median(rest, plateaus, numbers)
    shaded = numbers[medians < SOFTNESS.jump]
    if not len(shaded) or len(shaded) == len(numbers):
        return None
    nearest = ndimage.distance_transform_edt(plateaus == 0, return_distances=False, return_indices=True)
    return casters & ~np.isin(plateaus[tuple(nearest)], shaded)


def _plateaus(levels: Floats) -> tuple[NDArray[np.int32], int]:
    """Return the areas of one colour [h, w], numbered from 1 (0: none), and their number."""
    spread = ndimage.maximum_filter(levels, (3, 3, 1)) - ndimage.minimum_filter(levels, (3, 3, 1))
    core = spread.max(2) <= SOFTNESS.alike
    labels, count = ndimage.label(core)
    return labels.astype(np.int32), int(count)


def _ground(levels: Floats, plateaus: NDArray[np.int32], count: int) -> int | None:
    """Return the plateau that a shadow may lie on: the largest that reaches the border of the picture."""
    sizes = np.bincount(plateaus.ravel(), minlength=count + 1)
    rim = np.concatenate([plateaus[0], plateaus[-1], plateaus[:, 0], plateaus[:, -1]])
    outer = np.unique(rim[rim > 0])
    if not len(outer):
        return None
    best = int(outer[np.argmax(sizes[outer])])
    return best if sizes[best] >= SOFTNESS.ground_share * plateaus.size else None


def _casters(levels: Floats, plateaus: NDArray[np.int32], count: int, ground: int, is_ground: Mask) -> Mask | None:
    """Return the pixels of the plateaus with sharp edges [h, w]; None if there are none."""
    found = np.zeros(plateaus.shape, np.bool_)
    sizes = np.bincount(plateaus.ravel(), minlength=count + 1)
    boxes = ndimage.find_objects(plateaus)
    for number in range(1, count + 1):
        if number == ground or sizes[number] < SOFTNESS.plateau_area:
            continue
        rows, columns = (slice(max(part.start - 6, 0), part.stop + 6) for part in boxes[number - 1])
        own = plateaus[rows, columns] == number
        part = levels[rows, columns]
        color = np.median(part[own], axis=0)
        is_like = np.abs(part - color).max(2) <= 2.0 * SOFTNESS.alike
        whole = ndimage.binary_propagation(own, mask=is_like)
        away = ndimage.distance_transform_edt(~whole)
        change = np.abs(part - color).max(2)
        first, later = change[(away > 1.5) & (away <= 2.5)], change[(away > 3.5) & (away <= 4.5)]
        if not len(first) or not len(later):
            continue
        step, rest = float(np.median(first)), abs(float(np.median(later)) - float(np.median(first)))
        if step >= SOFTNESS.jump and step >= SOFTNESS.sharpness * rest:
            found[rows, columns] |= whole
    if not found.any():
        return None
    # The anti-aliased edge between two sharp parts belongs to them. A shadow that they enclose does not.
    closed: Mask = ndimage.binary_closing(np.pad(found, 4))[4:-4, 4:-4]
    return (found | closed) & ~is_ground


def _coverage(levels: Floats, casters: Mask, near: Mask, shaded: Floats | None) -> Floats:
    """Return how much of each pixel the casters cover [h, w]; of a pixel at their edge, by its colour.

    Args:
        levels: the picture [h, w, 3].
        casters: pixels that they cover [h, w].
        near: these and the pixels at their edges [h, w].
        shaded: the ground with its shadow [h, w, 3], which changes within a few pixels; None if that is not known.
    """
    _, (y, x) = ndimage.distance_transform_edt(~casters, return_indices=True)
    _, (v, u) = ndimage.distance_transform_edt(near, return_indices=True)
    own, beside = levels[y, x], levels[v, u]
    if shaded is not None:
        is_shade = np.abs(beside - shaded[v, u]).max(2) < SOFTNESS.jump
        beside = np.where(is_shade[..., None], shaded, beside)
    span = own - beside
    share = ((levels - beside) * span).sum(2) / np.maximum((span * span).sum(2), 1.0)
    return np.where(casters, 1.0, np.where(near, np.clip(share, 0.0, 1.0), 0.0))


def _unshaded(levels: Floats, ground: Floats, shade: Floats, pure: Mask, edge: Mask) -> Floats:
    """Return the colours of the pixels at an ``edge`` [K, 3] as they mix the nearest ``pure`` colour and the ground."""
    _, (y, x) = ndimage.distance_transform_edt(~pure, return_indices=True)
    own, beside = levels[y, x][edge], (ground + shade)[edge]
    span = own - beside
    share = ((levels[edge] - beside) * span).sum(1) / np.maximum((span * span).sum(1), 1.0)
    share = np.clip(share, 0.0, 1.0)[:, None]
    mixed: Floats = share * own + (1.0 - share) * ground
    return mixed


def _shade(cast: Floats, found: _Found) -> Floats:
    """Return what a shadow adds to the ground [h, w, 3], in levels."""
    offset, sigma, amplitude, _ = found
    shade: Floats = _moved_blur(cast, offset, sigma)[..., None] * amplitude
    return shade


def _moved_blur(mask: Floats, offset: tuple[float, float], sigma: float) -> Floats:
    """Return ``mask`` [h, w] moved and blurred; at the border of the picture it goes on as it is there."""
    moved = ndimage.shift(mask, (offset[1], offset[0]), order=3, mode="nearest") if any(offset) else mask
    blurred: Floats = ndimage.gaussian_filter(moved, sigma, mode="nearest", truncate=3.5)
    return blurred


def _fitted(change: Floats, mask: Floats, is_seen: Mask, rough: _Found | None) -> _Found | None:
    """Return the shadow that `_fit` finds in a small copy, or from a ``rough`` one on in the picture itself.

    It is None if the small copy shows that there is none.
    """
    step = -(-max(mask.shape) // SOFTNESS.coarse_side)
    if rough is not None:
        (dx, dy), sigma, _, _ = rough
        return _fit(change, mask, is_seen, (dx, dy, sigma))
    if step == 1:
        return _fit(change, mask, is_seen)
    small = [_reduced(each, step) for each in (change, mask, is_seen.astype(np.float64))]
    coarse = _fit(small[0], small[1], small[2] == 1.0)
    if coarse is None or coarse[3] > SOFTNESS.coarse_unexplained:
        return None
    (dx, dy), sigma, amplitude, unexplained = coarse
    return (step * dx, step * dy), step * sigma, amplitude, unexplained


def _reduced(values: Floats, step: int) -> Floats:
    """Return the means [h // step, w // step, ...] of blocks of ``step`` x ``step`` pixels."""
    height, width = (size // step for size in values.shape[:2])
    blocks = values[: height * step, : width * step].reshape(height, step, width, step, *values.shape[2:])
    means: Floats = blocks.mean((1, 3))
    return means


def _fit(change: Floats, mask: Floats, is_seen: Mask, begin: tuple[float, float, float] | None = None) -> _Found | None:
    """Return offset, standard deviation, amplitude [3] and the unexplained share of the energy of a shadow.

    Args:
        change: the picture minus its ground, in levels [h, w, 3].
        mask: coverage of the casters [h, w].
        is_seen: where nothing covers the shadow [h, w].
        begin: an offset and a standard deviation that are nearly right; None to look for these.
    """
    seen = change[is_seen]
    energy = float((seen * seen).sum())
    if energy <= 0.0 or not mask.any():
        return None

    def amplitude(shade: Floats) -> Floats:
        own = shade[is_seen]
        found: Floats = own @ seen / max(float(own @ own), 1e-12)
        return found

    def residual(values: Floats) -> Floats:
        shade = _moved_blur(mask, (values[0], values[1]), float(np.exp(values[2])))
        left: Floats = (seen - shade[is_seen][:, None] * amplitude(shade)).ravel()
        return left

    weight = np.abs(change).sum(2) * is_seen
    y, x = np.indices(mask.shape)
    lean = [float((weight * axis).sum() / weight.sum() - (mask * axis).sum() / mask.sum()) for axis in (x, y)]
    starts = [(dx, dy, np.log(sigma)) for sigma in _SIGMAS for dx, dy in ((0.0, 0.0), (0.5 * lean[0], 0.5 * lean[1]))]
    if begin is not None:
        starts = [(begin[0], begin[1], np.log(begin[2]))]
    losses = [float((residual(np.array(start)) ** 2).sum()) for start in starts]
    best = np.array(starts[int(np.argmin(losses))])
    bounds = ([-80.0, -80.0, np.log(0.25)], [80.0, 80.0, np.log(SOFTNESS.sigma_max)])
    best = np.clip(best, np.array(bounds[0]) + 1e-3, np.array(bounds[1]) - 1e-3)
    found = least_squares(residual, best, bounds=bounds, x_scale=(1.0, 1.0, 0.2), diff_step=1e-3, max_nfev=30)
    shade = _moved_blur(mask, (found.x[0], found.x[1]), float(np.exp(found.x[2])))
    offset, sigma = (float(found.x[0]), float(found.x[1])), float(np.exp(found.x[2]))
    return offset, sigma, amplitude(shade), float(2.0 * found.cost) / energy

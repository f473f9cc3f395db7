"""Find out whether a picture was enlarged, from which size, and by which kernel.

An enlarged row of N pixels has only n numbers. The rows of n pixels that explain it best (`resampling`) leave almost
nothing unexplained, but those of n - 2 or n + 2 pixels do, because their grid is another. No clean picture has such a
dip, and no blurred one. Which sizes are worth a try is seen in the changes of a row: the variance of second differences
of an interpolated row has the period of the enlargement. Source: Gallagher, Detection of linear and cubic interpolation
in JPEG compressed images, 2005.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from warpvec.arrays import Floats
from warpvec.condition.constants import CONDITION
from warpvec.condition.resampling import KERNELS, NEAREST, Upsampling, upsampling


@dataclass(frozen=True)
class Enlargement:
    """An enlargement that was found.

    Attributes:
        width: width in pixels before it.
        height: height in pixels before it.
        kernel: a key of `warpvec.condition.resampling.KERNELS`, or ``NEAREST``.
        factor: enlargement of the longer side.
        unexplained: root mean square in levels of what the enlargement does not explain along the edges that were
            looked at.
    """

    width: int
    height: int
    kernel: str
    factor: float
    unexplained: float

    @property
    def is_of_whole_pixels(self) -> bool:
        """Whether each pixel became a square of pixels."""
        return self.kernel == NEAREST and float(self.factor).is_integer()


def find_enlargement(gray: NDArray[np.floating[Any]]) -> Enlargement | None:
    """Return the enlargement of the levels ``gray`` [h, w] in [0, 255]; None if there is none."""
    height, width = gray.shape
    along, across = (Lines(busiest(line)) for line in ((gray.T, gray) if width >= height else (gray, gray.T)))
    if min(along.length, across.length) < CONDITION.side_min * CONDITION.factor_min or not along.rows.any():
        return None
    found = [_checked(along, across, size, NEAREST) for size in _whole_sizes(along.length)]
    exact = next((each for each in found if each is not None), None)  # multiples of its size explain it too
    best = exact or _best([_checked(along, across, size) for size in _deepest(along, _sizes_to_try(along, across))])
    if best is None:
        return None
    sides = (best.along, best.across) if width >= height else (best.across, best.along)
    names = [NEAREST] if best.kernel == NEAREST else list(KERNELS)
    rest = {
        name: Upsampling(along.length, best.along, name).unexplained_of_cut_off(along.rows, *CONDITION.cut_off)
        for name in names
    }
    kernel = min(names, key=lambda name: rest[name])
    return Enlargement(*sides, kernel, along.length / best.along, rest[kernel])


class _Candidate(NamedTuple):
    """An enlargement that both axes speak for: the sizes along and across, its kernel, and its dip."""

    along: int
    across: int
    kernel: str
    dip: float


def _best(found: list[_Candidate | None]) -> _Candidate | None:
    """Return the candidate with the deepest dip; of those with whole pixels, the smallest."""
    clear = [each for each in found if each is not None]
    exact = [each for each in clear if each.kernel == NEAREST]
    if exact:
        return min(exact, key=lambda each: each.along)
    return min(clear, key=lambda each: each.dip, default=None)


class Lines:
    """Lines of a picture, and what is unexplained of them by each size."""

    def __init__(self, rows: Floats) -> None:
        """Keep the ``rows`` [length, N]."""
        self.rows, self.length = rows, len(rows)
        self._known: dict[tuple[int, str, bool], float] = {}

    def unexplained(self, size: int, kernel: str, is_cut: bool = False) -> float:
        """Return the root mean square in levels of what rows of ``size`` pixels do not explain.

        With ``is_cut``, pixels at black or white may have been cut off there, if that explains more; it takes longer.
        """
        is_cut &= self.is_cut_off and kernel in OVERSHOOTING
        if (size, kernel, is_cut) not in self._known:
            up = upsampling(self.length, size, kernel)
            rest = up.unexplained_of_cut_off(self.rows, *CONDITION.cut_off) if is_cut else up.unexplained(self.rows)
            self._known[size, kernel, is_cut] = rest
        rest = self._known[size, kernel, is_cut]
        return min(rest, self.unexplained(size, kernel)) if is_cut else rest

    def dip(self, size: int, kernel: str, reach: int = 2, is_cut: bool = False, most: float = math.inf) -> float:
        """Return what ``size`` leaves unexplained, as a share of the least that sizes beside it, within reach, do.

        It is infinite if it is above ``most``: the first size beside it that is explained as well tells that.
        """
        sizes = [size + step for step in range(-reach, reach + 1) if step != 0 and size + step > 1]
        own, share = self.unexplained(size, kernel, is_cut) + CONDITION.dip_levels, 0.0
        for is_beside_cut in sorted({False, is_cut}):  # the quick test first, which bounds the other
            for each in sizes:
                share = max(share, own / (self.unexplained(each, kernel, is_beside_cut) + CONDITION.dip_levels))
                if share > most:
                    return math.inf
        return share

    @cached_property
    def is_cut_off(self) -> bool:
        """Whether some pixels are black or white, at which what an enlargement overshoots is cut off."""
        low, high = CONDITION.cut_off
        return bool(((self.rows <= low) | (self.rows >= high)).any())

    @cached_property
    def is_clean(self) -> bool:
        """Whether most changes are exactly as before: no JPEG and no noise."""
        return (
            float(np.quantile(np.abs(np.diff(self.rows, 2, axis=0)), CONDITION.clean_share)) <= CONDITION.clean_levels
        )

    @cached_property
    def has_plain_edges(self) -> bool:
        """Whether most edges begin at an even run that was not cut off, where a kernel overshoots."""
        low, high = CONDITION.cut_off
        begun = plain = 0
        for rows in (self.rows, self.rows[::-1]):
            change = np.abs(np.diff(rows, axis=0))
            is_begin = (change[2:] >= CONDITION.step_min) & (change[1:-1] < CONDITION.step_min)
            is_begin &= (rows[2:-1] > low) & (rows[2:-1] < high)
            begun += int(is_begin.sum())
            plain += int((is_begin & (np.maximum(change[1:-1], change[:-2]) <= 1.0)).sum())
        return 2 * plain > begun

    @cached_property
    def spectrum(self) -> Floats:
        """How much more the changes repeat at each of ``_FREQUENCIES`` than at those beside it."""
        change = np.abs(np.diff(self.rows, 2, axis=0))
        profile = (change / (change.max(0) + CONDITION.change_levels)).mean(1)
        count = 4 * len(profile)
        power = np.abs(np.fft.rfft((profile - profile.mean()) * np.hanning(len(profile)), count))
        relative = power / (median_filter(power, CONDITION.spectrum_window) + 1e-9)
        return np.interp(_FREQUENCIES, np.arange(len(power)) / count, relative)


OVERSHOOTING = frozenset(KERNELS) - {"bilinear"}
"""The kernels with negative weights."""

SCANNED = "bilinear"
"""The kernel that sizes are looked for with: it is quick, and what other kernels have made dips with it too."""

_FREQUENCIES = np.linspace(1.0 / 40.0, 0.5, 8000)
"""Repetitions per pixel at which spectra are compared."""


def busiest(lines: NDArray[np.floating[Any]]) -> Floats:
    """Return the columns [length, N] of ``lines`` [length, M] that change most, spread over the picture."""
    activity = (np.diff(lines, axis=0) ** 2).sum(0)
    order = np.argsort(-activity)[: 4 * CONDITION.rows]
    return np.asarray(lines[:, np.sort(order)[:: max(1, len(order) // CONDITION.rows)]], np.float64)


def _usual_sizes(length: int) -> list[int]:
    """Return the sizes that people enlarge to ``length`` from."""
    return _possible({*CONDITION.sides, *(round(length / factor) for factor in CONDITION.factors)}, length)


def _whole_sizes(length: int) -> list[int]:
    """Return the sizes that ``length`` is a multiple of, the smallest first."""
    return _possible({size for size in range(1, length // 2 + 1) if length % size == 0}, length)


def _possible(sizes: set[int], length: int) -> list[int]:
    return sorted(size for size in sizes if CONDITION.side_min <= size <= length / CONDITION.factor_min)


def _sizes_to_try(along: Lines, across: Lines) -> list[int]:
    """Return the sizes that the spectra of both axes speak for."""
    spectrum, length = along.spectrum + across.spectrum, along.length

    def strength(size: int) -> float:
        frequency = size / length
        is_near = np.abs(_FREQUENCIES - min(frequency, 1.0 - frequency)) < 0.5 / length
        return float(spectrum[is_near].max(initial=0.0))

    usual = sorted(_usual_sizes(length), key=strength)[-CONDITION.usual_count :]
    sizes = {*usual, *(round(length / factor) for factor in CONDITION.always)}
    left = spectrum.copy()
    for _ in range(CONDITION.peaks):
        frequency = float(_FREQUENCIES[left.argmax()])
        left[np.abs(_FREQUENCIES - frequency) < 1.5 / length] = 0.0
        for share in (frequency, 1.0 - frequency):  # the second is seen as the first, because pixels are whole
            sizes |= {round(length * share) + step for step in (-1, 0, 1)}
    return _possible(sizes, length)


def _deepest(along: Lines, sizes: list[int]) -> list[int]:
    """Return the few of the ``sizes`` with the deepest dips at a first look."""
    dips = {size: along.dip(size, SCANNED, most=CONDITION.scan_dip_max) for size in sizes}
    return sorted((size for size in sizes if dips[size] < math.inf), key=lambda size: dips[size])[: CONDITION.tried]


def _is_explained(along: Lines, across: Lines, sizes: tuple[int, int], kernel: str) -> bool:
    """Return whether an enlargement from ``sizes`` along and across leaves hardly more than rounding, or JPEG.

    Edges of an icon may lie on a grid by chance, but a clean picture that was enlarged is explained exactly.
    """
    if along.is_clean and across.is_clean:
        return all(_is_exact(lines, size, kernel) for lines, size in zip((along, across), sizes, strict=True))
    rest = along.unexplained(sizes[0], kernel, True), across.unexplained(sizes[1], kernel, True)
    limit = CONDITION.nearest_rest_max if kernel == NEAREST else CONDITION.rest_max
    return min(rest) <= limit  # what was cut off at black or white may be on one axis alone


def _is_exact(lines: Lines, size: int, kernel: str) -> bool:
    """Return whether an enlargement from ``size`` leaves no more of clean lines than rounding does."""
    limit = CONDITION.clean_levels if kernel == NEAREST else CONDITION.clean_rest_max
    return _may_be_exact(lines, size, kernel) and lines.unexplained(size, kernel, True) <= limit


def _may_be_exact(lines: Lines, size: int, kernel: str) -> bool:
    """Return whether `_is_exact` may say so, by what is unexplained with nothing cut off."""
    return lines.unexplained(size, kernel) <= CONDITION.clean_whole_rest_max


def _checked(along: Lines, across: Lines, size: int, kernel: str | None = None) -> _Candidate | None:
    """Return the enlargement from ``size`` along, if both axes speak for it; by the ``kernel`` that explains most."""
    may_overshoot = not (along.has_plain_edges and across.has_plain_edges)
    kernels = [name for name in KERNELS if may_overshoot or name not in OVERSHOOTING]
    names = [NEAREST, *kernels] if kernel is None else [kernel]
    if along.is_clean and across.is_clean and not any(_may_be_exact(along, size, each) for each in names):
        return None  # the test of cut-off values is slower, and could not change this
    name = min(names, key=lambda each: along.unexplained(size, each, True)) if kernel is None else kernel
    limit = CONDITION.nearest_dip_max if name == NEAREST else CONDITION.dip_max
    if name == NEAREST and along.length % size:
        return None  # squares of unequal sizes are as likely the edges of a drawing
    if along.is_clean and across.is_clean and not _is_exact(along, size, name):
        return None
    reach, most = CONDITION.dip_reach, CONDITION.axis_dip_max
    dips = [along.dip(size, name, reach, True, most)]
    if dips[0] > most:
        return None
    middle = round(size * across.length / along.length)
    near = [max(CONDITION.side_min // 2, middle + step) for step in (-1, 0, 1)]
    other = min(near, key=lambda each: across.unexplained(each, name, True))
    if other > CONDITION.side_min // 2 and across.rows.any():
        dips.append(across.dip(other, name, reach, True, most))
    mean = math.prod(dips) ** (1.0 / len(dips))
    is_clear = max(dips) <= most and mean <= limit
    is_clear = is_clear and _is_explained(along, across, (size, other), name)
    return _Candidate(size, other, name, mean) if is_clear else None

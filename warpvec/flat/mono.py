"""Black and white art, such as scans, line drawings and signatures, as one compound path in black."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.errors import InputError
from warpvec.flat.chains.saying import LoopRows
from warpvec.flat.chains.traced import said_enlarged
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.constants.mono import MONO
from warpvec.flat.curves.contours import contours_of, interpolated_contours, signed_area
from warpvec.flat.faint_lines import faint_line_count
from warpvec.flat.ink_specks import specks_among
from warpvec.flat.layers.fine_outlines import fine_contours_of
from warpvec.flat.staircases import staircase_outlines
from warpvec.flat.two_levels import has_two_levels
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.image.luma import LUMA
from warpvec.watch.watch import UNWATCHED, Watch


@dataclass(frozen=True)
class MonoTracing:
    """A tracing in black.

    Attributes:
        scene: one compound path in black, without a background; no path if the picture has no ink.
        threshold: level in [0, 255] below which a pixel is ink.
        coverage: share of ink in each pixel [h, w], in [0, 1].
        is_clean: whether the coverage is that of a renderer, blurred at most: it tells where in a pixel each edge lies.
        speck_count: number of specks and of holes that were left out, because they were too small.
        faint_count: number of lines that were left out, because they cover no pixel by half.
    """

    scene: Scene
    threshold: float
    coverage: Floats
    is_clean: bool
    speck_count: int
    faint_count: int = 0


def mono_tracing(
    image: NDArray[Any],
    threshold: float | Literal["auto"] = "auto",
    *,
    tolerance: float | None = None,
    min_area: float | None = None,
    blur: float = 0.0,
    is_to_be_fitted: bool = False,
    watch: Watch = UNWATCHED,
) -> MonoTracing:
    """Trace what is darker than ``threshold`` in an image, over white, as one compound path in black.

    The outlines lie between pixels, where the grey levels pass the threshold. Holes run the other way round.

    Args:
        image: [h, w, 3 or 4], uint8 or float in [0, 1].
        threshold: a level in [0, 255]; "auto" for the middle between ink and paper, which Otsu's threshold tells apart.
        tolerance: largest distance in pixels between an outline and its curves; None for one that suits the noise.
        min_area: specks and holes of fewer square pixels are left out; None to tell specks by what lies around them.
        blur: standard deviation in pixels of the blur of the image; 0 for none that is known.
        is_to_be_fitted: whether a fit follows if the tracing is clean. Outlines of small pictures are then found on a
            finer grid.
        watch: the watch over the run. When it is over, the outlines so far must do, the largest first.

    Raises:
        InputError: the threshold is not in [0, 255].
    """
    if threshold != "auto" and not 0 <= threshold <= 255:
        raise InputError("threshold", 'must be "auto" or a level in 0 to 255', str(threshold), "give 128")
    gray = _gray(image)
    levels = find_levels(gray, None if threshold == "auto" else threshold / 255.0)
    coverage = np.clip(0.5 + (levels.threshold - gray) / (levels.paper - levels.ink), 0.0, 1.0)
    is_clean, is_sharp, is_fine = False, False, False
    are_two_levels, is_thin, faint_count = has_two_levels(coverage), False, 0
    if are_two_levels:
        tolerance = MONO.staircase_tolerance if tolerance is None else tolerance
        outlines = staircase_outlines(coverage)
    else:
        noise_tolerance = MONO.noise_deviations * _noise(coverage) / MONO.edge_slope
        is_sharp = _pure_share(coverage) >= MONO.sharp_share
        is_clean = (is_sharp or blur > 0.0) and noise_tolerance <= CURVES.tolerance
        is_small = is_sharp and max(coverage.shape) <= DRAWING.small_side
        least = DRAWING.small_tolerance if is_small else CURVES.tolerance
        tolerance = max(least, noise_tolerance) if tolerance is None else tolerance
        may_be_fine = is_to_be_fitted and is_sharp and is_clean and blur == 0.0
        is_fine = may_be_fine and max(coverage.shape) <= DRAWING.fine_side
        faint_count = faint_line_count(coverage)
        is_plain = noise_tolerance <= CURVES.tolerance and blur == 0.0 and coverage.size <= LETTERING.thin_line_box
        is_thin = faint_count > 0 and is_plain
        if is_thin:
            outlines = fine_contours_of(coverage)
            faint_count = max(0, faint_count - len(outlines))
        elif is_fine:
            outlines = fine_contours_of(coverage, 0.0)
        else:
            outlines = contours_of(coverage) if is_sharp else interpolated_contours(np.pad(coverage, 1), 1)
    kept = _kept(outlines, coverage, min_area, are_two_levels)
    if are_two_levels or is_thin:
        scale = MONO.staircase_scale
    elif is_fine:
        scale = DRAWING.small_scale
    elif is_clean and len(kept) <= MONO.form_loops_max:
        scale = 1.0 / max(blur, 1.0)  # corners are as round as the blur is wide, and a later fit undoes it
    else:
        scale = 1.0 if is_sharp else MONO.soft_scale
    allowed = _tolerances(kept, tolerance) if are_two_levels or is_thin else np.full(len(kept), tolerance)
    fitted = _fitted(kept, allowed, scale, watch)
    left_out = len(outlines) - len(fitted)
    return MonoTracing(_scene(fitted), 255.0 * levels.threshold, coverage, is_clean, left_out, faint_count)


def _kept(outlines: list[Floats], coverage: Floats, min_area: float | None, are_two_levels: bool) -> list[Floats]:
    """Return the ``outlines`` [n, 2] that are no specks, the largest first; the arguments as in `mono_tracing`."""
    by_area = sorted(outlines, key=lambda outline: -abs(signed_area(outline)))[: MONO.outlines_max]
    areas = np.array([abs(signed_area(outline)) for outline in by_area])
    if min_area is None:
        is_speck = specks_among(by_area, areas, coverage > CURVES.contour_level, are_two_levels)
    else:
        is_speck = areas < max(min_area, MONO.point_area)
    return [outline for outline, is_left_out in zip(by_area, is_speck, strict=True) if not is_left_out]


def _tolerances(outlines: list[Floats], largest: float) -> Floats:
    """Return the tolerance in pixels for each of the ``outlines`` [L]: at most the ``largest``, less for letters."""
    steps = [np.hypot(*(outline - np.roll(outline, 1, 0)).T).sum() for outline in outlines]
    widths = [2.0 * abs(signed_area(outline)) / length for outline, length in zip(outlines, steps, strict=True)]
    allowed = np.clip(largest * np.array(widths) / MONO.full_width, min(MONO.thin_tolerance, largest), largest)
    is_letter = np.array([np.ptp(outline, axis=0).max() <= MONO.letter_side for outline in outlines], bool)
    return np.where(is_letter, allowed, largest)


class Levels(NamedTuple):
    """Levels in [0, 1] of ink and of paper, and that which parts them."""

    ink: float
    paper: float
    threshold: float


def find_levels(gray: Floats, threshold: float | None = None) -> Levels:
    """Return the levels of ink and paper of ``gray`` [h, w], and a threshold half way between, where it is not given.

    Otsu's threshold tells ink from paper. It lies above the middle if strokes are thin, because their mean is lighter
    than ink, and would make them bolder.
    """
    parting = otsu_threshold(gray) if threshold is None else threshold
    is_ink = gray < parting
    if is_ink.all() or not is_ink.any():
        return Levels(parting - 0.5, parting + 0.5, parting)
    solid = ndimage.binary_erosion(is_ink)
    darkest = float(np.quantile(gray[is_ink], MONO.thin_quantile))
    ink = float(np.median(gray[solid])) if solid.sum() >= MONO.solid_count else darkest
    paper = max(float(np.median(gray[~is_ink])), ink + 1.0 / 255.0)
    return Levels(ink, paper, (ink + paper) / 2 if threshold is None else threshold)


def otsu_threshold(gray: Floats) -> float:
    """Return the level in [0, 1] that parts the levels of ``gray`` [h, w] into the two most distinct classes.

    An image of one level is parted at 0.5. Source: Otsu, A threshold selection method from gray-level histograms, 1979.
    """
    counts, edges = np.histogram(gray, bins=MONO.bins, range=(0.0, 1.0))
    levels = (edges[:-1] + edges[1:]) / 2
    below, sums = np.cumsum(counts)[:-1].astype(np.float64), np.cumsum(counts * levels)
    above = gray.size - below
    is_parted = (below > 0) & (above > 0)
    if not is_parted.any():
        return 0.5
    with np.errstate(divide="ignore", invalid="ignore"):
        dark, light = sums[:-1] / below, (sums[-1] - sums[:-1]) / above
        between = np.where(is_parted, below * above * (light - dark) ** 2, -1.0)
    best = int(between.argmax())
    return float(dark[best] + light[best]) / 2


def _gray(image: NDArray[Any]) -> Floats:
    """Return the levels [h, w] in [0, 1] of ``image`` over white, by the weights of Rec. 601."""
    values = image.astype(np.float64) / (255.0 if image.dtype == np.uint8 else 1.0)
    if values.shape[2] == 4:
        values = values[..., :3] * values[..., 3:] + 1.0 - values[..., 3:]
    return values @ np.array(LUMA)


def _pure_share(coverage: Floats) -> float:
    """Return the share of partly covered pixels of ``coverage`` [h, w] with both ink and paper beside them."""
    is_partial = (coverage > MONO.between_levels) & (coverage < 1 - MONO.between_levels)
    has_ink = ndimage.maximum_filter(coverage, 3) >= 1 - MONO.pure_levels
    has_paper = ndimage.minimum_filter(coverage, 3) <= MONO.pure_levels
    return float((has_ink & has_paper)[is_partial].mean()) if is_partial.any() else 1.0


def _noise(coverage: Floats) -> float:
    """Return the standard deviation of the noise of ``coverage`` [h, w], from the differences of nearby pixels."""
    if min(coverage.shape) < 2:
        return 0.0
    # Where four pixels are of one class, their mixed second difference has four times the variance.
    mixed = coverage[1:, 1:] - coverage[1:, :-1] - coverage[:-1, 1:] + coverage[:-1, :-1]
    return float(1.4826 * np.median(np.abs(mixed)) / 2)


def _fitted(outlines: list[Floats], tolerance: Floats, scale: float, watch: Watch) -> list[LoopRows]:
    """Return the curves of ``outlines`` [L] within ``tolerance`` [L] pixels, fitted at ``scale``.

    Once the ``watch`` is over, they are those of the first outlines.
    """
    fitted: list[LoopRows] = []
    for first in range(0, len(outlines), MONO.outlines_at_once):
        if fitted and watch.is_over():
            break
        part = slice(first, first + MONO.outlines_at_once)
        some = outlines[part]
        fitted += said_enlarged(some, [scale] * len(some), tolerance[part])
    return fitted


def _scene(fitted: list[LoopRows]) -> Scene:
    """Return a scene of one path with the curves of its loops."""
    count = 1 if fitted else 0
    segments = np.concatenate([np.zeros((0, 3, 2)), *(loop for loop, _ in fitted)])
    lines = np.concatenate([np.zeros(0, bool), *(is_line for _, is_line in fitted)])
    sizes = [[len(loop) for loop, _ in fitted]] if fitted else []
    return Scene(
        torch.from_numpy(segments).float(),
        Structure.of_loops(sizes, torch.from_numpy(lines)),
        color=torch.zeros(count, 3),
        opacity=torch.ones(count),
        background=torch.zeros(3),
        generation=torch.zeros(count, dtype=torch.int64),
        transparent=True,
    )

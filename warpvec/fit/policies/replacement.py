"""Bezier Splatting's population: all paths at once; now and then some are removed, and as many are added elsewhere.

Source: Liu et al., Bezier Splatting (NeurIPS 2025), in the closed mode of its code, xiliu8006/Bezier_splatting at
9612a22: train_withsvg.py lines 178-191 (when), gaussianimage_cholesky_svg.py lines 236-273 (the start), 562-580 (new
paths) and 967-1075 (which are removed), utils.py lines 493-553 (where). Shares of the run are those of its 10,000
iterations; areas and sides are in pixels of the fitted image, whatever its size, as there.

Not as there: a path has one opacity, as in the code's first release, and is a circle at the start, without jitter. The
guard that should spare those that a removed path overlaps never holds there and is left out, as is the factor on the
gradient of the interior's colours. Boxes are of points along the outline, of which the interior samples are blends.
Learning rates are in units of half the longer side, there of half of either side: steps in y are 1.5 times as long on
a photo of 3 : 2. A component that has been used up is taken from the counts of all its levels, not from that of the
weightiest alone.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.fit import schedule
from warpvec.fit.placement import colors_at, new_paths
from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.fit.target import paint_colors
from warpvec.geometry.bezier import curve_boxes
from warpvec.geometry.scene import Scene

RADIUS = 0.02
"""Of a new path on either axis, in units of half the canvas's side; at the start too, as before the last commit."""

OPACITY_LOGIT = 1.0
"""Of a new path: an opacity of 0.73."""

OUTSIDE_SHARE = 0.6
"""A path is removed if more than this share of its box lies off the canvas."""

OVERLAP_SHARE, OVERLAP_COLOR, OVERLAP_SCORE = 0.1, 0.05, 0.5
"""A younger path counts against an older one if it covers more than this share of its box and differs by less in colour
times opacity (Euclidean); the older one is removed if the score of all that count is more than the third."""

SCORE_SLOPE, SCORE_OFFSET = 100.0, 0.01
"""The score of a younger path is its share over (sigmoid(slope * difference in colour) + offset)."""

SMALL_AREAS = ((0.8, 2_000.0), (0.6, 20_000.0), (0.0, 50_000.0))
"""From this share of the run, a box of less than these square pixels is small; only small paths go for an overlap."""

TINY_SIDE, TINY_AREA = 5.0, 16.0
"""A path is removed if its box is less than this wide and high, in pixels, and has less than this area."""

FAINT_OPACITY, FAINT_SMALL_FROM = 0.2, 0.7
"""A path of less than this opacity is removed; from this share of the run only if it is small."""

ERROR_MIN = 0.05
"""Squared errors, summed over the channels, below this count as none."""

LEVEL_QUANTILES = 200
"""Errors are sorted into levels by their quantiles."""

LEVELS_BELOW, LEVELS_ABOVE = 1, 3
"""A region's pixels are this many levels below to this many above the weightiest one."""

# Rows of the comparison of all paths with one another that are held at a time.
_COMPARED_ROWS = 256


class Replacement:
    """Bezier Splatting's policy for ``target`` [h, w, 3 or 4].

    Raises:
        InputError: SciPy, which finds the connected regions, is not installed.
    """

    def __init__(self, target: Tensor, config: FitConfig, first_generation: int = 0) -> None:
        if find_spec("scipy") is None:
            raise InputError("policy replacement needs SciPy, which is not installed; pip install 'warpvec[baseline]'")
        self._target, self._config = paint_colors(target), config
        self._height, self._width = target.shape[:2]
        self._generator = torch.Generator().manual_seed(config.seed)
        self._missing = 0
        self._generation = first_generation

    def first_paths(self, background: Tensor) -> Scene:
        """All N paths, anywhere and of muted random colours: nothing of them comes from the target."""
        count = self._config.curves
        return self._spawn(self._anywhere(count), self._uniform(count, 3).sigmoid(), background)

    def wants_removal_cost(self, iteration: int, iterations: int) -> bool:
        """Never: paths go by their shape, opacity and neighbours."""
        return False

    def update(
        self,
        population: Population,
        iteration: int,
        iterations: int,
        removal_cost: Tensor | None,
        squared_error: Callable[[Scene], Tensor],
    ) -> bool:
        """Remove paths or add as many again, as is due after ``iteration``; whether either was."""
        due = schedule.replacement_due(iteration, self._config, iterations)
        if due == "removal":
            self._remove(population, iteration / iterations)
        elif due == "addition" and self._missing:
            self._add(population, squared_error(population.scene))
        else:
            return False
        return True

    def state(self) -> State:
        """What :meth:`restore` needs to go on as if nothing had happened."""
        return {
            "generator": self._generator.get_state(),
            "generation": self._generation,
            "missing": self._missing,
        }

    def restore(self, state: State) -> None:
        """Go on from ``state``."""
        self._generator.set_state(state["generator"])
        self._generation, self._missing = state["generation"], state["missing"]

    def _remove(self, population: Population, progress: float) -> None:
        oldest_first = population.serial.argsort()
        removed = removable(population.scene.select(oldest_first), self._height, self._width, progress)
        keep = torch.ones_like(removed)
        keep[oldest_first[removed]] = False
        population.keep(keep)
        self._missing += int(removed.sum())

    def _add(self, population: Population, error: Tensor) -> None:
        regions = torch.from_numpy(region_centers(error.cpu().numpy(), self._missing)).to(self._target)
        center = torch.cat([regions, self._anywhere(self._missing - len(regions))])
        self._generation += 1
        population.append(self._spawn(center, colors_at(self._target, center), population.scene.background))
        self._missing = 0

    def _spawn(self, center: Tensor, color: Tensor, background: Tensor) -> Scene:
        radius = (RADIUS * self._width / 2, RADIUS * self._height / 2)
        opacity = torch.full_like(center[:, 0], OPACITY_LOGIT).sigmoid()
        return new_paths(center, radius, color, opacity, background, self._generation, self._config)

    def _anywhere(self, count: int) -> Tensor:
        return self._uniform(count, 2) * self._target.new_tensor([self._width, self._height])

    def _uniform(self, *shape: int) -> Tensor:
        return torch.rand(shape, generator=self._generator, dtype=torch.float64).to(self._target)


# Which paths are removed.


def removable(scene: Scene, height: int, width: int, progress: float) -> Tensor:
    """Which paths [N] of ``scene``, oldest first, are removed from a canvas at the share ``progress`` of the run."""
    box = curve_boxes(scene.points, scene.degree)
    side = box[:, 2:] - box[:, :2]
    area = side.prod(-1)
    small = area < next(limit for start, limit in SMALL_AREAS if progress >= start)
    canvas = box.new_tensor([[0.0, 0.0, width, height]])
    outside = area - _common_area(box, canvas)[:, 0] > OUTSIDE_SHARE * area
    overlapped = overlap_scores(box, scene.color * scene.opacity[:, None]) > OVERLAP_SCORE
    tiny = (side < TINY_SIDE).all(-1) & (area < TINY_AREA)
    faint = scene.opacity < FAINT_OPACITY
    if progress > FAINT_SMALL_FROM:
        faint &= small
    return outside | overlapped & small | tiny | faint


def overlap_scores(box: Tensor, paint: Tensor) -> Tensor:
    """How much younger paths of the same paint repeat each path [N].

    Args:
        box: left, top, right and bottom [N, 4] of each path, oldest first.
        paint: colour times opacity [N, 3].
    """
    index = torch.arange(len(box), device=box.device)
    area = (box[:, 2:] - box[:, :2]).prod(-1)
    scores = [box.new_zeros(0)]
    for first in range(0, len(box), _COMPARED_ROWS):
        rows = index[first : first + _COMPARED_ROWS]
        share = _common_area(box[rows], box) / area[rows, None]
        difference = (paint[rows, None] - paint).norm(dim=-1)
        counts = (share > OVERLAP_SHARE) & (difference < OVERLAP_COLOR) & (index > rows[:, None])
        score = share / ((SCORE_SLOPE * difference).sigmoid() + SCORE_OFFSET)
        scores.append(score.masked_fill(~counts, 0.0).sum(1))
    return torch.cat(scores)


def _common_area(a: Tensor, b: Tensor) -> Tensor:
    """Area [A, B] that each box of ``a`` [A, 4] shares with each of ``b`` [B, 4]."""
    low = torch.maximum(a[:, None, :2], b[:, :2])
    high = torch.minimum(a[:, None, 2:], b[:, 2:])
    return (high - low).clamp_min(0.0).prod(-1)


# Where paths are added.


def region_centers(error: NDArray[np.float32], count: int) -> NDArray[np.float64]:
    """Positions [at most ``count``, 2] in the regions of largest ``error`` [h, w]; fewer where no error is left.

    Errors are sorted into levels. The weightiest level is the one with the largest sum over its pixels of the level; of
    the connected components (by sides) of pixels near that level the largest is taken, its pixel nearest to its
    centroid is the position, and it is gone for the next one.
    """
    label = import_module("scipy.ndimage").label
    levels = _error_levels(error)
    centers: list[tuple[float, float]] = []
    while len(centers) < count:
        counts = np.bincount(levels.ravel())
        weightiest = int(np.argmax(counts * np.arange(len(counts))))
        if weightiest == 0:
            break
        near = (levels >= max(weightiest - LEVELS_BELOW, 1)) & (levels <= weightiest + LEVELS_ABOVE)
        component = _largest(label(near)[0])
        centers.append(_central_pixel(component))
        levels[component] = 0
    return np.array(centers, np.float64).reshape(-1, 2)


def _error_levels(error: NDArray[np.float32]) -> NDArray[np.int64]:
    """The level of each pixel [h, w], 0 where there is no error to speak of."""
    error = np.where(error < ERROR_MIN, 0.0, error)
    quantiles = np.unique(np.quantile(error, np.linspace(0.0, 1.0, LEVEL_QUANTILES)))
    return np.digitize(error, quantiles[1:-1])


def _largest(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """The pixels of the largest of the components 1, 2, ... of ``labels``."""
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return labels == np.argmax(sizes)


def _central_pixel(component: NDArray[np.bool_]) -> tuple[float, float]:
    """Centre (x, y) of the pixel of ``component`` that is nearest to its centroid."""
    rows, columns = np.nonzero(component)
    nearest = np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2)
    return float(columns[nearest]) + 0.5, float(rows[nearest]) + 0.5

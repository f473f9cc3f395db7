"""Bezier Splatting's policy: start with all paths; now and then remove some and add as many elsewhere.

Source: Liu et al., Bezier Splatting (NeurIPS 2025), in the closed mode of its code, xiliu8006/Bezier_splatting at
9612a22: train_withsvg.py lines 178-191 (when), gaussianimage_cholesky_svg.py lines 236-273 (the start), 562-580 (new
paths) and 967-1075 (which paths are removed), utils.py lines 493-553 (where paths are added). Shares of the run are
shares of its 10,000 iterations. Areas and sides are in pixels of the fitted image, whatever its size, as there.

Differences: a path has one opacity, as in the code's first release, and is a circle at the start, without jitter. The
guard that should spare paths overlapped by a removed one never applies there and is left out. Boxes are of points on
the outline; the interior samples are blends of these. The pixels of a component that has been used are removed from the
counts of all their levels, not only from that of the weightiest level.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.placement import colors_at, new_paths
from warpvec.fit.policies.generator import generator_state
from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.fit.state_form import check_fields, integer
from warpvec.fit.target import opaque_colors
from warpvec.generators import generator_of
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.scene import Scene
from warpvec.paper.replacement_schedule import replacement_due

RADIUS = 0.02
"""Radius of a new path on each axis, in units of half the canvas's side; at the start too, as before the source's last
commit."""

OPACITY_LOGIT = 1.0
"""Opacity logit of a new path: an opacity of 0.73."""

OUTSIDE_SHARE = 0.6
"""A path is removed if more than this share of its box lies off the canvas."""

OVERLAP_SHARE, OVERLAP_COLOR, OVERLAP_SCORE = 0.1, 0.05, 0.5
"""A younger path counts against an older one if it covers more than the first number as a share of its box, and differs
by less than the second in colour times opacity (Euclidean). The older path is removed if the scores of all that count
sum up to more than the third."""

SCORE_SLOPE, SCORE_OFFSET = 100.0, 0.01
"""The score of a younger path is its share over (sigmoid(slope * difference in colour) + offset)."""

SMALL_AREAS = ((0.8, 2_000.0), (0.6, 20_000.0), (0.0, 50_000.0))
"""From this share of the run on, a box of fewer square pixels is small. Only small paths are removed for overlap."""

TINY_SIDE, TINY_AREA = 5.0, 16.0
"""A path is removed if its box is narrower and lower than the first number, in pixels, and has less than the second as
its area."""

FAINT_OPACITY, FAINT_SMALL_FROM = 0.2, 0.7
"""A path of less opacity than the first number is removed; after the second, a share of the run, only if small."""

ERROR_MIN = 0.05
"""Squared errors, summed over the channels, below this count as none."""

LEVEL_QUANTILES = 200
"""Number of quantiles that separate the levels into which errors are sorted."""

LEVELS_BELOW, LEVELS_ABOVE = 1, 3
"""A region's pixels are from this many levels below to this many above the weightiest level."""

# Rows held at a time when all paths are compared with each other.
_COMPARED_ROWS = 256


class Replacement:
    """Bezier Splatting's policy for ``image`` [h, w, 3 or 4]."""

    def __init__(self, image: Tensor, config: FitConfig, first_generation: int = 0) -> None:
        self._colors, self._config = opaque_colors(image), config
        self._height, self._width = image.shape[:2]
        self._generator = generator_of(config.seed)
        self._missing = 0
        self._generation = first_generation

    def first_paths(self, background: Tensor) -> Scene:
        """Return all N paths at random places and in muted random colours; nothing depends on the image."""
        count = self._config.curves
        return self._spawn(self._anywhere(count), self._uniform(count, 3).sigmoid(), background)

    def look(
        self, population: Population, iteration: int, iterations: int, squared_error: Callable[[Scene], Tensor]
    ) -> None:
        """Do nothing: new paths lie where the image is wrong after the step."""

    def looks_before(self, iteration: int, iterations: int) -> bool:
        """Return False: :meth:`look` does nothing."""
        return False

    def is_due(self, iteration: int, iterations: int) -> bool:
        """Return whether paths are removed or added after ``iteration``."""
        return replacement_due(iteration, self._config, iterations) is not None

    def wants_removal_cost(self, iteration: int, iterations: int) -> bool:
        """Return False: removal depends on shape, opacity and neighbours."""
        return False

    def update(
        self,
        population: Population,
        iteration: int,
        iterations: int,
        removal_cost: Tensor | None,
        squared_error: Callable[[Scene], Tensor],
    ) -> bool:
        """Remove paths, or add as many again, if that is due after ``iteration``; return whether it was."""
        due = replacement_due(iteration, self._config, iterations)
        if due == "removal":
            self._remove(population, iteration / iterations)
        elif due == "addition" and self._missing:
            self._add(population, squared_error(population.scene))
        else:
            return False
        return True

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""
        return {
            "generator": self._generator.get_state(),
            "generation": self._generation,
            "missing": self._missing,
        }

    def check(self, state: State, iteration: int, path_count: int) -> int:
        """Return the highest generation that the fit's ``path_count`` paths may have after ``iteration``.

        Raises:
            InputError: ``state`` is none that :meth:`state` can have returned then.
        """
        check_fields(
            "policy",
            state,
            generator=generator_state(self._config.seed),
            generation=integer(0, iteration),
            missing=integer(0, self._config.curves - path_count),
        )
        return int(state["generation"])

    def restore(self, state: State) -> None:
        """Continue from ``state``, which :meth:`check` has accepted."""
        self._generator.set_state(state["generator"])
        self._generation, self._missing = state["generation"], state["missing"]

    def _remove(self, population: Population, progress: float) -> None:
        oldest_first = population.serial.argsort()
        removed = removable(population.scene.select(oldest_first), self._height, self._width, progress)
        population.remove(oldest_first[removed])
        self._missing += int(removed.sum())

    def _add(self, population: Population, error: Tensor) -> None:
        regions = torch.from_numpy(region_centers(error.cpu().numpy(), self._missing)).to(self._colors)
        center = torch.cat([regions, self._anywhere(self._missing - len(regions))])
        self._generation += 1
        population.append(self._spawn(center, colors_at(self._colors, center), population.scene.background))
        self._missing = 0

    def _spawn(self, center: Tensor, color: Tensor, background: Tensor) -> Scene:
        radius = (RADIUS * self._width / 2, RADIUS * self._height / 2)
        opacity = torch.full_like(center[:, 0], OPACITY_LOGIT).sigmoid()
        return new_paths(center, radius, color, opacity, background, self._generation, self._config)

    def _anywhere(self, count: int) -> Tensor:
        return self._uniform(count, 2) * self._colors.new_tensor([self._width, self._height])

    def _uniform(self, *shape: int) -> Tensor:
        return torch.rand(shape, generator=self._generator, dtype=torch.float64).to(self._colors)


# Which paths are removed.


def removable(scene: Scene, height: int, width: int, progress: float) -> Tensor:
    """Return a mask [N] of the paths of ``scene``, oldest first, to remove at the share ``progress`` of the run."""
    box = path_boxes(scene)
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


def overlap_scores(box: Tensor, weighted_color: Tensor) -> Tensor:
    """Score how much younger paths of the same colour and opacity repeat each path [N].

    Args:
        box: left, top, right and bottom [N, 4] of each path, oldest first.
        weighted_color: colour times opacity [N, 3].
    """
    index = torch.arange(len(box), device=box.device)
    area = (box[:, 2:] - box[:, :2]).prod(-1)
    scores = [box.new_zeros(0)]
    for first in range(0, len(box), _COMPARED_ROWS):
        rows = index[first : first + _COMPARED_ROWS]
        share = _common_area(box[rows], box) / area[rows, None]
        difference = (weighted_color[rows, None] - weighted_color).norm(dim=-1)
        counts = (share > OVERLAP_SHARE) & (difference < OVERLAP_COLOR) & (index > rows[:, None])
        score = share / ((SCORE_SLOPE * difference).sigmoid() + SCORE_OFFSET)
        scores.append(score.masked_fill(~counts, 0.0).sum(1))
    return torch.cat(scores)


def _common_area(a: Tensor, b: Tensor) -> Tensor:
    """Return the area [A, B] that each box of ``a`` [A, 4] shares with each of ``b`` [B, 4]."""
    low = torch.maximum(a[:, None, :2], b[:, :2])
    high = torch.minimum(a[:, None, 2:], b[:, 2:])
    return (high - low).clamp_min(0.0).prod(-1)


# Where paths are added.


def region_centers(error: NDArray[np.float32], count: int) -> NDArray[np.float64]:
    """Return at most ``count`` positions [K, 2] in the regions of largest ``error`` [h, w]; fewer if no error is left.

    Errors are sorted into levels. The weightiest level has the largest product of level and number of pixels. Of the
    connected components (by sides) of pixels near that level, the largest is used up: the pixel nearest to its
    centroid is a position, and its pixels do not count for later positions.
    """
    from scipy.ndimage import label

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
    """Return the level of each pixel [h, w], 0 where the error is below ``ERROR_MIN``."""
    error = np.where(error < ERROR_MIN, 0.0, error)
    quantiles = np.unique(np.quantile(error, np.linspace(0.0, 1.0, LEVEL_QUANTILES)))
    return np.digitize(error, quantiles[1:-1])


def _largest(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return a mask of the largest of the components 1, 2, ... of ``labels``."""
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return labels == np.argmax(sizes)


def _central_pixel(component: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the centre (x, y) of the pixel of ``component`` that is nearest to its centroid."""
    rows, columns = np.nonzero(component)
    nearest = np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2)
    return float(columns[nearest]) + 0.5, float(rows[nearest]) + 0.5

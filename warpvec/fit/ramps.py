"""Find the paths for which a gradient pays, and add these gradients.

A flat path may become a linear gradient. The gain is known beforehand, because the image is affine in the colour
of a path: the gain follows from the first moments of the residual over the visible pixels of the path. Let w(p) be the
visible share of the path in pixel p, g(p) the adjoint of the image, and let its colour change by the ramp B (p - m)
about its mean position m, with B [3, 2]. The mean squared error then changes by the sum of tr(B' G) + scale tr(B S B')
at most, where G is the sum of w g (p - m)', S the sum of w (p - m) (p - m)', and scale = 1 / (3 h w). (The exact term
has w^2 in place of w, and w is at most 1.) Both stops of a gradient lie on one line, so B = k n' for one direction n.
The best n maximises n' (G' G) n / (n' S n), and then k = -G n / (2 scale n' S n).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.config.fit_config import AUTO, FitConfig
from warpvec.fit.population import Population
from warpvec.fit.target import Target
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT, LINEAR
from warpvec.geometry.scene import Scene

SPREAD_MIN = 0.25
"""Smallest standard deviation in pixels of a path's visible pixels along a gradient; a narrower path shows no ramp."""

REACH = 1.7320508
"""Distance of the stops from the mean position, in standard deviations of the visible pixels: those of a bar of even
width end there."""


CHOICE_BEGIN, CHOICE_END, CHOICE_GAP = 0.2, 0.8, 50
"""Shares of the iterations between which paths are chosen, and the iterations from one choice to the next. A choice
takes the time of five steps."""


SHARE_GAINED = 0.25
"""With "auto", the predicted gain of a gradient must be this many times the mean squared error over the paths' number.
Twice as many paths divide the error by 1.55 (means of twelve photos, 256 to 1024 paths), so another path gains 0.65
times that. In the text a gradient takes as many bytes as a path, gzipped half as many, and a fit makes 2.4 times of the
prediction (kodim07 and kodim23 at 384 x 256, 256 paths): 0.27 for bytes, and half of it for gzipped bytes."""

MINIFIED_SHARE = 3.0
"""The same in minified files, where a gradient takes 2.5 times the bytes of a path. In 25,000 bytes of kodim23 at
384 x 256, 31.31 dB without gradients, 0.25 gives 35 gradients and 30.46 dB, 0.7 ten and 31.01, 1.5 four and 31.26, 3
one and 31.36."""


class Ramps(NamedTuple):
    """The best linear ramp of each of N paths.

    Attributes:
        gain: how much it lowers the mean squared error [N], at least; 0 for paths without visible pixels.
        geometry: the two stops [N, 4] in pixels.
        change: the colour of the second stop minus that of the path's mean [N, 3]; the first stop is as far below it.
    """

    gain: Tensor
    geometry: Tensor
    change: Tensor


def best_ramps(scene: Scene, target: Target) -> Ramps:
    """Return the best linear ramp for each path of ``scene``, as if all were flat."""
    first, second = target.ramp_moments(scene, path_boxes(scene))
    area = second[:, 0].clamp_min(1e-12)
    mean = second[:, 1:3] / area[:, None]
    spread = second[:, 3:].reshape(-1, 2, 2) - area[:, None, None] * mean[:, :, None] * mean[:, None, :]
    residual = first[:, :, 1:] - first[:, :, :1] * mean[:, None, :]  # G [N, 3, 2]
    direction, pull = _best_direction(residual, spread)
    along = (direction[:, None] @ spread @ direction[:, :, None]).flatten().clamp_min(1e-12)
    slope = -(residual @ direction[:, :, None])[:, :, 0] / (2.0 * target.error_scale * along[:, None])
    deviation = (along / area).sqrt()
    reach = REACH * deviation
    is_visible = (second[:, 0] > 1.0) & (deviation > SPREAD_MIN)
    gain = torch.where(is_visible, pull / (4.0 * target.error_scale), 0.0).nan_to_num(0.0, 0.0, 0.0)
    offset = direction * reach[:, None]
    return Ramps(gain, torch.cat([mean - offset, mean + offset], 1), slope * reach[:, None])


def flat_paths(scene: Scene) -> Tensor:
    """Return which paths of ``scene`` have no gradient [N]."""
    paints = scene.gradients
    return torch.ones_like(scene.opacity, dtype=torch.bool) if paints is None else paints.kind == FLAT


def wanted_count(config: FitConfig, path_count: int) -> int:
    """Return how many of the paths may have a gradient; with "auto" all for which it pays."""
    gradients = config.gradients or 0.0
    if isinstance(gradients, str):
        return path_count
    return min(path_count, round(gradients * path_count if gradients <= 1.0 else gradients))


def with_ramps(scene: Scene, rows: Tensor, ramps: Ramps) -> Scene:
    """Return ``scene`` with the linear gradients ``ramps`` on its paths ``rows`` (indices)."""
    gradients = scene.gradients or Gradients.none(scene.color)
    paints, color = gradients.map(torch.Tensor.clone), scene.color.clone()
    paints.kind[rows] = LINEAR
    paints.geometry[rows] = ramps.geometry[rows].to(color)
    mean, change = color[rows], ramps.change[rows].to(color)
    color[rows], paints.end_color[rows] = (mean - change).clamp(0.0, 1.0), (mean + change).clamp(0.0, 1.0)
    if paints.stops is not None:
        paints = paints.with_two_stops(rows)
    return replace(scene, color=color, gradients=paints)


def _best_direction(residual: Tensor, spread: Tensor) -> tuple[Tensor, Tensor]:
    """Return the unit vectors n [N, 2] that maximise n' G' G n / (n' S n), and the maxima [N].

    ``residual`` is G [N, 3, 2], ``spread`` S [N, 2, 2].
    """
    ridge = 1e-9 * (spread.diagonal(dim1=1, dim2=2).sum(1) + 1e-9)
    values, vectors = torch.linalg.eigh(spread + ridge[:, None, None] * torch.eye(2).to(spread))
    whitening = vectors / values.clamp_min(1e-12).sqrt()[:, None, :]
    whitened = residual @ whitening
    strengths, axes = torch.linalg.eigh(whitened.transpose(1, 2) @ whitened)
    direction = (whitening @ axes[:, :, 1:])[:, :, 0]
    return torch.nn.functional.normalize(direction, dim=1), strengths[:, 1]


class GradientChoice:
    """Gives the paths with the highest gains a gradient, until as many have one as ``config`` asks for."""

    def __init__(self, target: Target, config: FitConfig) -> None:
        self._target, self._config = target, config

    def update(self, population: Population, iteration: int, iterations: int, has_changed: bool) -> None:
        """Choose paths if that is due after ``iteration`` of ``iterations``.

        From ``CHOICE_END`` on that is so if the population ``has_changed``, as new paths are flat.
        """
        begin, end = (min(round(share * iterations), iterations - 1) for share in (CHOICE_BEGIN, CHOICE_END))
        is_regular = begin <= iteration <= end and (iteration - begin) % CHOICE_GAP == 0
        is_due = is_regular or iteration == end or (has_changed and iteration > end)
        if not self._config.gradients or not is_due:
            return
        scene = population.scene
        is_flat = flat_paths(scene)
        count = wanted_count(self._config, len(scene)) - int((~is_flat).sum())
        if count <= 0:
            return
        ramps = best_ramps(scene, self._target)
        rows = ramps.gain.masked_fill(~is_flat, -1.0).topk(min(count, len(scene))).indices
        rows = rows[ramps.gain[rows] > self._least_gain(scene)].sort().values
        if len(rows):
            population.paint(rows, with_ramps(scene, rows, ramps))

    def _least_gain(self, scene: Scene) -> float:
        """Return what a gradient must gain at least."""
        if self._config.gradients != AUTO:
            return 0.0
        error = self._target.error_scale * float(self._target.squared_error(scene).sum())
        return (MINIFIED_SHARE if self._config.minify else SHARE_GAINED) * error / len(scene)

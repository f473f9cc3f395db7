"""Finish the fit of a photo: all paths are fitted once more together, and a few become soft, where that pays.

A fit of many paths ends with small steps of each value by itself. Steps of L-BFGS, which know how values act together,
still find two tenths of a decibel in 3 % of the time. Points of files with coarse coordinates are rounded on the way
(`point_rounding.py`). Smooth parts of a photo need steps of colour, one for each path: one
soft path shows what several sharp ones do. A path is soft if a little blur lowers the loss; how much is fitted.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.target import Target
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.joints import with_lines
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import SIGMA_MAX, SIGMA_MIN, Softness
from warpvec.polish.descent import Descent
from warpvec.polish.point_rounding import GROUP_COUNT, point_groups, rounded_points
from warpvec.polish.variables import Evaluation, Variables
from warpvec.rendering.streams import on_warps_stream
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Part

SHARE = 0.03
"""Iterations of a turn, as a share of those of the fit: 60 of the usual 2000. Twice as many gain another 0.02 dB."""

ITERATIONS_MIN = 10
"""Fewest iterations of a turn: L-BFGS knows nothing before. Shorter fits are not finished."""

SOFT_SHARE = 0.05
"""Largest share of the paths that become soft. Browsers take 1.3 to 1.5 times as long to draw a file with so many; with
twice as many, which gain another 0.1 dB on smooth photos, twice as long."""

SOFT_AREA = 1.0
"""Largest area of the boxes of all soft paths, in areas of the canvas: a soft path takes time and memory by its box, in
browsers, too. With 2 kodim23 gains another 0.02 dB."""

PROBE_SIGMA = 0.5
"""Standard deviation in pixels at which the loss is asked whether it falls with more blur."""

PROBE_AREA = 1.0
"""Area of the boxes of the paths that are asked at once, in areas of the canvas."""

FIRST_SIGMA = 1.0
"""Standard deviation in pixels that a soft path begins with."""

GAIN_MIN = 0.012
"""Least share of the loss that soft paths must gain. They take 1.3 % of the bytes of a file, and a fit with as many
bytes of other paths gains 0.8 %; the second turn gains 0.4 % without them."""

SIGMA_STEP = 2.0**0.5
"""Factor from one standard deviation of a drawing to the next. Each is a filter of 130 to 170 bytes in its file, so
that near ones are not worth their bytes."""

LAST_SHARE = 1.0 / 3.0
"""Iterations after the standard deviations were rounded, as a share of those of a turn."""

ROUNDING_SHARE = 1.0 / 6.0
"""Iterations after each group of points was rounded, as a share of those of a turn."""


def finish(
    scene: Scene, target: Target, config: FitConfig, part: Part, *,
    soft_max: int | None, step: tuple[float, float] | None = None,
) -> Scene:  # fmt: skip
    """Return ``scene`` fitted to ``target`` once more, or itself if nothing is better.

    Args:
        scene: the fitted cubic drawing, in pixels of the target.
        target: the photo.
        config: settings of the fit.
        part: the part of a run that this is.
        soft_max: most paths that become soft; None for ``SOFT_SHARE`` of the paths, if that pays.
        step: distance of the coordinates of the file in pixels of the target, across and down, if it is coarse. The
            points are then multiples of it.
    """
    with on_warps_stream(target.device), single_torch_thread(), torch.no_grad(), part:
        return _Finish(target, config, part, step).of(with_lines(scene.to(target.device)), soft_max)


def planned_iterations(config: FitConfig) -> int:
    """Return how many iterations the end of a fit has at most; 0 if `finish` does not apply to such a fit.

    The drawings of other renderers, of levels of detail and of palettes have rules that it does not know.
    """
    is_free = config.renderer == "exact" and not config.lod and config.palette is None and not config.colors
    turn = _turn(config)
    count = turn + turn + round(LAST_SHARE * turn)
    if config.minify:
        count += GROUP_COUNT * round(ROUNDING_SHARE * turn)
    return count if is_free and turn >= ITERATIONS_MIN else 0


def _turn(config: FitConfig) -> int:
    return round(SHARE * config.iterations)


class _Fitted(NamedTuple):
    scene: Scene
    loss: float


class _Finish:
    def __init__(self, target: Target, config: FitConfig, part: Part, step: tuple[float, float] | None) -> None:
        self._target, self._config, self._part, self._step = target, config, part, step
        self._turn = _turn(config)
        self._iteration = self._path_count = 0

    def of(self, scene: Scene, soft_max: int | None) -> Scene:
        self._path_count = len(scene)
        begun = self._fitted(scene)
        found = self._soft_or_sharp(self._descended(begun, self._turn), soft_max)
        if self._step is None or found is begun:
            return found.scene
        return min(begun, self._rounded(found.scene, self._step), key=lambda fitted: fitted.loss).scene

    def _soft_or_sharp(self, sharp: _Fitted, soft_max: int | None) -> _Fitted:
        """Return the ``sharp`` drawing with the soft paths that pay, or itself if none do."""
        scene = sharp.scene
        count = int(SOFT_SHARE * len(scene)) if soft_max is None else min(soft_max, len(scene))
        chosen = self._candidates(scene)[:count] if count and not self._is_over else None
        if chosen is None or not len(chosen):
            return sharp
        sigma = torch.zeros_like(scene.opacity)
        sigma[chosen] = FIRST_SIGMA
        soft = self._descended(self._fitted(scene, Softness(sigma)), self._turn)
        assert soft.scene.softness is not None
        rounded = self._fitted(soft.scene, _few_sigmas(soft.scene.softness))
        soft = self._descended(rounded, round(LAST_SHARE * self._turn), keeps_softness=True)
        least = GAIN_MIN if soft_max is None else 0.0
        return soft if soft.loss < (1.0 - least) * sharp.loss else sharp

    @property
    def _is_over(self) -> bool:
        return self._part.is_stopped() or self._part.is_late()

    def _fitted(self, scene: Scene, softness: Softness | None = None) -> _Fitted:
        scene = scene if softness is None else replace(scene, softness=softness)
        return _Fitted(scene, float(self._target.whole_step(scene).loss))

    def _variables(self, scene: Scene, *, keeps_softness: bool = False) -> Variables:
        return Variables(scene, self._target, self._config, keeps_softness=keeps_softness, keeps_smooth=False)

    def _descended(self, begun: _Fitted, count: int, *, keeps_softness: bool = False) -> _Fitted:
        """Return the best drawing of ``count`` iterations from ``begun`` on."""
        variables = self._variables(begun.scene, keeps_softness=keeps_softness)
        found = self._lowest(variables, variables.start, count)
        return begun if found is None or found.loss >= begun.loss else _Fitted(variables.scene(found.x), found.loss)

    def _rounded(self, scene: Scene, step: tuple[float, float]) -> _Fitted:
        """Return ``scene`` with its points at multiples of ``step`` and its other values fitted to them."""
        variables = self._variables(scene, keeps_softness=True)
        x = variables.start
        # Without time for a fit after each group, all points are one group.
        groups = [torch.ones_like(variables.is_free)] if self._is_over else point_groups(variables, self._config.seed)
        for group in groups:
            x = rounded_points(variables, x, group, step)
            found = self._lowest(variables, x, round(ROUNDING_SHARE * self._turn))
            x = x if found is None else found.x
        return self._fitted(variables.scene(x))

    def _lowest(self, variables: Variables, x: Tensor, count: int) -> Evaluation | None:
        """Return the evaluation of the lowest loss of ``count`` iterations from ``x`` on; None without time for one."""
        best = None
        if self._is_over:
            return best
        for found in Descent(variables, x, self._config.seed, self._config.lr_scale).by_curvature(count):
            best = found if best is None or found.loss < best.loss else best
            self._report(variables, found.x, found.loss)
            if self._is_over:
                break
        return best

    def _candidates(self, scene: Scene) -> Tensor:
        """Return the paths whose blur would lower the loss, the best first, with boxes of ``SOFT_AREA`` together."""
        height, width = self._target.size
        canvas = float(height * width)
        boxes = path_boxes(scene)
        size = boxes.new_tensor([width, height])
        sides = boxes[:, 2:].clamp(boxes.new_zeros(2), size) - boxes[:, :2].clamp(boxes.new_zeros(2), size)
        area = sides.double().prod(1) / canvas
        slope = torch.zeros_like(scene.opacity)
        for rows in _groups(area):
            sigma = torch.zeros_like(slope)
            sigma[rows] = PROBE_SIGMA
            if self._is_over:
                return rows[:0]
            adjoints = self._target.whole_step(replace(scene, softness=Softness(sigma)))
            assert adjoints.softness is not None
            slope[rows] = adjoints.softness[rows]
        slope, area = slope.cpu(), area.cpu()  # where sorts and sums have one order
        order = slope.argsort(stable=True)
        order = order[(slope[order] < 0.0) & (area[order] > 0.0)]
        return order[area[order].cumsum(0) <= SOFT_AREA]

    def _report(self, variables: Variables, x: Tensor, loss: float) -> None:
        self._iteration += 1
        count, seconds, shown = planned_iterations(self._config), self._part.seconds(), lambda: variables.scene(x)
        self._part.report(Progress(self._iteration, count, self._path_count, seconds, torch.tensor(loss), shown))


def _few_sigmas(softness: Softness) -> Softness:
    """Return ``softness`` with standard deviations of a series of short numbers: 1, 1.4, 2, 2.8 and so on."""
    steps = (softness.sigma.double().clamp_min(1e-6).log() / math.log(SIGMA_STEP)).round()
    series = ((10.0 * SIGMA_STEP**steps).round() / 10.0).clamp(SIGMA_MIN, SIGMA_MAX)
    return Softness(torch.where(softness.is_soft, series.to(softness.sigma.dtype), 0.0))


def _groups(area: Tensor) -> list[Tensor]:
    """Return the paths in groups whose boxes, of ``area`` [N] in canvases, have ``PROBE_AREA`` together."""
    number = (area.cpu().cumsum(0) / PROBE_AREA).floor().to(area.device)
    return [(number == each).nonzero().flatten() for each in sorted(set(number.tolist()))]

"""The schedule of a fit: when paths are added, how many, how large, and the learning rate.

All are pure functions of the settings and the iteration.
"""

from __future__ import annotations

import math
from dataclasses import replace

from warpvec.config.fit_config import FitConfig

RADIUS_MIN = math.sqrt(2.0)
"""Smallest radius of a new path in pixels: a circle of this radius fully covers the pixel that holds its centre,
wherever in the pixel the centre is. If a path covers no pixel fully, colour and opacity cannot be told apart."""

INFLATION_SHARE = 0.5
"""The last inflation is due at this share of the iterations at the latest. So a short run still reaches its N paths,
and has as many iterations left to fit them."""

RECYCLING_FILL = 0.3
"""Area of N recycled paths over the area of the canvas. The radius is 6 px for 256 paths on 384x256 and 9 px for 512 on
768x512. At 256 paths this is better by 0.07 dB than a share of 0.5 (two photos)."""

NODE_GAP = 25
"""Iterations between exchanges of nodes. An exchange takes a third of the time of a step."""

NODE_SPAN = (30, 0.9)
"""Exchanges of nodes begin after so many iterations and end at this share of the run. The last ones come after the
last recycling, which changes the number of segments, and leave time to fit."""

SHIFT_GAP = 25
"""Iterations between two computations of how the term for SSIM shifts the target. Recyclings have the same gap, and
place new paths by it. With 50 the SSIM of the files is lower by 0.003 (six photos, 256 paths, half size)."""

RATE_STEPS = ((0.9, 0.1), (0.6, 0.2), (0.5, 0.5))
"""Learning rates have the second number as a factor from the first number, a share of the run, on. These are Bezier
Splatting's steps after 5000, 6000 and 9000 of its 10,000 iterations."""


# The population.


def population(k: int, config: FitConfig) -> int:
    """Return the number of paths after k inflations: min(N0 growth^k, N), rounded (halves up); N if flat."""
    if config.one_generation or k >= _generations_to(config.curves, config):
        return config.curves
    return min(math.floor(config.initial_curves * config.growth**k + 0.5), config.curves)


def inflation_count(config: FitConfig) -> int:
    """Return the number of inflations until there are N paths; 0 if flat.

    Raises:
        InputError: there are fewer than N paths at the start, and no growth.
    """
    return 0 if config.one_generation else _last_generation(config)


def inflation_steps(config: FitConfig, iterations: int) -> list[int]:
    """Return the iterations after which an inflation is due: dT, 2 dT, ... (Algorithm 1).

    With ``shorten_gap``, dT is shortened if the last inflation would be due after half the run (``INFLATION_SHARE``).
    In a very short run several are due at one iteration; the population then grows at once to that of the last one.
    """
    count = inflation_count(config)
    longest = INFLATION_SHARE * iterations / max(count, 1)
    gap = min(config.inflation_gap, longest) if config.shorten_gap else config.inflation_gap
    return [math.floor(k * gap) for k in range(1, count + 1)]


def _last_generation(config: FitConfig) -> int:
    if config.curves <= config.initial_curves:
        return 0
    # Half a path below N rounds to N. The logarithm may be off in its last digit, so both neighbours are tried.
    guess = math.ceil(_generations_to(config.curves - 0.5, config))
    return next(k for k in range(max(guess - 1, 0), guess + 2) if population(k, config) == config.curves)


def _generations_to(count: float, config: FitConfig) -> float:
    """Return the real k at which N0 growth^k is ``count``; infinite without growth."""
    if count <= config.initial_curves:
        return 0.0
    return math.log(count / config.initial_curves) / math.log(config.growth) if config.growth > 1.0 else math.inf


def grow_from(config: FitConfig, count: int, height: int, width: int) -> FitConfig:
    """Return the settings of a fit of a canvas [height, width] that begins with ``count`` paths and grows to N.

    New paths have the size of recycled ones: the paths of each generation would cover the share ``RECYCLING_FILL``.
    """
    growth = config.growth if config.growth > 1.0 else FitConfig.growth
    radius = recycling_radius(replace(config, curves=count), height, width)
    return replace(
        config,
        one_generation=False,
        initial_curves=count,
        growth=growth,
        initial_radius=2.0 * radius / max(height, width),
        radius_decay=growth**-0.5,
    )


# The size of new paths.


def radius(k: int, config: FitConfig, height: int, width: int) -> float:
    """Return the radius in pixels of new paths in generation k: R_k = R_0 r_rad^k, at least ``RADIUS_MIN``.

    R_0 is ``initial_radius`` times half the longer side. A flat fit adds all paths in generation 0, with the radius of
    the last generation of a fit that is not flat: 0.008 of half the side for 512 paths. Bezier Splatting, which is
    flat, takes 0.01.
    """
    if config.one_generation:
        k = _last_generation(replace(config, one_generation=False))
    first = config.initial_radius * max(height, width) / 2
    return max(first * config.radius_decay**k, RADIUS_MIN)


def recycling_radius(config: FitConfig, height: int, width: int) -> float:
    """Return the radius in pixels of recycled paths: N of them cover the share ``RECYCLING_FILL`` of the canvas."""
    return max(math.sqrt(RECYCLING_FILL * height * width / (math.pi * config.curves)), RADIUS_MIN)


# What is due at an iteration.


def lr_factor(iteration: int, config: FitConfig, iterations: int) -> float:
    """Return the factor of every learning rate: ``lr_scale`` times the decay.

    "cosine": a cosine from 1 (first iteration) to ``lr_final`` (last). "steps": ``RATE_STEPS``. "constant": 1.
    """
    if config.lr_decay == "constant":
        return config.lr_scale
    if config.lr_decay == "steps":
        return config.lr_scale * next((factor for start, factor in RATE_STEPS if iteration >= start * iterations), 1.0)
    progress = min(iteration / max(iterations - 1, 1), 1.0)
    return config.lr_scale * (config.lr_final + (1.0 - config.lr_final) * 0.5 * (1.0 + math.cos(math.pi * progress)))


def is_recycling(iteration: int, config: FitConfig, iterations: int) -> bool:
    """Return whether a recycling is due after ``iteration``.

    It is due every ``recycle_gap`` iterations after the last inflation, until the share ``recycle_until`` of the run.
    """
    if config.recycle_gap == 0 or iteration > config.recycle_until * iterations:
        return False
    since_full = iteration - max(inflation_steps(config, iterations), default=0)
    return since_full > 0 and since_full % config.recycle_gap == 0


def exchanges_nodes(config: FitConfig) -> bool:
    """Return whether a fit moves nodes between paths: only where paths are recycled, and drawn by their exact area."""
    is_able = config.renderer == "exact" and config.path_model == "segments" and config.policy == "scaffolding"
    return is_able and config.recycle_gap > 0 and not config.fixed_segments


def is_exchanging_nodes(iteration: int, config: FitConfig, iterations: int) -> bool:
    """Return whether an exchange of nodes is due: in the middle between recyclings, which the paths then get over."""
    if not exchanges_nodes(config) or not NODE_SPAN[0] <= iteration <= NODE_SPAN[1] * iterations:
        return False
    return iteration % NODE_GAP == NODE_GAP // 2


def shifts_target(iteration: int, config: FitConfig) -> bool:
    """Return whether the target is shifted anew after ``iteration``, for the term for SSIM.

    It is not where levels of detail are fitted: a prefix would need a shift of its own.
    """
    return config.ssim_weight > 0.0 and not config.lod and iteration % SHIFT_GAP == 0

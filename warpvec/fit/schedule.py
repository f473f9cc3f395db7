"""When paths come, how many, how large and where, and the learning rate: pure functions of the iteration."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from warpvec.config.fit_config import FitConfig

RADIUS_MIN = math.sqrt(2.0)
"""Smallest radius of a new path in pixels: that of the smallest circle that wholly covers the pixel under its centre,
wherever in the pixel that is. A path that covers no pixel wholly cannot tell its colour from its opacity."""

INFLATION_SHARE = 0.5
"""The last inflation comes no later than at this share of the iterations: a short run still reaches its N paths, with
as many iterations left to fit them."""

RECYCLING_FILL = 0.3
"""Area of the N paths over that of the canvas if all had the radius of a recycled one: 6 px for 256 paths on 384x256,
9 px for 512 on 768x512. Better by 0.07 dB than 0.5 at 256 paths (two photos)."""

RATE_STEPS = ((0.9, 0.1), (0.6, 0.2), (0.5, 0.5))
"""From this share of the run the learning rates have these factors: those of Bezier Splatting after 5000, 6000 and
9000 of its 10,000 iterations."""

REPLACEMENT_SHARE = 0.05
"""The gap of replacements is at most this share of the iterations: what 500 is of Bezier Splatting's 10,000."""

REPLACEMENT_SPAN = (0.1, 0.92)
"""Bezier Splatting replaces paths from the first to before the second share of the run: iterations 1000 to 9200 of its
10,000."""


# The population.


def population(k: int, config: FitConfig) -> int:
    """Paths after k inflations: min(N0 growth^k, N), rounded to the nearest whole number (halves up); N if flat."""
    if config.flat or k >= _generations_to(config.curves, config):
        return config.curves
    return min(math.floor(config.initial_curves * config.growth**k + 0.5), config.curves)


def inflation_count(config: FitConfig) -> int:
    """How many inflations until the population is N; 0 if flat.

    Raises:
        InputError: the population does not grow and starts below N.
    """
    return 0 if config.flat else _last_generation(config)


def inflation_steps(config: FitConfig, iterations: int) -> list[int]:
    """The iterations after which an inflation is due: dT, 2 dT, ... (Algorithm 1).

    With ``shorten_gap`` dT is shortened where the last would come after half the run (``INFLATION_SHARE``). In a very
    short run several fall on one iteration: the population then goes straight to that of the last of them.
    """
    count = inflation_count(config)
    longest = INFLATION_SHARE * iterations / max(count, 1)
    gap = min(config.inflation_gap, longest) if config.shorten_gap else config.inflation_gap
    return [math.floor(k * gap) for k in range(1, count + 1)]


def _last_generation(config: FitConfig) -> int:
    if config.curves <= config.initial_curves:
        return 0
    # Half a path below N rounds to N. The logarithm may be off by its last digit, hence the look at both neighbours.
    guess = math.ceil(_generations_to(config.curves - 0.5, config))
    return next(k for k in range(max(guess - 1, 0), guess + 2) if population(k, config) == config.curves)


def _generations_to(count: float, config: FitConfig) -> float:
    """The k, not whole, at which N0 growth^k is ``count``; infinite without growth."""
    if count <= config.initial_curves:
        return 0.0
    return math.log(count / config.initial_curves) / math.log(config.growth) if config.growth > 1.0 else math.inf


def continued(config: FitConfig, count: int, height: int, width: int) -> FitConfig:
    """The settings of a fit of a canvas [height, width] that goes on with ``count`` paths, and grows them to N.

    New paths are of the size of recycled ones: however many there are, they would cover the share ``RECYCLING_FILL``.
    """
    growth = config.growth if config.growth > 1.0 else FitConfig.growth
    radius = recycling_radius(replace(config, curves=count), height, width)
    return replace(
        config,
        flat=False,
        initial_curves=count,
        growth=growth,
        initial_radius=2.0 * radius / max(height, width),
        radius_decay=growth**-0.5,
    )


# The size of new paths.


def radius(k: int, config: FitConfig, height: int, width: int) -> float:
    """Radius in pixels of paths that are spawned at generation k: R_k = R_0 r_rad^k, at least ``RADIUS_MIN``.

    R_0 is ``initial_radius`` of half the longer side. A flat fit spawns all its paths at generation 0, with the radius
    of the last generation it would have had: 0.008 of half the side for 512 paths, where Bezier Splatting, which is
    flat, takes 0.01.
    """
    if config.flat:
        k = _last_generation(replace(config, flat=False))
    first = config.initial_radius * max(height, width) / 2
    return max(first * config.radius_decay**k, RADIUS_MIN)


def recycling_radius(config: FitConfig, height: int, width: int) -> float:
    """Radius in pixels of recycled paths: N of them cover the share ``RECYCLING_FILL`` of the canvas."""
    return max(math.sqrt(RECYCLING_FILL * height * width / (math.pi * config.curves)), RADIUS_MIN)


# What is due at an iteration.


def lr_factor(iteration: int, config: FitConfig, iterations: int) -> float:
    """Factor of every learning rate: ``lr_scale``, times what the decay makes of it.

    "cosine": a cosine from 1 (first iteration) to ``lr_final`` (last). "steps": ``RATE_STEPS``. "constant": 1.
    """
    if config.lr_decay == "constant":
        return config.lr_scale
    if config.lr_decay == "steps":
        return config.lr_scale * next((factor for start, factor in RATE_STEPS if iteration >= start * iterations), 1.0)
    progress = min(iteration / max(iterations - 1, 1), 1.0)
    return config.lr_scale * (config.lr_final + (1.0 - config.lr_final) * 0.5 * (1.0 + math.cos(math.pi * progress)))


def is_recycling(iteration: int, config: FitConfig, iterations: int) -> bool:
    """Whether a recycling is due: every ``recycle_gap`` after full population, until ``recycle_until`` of the run."""
    if config.recycle_gap == 0 or iteration > config.recycle_until * iterations:
        return False
    since_full = iteration - max(inflation_steps(config, iterations), default=0)
    return since_full > 0 and since_full % config.recycle_gap == 0


def replacement_gap(config: FitConfig) -> int:
    """Iterations between removals and additions: ``replace_gap``, or less in a short run with ``shorten_gap``."""
    longest = max(1, int(REPLACEMENT_SHARE * config.iterations))
    return min(config.replace_gap, longest) if config.shorten_gap else config.replace_gap


def replacement_due(iteration: int, config: FitConfig, iterations: int) -> Literal["removal", "addition"] | None:
    """What the policy "replacement" does after ``iteration``: at every gap, removal and addition in turn.

    An odd number of gaps brings a removal if it and the addition that follows lie in ``REPLACEMENT_SPAN``; an even
    number the addition, wherever it lies: a time budget may have shortened the run since the removal.
    """
    gap = replacement_gap(config)
    gaps, rest = divmod(iteration, gap)
    if rest:
        return None
    if gaps % 2 == 0:
        return "addition"
    first, end = (share * iterations for share in REPLACEMENT_SPAN)
    return "removal" if iteration >= first and iteration + gap < end else None


# Where new paths go.

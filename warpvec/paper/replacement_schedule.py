"""When the policy "replacement" removes and adds paths."""

from __future__ import annotations

from typing import Literal

from warpvec.config.fit_config import FitConfig
from warpvec.paper.settings import paper_settings

REPLACEMENT_SHARE = 0.05
"""Largest gap between replacements as a share of the iterations: Bezier Splatting's 500 of 10,000."""

REPLACEMENT_SPAN = (0.1, 0.92)
"""Shares of the run between which paths are replaced: Bezier Splatting's iterations 1000 to 9200 of 10,000, the last
one excluded."""


def replacement_gap(config: FitConfig) -> int:
    """Return the iterations between removals and additions.

    They are ``replace_gap``, or fewer in a short run if ``shorten_gap`` is on.
    """
    gap, longest = paper_settings(config).replace_gap, max(1, int(REPLACEMENT_SHARE * config.iterations))
    return min(gap, longest) if config.shorten_gap else gap


def replacement_due(iteration: int, config: FitConfig, iterations: int) -> Literal["removal", "addition"] | None:
    """Return what the policy "replacement" does after ``iteration``: removal and addition take turns at every gap.

    After an odd number of gaps a removal is due if it and the addition that follows lie in ``REPLACEMENT_SPAN``. After
    an even number an addition is due wherever it lies: a time budget may have shortened the run since the removal.
    """
    gap = replacement_gap(config)
    gaps, rest = divmod(iteration, gap)
    if rest:
        return None
    if gaps % 2 == 0:
        return "addition"
    first, end = (share * iterations for share in REPLACEMENT_SPAN)
    return "removal" if iteration >= first and iteration + gap < end else None

"""The goal of a smallest structural similarity (SSIM) of the file, as resvg draws it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from warpvec.config.kinds import Positive
from warpvec.goals.quantity import Quantity, reached

if TYPE_CHECKING:
    from warpvec.drawing.drawing import Drawing

SSIM_MAX = 0.999
"""Largest SSIM to ask for. Photos reach 0.95 with thousands of paths, and clean flat art 0.999."""


def _measure(drawing: Drawing, gzip: bool) -> float:
    from warpvec.image.metrics import ssim  # not above: the help shows this goal without loading NumPy
    from warpvec.svg.measure import draw_like

    del gzip
    pixels = drawing.encoding.picture.pixels
    return ssim(draw_like(drawing.text, pixels), pixels)


def _describe(facts: Mapping[str, object]) -> str:
    return f"SSIM {facts['target_ssim']:g} {reached(facts)}"


def _decibels(figure: float) -> float:
    """Return the distance from 1 in decibels: like a PSNR, it grows evenly with the doublings of the paths."""
    return math.inf if figure >= 1.0 else -10.0 * math.log10(1.0 - figure)


QUANTITY = Quantity(
    "target_ssim", Positive(SSIM_MAX, f"must be above 0 and at most {SSIM_MAX:g}", "give 0.6 to 0.9 for a photo"),
    "Use the fewest paths that reach this SSIM (0.6 to 0.9).", "X", "smallest", _measure, _describe,
    _decibels,
)  # fmt: skip

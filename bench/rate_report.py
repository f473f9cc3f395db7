"""The table and the Bjontegaard gains of `bench/rate.py`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from harness import markdown_table
from scipy.interpolate import PchipInterpolator

Curve = Sequence[tuple[float, float]]
"""Points (bytes, value), such as decibels."""


def gain(before: Curve, after: Curve) -> float:
    """Return the Bjontegaard gain: the mean of ``after`` above ``before`` over the logarithm of the bytes.

    Both curves are interpolated by monotone cubics, and compared over the bytes that both reach. NaN if these are none.
    """
    curves = [sorted((math.log(size), value) for size, value in curve) for curve in (before, after)]
    low, high = max(curve[0][0] for curve in curves), min(curve[-1][0] for curve in curves)
    if min(map(len, curves)) < 2 or high <= low:
        return math.nan
    integrals = [float(PchipInterpolator(*zip(*curve, strict=True)).integrate(low, high)) for curve in curves]
    return (integrals[1] - integrals[0]) / (high - low)


def table(curves: Mapping[str, Mapping[int, tuple[float, float]]], sizes: Sequence[int], name: str) -> str:
    """Return a Markdown table with a row a method and a column a size; ``curves`` has (bytes, value) by size."""
    digits = 2 if name == "PSNR" else 3
    rows = [
        [method, *(f"{curve[size][1]:.{digits}f}" if size in curve else "-" for size in sizes)]
        for method, curve in curves.items()
    ]
    return markdown_table([f"{name} at bytes", *(f"{size:,}" for size in sizes)], rows)


def means(
    found: Mapping[str, Mapping[int, Sequence[tuple[float, float]]]],
) -> dict[str, dict[int, tuple[float, float]]]:
    """Return the mean (bytes, value) of each method and size over the photos."""
    return {
        method: {size: (float(pair[0]), float(pair[1])) for size, pair in _mean_pairs(sizes)}
        for method, sizes in found.items()
    }


def _mean_pairs(sizes: Mapping[int, Sequence[tuple[float, float]]]) -> list[tuple[int, np.ndarray]]:
    return [(size, np.mean(pairs, axis=0)) for size, pairs in sorted(sizes.items()) if pairs]

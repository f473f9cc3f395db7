"""Read filters that blur, and nothing else: Gaussian blurs, as drawing programs write them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.softness import SIGMA_MAX
from warpvec.svg.document import local_name
from warpvec.svg.units import NUMBER

_REFERENCE = re.compile(r"url\(\s*[\"']?#([^\"')]+)[\"']?\s*\)")
_DEVIATIONS = re.compile(rf"\s*({NUMBER})(?:[\s,]+({NUMBER}))?\s*")
_UNEVEN = 1.05
"""Largest ratio of the deviations across and down that counts as even: less than half a level at an edge."""


def read_filter(text: str, matrix: NDArray[np.float64], by_id: Mapping[str, Element], omitted: Counter[str]) -> float:
    """Return the standard deviation in pixels of the blur that the property ``filter`` names; 0 without any.

    Blurred in linear light or as it is encoded, a flat path looks the same.

    Args:
        text: the property.
        matrix: from user space to pixels [2, 3].
        by_id: the elements of the file by their id.
        omitted: counts what the result leaves out, such as filters that do more than blur.
    """
    if text == "none":
        return 0.0
    deviations = _deviations(by_id.get(match[1])) if (match := _REFERENCE.fullmatch(text)) else None
    if deviations is None:
        omitted["filter"] += 1
        return 0.0
    scales = np.hypot(*matrix[:, :2])  # of the axes across and down
    with np.errstate(over="ignore", invalid="ignore"):
        across, down = (float(each) for each in np.array(deviations) * scales)
    if not 0.0 < across * down < np.inf:
        return 0.0
    omitted["uneven blur"] += max(across, down) > _UNEVEN * min(across, down)
    sigma = float(np.sqrt(across * down))
    omitted["blur beyond the limit"] += sigma > SIGMA_MAX
    return min(sigma, SIGMA_MAX)


def _deviations(element: Element | None) -> tuple[float, float] | None:
    """Return the deviations in user space of a filter that only blurs; None for any other."""
    if element is None or local_name(element.tag) != "filter" or element.get("primitiveUnits") == "objectBoundingBox":
        return None
    steps = [step for step in element if local_name(step.tag)]
    if len(steps) != 1 or local_name(steps[0].tag) != "feGaussianBlur":
        return None
    if steps[0].get("in", "SourceGraphic") != "SourceGraphic":
        return None
    found = _DEVIATIONS.fullmatch(steps[0].get("stdDeviation", "0"))
    if found is None:
        return None
    across = float(found[1])
    return across, across if found[2] is None else float(found[2])

"""How many nats the regions of a picture take, with what they leave of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warpvec.arrays import Floats
from warpvec.flat.evidence.evidence import Evidence
from warpvec.flat.price import COLOR_NATS, RAMP_NUMBERS, number_nats
from warpvec.geometry.paints.registry import FLAT

if TYPE_CHECKING:
    from warpvec.flat.regions.regions import Regions

OUTLINE_NUMBERS = 8
"""Numbers of the simplest outline of a region, four lines. What more an outline has, its mixed pixels pay for."""


def shown_by(regions: Regions) -> Floats:
    """Return the picture that ``regions`` state over white [h, w, 3], in [0, 255]."""
    mixed = regions.mixed().astype(np.float64)
    return np.asarray(255.0 * (mixed[..., :3] + 1.0 - mixed[..., 3:]))


def regions_nats(regions: Regions, evidence: Evidence) -> float:
    """Return the nats of ``regions`` and of what they leave of the picture of ``evidence``.

    A region says its outline and its paint. A mixed pixel says its share, to the deviation of the pixels: that takes
    the more, the farther its two paints are apart.
    """
    number = number_nats(max(regions.label.shape))
    ramp_count = int((regions.paints.kind != FLAT).sum())
    stated = len(regions) * (OUTLINE_NUMBERS * number + COLOR_NATS) + ramp_count * (RAMP_NUMBERS * number + COLOR_NATS)
    y, x = np.nonzero(regions.share < 1.0)
    places = x.astype(np.float32) + np.float32(0.5), y.astype(np.float32) + np.float32(0.5)
    one, other = (regions.paints.at(label[y, x], *places) for label in (regions.label, regions.other))
    contrast = 255.0 * np.abs(one - other).max(1, initial=0.0)
    stated += float(np.log(np.maximum(contrast / evidence.sigma.mean(), 1.0)).sum())
    return stated + float(evidence.misfit(shown_by(regions)).sum())

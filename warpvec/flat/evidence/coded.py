"""Price a picture as a photo: the nats that a transform coder takes.

A coder of cosine transforms says a photo briefly, and a drawing of even areas and sharp edges at length. So it is the
other explanation that regions of flat art compete with.
"""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from warpvec.condition.jpeg import color_steps_of, steps_of
from warpvec.flat.evidence.evidence import Evidence

_SHIFT = 4
"""Pixels by which a JPEG is moved before it is coded again. Its own blocks would cost as little as those of its
file, for a drawing as for a photo."""

_MISFIT_MAX = 1.5
"""Nats that rounding by steps of the deviation times the root of 12 leaves of a pixel: half for each channel."""


def coded_nats(evidence: Evidence) -> float:
    """Return the nats of the picture of ``evidence`` as a transform coder says it, with what that leaves of it.

    Its steps leave as much as the deviation of the pixels is.
    """
    levels = np.rint(evidence.levels).clip(0.0, 255.0).astype(np.uint8)
    options, shift = _options(evidence), _SHIFT if evidence.jpeg is not None else 0
    file = _saved(np.pad(levels, [(shift, 0), (shift, 0), (0, 0)], mode="edge"), options)
    header = len(_saved(np.zeros((8, 8, 3), np.uint8), options).getvalue())
    shown = np.asarray(Image.open(file), np.float64)[shift:, shift:]
    left = np.minimum(evidence.misfit(shown).sum(), _MISFIT_MAX * levels[..., 0].size)
    return 8.0 * math.log(2.0) * (len(file.getvalue()) - header) + float(left)


def _options(evidence: Evidence) -> dict[str, Any]:
    """Return the tables of steps for Pillow."""
    jpeg = evidence.jpeg
    if jpeg is None:
        step = int(np.clip(np.rint(evidence.sigma.mean() * math.sqrt(12.0)), 1, 255))
        return {"qtables": [[step] * 64] * 2, "subsampling": 0}
    tables = [steps.astype(int).ravel().tolist() for steps in (steps_of(jpeg.quality), color_steps_of(jpeg.quality))]
    return {"qtables": tables, "subsampling": 2 if jpeg.is_subsampled else 0}


def _saved(levels: NDArray[np.uint8], options: dict[str, Any]) -> io.BytesIO:
    file = io.BytesIO()
    Image.fromarray(levels).save(file, "JPEG", optimize=True, **options)
    return file

"""Read PAM files of netpbm, of which Pillow knows few: the magic number P7, lines of words, and the samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

PAM_MARK = b"P7\n"
"""Begin of a PAM file."""

_END = b"\nENDHDR\n"

_MAX_HEAD = 2**16
"""Longest header in bytes; those of netpbm have some hundred."""


def pam_samples(data: bytes, check: Callable[[int, int, bool], None]) -> NDArray[Any]:
    """Return the samples [h, w, 1 to 4] of the PAM file ``data``, whose depths of 2 and 4 have alpha.

    ``check`` refuses a width, a height, and whether there is alpha, before the samples are looked at.

    Raises:
        ValueError: it is not complete, or has other channels.
    """
    end = data.find(_END, 0, _MAX_HEAD)
    words = [line.split() for line in data[:end].split(b"\n") if line and not line.startswith(b"#")]
    facts = {key: values[0] for key, *values in words if values}
    try:
        width, height, depth, most = (int(facts[key]) for key in (b"WIDTH", b"HEIGHT", b"DEPTH", b"MAXVAL"))
    except KeyError as error:
        raise ValueError("its header is not complete") from error
    if end < 0 or depth not in (1, 2, 3, 4) or not 1 <= most <= 65535:
        raise ValueError("its header is none of a picture")
    check(width, height, depth in (2, 4))
    kind = np.dtype(">u2" if most > 255 else "u1")
    samples = np.frombuffer(data, kind, width * height * depth, end + len(_END)).reshape(height, width, depth)
    if samples.max() > most:
        raise ValueError("a sample is above MAXVAL")
    full = 65535 if most > 255 else 255
    # Of the array of the levels, not of the samples: it is small.
    levels = (np.arange(most + 1) * (full / most)).round().astype(np.uint16 if full > 255 else np.uint8)
    found: NDArray[Any] = levels[samples]
    return found

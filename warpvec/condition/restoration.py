"""The picture before its enlargement."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32
from warpvec.condition.enlargement import Enlargement
from warpvec.condition.resampling import Upsampling
from warpvec.image.alpha import is_transparent, premultiplied, straight


def before_enlargement(pixels: Floats32, enlargement: Enlargement) -> Floats32:
    """Return the small picture that explains ``pixels`` [h, w, 3 or 4], in [0, 1], best.

    Programs enlarge colours that are multiplied by alpha.
    """
    height, width = pixels.shape[:2]
    down = Upsampling(height, enlargement.height, enlargement.kernel)
    across = Upsampling(width, enlargement.width, enlargement.kernel)
    image = premultiplied(pixels) if is_transparent(pixels) else pixels
    channels = (np.asarray(image[..., k], np.float64) for k in range(image.shape[2]))
    small = np.stack([across.inverse(down.inverse(channel).T).T for channel in channels], -1).astype(np.float32)
    return straight(small) if is_transparent(pixels) else small.clip(0.0, 1.0)

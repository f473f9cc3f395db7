"""The regions of a picture that was saved as JPEG, and the picture as it was before.

The regions say what each pixel is mixed of, which is a drawing of the picture without its ringing. Of all pictures that
become the same JPEG, the nearest to it shows small and thin parts that the ringing hid, and the regions are found in it
once more.
"""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32
from warpvec.condition.jpeg import steps_of
from warpvec.condition.unrounding import Rounding
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.regions import Regions, find_regions
from warpvec.watch.watch import UNWATCHED, Watch


def before_jpeg(
    image: Floats32, found: Regions, rounding: Rounding, min_area: float = 0.0, watch: Watch = UNWATCHED
) -> tuple[Floats32, Regions]:
    """Return the picture before it was saved as JPEG [h, w, 3], and its regions.

    Args:
        image: the picture [h, w, 3], sRGB-encoded in [0, 1].
        found: the regions of ``image``.
        rounding: how it was rounded, perhaps as an enlargement.
        min_area: as `find_regions`.
        watch: the watch over the run. When it is over, what is known must do.
    """
    noise = REGIONS.jpeg_noise * float(steps_of(rounding.jpeg.quality).mean() / steps_of(50).mean()) / rounding.factor
    before, regions = image, found
    for _ in range(REGIONS.jpeg_rounds):
        if watch.is_over():
            break
        drawn = 255.0 * regions.mixed()[..., :3].astype(np.float64)
        before = np.asarray(rounding.nearest(drawn) / 255.0, np.float32)
        regions = find_regions(before, min_area, watch, noise_min=noise)
    return before, regions

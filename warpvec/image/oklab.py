"""OKLab: colours as points whose distances are how different they look."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats


def to_oklab(colors: Floats) -> Floats:
    """Return sRGB-encoded ``colors`` [C, 3] in [0, 1] as lightness, green to red, and blue to yellow [C, 3].

    Source: Bjorn Ottosson, "A perceptual color space for image processing", 2020.
    """
    linear = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    cones = linear @ np.array([[0.4122214708, 0.2119034982, 0.0883024619],
                               [0.5363325363, 0.6806995451, 0.2817188376],
                               [0.0514459929, 0.1073969566, 0.6299787005]])  # fmt: skip
    return np.cbrt(cones) @ np.array([[0.2104542553, 1.9779984951, 0.0259040371],
                                               [0.7936177850, -2.4285922050, 0.7827717662],
                                               [-0.0040720468, 0.4505937099, -0.8086757660]])  # fmt: skip

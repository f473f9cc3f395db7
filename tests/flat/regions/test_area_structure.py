"""Areas of one paint with both structure and grain belong to a photo."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from sweep import sweep

import warpvec
from warpvec.arrays import Floats32
from warpvec.flat.regions.area_structure import require_plain_areas
from warpvec.flat.regions.regions import NotFlatArtError, find_regions


def disk(structure: float, noise: float) -> Floats32:
    """Return a gray disk on white [128, 128, 3], with clouds and noise of so many levels of deviation."""
    random = np.random.default_rng(4)
    clouds, grain = random.normal(size=(2, 128, 128))
    clouds = ndimage.gaussian_filter(clouds, 5.0)
    away = np.hypot(*(np.indices((128, 128)) - 63.5))
    share = np.clip(50.0 - away, 0.0, 1.0)
    gray = 110.0 + structure * clouds / clouds.std() + noise * grain
    levels = np.round(255.0 + share * (gray - 255.0)).clip(0.0, 255.0)
    return np.repeat(levels[..., None], 3, 2).astype(np.float32) / np.float32(255)


def test_a_photo_of_soft_structure_and_grain_is_refused() -> None:
    image = disk(structure=4.0, noise=3.0)
    with pytest.raises(NotFlatArtError, match="levels of texture"):
        require_plain_areas(find_regions(image), image)


def test_auto_fits_it_as_a_photo() -> None:
    result = warpvec.vectorize(disk(structure=4.0, noise=3.0), curves=8, iterations=2, threads=1)
    assert result.metrics["mode"] == "photo"
    assert "levels of texture" in result.metrics["mode_reason"]


@sweep(("structure", "noise"), [(0.0, 0.0), (0.0, 6.0), (4.0, 0.0)])
def test_noise_alone_and_soft_shading_alone_are_drawn(structure: float, noise: float) -> None:
    image = disk(structure, noise)
    require_plain_areas(find_regions(image), image)

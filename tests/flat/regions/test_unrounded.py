"""The regions of a JPEG bring back the picture before it."""

from __future__ import annotations

import numpy as np
from damage import as_jpeg, drawn, enlarged, levels_of
from PIL.Image import Resampling

from warpvec.condition.enlargement import Enlargement
from warpvec.condition.jpeg import Jpeg
from warpvec.condition.restoration import before_enlargement
from warpvec.condition.unrounding import EnlargedRounding, JpegRounding
from warpvec.flat.regions.regions import find_regions
from warpvec.flat.regions.unrounded import before_jpeg


def test_the_picture_before_a_jpeg_is_nearer_to_the_clean_one() -> None:
    clean = drawn(160)
    image = (levels_of(as_jpeg(clean, 70)) / 255.0).astype(np.float32)
    before, _ = before_jpeg(image, find_regions(image), JpegRounding(255.0 * image, Jpeg(70, True)))
    given, found = (np.sqrt(np.mean((255.0 * each - levels_of(clean)) ** 2)) for each in (image, before))
    assert found < 0.65 * given


def test_so_is_that_of_an_enlargement() -> None:
    clean = drawn(64)
    large = levels_of(as_jpeg(enlarged(clean, 3.0, Resampling.BICUBIC), 60)).astype(np.float32)
    enlargement = Enlargement(*clean.size, "bicubic", 3.0, 0.0)
    image = before_enlargement(large / 255.0, enlargement)
    rounding = EnlargedRounding(JpegRounding(large, Jpeg(60, True)), enlargement)
    before, _ = before_jpeg(image, find_regions(image), rounding)
    given, found = (np.sqrt(np.mean((255.0 * each - levels_of(clean)) ** 2)) for each in (image, before))
    assert found < 0.65 * given


def test_what_a_jpeg_cannot_tell_from_black_and_white_is_black_and_white() -> None:
    image = np.full((48, 48, 3), 254.0 / 255.0, np.float32)
    image[:, 24:] = np.array([1.0, 0.0, 1.0]) / 255.0
    _, regions = before_jpeg(image, find_regions(image), JpegRounding(255.0 * image, Jpeg(80, True)))
    assert sorted(regions.paints.color.tolist()) == [[0.0] * 3, [1.0] * 3]

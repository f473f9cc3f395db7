"""The blur of a picture is measured within a tenth, and is 0 where edges are as a renderer draws them."""

from __future__ import annotations

import numpy as np
import pytest
from damage import as_jpeg, blurred, drawn, levels_of, noisy
from PIL import Image
from sweep import sweep

from warpvec.condition.blur import measure_blur

LUMA = np.array([0.299, 0.587, 0.114])


def blur_of(image: Image.Image, noise: float = 0.0) -> float:
    return measure_blur(levels_of(image) @ LUMA, noise).deviation


@sweep(("width", "deviation"), [(width, blur) for width in (256, 512) for blur in (0.6, 0.8, 1.0, 1.5, 2.0, 3.0)])
def test_a_blur_is_measured_within_a_tenth(width: int, deviation: float) -> None:
    assert blur_of(blurred(drawn(width), deviation)) == pytest.approx(deviation, rel=0.1)


def test_a_blur_is_measured_under_noise_and_after_jpeg() -> None:
    image = blurred(drawn(400), 1.5)
    assert blur_of(noisy(image, 5.0), 5.0) == pytest.approx(1.5, rel=0.1)
    assert blur_of(as_jpeg(image, 80)) == pytest.approx(1.5, rel=0.1)


@sweep("width", [32, 64, 100, 257, 512])
def test_clean_edges_have_no_blur(width: int) -> None:
    assert blur_of(drawn(width)) == 0.0
    assert blur_of(drawn(width).quantize(4, dither=Image.Dither.NONE)) == 0.0  # without anti-aliasing
    assert blur_of(as_jpeg(drawn(width), 75)) == 0.0


def test_pictures_without_edges_have_no_blur() -> None:
    assert measure_blur(np.full((80, 80), 120.0)).deviation == 0.0
    assert measure_blur(np.zeros((2, 300))).deviation == 0.0


def test_a_blur_is_even_unless_some_edges_are_sharp() -> None:
    sharp, soft = drawn(300), blurred(drawn(300), 2.0)
    half = soft.copy()
    half.paste(sharp.crop((0, 0, 100, 240)), (0, 0))
    assert measure_blur(levels_of(soft) @ LUMA).is_even
    found = measure_blur(levels_of(half) @ LUMA)
    assert found.deviation > 1.5 and not found.is_even

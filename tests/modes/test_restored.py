"""An enlarged picture is drawn as it was before, at the size that it has now."""

from __future__ import annotations

import numpy as np
from damage import drawn, enlarged, levels_of
from PIL import Image
from PIL.Image import Resampling

import warpvec
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw

WIDTH, FACTOR = 80, 5


def drawing_of(image: Image.Image, **options: object) -> warpvec.Result:
    return warpvec.vectorize(np.asarray(image), iterations=6, **options)


def test_an_enlarged_drawing_gets_the_edges_of_its_original() -> None:
    original = levels_of(drawn(WIDTH * FACTOR))
    large = enlarged(drawn(WIDTH), FACTOR, Resampling.BICUBIC)
    restored, as_is = drawing_of(large), drawing_of(large, as_is=True, mode="flat")
    size = (large.width, large.height)
    errors = [psnr(draw(result.svg(), *size), original.astype(np.float32) / 255.0) for result in (restored, as_is)]
    assert errors[0] > errors[1] + 2.0
    assert len(restored.scene.segments) < len(as_is.scene.segments)
    assert (restored.picture.width, restored.picture.height) == size
    assert restored.metrics["condition"]["enlarged"]["width"] == WIDTH
    assert restored.metrics["psnr_as_fitted"] > restored.metrics["psnr"]
    assert as_is.metrics["condition"] is None


def test_a_clean_drawing_is_drawn_as_it_is() -> None:
    clean = drawn(WIDTH)
    result = drawing_of(clean, metadata=False)
    assert result.svg() == drawing_of(clean, as_is=True, metadata=False).svg()
    assert result.metrics["condition_words"] is None


def test_a_goal_for_the_quality_is_about_the_given_picture() -> None:
    large = enlarged(drawn(WIDTH), FACTOR, Resampling.BICUBIC)
    result = drawing_of(large, mode="flat", target_psnr=20.0)
    assert not result.picture.is_restored
    assert result.metrics["psnr_as_fitted"] is None

"""Drawings with photos in them become flat art with photos in its windows."""

from __future__ import annotations

import numpy as np
import pytest
from cards import card
from scipy.ndimage import gaussian_filter

import warpvec
from warpvec.condition.condition import Condition
from warpvec.condition.enlargement import Enlargement
from warpvec.condition.jpeg import Jpeg
from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.modes.choice import suited_mode
from warpvec.modes.request import Request
from warpvec.svg.measure import draw


@pytest.mark.slow
def test_auto_draws_a_card_with_a_photo_as_both() -> None:
    image, share = card("ellipse")
    levels = np.rint(255.0 * image).astype(np.uint8)
    result = warpvec.vectorize(levels, iterations=60)
    assert result.config.mode == "mixed"
    assert 'inkscape:label="1 photo"' in result.svg()
    assert len(result.scene) <= 512
    drawn = draw(result.svg(), 200, 160)
    beside = np.abs(drawn[share == 0.0].astype(int) - levels[share == 0.0])
    assert beside.max() <= 16
    assert beside.mean() < 0.05
    assert result.metrics["psnr"] > 24.0


def test_a_drawing_without_photos_is_flat_art_in_the_mode_mixed() -> None:
    plain = np.full((64, 64, 3), 255, np.uint8)
    plain[20:40, 10:50] = (200, 30, 20)
    mixed, flat = (warpvec.vectorize(plain, mode=mode, iterations=2) for mode in ("mixed", "flat"))
    assert mixed.metrics["psnr"] == flat.metrics["psnr"]


def test_a_photo_that_is_the_ground_of_the_picture_makes_it_a_photo() -> None:
    noise = gaussian_filter(np.random.default_rng(0).random((80, 80, 3)), (1.5, 1.5, 0.0))
    levels = np.rint(255.0 * (noise - noise.min()) / np.ptp(noise)).astype(np.uint8)
    levels[24:56, 24:56] = 255
    result = warpvec.vectorize(levels, mode="mixed", curves=16, iterations=2)
    assert (result.metrics["mode"], len(result.scene)) == ("photo", 16)
    assert "no outline of their own" in result.metrics["mode_reason"]


def test_a_goal_is_refused() -> None:
    image, _ = card("rectangle")
    with pytest.raises(InputError, match="mode must be another one for a file of a given size"):
        warpvec.vectorize(image, mode="mixed", max_bytes=9000)


def test_traces_of_a_jpeg_after_an_enlargement_are_no_photo() -> None:
    image, _ = card("ellipse")
    request = Request.of(image.astype(np.float32), FitConfig())
    enlargement = Enlargement(image.shape[1], image.shape[0], "bicubic", 3.0, 0.5)
    found = {
        jpeg: suited_mode(request, Condition(enlargement=enlargement, jpeg=Jpeg(80, True) if jpeg else None))
        for jpeg in (False, True)
    }
    assert found[False][0].mode == "mixed" and found[False][1] is not None
    assert found[True][0].mode != "mixed" and found[True][1] is None

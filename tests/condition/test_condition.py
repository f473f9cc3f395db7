"""What has happened to a picture is said in a line, and nothing is said of clean pictures."""

from __future__ import annotations

import json
import tracemalloc

import numpy as np
from damage import as_jpeg, blurred, drawn, enlarged, levels_of, noisy
from PIL import Image
from PIL.Image import Resampling

from warpvec.condition.condition import Condition, measure_condition


def condition_of(image: Image.Image) -> Condition:
    return measure_condition((levels_of(image) / 255.0).astype(np.float32))


def test_each_damage_is_said() -> None:
    assert condition_of(as_jpeg(enlarged(drawn(100), 4.0, Resampling.BICUBIC), 60)).words == (
        "enlarged 4 times from 100 x 80 px (bicubic); JPEG about 60, colours at half size"
    )
    assert condition_of(blurred(drawn(300), 2.0)).words == "blur 2.0 px"
    assert (condition_of(noisy(drawn(300), 8.0)).words or "").startswith("noise ")


def test_nothing_is_said_of_clean_pictures() -> None:
    for width in (16, 64, 200, 512):
        condition = condition_of(drawn(width))
        assert condition.words is None


def test_white_shapes_on_a_transparent_ground_are_measured_by_their_alpha() -> None:
    small = np.zeros((40, 50, 4), np.uint8)
    small[...] = 255
    small[..., 3] = np.asarray(drawn(50).convert("L"))
    large = Image.fromarray(small).resize((200, 160), Resampling.BICUBIC)
    found = measure_condition(np.asarray(large).astype(np.float32) / 255.0).enlargement
    assert found is not None
    assert found.width == 50


def test_the_facts_are_plain_values() -> None:
    facts = condition_of(enlarged(drawn(60), 3.0, Resampling.NEAREST)).facts
    assert json.loads(json.dumps(facts)) == facts
    assert facts["enlarged"]["width"] == 60


def test_a_large_picture_with_alpha_is_measured_without_copies_of_it() -> None:
    pixels = np.zeros((4500, 4500, 4), np.float32)
    pixels[:] = np.linspace(0.0, 1.0, 4500, dtype=np.float32)[:, None]
    tracemalloc.start()
    try:
        measure_condition(pixels)
        assert tracemalloc.get_traced_memory()[1] < 1.5 * pixels.nbytes  # 2.7 with a copy over white
    finally:
        tracemalloc.stop()

"""Words of letters that are too small to be read."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageFont

from warpvec.flat.regions.regions import find_regions
from warpvec.flat.regions.small_text import small_word_count


@pytest.mark.parametrize(("size", "is_small"), [(6, True), (14, False)])
def test_words_of_tiny_letters_are_counted(size: int, is_small: bool) -> None:
    picture = Image.new("RGB", (160, 60), "white")
    ImageDraw.Draw(picture).text((20, 20), "seven words are on one line", "black", ImageFont.load_default(size))
    regions = find_regions(np.asarray(picture, np.float32) / 255.0)
    assert (small_word_count(regions) > 0) == is_small

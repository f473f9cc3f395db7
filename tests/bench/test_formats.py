"""Pictures of real programs are read right or refused in one line."""

from __future__ import annotations

import formats
import pytest

pytestmark = pytest.mark.slow


def test_no_format_is_read_wrongly_without_a_word():
    found = {format.name: words for format, words in formats.rows()}
    assert [name for name, words in found.items() if words.startswith("wrong")] == []
    assert {name for name, words in found.items() if words == "right"} >= {"TGA with alpha", "AVIF"}  # by Pillow


def test_a_picture_with_two_channels_exchanged_is_wrong():
    pixels = formats.pictures()["colours"]
    assert formats._compared(pixels.astype("float32") / 255, pixels) == "right"
    assert formats._compared(pixels[..., ::-1].astype("float32") / 255, pixels).startswith("wrong by")

"""Few colours, two levels and dither are told from other pictures."""

from __future__ import annotations

from damage import drawn, levels_of
from PIL import Image

from warpvec.condition.levels import find_palette


def test_a_palette_is_counted() -> None:
    colors = drawn(200).quantize(12, dither=Image.Dither.NONE)
    found = find_palette(levels_of(colors))
    assert found is not None
    assert found.color_count == len(colors.convert("RGB").getcolors())
    assert not found.is_dithered and not found.has_two_levels


def test_two_levels_and_their_dither_are_found() -> None:
    gray = drawn(200).convert("L")
    dithered, plain = (
        find_palette(levels_of(gray.convert("1", dither=dither)))
        for dither in (Image.Dither.FLOYDSTEINBERG, Image.Dither.NONE)
    )
    assert dithered is not None and dithered.has_two_levels and dithered.is_dithered
    assert plain is not None and plain.has_two_levels and not plain.is_dithered


def test_many_colors_are_no_palette() -> None:
    ramp = Image.linear_gradient("L").convert("RGB")
    assert find_palette(levels_of(ramp)) is None

"""A drawing is split into the parts that lie apart, each with all of its pieces and at the scale of the whole."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

import warpvec
from warpvec.drawing.file_options import FileOptions
from warpvec.drawing.split import split_texts
from warpvec.svg.measure import draw


def _picture(elements: str) -> np.ndarray:
    size = 'width="120" height="80"'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><rect {size} fill="#fff"/>{elements}</svg>'
    return (draw(text, 120, 80) / 255.0).astype(np.float32)


BAR_WITH_DOT = '<path d="M{0} 30h10v30h-10zM{0} 14h10v10h-10z"/>'
RING = (
    '<path fill="#c22" fill-rule="evenodd" d="M84 20h26v26h-26zM90 26h14v14h-14z"/>'
    '<path fill="#06c" d="M94 30h6v6h-6z"/>'
)


def test_pieces_of_one_icon_stay_together_and_icons_come_apart() -> None:
    drawing = warpvec.vectorize(_picture(BAR_WITH_DOT.format(10) + BAR_WITH_DOT.format(45) + RING)).drawing
    texts = split_texts(drawing)
    assert len(texts) == 3
    sizes = [tuple(map(int, re.findall(r'(?:width|height)="(\d+)"', text)[:2])) for text in texts]
    assert sorted(sizes) == [(10, 46), (10, 46), (26, 26)]
    ring = draw(texts[sizes.index((26, 26))], 26, 26, transparent=True)
    assert ring[8, 8, 3] == 0  # its hole
    assert ring[12, 12].tolist() == [0, 0x66, 0xCC, 255]
    assert ring[2, 2].tolist() == [0xCC, 0x22, 0x22, 255]


def test_parts_have_the_scale_of_the_whole() -> None:
    drawing = warpvec.vectorize(_picture(BAR_WITH_DOT.format(10) + RING)).drawing
    drawing = replace(drawing, encoding=replace(drawing.encoding, options=FileOptions(size="120mm")))
    assert any('width="26mm" height="26mm"' in text for text in split_texts(drawing))


def test_parts_are_for_the_same_programs_and_as_short_as_the_whole() -> None:
    dot = '<circle cx="30" cy="40" r="14"/><circle fill="#06c" cx="90" cy="40" r="14"/>'
    short, plain = (
        split_texts(warpvec.vectorize(_picture(dot), **more).drawing)
        for more in ({"minify": True}, {"purpose": "plain"})
    )
    assert len(short) == len(plain) == 2
    for one, two in zip(short, plain, strict=True):
        assert "inkscape" not in one and "inkscape" in two
        assert "<circle" in one and "<circle" not in two and not re.search("[0-9]a", two)
        width, height = map(int, re.findall(r'(?:width|height)="(\d+)"', two)[:2])
        assert np.abs(draw(one, width, height).astype(int) - draw(two, width, height)).mean() < 1.0


def test_parts_of_a_drawing_on_a_grid_are_on_that_grid() -> None:
    bars = '<path d="M10 20h20v10h-20zM70 20h10v40h-10z"/>'
    texts = split_texts(warpvec.vectorize(_picture(bars), grid="12").drawing)
    assert [re.findall('width="([^"]*)" height="([^"]*)" viewBox="([^"]*)"', text)[0] for text in texts] == [
        ("20", "10", "0 0 2 1"),
        ("10", "40", "0 0 1 4"),
    ]
    sizes = ((20, 10), (10, 40))
    assert all(
        draw(text, *size, transparent=True)[..., 3].min() == 255 for text, size in zip(texts, sizes, strict=True)
    )

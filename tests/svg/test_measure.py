"""Drawing and measuring files with resvg, at their own size and at that of an image."""

from __future__ import annotations

import gzip
import math
import tracemalloc

import numpy as np
import pytest
from svg_files import refusal, svg_file

from warpvec.svg import document as document_module
from warpvec.svg import measure
from warpvec.svg.document import parse_svg
from warpvec.svg.measure import draw, draw_like, evaluate, file_facts, file_quality


def test_draw_gives_the_stated_pixels():
    image = draw(svg_file('<rect x="2" width="3" height="4" fill="#204060"/>'))
    expected = np.full((4, 8, 3), 255, np.uint8)
    expected[:, 2:5] = (0x20, 0x40, 0x60)
    assert image.dtype == np.uint8
    assert np.array_equal(image, expected)


def test_transparency_shows_white():
    image = draw(svg_file('<rect width="4" height="4" fill="#000" fill-opacity=".5"/>'))
    assert abs(int(image[0, 0, 0]) - 127) <= 1
    assert (image[:, 4:] == 255).all()


def test_draw_scales_to_the_size_asked_for():
    image = draw(svg_file('<rect width="4" height="4" fill="#000"/>'), 80, 40)
    assert image.shape == (40, 80, 3)
    assert (image[:, :40] == 0).all()
    assert (image[:, 40:] == 255).all()


def test_a_pixel_of_rounding_is_filled_from_the_edge():
    attributes = 'width="300" height="199" viewBox="0 0 300 199"'
    image = draw(svg_file('<rect width="300" height="199" fill="#f00"/>', attributes), 300, 200)
    assert image.shape == (200, 300, 3)
    assert (image == (255, 0, 0)).all()


def test_a_file_that_resvg_cannot_draw_is_refused_in_one_line():
    assert "resvg" in refusal(draw, svg_file(attributes='width="0" height="4"'), 8, 4)


@pytest.mark.parametrize("dtype", ["uint8", "float32", "float64"])
def test_quality_of_a_perfect_file_is_perfect(dtype):
    levels = np.arange(256, dtype=np.uint8)
    content = "".join(f'<rect x="{x}" width="1" height="8" fill="rgb({x},{255 - x},9)"/>' for x in range(256))
    svg = svg_file(content, 'width="256" height="8"')
    photo = np.broadcast_to(np.stack([levels, 255 - levels, 0 * levels + 9], -1), (8, 256, 3))
    photo = photo if dtype == "uint8" else photo.astype(dtype) / np.dtype(dtype).type(255)
    measured = file_quality(svg, photo)
    assert measured == {"psnr": math.inf, "ssim": pytest.approx(1.0)}


def test_quality_is_measured_at_the_size_of_the_photo():
    photo = np.full((40, 80, 3), 1.0)
    photo[:, :40] = 0.1
    measured = file_quality(svg_file('<rect width="4" height="4"/>'), photo)
    assert measured["psnr"] == pytest.approx(20 - 10 * math.log10(0.5))
    assert 0 < measured["ssim"] < 1


def test_quality_does_not_round_the_photo():
    photo = np.full((8, 8, 3), 0.5)
    grey = svg_file('<rect width="8" height="8" fill="#808080"/>', 'width="8" height="8"')
    assert file_quality(grey, photo)["psnr"] == pytest.approx(-20 * math.log10(128 / 255 - 0.5))


def test_facts_of_a_file_and_of_its_gzip_are_the_same():
    paths = '<path d="M0 0c1 1 2 2 3 3 1 1 2 2-3-3z"/><g><path d="M0 0h1v1z"/><path/></g><rect/>'
    text = svg_file(paths + "<!-- \u00e9 -->" * 30)
    facts = file_facts(text)
    assert facts == file_facts(text.encode()) == file_facts(gzip.compress(text.encode()))
    assert (facts["paths"], facts["segments"], facts["bytes"]) == (4, 5, len(text.encode()))
    assert len(gzip.compress(text.encode())) - 20 <= facts["gzip_bytes"] < facts["bytes"]


def test_paths_with_a_namespace_prefix_are_counted_and_those_of_other_namespaces_are_not():
    svg = '<s:svg xmlns:s="http://www.w3.org/2000/svg"><s:path d="M0 0"/><x:path xmlns:x="http://x"/></s:svg>'
    assert file_facts(svg)["paths"] == 1


def test_what_is_painted_is_counted_and_definitions_and_the_background_are_not():
    shape = '<circle r="1"/><g><line/></g>'
    hidden = "".join(f"<{name}>{shape}</{name}>" for name in ("defs", "clipPath", "mask", "symbol", "pattern"))
    nested = f"<defs><mask>{shape}</mask>{shape}</defs>"
    painted = f'{shape}<ellipse/><polygon/><polyline/><rect id="back"/><text>a<tspan>b</tspan></text><use href="#a"/>'
    svg = svg_file(f'<rect id="background"/>{hidden}{painted}{nested}<image href="data:,"/>')
    assert file_facts(svg)["paths"] == 9


def test_elements_with_gradients_are_counted():
    gradient = '<defs><linearGradient id="a"/><clipPath id="c"><path fill="url(#a)"/></clipPath></defs>'
    styled = '<g><circle style="opacity:1; fill : url( #a )"/></g>'
    svg = svg_file(f'{gradient}<path fill="url(#a)"/><path fill="#fff"/>{styled}')
    assert (file_facts(svg)["paths"], file_facts(svg)["gradients"]) == (3, 2)


def test_a_file_without_a_size_is_told_to_state_one():
    message = refusal(draw, svg_file('<rect width="4" height="4"/>', ""), 80, 40)
    assert "got no stated size; add width and height, or a viewBox, to its <svg>" in message


@pytest.mark.parametrize("unit", ["z", "h", "h1", "1 ", "a1 1 0 0 0 1 1 "])
def test_the_segments_of_a_long_path_are_counted_in_little_memory(unit):
    svg = svg_file(f'<path d="M0 0 {unit * 50_000}"/>')
    tracemalloc.start()
    try:
        segment_count = file_facts(svg)["segments"]
        assert tracemalloc.get_traced_memory()[1] < 5 * len(svg) + 500_000
    finally:
        tracemalloc.stop()
    assert segment_count == {"z": 0, "h": 0, "1 ": 25_000}.get(unit, 50_000)


def test_more_commands_than_can_be_counted_soon_are_refused(monkeypatch):
    monkeypatch.setattr(measure, "MAX_COMMANDS", 50)
    assert file_facts(svg_file('<path d="M0 0' + "h1" * 49 + 'z"/>'))["segments"] == 50
    assert "at most 50 commands" in refusal(file_facts, svg_file(('<path d="M0 0' + "h1" * 25 + '"/>') * 2))


def test_evaluate_parses_a_file_once(monkeypatch):
    parsed = []
    parser = document_module._Parser
    monkeypatch.setattr(document_module, "_Parser", lambda *arguments: parsed.append(1) or parser(*arguments))
    svg, image = svg_file('<path d="M0 0h4v4z"/>').encode(), np.ones((4, 8, 3))
    facts, quality = file_facts(svg), file_quality(svg, image)
    parsed.clear()
    metrics = evaluate(svg, image)
    assert len(parsed) == 1
    assert (metrics["curves"], metrics["segments"], metrics["transparent"]) == (1, facts["segments"], False)
    assert {name: metrics[name] for name in quality} == quality
    document = parse_svg(svg)
    assert np.array_equal(draw_like(document, image), draw(svg, 8, 4)) and file_facts(document) == facts


BLOCK = '<rect x="20%" y="40%" width="30%" height="50%" fill="#a30"/>'


# An image of 600 x 400 pixels is reduced to 100 x 67, one of 513 x 342 to 512 x 341.
@pytest.mark.parametrize("box", ["", 'viewBox="0 0 300 200" preserveAspectRatio="none"', 'viewBox="-1 -2 50 33.5"'])
@pytest.mark.parametrize(
    ("stated", "size"),
    [((100, 67), (600, 400)), ((67, 100), (400, 600)), ((512, 341), (513, 342)), ((64, 43), (192, 128))],
)
def test_sizes_that_differ_by_rounding_are_stretched(stated, size, box):
    svg = svg_file(BLOCK, f'width="{stated[0]}" height="{stated[1]}" {box}')
    image = draw(svg, *size)
    assert image.shape[:2] == size[::-1]
    # The centre of the block is at the same fraction of both sides as at the file's own size.
    own = draw(svg)
    for axis in (0, 1):
        centers = [np.nonzero((pixels[..., 1] < 128).any(1 - axis))[0].mean() + 0.5 for pixels in (own, image)]
        assert centers[1] / image.shape[axis] == pytest.approx(centers[0] / own.shape[axis], abs=0.01)
    transparent = draw(svg, *size, transparent=True)
    assert transparent.shape == (*size[::-1], 4)


@pytest.mark.parametrize(
    ("stated", "size"), [((100, 67), (600, 410)), ((512, 512), (530, 512)), ((2, 1), (100, 100)), ((8, 4), (80, 80))]
)
def test_other_proportions_are_refused_in_one_line(stated, size):
    svg = svg_file(BLOCK, f'width="{stated[0]}" height="{stated[1]}"')
    assert f"must have the proportions of {size[0]} x {size[1]}" in refusal(draw, svg, *size)


def test_a_file_with_a_prolog_a_prefix_and_an_epilog_is_stretched():
    head = "\ufeff<?xml version='1.0'?><!-- <svg> --><!DOCTYPE svg>"
    svg = f'{head}<s:svg xmlns:s="http://www.w3.org/2000/svg" width="100" height="67"><s:rect id=">" width="50"'
    image = draw(svg + ' height="67" fill="#000"/></s:svg><!-- end -->', 600, 400)
    assert (image[:, :299] == 0).all() and (image[:, 301:] == 255).all()

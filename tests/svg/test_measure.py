"""Drawing and measuring files with resvg, PSNR and SSIM against scikit-image, and hostile files."""

from __future__ import annotations

import gzip
import math
import tracemalloc

import numpy as np
import pytest
from skimage.metrics import peak_signal_noise_ratio, structural_similarity
from svg_files import refusal, svg_file

from warpvec.image import metrics
from warpvec.image.metrics import psnr, ssim
from warpvec.svg import document as document_module
from warpvec.svg.document import parse_svg
from warpvec.svg.measure import draw, draw_like, evaluate, file_facts, file_quality

NS = 'xmlns="http://www.w3.org/2000/svg"'


def image_pair(height: int, width: int, seed: int = 0, dtype: str = "float64"):
    """A smooth image and a disturbed copy."""
    generator = np.random.default_rng(seed)
    waves = np.sin(np.arange(height)[:, None, None] / 9 + np.arange(width)[:, None] / 5 + np.arange(3))
    first = 0.5 + 0.4 * waves
    second = np.clip(first + 0.1 * generator.standard_normal(first.shape), 0, 1)
    if dtype == "uint8":
        return (first * 255).round().astype(np.uint8), (second * 255).round().astype(np.uint8)
    return first.astype(dtype), second.astype(dtype)


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


def test_draw_takes_text_bytes_byte_order_mark_and_gzip():
    text = svg_file('<rect width="4" height="4" fill="#123"/><!-- \u00e9 -->')
    data = text.encode()
    for form in (data, b"\xef\xbb\xbf" + data, gzip.compress(data)):
        assert np.array_equal(draw(form), draw(text))


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


@pytest.mark.parametrize(
    ("attributes", "shape"),
    [
        ('viewBox="0 0 30 20"', (20, 30)), ('width="60" viewBox="0 0 30 20"', (40, 60)),
        ('width="10mm" height="1in"', (96, 38)), ('width="10px" height="6pt"', (8, 10)),
        ('width="1e1" height="1em"', (16, 10)), ('width="200%" height="50%" viewBox="0,0,30,20"', (10, 60)),
    ],
)  # fmt: skip
def test_draw_at_the_size_that_the_file_states(attributes, shape):
    assert draw(svg_file(attributes=attributes)).shape[:2] == shape


@pytest.mark.parametrize("svg", ["", "nonsense", "<svg", b"\x89PNG\r\n\x1a\n\x00", b"\x1f\x8bnonsense", "<a></b>"])
def test_other_content_is_refused_in_one_line(svg):
    for function in (draw, file_facts):
        assert refusal(function, svg).startswith("SVG must ")


def test_a_truncated_svgz_is_refused():
    assert "gzipped" in refusal(draw, gzip.compress(svg_file().encode() * 9)[:-20])


def test_another_xml_document_is_refused():
    assert "got <html>" in refusal(draw, "<html/>")


def test_a_file_that_resvg_cannot_draw_is_refused_in_one_line():
    assert "resvg" in refusal(draw, svg_file(attributes='width="0" height="4"'), 8, 4)


def test_entities_are_refused_but_a_plain_doctype_is_not():
    plain = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
    bomb = '<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>'
    assert draw(svg_file(before=plain)).shape == (4, 8, 3)
    for function in (draw, file_facts):
        assert "entities" in refusal(function, svg_file(before=bomb))


@pytest.mark.parametrize(
    "reference", ["/photo.png", "photo.png", "file:///photo.png", "http://a/b.svg#c", "../x.svg#y"]
)
@pytest.mark.parametrize("element", ["image", "feImage", "use"])
def test_other_files_are_not_drawn(element, reference):
    svg = svg_file(
        f'<{element} xlink:href="{reference}"/>', 'xmlns:xlink="http://www.w3.org/1999/xlink" width="4" height="4"'
    )
    assert f"<{element} href=" in refusal(draw, svg)
    assert f"<{element} href=" in refusal(draw, svg.replace("xlink:href", "href"))


def test_references_inside_the_file_are_drawn():
    image = draw(svg_file('<defs><rect id="r" width="8" height="4"/></defs><use href="#r"/><a href="http://x"/>'))
    assert (image == 0).all()


def test_deep_nesting_is_refused_before_it_overflows_the_stack():
    def nested(depth: int) -> str:
        return svg_file("<g>" * depth + '<path d="M0 0h9v9z"/>' + "</g>" * depth)

    assert (draw(nested(document_module.MAX_DEPTH - 2))[0, :4] != 255).any()
    assert "nest" in refusal(draw, nested(document_module.MAX_DEPTH - 1))


@pytest.mark.parametrize(
    "attributes",
    [
        'width="1000000" height="1000000"',
        'width="1e9mm" height="1"',
        'width="8" viewBox="0 0 1 1e9"',
        'viewBox="0 0 1e6 1e6"',
        'width="1e6%" height="1e6%" viewBox="0 0 10 10"',
        'width="1e999" height="1"',
    ],
)
def test_a_huge_canvas_is_refused_before_it_is_allocated(attributes):
    svg = svg_file(attributes=attributes)
    assert "pixels" in refusal(draw, svg)
    assert "pixels" in refusal(draw, svg, 10**6, 10**6)


@pytest.mark.parametrize("attributes", ["", 'width="8"', 'width="100%" height="50%"', 'width="a" height="b"'])
def test_a_canvas_of_no_stated_size_is_refused(attributes):
    assert "state its size" in refusal(draw, svg_file('<rect width="1e9" height="1e9"/>', attributes))


@pytest.mark.parametrize("size", [(0, 4), (8, -4)])
def test_a_size_of_nothing_is_refused(size):
    assert "pixels" in refusal(draw, svg_file(), *size)


def test_a_gzip_bomb_is_refused_before_it_fills_the_memory(monkeypatch):
    monkeypatch.setattr(document_module, "MAX_SVG_BYTES", 1000)
    bomb = gzip.compress(svg_file(" " * 10_000_000).encode())
    tracemalloc.start()
    try:
        assert "at most 1000 bytes" in refusal(draw, bomb)
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()
    assert draw(gzip.compress(svg_file(" " * 800).encode())).shape == (4, 8, 3)


@pytest.mark.parametrize("dtype", ["float64", "float32", "uint8"])
def test_psnr_agrees_with_scikit_image(dtype):
    first, second = image_pair(600, 31, dtype=dtype)
    expected = peak_signal_noise_ratio(first, second, data_range=255 if dtype == "uint8" else 1)
    assert psnr(first, second) == pytest.approx(expected, abs=1e-5)


def test_psnr_of_a_known_difference():
    black = np.zeros((5, 7, 3))
    assert psnr(black, black + 0.1) == pytest.approx(20.0)
    assert psnr(black, black) == math.inf
    assert psnr(np.full((2, 2, 3), 51, np.uint8), np.full((2, 2, 3), 0.2)) == math.inf


# Images are compared in bands, here of 256 rows. The heights cross their borders: by one row less, by one window row
# more, by two and a half bands.
@pytest.mark.parametrize(
    "shape", [(7, 7), (7, 40), (33, 50), (255, 9), (256, 9), (257, 9), (262, 9), (263, 9), (640, 12)]
)
def test_ssim_agrees_with_scikit_image(shape, monkeypatch):
    monkeypatch.setattr(metrics, "_BAND_PIXELS", 256 * shape[1])
    first, second = image_pair(*shape)
    expected = structural_similarity(first, second, channel_axis=2, data_range=1)
    assert ssim(first, second) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("dtype", ["float32", "uint8"])
def test_ssim_of_other_types_agrees_with_scikit_image(dtype):
    first, second = image_pair(40, 50, dtype=dtype)
    expected = structural_similarity(first, second, channel_axis=2, data_range=255 if dtype == "uint8" else 1)
    assert ssim(first, second) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("side", [3, 5])
def test_ssim_of_a_small_image_has_a_smaller_window(side):
    first, second = image_pair(side, side)
    expected = structural_similarity(first, second, channel_axis=2, data_range=1, win_size=side)
    assert ssim(first, second) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (4, 1), (2, 300)])
def test_ssim_is_defined_for_any_size(shape):
    first, second = image_pair(*shape)
    assert ssim(first, first) == pytest.approx(1.0)
    assert -1.0 <= ssim(first, second) < 1.0


@pytest.mark.parametrize("function", [psnr, ssim])
def test_images_that_cannot_be_compared_are_refused(function):
    image = np.zeros((4, 4, 3))
    assert "the same shape" in refusal(function, image, image[:3])
    assert "the same shape" in refusal(function, image[..., 0], image[..., 0])
    assert "the same shape" in refusal(function, image[:0], image[:0])
    assert "uint16" in refusal(function, image, image.astype(np.uint16))


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
    assert (facts["paths"], facts["segments"], facts["bytes"]) == (3, 4, len(text.encode()))
    assert len(gzip.compress(text.encode())) - 20 <= facts["gzip_bytes"] < facts["bytes"]


def test_paths_with_a_namespace_prefix_are_counted_and_those_of_other_namespaces_are_not():
    svg = '<s:svg xmlns:s="http://www.w3.org/2000/svg"><s:path d="M0 0"/><x:path xmlns:x="http://x"/></s:svg>'
    assert file_facts(svg)["paths"] == 1


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


def test_the_root_is_of_svg():
    assert "another namespace" in refusal(draw, '<svg xmlns="http://x" width="8" height="4"/>')

"""Forms of a file, and hostile files, which are refused before they do harm."""

from __future__ import annotations

import base64
import gzip
import time
import tracemalloc

import numpy as np
import pytest
from PIL import Image
from svg_files import SQUARE, refusal, square_file, svg_file

from warpvec.svg import document as document_module
from warpvec.svg.measure import draw, file_facts
from warpvec.svg.read import read_svg


def test_draw_takes_text_bytes_byte_order_mark_and_gzip():
    text = svg_file('<rect width="4" height="4" fill="#123"/><!-- \u00e9 -->')
    data = text.encode()
    for form in (data, b"\xef\xbb\xbf" + data, gzip.compress(data)):
        assert np.array_equal(draw(form), draw(text))


@pytest.mark.parametrize("svg", ["", "nonsense", "<svg", b"\x89PNG\r\n\x1a\n\x00", b"\x1f\x8bnonsense", "<a></b>"])
def test_other_content_is_refused_in_one_line(svg):
    for function in (draw, file_facts):
        assert refusal(function, svg).startswith("SVG must ")


def test_a_truncated_svgz_is_refused():
    assert "gzipped" in refusal(draw, gzip.compress(svg_file().encode() * 9)[:-20])


def test_another_xml_document_is_refused():
    assert "got <html>" in refusal(draw, "<html/>")


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


def test_no_reference_draws_a_local_file(tmp_path, monkeypatch):
    """Names that look like fragments and data URLs can be files too: "#p.png", and "p.png" by way of a folder "#"."""
    monkeypatch.chdir(tmp_path)
    for name in ("#", "data:", " data:"):
        (tmp_path / name).mkdir()
    for name in ("#p.png", "p.png"):
        Image.new("RGB", (8, 4), "red").save(tmp_path / name)
    for reference in ("#p.png", "#/../p.png", "#/../p.png,", "data:/../p.png", " data:/../p.png", "&#35;p.png"):
        image = f'<image width="8" height="4" href="{reference}"/>'
        assert "<image href=" in refusal(draw, svg_file(image))
        filtered = image.replace("<image", '<filter id="f"><feImage') + "</filter>"
        svg = svg_file(filtered + '<rect width="8" height="4" filter="url(#f)"/>')
        if "/" in reference:
            assert "<feImage href=" in refusal(draw, svg)
        else:  # an element that does not exist
            assert not (draw(svg) == (255, 0, 0)).all(-1).any()


def test_embedded_images_are_drawn_and_what_these_refer_to_is_not(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Image.new("RGB", (8, 4), "red").save("p.png")
    data = base64.b64encode((tmp_path / "p.png").read_bytes()).decode()
    inner = svg_file('<image width="8" height="4" href="p.png"/><rect width="1" height="1" fill="#00f"/>')
    nested = base64.b64encode(inner.encode()).decode()
    for element in ("image", "feImage"):
        wrap = "{}" if element == "image" else '<filter id="f">{}</filter><rect width="8" height="4" filter="url(#f)"/>'
        image = wrap.format(f'<{element} x="0" y="0" width="8" height="4" href=" data:image/png;base64,{data}"/>')
        assert (draw(svg_file(image))[1:3, 1:7] == (255, 0, 0)).all()
    drawing = draw(svg_file(f'<image width="8" height="4" href="data:image/svg+xml;base64,{nested}"/>'))
    assert (drawing[0, 0] == (0, 0, 255)).all() and (drawing[1:] == 255).all()


def test_references_inside_the_file_are_drawn():
    image = draw(svg_file('<defs><rect id="r" width="8" height="4"/></defs><use href="#r"/><a href="http://x"/>'))
    assert (image == 0).all()
    square = '<rect id="r" width="8" height="4"/><filter id="f"><feImage href="#r"/></filter>'
    image = draw(svg_file(square + '<rect width="8" height="4" fill="#fff" filter="url(#f)"/>'))
    assert (image[1:3, 1:7] == 0).all()


def test_deep_nesting_is_refused_before_it_overflows_the_stack():
    def nested(depth: int) -> str:
        return svg_file("<g>" * depth + '<path d="M0 0h9v9z"/>' + "</g>" * depth)

    assert (draw(nested(document_module.MAX_DEPTH - 2))[0, :4] != 255).any()
    assert "nest" in refusal(draw, nested(document_module.MAX_DEPTH - 1))


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


def test_the_root_is_of_svg():
    assert "another namespace" in refusal(draw, '<svg xmlns="http://x" width="8" height="4"/>')


def test_text_is_text_whatever_encoding_it_declares():
    drawing = read_svg("<?xml version='1.0' encoding='utf-16'?>" + square_file(SQUARE))
    assert len(drawing.scene) == 1


def test_entities_of_a_file_to_read_are_refused():
    assert "entities" in refusal(read_svg, '<!DOCTYPE svg [<!ENTITY a "b">]>' + square_file("&a;"))
    assert "entities" in refusal(read_svg, '<!DOCTYPE svg SYSTEM "a.dtd">' + square_file("&a;"))


def test_more_elements_than_any_drawing_has_are_refused(monkeypatch):
    monkeypatch.setattr(document_module, "MAX_ELEMENTS", 10)
    assert len(document_module.parse_svg(square_file("<path/>" * 8)).path_data) == 8
    assert "at most 10 elements" in refusal(document_module.parse_svg, square_file("<path/>" * 11))


def test_a_long_text_is_refused_as_bytes_of_that_length_are(monkeypatch):
    monkeypatch.setattr(document_module, "MAX_SVG_BYTES", 1000)
    for text in (square_file(" " * 1000), square_file("<desc>" + 400 * "\u20ac" + "</desc>")):
        assert "at most 1000 bytes" in refusal(file_facts, text) == refusal(file_facts, text.encode())


def test_a_long_namespace_is_refused_before_it_is_repeated_for_every_name():
    attributes = " ".join(f"n:a{number}=''" for number in range(900))
    for quote in "'", '"':
        namespace = f"xmlns:n\t = {quote}http://{'a' * 10**6}{quote}"
        start = time.process_time()
        assert "namespaces" in refusal(file_facts, square_file(f"<a {namespace} {attributes}/>"))
        assert time.process_time() - start < 1.0  # it takes 0.05 s; repeated for every name, 3 s and 1 GB
    assert file_facts(square_file(f"<a xmlns:n='{'a' * document_module.MAX_NAMESPACE}' {attributes}/>"))


def test_more_attributes_than_any_element_has_are_refused():
    def with_attributes(count: int) -> str:
        return square_file("<path " + " ".join(f"a{number}=''" for number in range(count)) + "/>")

    assert file_facts(with_attributes(document_module.MAX_ATTRIBUTES))["paths"] == 1
    assert "attributes" in refusal(file_facts, with_attributes(document_module.MAX_ATTRIBUTES + 1))


def test_attributes_are_counted_before_they_fill_the_memory(monkeypatch):
    tag = square_file("<path " + " ".join(f"a{number}=''" for number in range(100_000)) + "/>")
    tracemalloc.start()
    try:
        assert "attributes" in refusal(file_facts, tag)
        assert tracemalloc.get_traced_memory()[1] < 5_000_000
    finally:
        tracemalloc.stop()
    monkeypatch.setattr(document_module, "MAX_ALL_ATTRIBUTES", 50)
    declared = "<!DOCTYPE svg [<!ATTLIST a b CDATA 'c'>]>"
    assert "at most 50 attributes" in refusal(file_facts, svg_file("<a/>" * 60, before=declared))

"""SVGs as parts of web pages: the page's colour, symbols and components."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from logo import logo

import warpvec
from warpvec.errors import InputError
from warpvec.svg.measure import draw, file_facts
from warpvec.svg.on_pages import as_component, as_symbol, component_name, with_current_color
from warpvec.svg.read import read_svg

DRAWING = """<?xml version="1.0" encoding="UTF-8"?>
<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" width="60" height="40" viewBox="0 0 60 40">
<title>A "b" &amp; {c}</title>
<metadata>{"generator": "warpvec"}</metadata>
<defs><linearGradient id="g1" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="60" y2="0"><stop stop-color="#f00"/>
<stop offset="1" stop-color="#00f" stop-opacity=".5"/></linearGradient></defs>
<rect id="background" width="60" height="40" fill="#112"/>
<g id="layer-1" inkscape:groupmode="layer" inkscape:label="red"><path fill="url(#g1)" fill-opacity=".9" d="M3 3h40v30z"/>
<path fill="none" stroke="#102030" stroke-width="2" stroke-linecap="round" d="M2 36h50"/>
<rect fill="#e0e0e0" x="40" y="5" width="9" height="9"/></g>
</svg>
"""  # noqa: E501


@pytest.mark.parametrize(("color", "chosen"), [("darkest", 'stroke="'), ("#ffffff", '<rect fill="')])
def test_the_nearest_paint_takes_the_colour_of_the_page(color: str, chosen: str) -> None:
    text = with_current_color(DRAWING, color)
    assert text.count("currentColor") == 1 and f'{chosen}currentColor"' in text
    assert '<rect id="background" width="60" height="40" fill="#112"/>' in text


def test_a_symbol_looks_like_its_drawing_and_shares_no_id() -> None:
    text = as_symbol(DRAWING, "logo")
    np.testing.assert_array_equal(draw(text, 240, 160), draw(DRAWING, 240, 160))
    assert re.findall(r' id="([^"]+)"', text) == ["logo", "logo-g1"]
    assert "inkscape" not in text and "metadata" not in text
    assert '<use xlink:href="#logo"/>' in text
    assert len(read_svg(text).scene) == len(read_svg(DRAWING).scene)


def test_a_component_is_the_drawing_with_the_names_of_react() -> None:
    text = as_component(DRAWING, "MyLogo")
    assert text.startswith("export default function MyLogo(props) {\n  return (\n    <svg ")
    assert 'viewBox="0 0 60 40" {...props}>' in text
    assert '<title>{"A \\"b\\" & {c}"}</title>' in text
    names = {name for tag in re.findall(r"<\w+ ([^>]*)/?>", text) for name in re.findall(r"([\w:-]+)=", tag)}
    assert not any("-" in name or ":" in name for name in names)
    body = text[text.index("<svg") : text.rindex("</svg>") + 6].replace(" {...props}", "")
    body = re.sub(r"<title>.*</title>", "", body)
    hyphens = re.sub(r"(stop|fill|stroke)(Color|Opacity|Width|Linecap)=", lambda m: f"{m[1]}-{m[2].lower()}=", body)
    np.testing.assert_array_equal(draw(hyphens, 240, 160), draw(DRAWING, 240, 160))


@pytest.mark.parametrize(
    ("stem", "name"), [("my-logo 2", "MyLogo2"), ("logo", "Logo"), ("24px", "Drawing24px"), ("ä", "Drawing")]
)
def test_a_component_has_a_name_that_react_takes(stem: str, name: str) -> None:
    assert component_name(stem) == name


QUICK = {"mode": "photo", "curves": 6, "iterations": 4, "gradients": 3, "threads": 1}


def test_saved_files_for_pages_are_measured_as_drawn(tmp_path: Path) -> None:
    options = {**QUICK, "background": "white", "metadata": False}
    plain = warpvec.vectorize(logo(), **options)
    result = warpvec.vectorize(logo(), **options, current_color="#146edc", symbol="logo")
    for name in ("a.svg", "my-logo.jsx"):
        result.save(tmp_path / name)
    text = (tmp_path / "a.svg").read_text()
    assert text == result.svg() and "<symbol id=" in text and text.count("currentColor") == 1
    component = (tmp_path / "my-logo.jsx").read_text()
    assert "function MyLogo(" in component and component.count("currentColor") == 1 and "symbol" not in component
    assert result.metrics["psnr"] == plain.metrics["psnr"]
    assert result.metrics["bytes"] == len(text.encode()) != plain.metrics["bytes"]


def test_files_share_the_id_of_a_gradient_only_if_it_is_equal() -> None:
    found = [warpvec.vectorize(logo(), **QUICK, background=color).svg() for color in ("white", "#fafafa")]
    gradients = [dict(re.findall(r'<\w+Gradient id="(\w+)"(.*?)</', text)) for text in found]
    assert all(gradients)
    assert all(gradients[0][name] == gradients[1][name] for name in gradients[0].keys() & gradients[1].keys())
    assert {*gradients[0]} != {*gradients[1]}
    assert all(file_facts(text)["gradients"] for text in found)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"symbol": "2 b"}, "symbol must be letters"),
        ({"symbol": ""}, "symbol must be"),
        ({"current_color": "rad"}, "must be a colour"),
    ],
)
def test_other_ids_and_colours_are_refused(options: dict[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        warpvec.vectorize(np.zeros((4, 4, 3), np.uint8), **options)

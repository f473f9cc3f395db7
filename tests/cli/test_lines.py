"""`warpvec run --mode lines`: strokes, what the summary says, and what is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from commands import assert_refused, invoke
from PIL import Image, ImageDraw


@pytest.fixture
def sketch(tmp_path: Path) -> Path:
    """The path of a picture of two lines, 96 x 64 pixels."""
    image = Image.new("L", (96 * 4, 64 * 4), 255)
    pen = ImageDraw.Draw(image)
    pen.line([(40, 60), (340, 60)], fill=0, width=16)
    pen.line([(40, 180), (340, 200)], fill=0, width=16)
    image.resize((96, 64), Image.Resampling.BOX).save(tmp_path / "sketch.png")
    return tmp_path / "sketch.png"


def test_each_line_is_one_stroke_and_the_summary_says_so(sketch: Path) -> None:
    out = sketch.with_suffix(".svg")
    result = invoke("run", sketch, "--mode", "lines")
    assert re.search(r"2 lines, \d\.?\d* px wide; pen up for \d+ px\n", result.stdout)
    assert out.read_text().count("<path") == 2 and 'fill="none"' in out.read_text()
    facts = json.loads(invoke("run", sketch, "--mode", "lines", "--json").stdout)
    assert (facts["lines"], facts["wide_areas"], facts["mode"]) == (2, 0, "lines")
    assert 25.0 < facts["pen_up"] < 40.0 and facts["line_widths"] == [pytest.approx(4.0, abs=0.3)]


def test_strokes_thinner_than_wanted_are_said(sketch: Path) -> None:
    words = ["run", sketch, "--mode", "lines", "--line-width", "0.7"]
    summary = invoke(*words, "--line-width-min", "0.8").stdout
    assert "2 strokes are thinner than --line-width-min, down to 0.7 px" in summary
    assert "are thinner" not in invoke(*words, "--line-width-min", "0.7").stdout
    assert "thin_strokes" not in json.loads(invoke(*words, "--json").stdout)


def test_a_given_width_is_that_of_all_lines_and_selects_the_mode(sketch: Path) -> None:
    facts = json.loads(invoke("run", sketch, "--line-width", "1.5", "--size", "90mm", "--json").stdout)
    assert (facts["mode"], facts["line_widths"]) == ("lines", [1.5])
    text = sketch.with_suffix(".svg").read_text()
    assert 'width="90mm"' in text and text.count('stroke-width="1.5"') == 2


def test_the_summary_of_a_filled_shape_names_the_modes_that_fill(tmp_path: Path) -> None:
    image = Image.new("L", (96, 64), 255)
    ImageDraw.Draw(image).rectangle([10, 20, 84, 43], fill=0)
    image.save(tmp_path / "bar.png")
    hint = "for filled shapes give --mode mono or flat"
    assert hint in invoke("run", tmp_path / "bar.png", "--mode", "lines").stdout


def test_what_lines_cannot_do_is_refused_in_one_line(sketch: Path) -> None:
    assert_refused(invoke("run", sketch, "--mode", "lines", "--trim"), "--trim must not be given in the mode lines")
    assert_refused(invoke("run", sketch, "--mode", "lines", "--cutout"), "--cutout must not be given in the mode lines")
    assert_refused(invoke("run", sketch, "--line-width", "0"), "--line-width must be auto or a width above 0")
    Image.fromarray(np.full((32, 32), 255, np.uint8)).save(sketch)
    assert_refused(invoke("run", sketch, "--mode", "lines"), "must have lines darker than their paper")

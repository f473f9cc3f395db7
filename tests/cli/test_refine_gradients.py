"""`warpvec refine --gradients auto`: it says if no path got a gradient."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import invoke
from PIL import Image

from warpvec.svg.measure import draw

OPENING = '<svg xmlns="http://www.w3.org/2000/svg" width="32" height="32">'

RAMP = (
    '<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="4" y1="4" x2="28" y2="28">'
    '<stop stop-color="#026"/><stop offset="1" stop-color="#9cf"/></linearGradient>'
)


@pytest.mark.parametrize(("paint", "is_said"), [("#37a", True), ("url(#a)", False)])
def test_refine_says_if_no_gradient_paid(tmp_path: Path, paint: str, is_said: bool) -> None:
    square = '<path fill="{}" d="M4.3 4.3H27.6V27.6H4.3z"/></svg>'
    photo, given = tmp_path / "in.png", tmp_path / "given.svg"
    Image.fromarray(draw(OPENING + RAMP + square.format(paint), 32, 32)).save(photo)
    given.write_text(OPENING + square.format("#48a").replace("27.6", "27"))
    options = ("--gradients", "auto", "--iterations", 60, "--threads", 1)
    done = invoke("refine", photo, tmp_path / "out.svg", "--from", given, *options)
    assert done.exit_code == 0, done.output
    assert ("no path got a gradient" in done.stderr) == is_said
    assert "dB (the given file)" in done.output

"""`warpvec.refine`: the paths it begins with, and drawings it refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from short_fits import Photo

import warpvec

SQUARE = '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"><path d="M1 1H7V7H1z" fill="red"/></svg>'


def test_refine_begins_with_the_paths_of_a_file(tmp_path: Path) -> None:
    photo = np.random.default_rng(1).integers(0, 256, (4, 6, 3), dtype=np.uint8).repeat(8, 0).repeat(8, 1)
    first = warpvec.vectorize(photo, 10, iterations=20, threads=1)
    first.save(tmp_path / "a.svgz")
    results = [
        warpvec.refine(photo, svg, iterations=20, threads=1)
        for svg in (first.svg(), first.svg().encode(), tmp_path / "a.svgz")
    ]
    assert results[0].svg() == results[1].svg() == results[2].svg()
    assert results[0].metrics["psnr"] > first.metrics["psnr"]
    assert results[0].metrics["curves"] == 10
    assert warpvec.refine(photo, first.svg(), 16, iterations=20, trim=True).metrics["curves"] > 10


@pytest.mark.parametrize(
    ("svg", "settings", "message"),
    [
        ("missing.svg", {}, "svg must be an SVG file, its text or its bytes, got 'missing.svg'"),
        ('<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"/>', {}, "svg must contain filled paths"),
        ("<svg", {}, "svg must be well-formed XML"),
        (SQUARE, {}, "svg must have the proportions of the photo, 48 x 32, got 8 x 8"),
        (SQUARE, {"segments": 7}, "segments must be 4, as in the SVG, got 7"),
        (SQUARE, {"preset": "paper"}, "path_model must be segments to refine a drawing, got 'sides'"),
    ],
)
def test_refine_refuses_what_does_not_match(photo: Photo, svg: str, settings: dict[str, Any], message: str) -> None:
    with pytest.raises(warpvec.InputError, match="^" + message):
        warpvec.refine(photo, svg, **settings)

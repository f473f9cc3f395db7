"""`warpvec.refine`: the paths it begins with, and drawings it refuses."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from damage import blurred
from PIL import Image
from short_fits import Photo

import warpvec
from warpvec.geometry.joints import Joints
from warpvec.geometry.paints.registry import FLAT, LINEAR
from warpvec.image.metrics import psnr
from warpvec.polish import folds
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg

SQUARE = '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"><path d="M1 1H7V7H1z" fill="red"/></svg>'

DISC = '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"><circle cx="4" cy="4" r="3"/></svg>'


def test_refine_begins_with_the_paths_of_a_file(tmp_path: Path) -> None:
    photo = np.random.default_rng(1).integers(0, 256, (4, 6, 3), dtype=np.uint8).repeat(8, 0).repeat(8, 1)
    first = warpvec.vectorize(photo, 10, iterations=20, threads=1, mode="photo")
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
        (DISC, {"segments": 7}, "segments must be 4, as in the SVG, got 7"),
        (SQUARE, {"preset": "paper"}, "path_model must be segments to refine a drawing, got 'sides'"),
    ],
)
def test_refine_refuses_what_does_not_match(photo: Photo, svg: str, settings: dict[str, Any], message: str) -> None:
    with pytest.raises(warpvec.InputError, match="^" + message):
        warpvec.refine(photo, svg, **settings)


def _wavy(size: int) -> str:
    """Return a drawing of a translucent path with corners, smooth nodes and lines over an opaque disc."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size}">'
        '<circle cx="30" cy="34" r="22" fill="#c62"/>'
        '<path fill="#26c" fill-opacity=".6"'
        ' d="M12 12 H40 C46 12 52 18 52 24 V50 C44 44 40 56 30 50 C20 44 14 30 12 12z"/>'
        "</svg>"
    )


def _moved(svg: str) -> str:
    """Return the drawing with each path a little off, and in other colours."""
    return (
        svg.replace('cx="30"', 'cx="31.5"').replace("V50", "V51.5").replace("C46 12", "C47 12").replace("#c62", "#b63")
    )


@pytest.mark.parametrize("iterations", [1, 10, 60])
def test_a_drawing_gets_no_worse_and_keeps_its_structure(iterations: int) -> None:
    right, start = _wavy(64), _moved(_wavy(64))
    photo = draw(right, 64, 64)
    result = warpvec.refine(photo, start, iterations=iterations, threads=1)
    before, after = read_svg(start).scene, read_svg(result.svg()).scene
    start_psnr, end_psnr = (psnr(draw(svg, 64, 64), photo) for svg in (start, result.svg()))
    assert result.metrics["start_psnr"] == pytest.approx(start_psnr, abs=0.5)
    assert end_psnr >= start_psnr
    if iterations == 60:
        assert not result.metrics["unchanged"]
        assert end_psnr > start_psnr + 8.0
    assert after.opacity[0] == 1.0
    first, second = Joints.of(before), Joints.of(after)
    assert torch.equal(first.is_line, second.is_line)
    assert torch.equal(first.is_smooth, second.is_smooth)
    assert first.is_smooth.any()
    assert not first.is_smooth.all()


@pytest.mark.parametrize("iterations", [0, 10])
def test_translucent_paths_become_opaque_if_asked_for(iterations: int) -> None:
    photo = draw(_wavy(64), 64, 64)
    result = warpvec.refine(photo, _wavy(64), iterations=iterations, threads=1, opacity="opaque")
    assert read_svg(result.svg()).scene.opacity.tolist() == [1.0, 1.0]
    assert result.metrics["start_psnr"] > 45.0  # of the drawing that came in
    assert result.metrics["psnr"] < 30.0


def _outline(points: torch.Tensor) -> str:
    """Return a drawing of one path through ``points`` [n, 2], or of cubics with control points [n, 6]."""
    letter = "L" if points.shape[1] == 2 else "C"
    data = "M1 1" + "".join(letter + " ".join(f"{v:.2f}" for v in row) for row in points.tolist())
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64"><path fill="#26c" d="{data}z"/></svg>'


def test_large_paths_are_looked_at_for_folds_unless_they_are_scribbles(monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[list[bool]] = []

    def counted(count: Callable[..., torch.Tensor]) -> Callable[..., torch.Tensor]:
        def look(*arguments: Any) -> torch.Tensor:
            looks.append(arguments[-1].tolist())  # which paths are guarded
            return count(*arguments)

        return look

    monkeypatch.setattr(folds, "crossings_of_rows", counted(folds.crossings_of_rows))
    monkeypatch.setattr(folds.FoldLook, "crossings", counted(folds.FoldLook.crossings))
    angle = torch.linspace(0, 2 * math.pi, 600)
    polygon = 32 + 28 * torch.stack([angle.cos(), angle.sin()], 1)
    scribble = 64 * torch.rand(60, 6, generator=torch.Generator().manual_seed(0))
    photo = draw(_wavy(64), 64, 64)
    found = []
    for points in (polygon, scribble):
        looks.clear()
        warpvec.refine(photo, _outline(points), iterations=5, threads=1)
        found.append(len(looks))
    # Each fit looks twice before its first step, to tell what a scribble is.
    assert found[1] <= 4 < found[0] and looks[0] == [True]


def test_a_drawing_that_is_right_stays_as_it_is() -> None:
    photo = draw(_wavy(64), 64, 64)
    for iterations in (1, 10, 100):
        result = warpvec.refine(photo, _wavy(64), iterations=iterations, threads=1)
        assert result.svg() == _wavy(64)
        assert result.metrics["unchanged"]
        assert result.metrics["psnr"] == math.inf


@pytest.mark.parametrize("minify", [False, True])
def test_a_drawing_on_a_grid_stays_on_it_with_decimals_of_pixels(minify: bool) -> None:
    body = '<circle fill="#000" cx="12" cy="12" r="8.{}"/></svg>'
    given = '<svg xmlns="http://www.w3.org/2000/svg" width="240" height="240" viewBox="0 0 24 24">' + body
    photo = draw(given.format("23").replace("<circle", '<rect width="24" height="24" fill="#fff"/><circle'), 240, 240)
    options: dict[str, Any] = {"iterations": 30, "precision": 0, "threads": 1, "minify": minify}
    result = warpvec.refine(photo[..., :3], given.format("1"), **options)
    assert 'viewBox="0 0 24 24"' in result.svg() and ' r="8.2"' in result.svg()
    assert result.metrics["grid"] == 24


def test_a_drawing_is_written_anew_if_an_option_asks_for_a_change() -> None:
    photo, given = draw(_wavy(64), 64, 64), _wavy(64).replace("</svg>", "<metadata>x</metadata></svg>")
    for options in ({"size": "90mm"}, {"trim": True}, {"metadata": False}, {"opacity": "opaque"}):
        result = warpvec.refine(photo, given, iterations=2, threads=1, **options)
        assert not result.metrics["unchanged"], options
        assert "<metadata>x<" not in result.svg()


def test_without_iterations_a_foreign_drawing_gets_no_canvas_and_no_settings() -> None:
    photo = draw(_wavy(64), 64, 64)
    result = warpvec.refine(photo, _wavy(64), iterations=0, threads=1)
    assert "<rect" not in result.svg()
    assert "<metadata" not in result.svg()
    assert result.metrics["start_psnr"] == math.inf  # the given file is the photo itself
    kept = warpvec.refine(photo, _moved(_wavy(64)), iterations=2, threads=1, gradients=1)
    assert kept.metrics["start_psnr"] == pytest.approx(psnr(draw(_moved(_wavy(64)), 64, 64), photo))


def test_flat_paths_get_a_gradient_if_asked_for_and_only_where_the_picture_has_one() -> None:
    shapes = '<path fill="{}" d="M6 6H40V58H6z"/><path fill="#e80" d="M44 6H60V58H44z"/></svg>'
    opening = '<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64">'
    ramp = '<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="6" y1="6" x2="40" y2="58">'
    ramp += '<stop stop-color="#026"/><stop offset="1" stop-color="#9cf"/></linearGradient>'
    photo = draw(opening + ramp + shapes.format("url(#a)"), 64, 64)
    flat = warpvec.refine(photo, opening + shapes.format("#48a"), iterations=60, threads=1)
    shaded = warpvec.refine(photo, opening + shapes.format("#48a"), iterations=60, threads=1, gradients=1)
    assert flat.drawing.fitted.gradients is None
    assert shaded.drawing.fitted.gradients.kind.tolist() == [LINEAR, FLAT]
    assert shaded.metrics["psnr"] > 45 > flat.metrics["psnr"] + 15


SHAKEN = """<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64" viewBox="0 0 64 64">
<rect width="64" height="64" fill="#fff"/><g><circle fill="#c22" cx="20.6" cy="21.3" r="11.4"/>
<rect fill="#27c" x="33.6" y="28.1" width="22.2" height="26.4" rx="4" transform="rotate(11.5 44.7 41.3)"/></g></svg>"""


def test_forms_stay_forms_unless_paths_are_asked_for() -> None:
    right = SHAKEN.replace('cx="20.6" cy="21.3" r="11.4"', 'cx="20" cy="21" r="12"').replace("11.5", "10")
    image = draw(right, 64, 64)
    found = warpvec.refine(image, SHAKEN, threads=1)
    assert found.scene.forms is not None
    circle, rect = found.scene.forms.parameters
    assert circle[:3].tolist() == pytest.approx([20.0, 21.0, 12.0], abs=0.03)
    assert rect[4:].tolist() == pytest.approx([math.radians(10), 4.0], abs=0.1)
    assert "<circle" in found.svg() and "rotate(" in found.svg()
    assert found.metrics["circles"] == found.metrics["rects"] == 1 and found.metrics["psnr"] > 45
    plain = warpvec.refine(image, found.svg(), iterations=0, plain_paths=True, threads=1)
    assert plain.svg().count("<path") == 2 and "<circle" not in plain.svg()


def test_a_drawing_of_a_blurred_picture_stays_sharp() -> None:
    size = 96
    original = Image.fromarray(draw(_wavy(size), size, size))
    photo = np.asarray(blurred(original, 1.5))
    results = [warpvec.refine(photo, _moved(_wavy(size)), iterations=30, threads=1, blur=blur) for blur in ("0", 1.5)]
    errors = [psnr(draw(result.svg(), size, size), np.asarray(original)) for result in results]
    assert errors[1] > errors[0] + 6.0
    assert results[1].metrics["psnr_as_fitted"] > results[1].metrics["start_psnr"] + 6.0


def test_a_drawing_that_is_right_before_a_measured_blur_stays_as_it_is() -> None:
    photo = np.asarray(blurred(Image.fromarray(draw(_wavy(96), 96, 96)), 1.5))
    result = warpvec.refine(photo, _wavy(96), iterations=10, threads=1, blur="auto")
    assert result.metrics["blur_undone"] == pytest.approx(1.5, rel=0.1)
    assert psnr(draw(result.svg(), 96, 96), draw(_wavy(96), 96, 96)) > 45.0
    with pytest.raises(warpvec.InputError, match="^blur must not be given where paths are added"):
        warpvec.refine(photo, _wavy(96), 9, blur="auto")

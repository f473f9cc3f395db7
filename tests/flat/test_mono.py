"""Test black and white tracing: outlines between pixels, thresholds, holes and specks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from warpvec.errors import InputError
from warpvec.flat import mono
from warpvec.flat.constants.mono import MONO
from warpvec.flat.mono import mono_tracing
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg
from warpvec.watch.watch import Watch

OVER = Watch(time_budget=1e-9)
"""A watch whose time is up."""

SIDE = 96


def _picture(elements: str, ink: int = 0, paper: int = 255) -> NDArray[np.uint8]:
    """Return black ``elements`` as resvg draws them over white, at these levels [h, w, 3]."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}">'
    levels = draw(f"{head}{elements}</svg>", SIDE, SIDE) / 255.0
    return np.rint(ink + (paper - ink) * levels).astype(np.uint8)


def _drawn(scene: Scene, precision: int = 2) -> NDArray[np.uint8]:
    return draw(write_svg(scene, SIDE, SIDE, precision=precision), SIDE, SIDE)


def _overlap(one: NDArray[np.uint8], two: NDArray[np.uint8]) -> float:
    """Return the ink that two pictures share over the ink of either."""
    first, second = (1.0 - picture / 255.0 for picture in (one, two))
    return float(np.minimum(first, second).sum() / np.maximum(first, second).sum())


RING = (
    '<circle cx="48.3" cy="47.6" r="30.4" fill="none" stroke="#000" stroke-width="11.3"/><path d="M40,44h17v9h-17z"/>'
)


def test_ring_and_square_are_one_path_in_black_with_a_hole() -> None:
    picture = _picture(RING)
    scene = mono_tracing(picture).scene
    assert len(scene) == 1
    assert scene.structure.loop_count == 3
    assert scene.color.abs().max() == 0
    assert _overlap(_drawn(scene), picture) > 0.985
    assert scene.structure.segment_count <= 14


def test_two_levels_make_smooth_outlines() -> None:
    truth = _picture('<circle cx="48.3" cy="47.6" r="33.4"/>')
    scene = mono_tracing(np.where(truth < 128, 0, 255).astype(np.uint8)).scene
    assert scene.structure.segment_count <= 8
    assert _overlap(_drawn(scene), truth) > 0.985


@pytest.mark.parametrize("blur", [1.0, 2.0])
def test_corners_of_a_blurred_picture_are_few_nodes(blur: float) -> None:
    arrow = _picture('<path d="M12,12h28l40,34-40,34h-28l36-34z"/>')
    blurred = np.rint(gaussian_filter(arrow.astype(np.float64), (blur, blur, 0))).astype(np.uint8)
    tracing = mono_tracing(blurred, blur=blur)
    assert tracing.is_clean
    assert len(tracing.scene.segments) <= 9


def test_threshold_is_half_way_between_ink_and_paper_for_thin_strokes() -> None:
    rings = "".join(
        f'<circle cx="48" cy="48" r="{r}" fill="none" stroke="#000" stroke-width="3"/>' for r in (13, 28, 43)
    )
    found = mono_tracing(_picture(rings, ink=40, paper=220))
    assert found.threshold == pytest.approx(130, abs=2)
    assert _overlap(_drawn(found.scene), _picture(rings)) > 0.95


def test_given_threshold_moves_the_outline() -> None:
    ramp = np.linspace(0, 255, SIDE)[None, :, None].repeat(SIDE, 0).repeat(3, 2).astype(np.uint8)
    widths = [
        1.0 - _drawn(mono_tracing(ramp, threshold).scene)[SIDE // 2, :, 0].mean() / 255.0 for threshold in (64, 191)
    ]
    assert widths == pytest.approx([0.25, 0.75], abs=0.02)


def test_specks_and_small_holes_are_left_out_and_counted() -> None:
    specks = '<path d="M8,8h1v1h-1zM80,80h1v1h-1z"/><path d="M50,46h1v1h-1z" fill="#fff"/>'
    found = mono_tracing(_picture(RING + specks))
    assert found.speck_count == 3
    assert found.scene.structure.loop_count == 3


LETTER = "M10,14h1v9h-1zM15,14h1v9h-1zM11,22h4v1h-4z"
"""A letter u with strokes of one pixel."""

DOTS = "M11,11h1v1h-1zM14,11h1v1h-1z"
COMMA = "M18,22h1v2h-1z"


def test_dots_and_commas_beside_letters_of_two_levels_are_kept() -> None:
    tracing = mono_tracing(_picture(f'<path d="{LETTER}{DOTS}{COMMA}"/>'))
    assert tracing.speck_count == 0
    drawn = _drawn(tracing.scene)[..., 0]
    for row, column in ((11, 11), (11, 14), (22, 18), (23, 18)):
        assert drawn[row, column] < 100


@pytest.mark.parametrize("levels", [2, 256])
def test_dust_is_left_out_beside_letters_too(levels: int) -> None:
    generator = np.random.default_rng(1)
    picture = _picture(f'<path d="{LETTER}"/>' + RING)
    clean = mono_tracing(picture if levels > 2 else np.where(picture < 128, 0, 255).astype(np.uint8))
    is_dust = generator.random(picture.shape[:2]) < 0.006
    dusty = np.where(is_dust[..., None], 255 - picture, picture)
    if levels == 2:
        dusty = np.where(dusty < 128, 0, 255).astype(np.uint8)
    found = mono_tracing(dusty)
    assert found.speck_count > 30
    assert found.scene.structure.loop_count <= clean.scene.structure.loop_count + 2


def test_lines_that_cover_no_pixel_by_half_are_drawn_or_counted() -> None:
    picture = _picture(RING + '<path d="M4,6H90M4,90H90" stroke="#000" stroke-width=".8"/>')
    found = mono_tracing(picture)
    assert found.faint_count == 0
    assert _overlap(_drawn(found.scene), picture) > 0.95
    assert mono_tracing(picture, blur=0.5).faint_count == 2


def test_pixels_of_exactly_the_level_that_parts_ink_and_paper_are_no_outlines() -> None:
    """Around each of them there is an outline of four equal points."""
    levels = np.random.default_rng(0).integers(240, 249, (24, 24, 1), np.uint8).repeat(3, 2)
    found = mono_tracing(levels, min_area=0.0)
    assert found.scene.structure.loop_count > 10
    assert found.speck_count > 0


def test_transparent_pixels_are_paper() -> None:
    picture = np.zeros((SIDE, SIDE, 4), np.uint8)
    picture[20:60, 30:70, 3] = 255
    drawn = _drawn(mono_tracing(picture).scene)
    assert drawn[40, 50].max() == 0
    assert drawn[10, 10].min() == 255


def test_blank_picture_has_no_path() -> None:
    scene = mono_tracing(np.full((SIDE, SIDE, 3), 255, np.uint8)).scene
    assert len(scene) == 0
    assert _drawn(scene).min() == 255


def test_threshold_beyond_the_levels_is_refused() -> None:
    with pytest.raises(InputError, match="threshold"):
        mono_tracing(np.zeros((8, 8, 3), np.uint8), 300)


def test_late_tracings_have_the_largest_outlines(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mono, "MONO", replace(MONO, outlines_at_once=2))
    sides = (4, 12, 8, 16)
    boxes = "".join(f'<rect x="{4 + 20 * k}" y="8" width="{side}" height="{side}"/>' for k, side in enumerate(sides))
    tracing = mono_tracing(_picture(boxes), watch=OVER)
    left = tracing.scene.segments[:, 0, 0].numpy().round()
    assert set(left.tolist()) == {24.0, 36.0, 64.0, 80.0}
    assert tracing.speck_count == 2


def test_small_letters_of_a_scan_keep_their_strokes() -> None:
    # Letters of 12 px with strokes of 1.6 px and serifs, blurred by half a pixel as by a scanner.
    letter = "<path d='M2.3 2h9v3h-1l-.6-1.4H5.5v3.8h3.2v1.6H5.5v4h4.4l.8-1.8h1L11 14.6H2.3v-1h1.4V3H2.3z'/>"
    letters = "".join(f"<g transform='translate({8 + 14.3 * k} {8 + 17.4 * j})'>{letter}</g>" for j in range(5)
                      for k in range(6))  # fmt: skip
    svg = f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 100 100' width='100' height='100'>{letters}</svg>"
    clean = draw(svg, 400, 400)
    covered = 1.0 - clean[..., 0].reshape(100, 4, 100, 4).mean((1, 3)) / 255.0
    gray = np.rint(240.0 - 200.0 * gaussian_filter(covered, 0.5)).astype(np.uint8)
    tracing = mono_tracing(np.repeat(gray[..., None], 3, 2))
    traced = draw(write_svg(tracing.scene, 100, 100), 400, 400)
    assert _overlap(traced, clean) > 0.75


def test_long_side_of_a_bar_of_two_levels_is_a_line() -> None:
    picture = np.full((110, 120, 3), 255, np.uint8)
    picture[20:93, 30:32] = picture[94:96, 30:32] = picture[92:100, 10:30] = 0  # a door, not quite at the wall
    angle = np.linspace(0.0, 1.4, 2000)
    picture[(100 - 80 * np.cos(angle)).astype(int), (30 + 80 * np.sin(angle)).astype(int)] = 0
    scene = mono_tracing(picture).scene
    curves = whole_curves(scene)[:, [0, 3]]
    is_side = ((curves[..., 0] - 32.0).abs() < 0.05).all(1) & ((curves[:, 0] - curves[:, 1]).norm(dim=1) > 60.0)
    assert (is_side & scene.structure.lines).sum() == 1

"""How a scene becomes a file: a rounded scene is what the file states, and the file has the right units and size."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from svg_files import make_scene, path_elements

from warpvec.config.presets import make_config
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import STEP_MAX, STEP_SHARE, Encoding
from warpvec.drawing.file_options import FileOptions
from warpvec.image.picture import Picture
from warpvec.svg.document import parse_svg
from warpvec.svg.read import read_svg

WIDTH, HEIGHT = 90, 60


def encoding(fit_size: int = 1024, *, options: FileOptions | None = None, **settings: object) -> Encoding:
    """Return the encoding of a grey picture of 90 x 60 pixels."""
    picture = Picture.of(np.full((HEIGHT, WIDTH, 3), 0.5, np.float32), fit_size)
    return Encoding.of(picture, make_config(mode="photo", **settings), options or FileOptions())  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "settings",
    [{"precision": 2}, {"precision": 0}, {"minify": True}, {"minify": True, "units": 7, "opacity": "opaque"}],
)
def test_the_file_states_the_rounded_scene(settings: dict[str, object]) -> None:
    made = encoding(**settings)
    made = made.of_photo(made.settings)
    scene = make_scene(9, size=(WIDTH, HEIGHT))
    if made.is_minified:
        scene = replace(scene, opacity=torch.full_like(scene.opacity, 0.7))
    rounded = made.round(scene)
    read = read_svg(made.text(rounded).encode()).scene
    units = made.size[1] / WIDTH
    torch.testing.assert_close(read.segments / units, rounded.segments, rtol=0.0, atol=1e-4)
    assert not torch.equal(rounded.segments, scene.segments)
    again = made.round(rounded)
    torch.testing.assert_close(again.segments, rounded.segments, rtol=0.0, atol=1e-5)
    torch.testing.assert_close(read.color, rounded.color)
    torch.testing.assert_close(read.opacity, rounded.opacity)


@pytest.mark.parametrize(("settings", "units"), [({}, 1), ({"minify": True, "units": 8}, 8)])
def test_units_are_finer_and_the_size_stays(settings: dict[str, object], units: int) -> None:
    made = encoding(**settings)
    made = made.of_photo(made.settings)
    root = parse_svg(made.text(made.round(make_scene(2, size=(WIDTH, HEIGHT)))).encode()).root
    assert root.get("viewBox") == f"0 0 {WIDTH * units} {HEIGHT * units}"
    assert (root.get("width"), root.get("height")) == (str(WIDTH), str(HEIGHT))


def test_a_large_picture_of_few_paths_has_coarse_units_in_its_exact_proportions() -> None:
    picture = Picture.of(np.full((1000, 1500, 3), 0.5, np.float32), 64)
    made = Encoding.of(picture, make_config(minify=True, curves=1, mode="photo"))
    made = made.of_photo(made.settings)
    rows, columns = made.size
    assert rows < 1000
    assert columns * 1000 == rows * 1500


@pytest.mark.parametrize("size", [(2667, 4000), (683, 1024), (667, 1000), (512, 768), (401, 401)])
def test_the_units_of_a_photo_are_nearly_those_that_its_paths_need(size: tuple[int, int]) -> None:
    picture = Picture.of(np.full((*size, 3), 0.5, np.float32), 768)
    made = Encoding.of(picture, make_config(minify=True, curves=300, mode="photo"))
    made = made.of_photo(made.settings)
    rows, columns = picture.reduced_size
    wanted = min(STEP_MAX, STEP_SHARE * math.sqrt(rows * columns / 300))
    assert made.grid_step == pytest.approx((wanted, wanted), rel=0.03)
    assert made.size[0] / made.size[1] == pytest.approx(size[0] / size[1], abs=0.01 / made.size[1])


def test_a_given_size_changes_no_coordinate() -> None:
    scene = make_scene(3, size=(WIDTH, HEIGHT))
    plain, sized = encoding(), encoding(options=FileOptions(size="90mm"))
    texts = [made.text(made.round(scene)) for made in (plain, sized)]
    root = parse_svg(texts[1].encode()).root
    assert (root.get("width"), root.get("height")) == ("90mm", "60mm")
    first, second = ([path.get("d") for path in path_elements(text)] for text in texts)
    assert first == second != []


def test_a_drawing_scales_what_was_fitted_to_a_reduced_picture() -> None:
    made = encoding(fit_size=45)
    fitted = make_scene(4, size=(45, 30))
    drawing = Drawing.of(fitted, replace(made, keeps_paths=True), "cpu")
    assert (drawing.scene.segments - 2.0 * fitted.segments).abs().max() < 0.1  # handles have fewer decimals


def test_trimmed_paths_end_at_the_edges_of_the_canvas() -> None:
    made = encoding(options=FileOptions(trim=True))
    scene = make_scene(12, size=(WIDTH, HEIGHT))
    trimmed = made.trim(made.round(scene)).segments
    assert scene.segments.min() < 0.0
    assert trimmed[..., 0].max() <= WIDTH
    assert trimmed.min() >= 0.0

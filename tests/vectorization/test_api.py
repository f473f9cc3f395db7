"""`vectorize`, `refine` and `Result`: units, inputs, file options, and that every number is that of the file."""

from __future__ import annotations

import base64
import gzip
import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from PIL import Image

import warpvec
from warpvec.geometry.cubics import to_cubics
from warpvec.image.metrics import psnr
from warpvec.image.metrics import ssim as ssim_of
from warpvec.image.resize import reduce_image
from warpvec.svg.measure import draw, draw_like
from warpvec.vectorization import api

Photo = NDArray[np.uint8]

SQUARE = '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"><path d="M1 1H7V7H1z" fill="red"/></svg>'


@pytest.fixture
def photo() -> Photo:
    return np.random.default_rng(1).integers(0, 256, (32, 48, 3), dtype=np.uint8)


def _png(photo: Photo) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(photo).save(stream, format="PNG")
    return stream.getvalue()


def _vectorize(photo: Any, curves: int | None = 8, **settings: Any) -> warpvec.Result:
    return warpvec.vectorize(photo, curves, **{"iterations": 3, **settings})


@pytest.mark.usefixtures("quick_fit")
def test_every_kind_of_image_is_the_same_photo(photo: Photo, tmp_path: Path) -> None:
    path = tmp_path / "photo.png"
    path.write_bytes(_png(photo))
    expected = photo.astype(np.float32) / 255
    for image in (photo, _png(photo), Image.fromarray(photo), path, str(path)):
        np.testing.assert_allclose(_vectorize(image).photo, expected, atol=1e-7)


@pytest.mark.usefixtures("quick_fit")
def test_scene_is_in_the_photos_pixels_when_rounding_differs_by_axis() -> None:
    # 100 x 37 reduced to a longest side of 10 is 10 x 4, so the factors are 10 and 9.25.
    result = _vectorize(np.zeros((37, 100, 3), np.uint8), fit_size=10)
    assert result.fitted_size == (4, 10)
    expected = result.fitted.scene.points * torch.tensor([10.0, 9.25])
    for corner in (torch.amin, torch.amax):  # a path may start at another anchor in the file
        torch.testing.assert_close(corner(result.scene.points, 1), corner(expected, 1), atol=0.005 + 1e-5, rtol=0)


@pytest.mark.usefixtures("quick_fit")
@pytest.mark.parametrize("precision", [0, 1, 3])
def test_scene_is_what_the_file_says(photo: Photo, precision: int) -> None:
    result = _vectorize(photo, precision=precision)
    ticks = result.scene.points.double() * 10**precision
    torch.testing.assert_close(ticks, ticks.round(), atol=1e-3, rtol=0)
    decimals = {
        len(digits) for data in re.findall(r' d="(.*?)"', result.svg()) for digits in re.findall(r"\.(\d+)", data)
    }
    assert max(decimals, default=0) == precision


@pytest.mark.usefixtures("quick_fit")
def test_metrics_are_those_of_the_file(photo: Photo) -> None:
    result = _vectorize(photo)
    text, metrics = result.svg(), result.metrics
    drawing = draw(text, 48, 32)
    assert metrics["curves"] == text.count("<path") == 8
    assert metrics["segments"] == 32
    assert metrics["bytes"] == len(text.encode())
    assert len(gzip.compress(text.encode())) * 0.9 < metrics["gzip_bytes"] < metrics["bytes"]
    assert metrics["psnr"] == pytest.approx(psnr(drawing, result.photo))
    assert metrics["ssim"] == pytest.approx(ssim_of(drawing, result.photo))
    assert metrics["internal_psnr"] == pytest.approx(
        psnr(np.rint(result.render() * 255.0) / 255.0, result.photo), abs=1e-4
    )
    assert metrics["mean_opacity"] == 1.0
    assert (metrics["width"], metrics["height"]) == (48, 32)
    assert (metrics["iterations"], metrics["seconds"], metrics["device"]) == (3, 1.5, "cpu")
    assert metrics["interrupted"] is False


@pytest.mark.usefixtures("quick_fit")
def test_the_file_of_sides_has_cubics_that_come_close() -> None:
    # 64 x 96 fitted as 16 x 24: deviations are in pixels of the photo.
    result = _vectorize(np.zeros((64, 96, 3), np.uint8), preset="paper", fit_size=24)
    assert result.fitted.scene.degree == result.metrics["degree"] == 5
    cubics, deviation = to_cubics(result.fitted.scene.scaled(4.0))
    assert result.scene.degree == 3
    assert (result.scene.points - cubics.points).abs().max() <= 0.051  # handles are rounded to 0.1
    assert 0.0 < result.metrics["conversion_px"] == deviation <= 0.05
    assert _vectorize(np.zeros((64, 96, 3), np.uint8)).metrics["conversion_px"] == 0.0


@pytest.mark.usefixtures("quick_fit")
def test_internal_psnr_of_splat_is_that_of_the_soft_image_at_the_fitted_size() -> None:
    photo = np.random.default_rng(1).integers(0, 256, (64, 96, 3), dtype=np.uint8)
    settings: dict[str, Any] = {"samples": 12, "lines": 5}
    result = _vectorize(photo, preset="paper", fit_size=48, **settings)
    soft = warpvec.render(result.fitted.scene, 32, 48, renderer="splat", **settings).numpy()
    np.testing.assert_allclose(result.soft_image(), soft, atol=1e-6)
    reduced = reduce_image(result.photo, 48)
    assert result.metrics["internal_psnr"] == pytest.approx(psnr(np.rint(soft.clip(0, 1) * 255) / 255, reduced))
    assert (result.metrics["renderer"], result.render().shape) == ("splat", (64, 96, 3))
    # What is drawn is the file.
    assert psnr(result.render(), draw(result.svg())) > 35


@pytest.mark.usefixtures("quick_fit")
def test_metrics_of_an_empty_scene_are_numbers(photo: Photo, monkeypatch: pytest.MonkeyPatch) -> None:
    result = _vectorize(photo)
    monkeypatch.setitem(result.__dict__, "scene", result.scene.select(torch.zeros(8, dtype=torch.bool)))
    assert result.metrics["curves"] == 0
    assert result.metrics["mean_opacity"] == 0.0


@pytest.mark.usefixtures("quick_fit")
def test_render_is_the_drawing_of_the_file(photo: Photo) -> None:
    result = _vectorize(photo)
    assert result.render().shape == (32, 48, 3)
    assert result.render().dtype == np.float32
    assert psnr(result.render(), draw(result.svg())) > 35  # what 8-bit anti-aliasing of small circles leaves


@pytest.mark.usefixtures("quick_fit")
def test_render_at_a_scale_draws_the_same_scene_larger(photo: Photo) -> None:
    result = _vectorize(photo)
    twice = result.render(2)
    assert twice.shape == (64, 96, 3)
    means = twice.reshape(32, 2, 48, 2, 3).mean((1, 3))
    # Coverage is exact, so only overlapping edges tell the mean of four pixels from the one pixel they make up.
    assert psnr(means, result.render()) > 40
    assert result.render(0.001).shape == (1, 1, 3)


@pytest.mark.usefixtures("quick_fit")
def test_bands_do_not_change_the_image(photo: Photo, monkeypatch: pytest.MonkeyPatch) -> None:
    result = _vectorize(photo)
    whole = result.render()
    monkeypatch.setattr("warpvec.rendering.draw.BAND_PIXELS", 48 * 7)
    np.testing.assert_allclose(result.render(), whole, atol=1e-5)


@pytest.mark.usefixtures("quick_fit")
@pytest.mark.parametrize("scale", [0, -1, float("nan"), float("inf")])
def test_render_refuses_a_scale_that_is_not_above_zero(photo: Photo, scale: float) -> None:
    with pytest.raises(warpvec.InputError, match="scale must be above 0"):
        _vectorize(photo).render(scale)


@pytest.mark.usefixtures("quick_fit")
def test_save_writes_text_or_gzip_by_the_name(photo: Photo, tmp_path: Path) -> None:
    result = _vectorize(photo)
    result.save(tmp_path / "a.svg")
    result.save(tmp_path / "a.svgz")
    assert (tmp_path / "a.svg").read_text(encoding="utf-8") == result.svg()
    assert gzip.decompress((tmp_path / "a.svgz").read_bytes()).decode() == result.svg()


@pytest.mark.usefixtures("quick_fit")
def test_save_writes_the_picture_of_the_file_as_a_png(photo: Photo, tmp_path: Path) -> None:
    for image in (photo, np.dstack([photo, photo[..., :1]])):
        result = _vectorize(image)
        result.save(tmp_path / "a.PNG")
        with Image.open(tmp_path / "a.PNG") as drawn:
            np.testing.assert_array_equal(drawn, draw_like(result.svg(), result.photo))


@pytest.mark.usefixtures("quick_fit")
def test_save_refuses_other_suffixes(photo: Photo, tmp_path: Path) -> None:
    with pytest.raises(warpvec.InputError, match="^path must end in .svg, .svgz or .png, got .*a.jpg'; rename it$"):
        _vectorize(photo).save(tmp_path / "a.jpg")


@pytest.mark.usefixtures("quick_fit")
def test_a_notebook_shows_the_picture_and_a_line(photo: Photo) -> None:
    result = _vectorize(photo)
    size = f"{len(result.svg().encode()):,}"
    assert repr(result) == f"<Result: 48 x 32, 8 paths, {size} bytes>"
    assert result._repr_svg_() == result.svg()
    psnr = f"{result.metrics['psnr']:.2f}"
    assert repr(result).endswith(f", PSNR {psnr} dB>")
    found = re.search('base64,(.*?)"', result._repr_html_())
    assert found is not None and base64.b64decode(found[1]).decode() == result.svg()


@pytest.mark.usefixtures("quick_fit")
def test_a_file_without_metadata_is_smaller_by_that_alone(photo: Photo) -> None:
    torch.manual_seed(0)
    full = _vectorize(photo).svg()
    torch.manual_seed(0)
    bare = _vectorize(photo, metadata=False)
    assert bare.svg() == re.sub("<metadata>.*</metadata>\n", "", full)
    assert len(full) - len(bare.svg()) > 800
    goal = _vectorize(photo, None, max_bytes=1500, metadata=False)
    assert goal.goal_facts is not None and goal.goal_facts["bytes"] == len(goal.svg().encode())


@pytest.mark.usefixtures("quick_fit")
def test_a_trimmed_file_has_its_points_on_the_canvas(photo: Photo) -> None:
    scenes = []
    for trim in (False, True):
        torch.manual_seed(0)
        scenes.append(_vectorize(photo, trim=trim).scene)
    size = torch.tensor([48.0, 32.0])
    assert scenes[0].points.min() < -1
    assert (scenes[1].points >= -0.051).all() and (scenes[1].points <= size + 0.051).all()


@pytest.mark.usefixtures("quick_fit")
def test_save_into_a_missing_folder_is_an_input_error(photo: Photo, tmp_path: Path) -> None:
    with pytest.raises(warpvec.InputError, match="path must be in an existing folder"):
        _vectorize(photo).save(tmp_path / "missing" / "a.svg")


@pytest.mark.usefixtures("quick_fit")
def test_file_does_not_depend_on_threads_or_on_how_the_device_was_named(photo: Photo) -> None:
    files = []
    for settings in ({"threads": 1}, {"threads": 2}, {"device": "cpu"}):
        torch.manual_seed(3)
        files.append(_vectorize(photo, **settings).svg())
    assert files[0] == files[1] == files[2]
    assert '"seed": 0' in files[0]


@pytest.mark.usefixtures("quick_fit")
def test_title_is_the_stem_of_the_path_and_nothing_more(photo: Photo, tmp_path: Path) -> None:
    path = tmp_path / "my <photo>.png"
    path.write_bytes(_png(photo))
    text = _vectorize(path).svg()
    assert "<title>my &lt;photo&gt;</title>" in text
    assert str(tmp_path) not in text
    assert "<title>" not in _vectorize(photo).svg()


@pytest.mark.usefixtures("quick_fit")
def test_on_progress_is_called_after_every_iteration(photo: Photo) -> None:
    seen: list[int] = []
    result = _vectorize(photo, on_progress=lambda progress: seen.append(progress.iteration))
    assert seen == [1, 2, 3]
    assert result.history == result.fitted.history


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"curves": 0}, "curves must be"),
        ({"preset": "fast"}, "preset must be one of"),
        ({"tempo": 1}, "tempo is not a setting"),
        ({"device": "gpu"}, "device must be .*, got 'gpu'"),
        ({"device": "cuda:x"}, "device must be .*, got 'cuda:x'"),
        ({"device": "cuda:99"}, "device must be .* on this machine, got 'cuda:99'"),
        ({"background": "sea"}, "background must be"),
        ({"trim": 1}, "trim must be True or False, got 1"),
        ({"metadata": "no"}, "metadata must be True or False, got 'no'"),
    ],
)
def test_wrong_arguments_are_input_errors(photo: Photo, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(warpvec.InputError, match=message) as caught:
        warpvec.vectorize(photo, **arguments)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "image",
    [
        "no such file.png",
        b"not an image",
        b"",
        7,
        np.zeros((0, 4, 3), np.uint8),
        np.zeros((4, 4, 7), np.uint8),
        np.full((4, 4, 3), np.nan, np.float32),
    ],
)
def test_wrong_images_are_input_errors(image: Any) -> None:
    with pytest.raises(warpvec.InputError, match="^image must") as caught:
        warpvec.vectorize(image)
    assert "\n" not in str(caught.value)


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


def test_evaluate_measures_any_svg(photo: Photo) -> None:
    svg = '<svg xmlns="http://www.w3.org/2000/svg" width="48" height="32"><path d="M0 0H48V32H0z" fill="gray"/></svg>'
    facts = api.evaluate(svg, photo)
    grey = np.full_like(photo, 0x80)
    assert facts["curves"] == 1
    assert facts["segments"] == 3
    assert facts["psnr"] == pytest.approx(psnr(grey, photo))


def test_the_real_fit_comes_near_the_photo() -> None:
    ramp = np.linspace(0, 255, 48).astype(np.uint8)
    photo = np.broadcast_to(ramp[None, :, None], (32, 48, 3)).copy()
    result = warpvec.vectorize(photo, curves=16, iterations=60, inflation_gap=10)
    flat = psnr(np.full_like(photo, photo.mean()), photo)
    assert result.metrics["curves"] <= 16
    assert result.metrics["psnr"] > flat + 6  # the error of one flat colour, halved
    assert abs(result.metrics["internal_psnr"] - result.metrics["psnr"]) < 0.5


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (20, 20)])
def test_tiny_and_one_coloured_images_work(shape: tuple[int, int]) -> None:
    photo = np.full((*shape, 3), 51, np.uint8)
    result = warpvec.vectorize(photo, curves=4, iterations=20)
    drawing = draw(result.svg(), shape[1], shape[0])
    assert np.abs(drawing.astype(int) - 51).max() <= 3

"""`Result`: units, file options, saved files, and that every number is that of the file."""

from __future__ import annotations

import base64
import gzip
import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image
from short_fits import Photo, vectorize_briefly

import warpvec
from warpvec.drawing.drawing import Drawing
from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.softness import Softness
from warpvec.image.metrics import psnr
from warpvec.image.metrics import ssim as ssim_of
from warpvec.image.picture import reduce_image
from warpvec.svg.measure import draw, draw_like
from warpvec.watch.watch import RunFacts
from warpvec.writers.registry import WRITERS, listed


@pytest.mark.usefixtures("quick_fit")
def test_scene_is_in_the_photos_pixels_when_rounding_differs_by_axis() -> None:
    # 100 x 37 reduced to a longest side of 10 is 10 x 4, so the factors are 10 and 9.25.
    result = vectorize_briefly(np.zeros((37, 100, 3), np.uint8), fit_size=10)
    assert result.picture.reduced_size == (4, 10)
    expected = result.drawing.fitted.points * torch.tensor([10.0, 9.25])
    for corner in (torch.amin, torch.amax):  # a path may start at another anchor in the file
        torch.testing.assert_close(corner(result.scene.points, 1), corner(expected, 1), atol=0.005 + 1e-5, rtol=0)


@pytest.mark.usefixtures("quick_fit")
@pytest.mark.parametrize("precision", [0, 1, 3])
def test_scene_is_what_the_file_says(photo: Photo, precision: int) -> None:
    result = vectorize_briefly(photo, precision=precision)
    ticks = result.scene.points.double() * 10**precision
    torch.testing.assert_close(ticks, ticks.round(), atol=1e-3, rtol=0)
    decimals = {
        len(digits) for data in re.findall(r' d="(.*?)"', result.svg()) for digits in re.findall(r"\.(\d+)", data)
    }
    assert max(decimals, default=0) == precision


@pytest.mark.usefixtures("quick_fit")
def test_metrics_are_those_of_the_file(photo: Photo) -> None:
    result = vectorize_briefly(photo)
    text, metrics = result.svg(), result.metrics
    drawing = draw(text, 48, 32)
    assert metrics["curves"] == text.count("<path") == 8
    assert metrics["segments"] == 32
    assert metrics["bytes"] == len(text.encode())
    assert len(gzip.compress(text.encode())) * 0.9 < metrics["gzip_bytes"] < metrics["bytes"]
    assert metrics["psnr"] == pytest.approx(psnr(drawing, result.picture.pixels))
    assert metrics["ssim"] == pytest.approx(ssim_of(drawing, result.picture.pixels))
    assert metrics["internal_psnr"] == pytest.approx(
        psnr(np.rint(result.render() * 255.0) / 255.0, result.picture.pixels), abs=1e-4
    )
    assert metrics["mean_opacity"] == 1.0
    assert (metrics["width"], metrics["height"]) == (48, 32)
    assert (metrics["iterations"], metrics["seconds"], metrics["device"]) == (3, result.run.seconds, "cpu")
    assert metrics["interrupted"] is False


@pytest.mark.usefixtures("quick_fit")
def test_the_file_of_sides_has_cubics_that_come_close() -> None:
    # 64 x 96 fitted as 16 x 24: deviations are in pixels of the photo.
    result = vectorize_briefly(np.zeros((64, 96, 3), np.uint8), preset="paper", fit_size=24)
    assert result.drawing.fitted.degree == result.metrics["degree"] == 5
    cubics, deviation = to_cubics(result.drawing.fitted.scaled(4.0))
    assert result.scene.degree == 3
    assert (result.scene.points - cubics.points).abs().max() <= 0.051  # handles are rounded to 0.1
    assert 0.0 < result.metrics["conversion_px"] == deviation <= 0.05
    assert vectorize_briefly(np.zeros((64, 96, 3), np.uint8)).metrics["conversion_px"] == 0.0


@pytest.mark.usefixtures("quick_fit")
def test_internal_psnr_of_splat_is_that_of_the_soft_image_at_the_fitted_size() -> None:
    photo = np.random.default_rng(1).integers(0, 256, (64, 96, 3), dtype=np.uint8)
    settings: dict[str, Any] = {"samples": 12, "lines": 5}
    result = vectorize_briefly(photo, preset="paper", fit_size=48, **settings)
    soft = warpvec.render(result.drawing.fitted, 32, 48, renderer="splat", **settings).numpy()
    np.testing.assert_allclose(result.soft_image(), soft, atol=1e-6)
    reduced = reduce_image(result.picture.pixels, 48)
    assert result.metrics["internal_psnr"] == pytest.approx(psnr(np.rint(soft.clip(0, 1) * 255) / 255, reduced))
    assert (result.metrics["renderer"], result.render().shape) == ("splat", (64, 96, 3))
    # What is drawn is the file.
    assert psnr(result.render(), draw(result.svg())) > 35


@pytest.mark.usefixtures("quick_fit")
def test_metrics_of_an_empty_scene_are_numbers(photo: Photo) -> None:
    drawing = vectorize_briefly(photo).drawing
    empty = replace(drawing, scene=drawing.scene.select(torch.zeros(8, dtype=torch.bool)))
    result = warpvec.Result(empty, RunFacts([], 0, 0.0, False))
    assert result.metrics["curves"] == 0
    assert result.metrics["mean_opacity"] == 0.0


@pytest.mark.usefixtures("quick_fit")
def test_render_is_the_drawing_of_the_file(photo: Photo) -> None:
    result = vectorize_briefly(photo)
    assert result.render().shape == (32, 48, 3)
    assert result.render().dtype == np.float32
    assert psnr(result.render(), draw(result.svg())) > 35  # what 8-bit anti-aliasing of small circles leaves


@pytest.mark.usefixtures("quick_fit")
def test_render_at_a_scale_draws_the_same_scene_larger(photo: Photo) -> None:
    result = vectorize_briefly(photo)
    twice = result.render(2)
    assert twice.shape == (64, 96, 3)
    means = twice.reshape(32, 2, 48, 2, 3).mean((1, 3))
    # Coverage is exact, so only overlapping edges tell the mean of four pixels from the one pixel they make up.
    assert psnr(means, result.render()) > 40
    assert result.render(0.001).shape == (1, 1, 3)


@pytest.mark.usefixtures("quick_fit")
def test_bands_do_not_change_the_image(photo: Photo, monkeypatch: pytest.MonkeyPatch) -> None:
    result = vectorize_briefly(photo)
    whole = result.render()
    monkeypatch.setattr("warpvec.rendering.draw.BAND_PIXELS", 48 * 7)
    np.testing.assert_allclose(result.render(), whole, atol=1e-5)


@pytest.mark.usefixtures("quick_fit")
@pytest.mark.parametrize("scale", [0, -1, float("nan"), float("inf")])
def test_render_refuses_a_scale_that_is_not_above_zero(photo: Photo, scale: float) -> None:
    with pytest.raises(warpvec.InputError, match="scale must be above 0"):
        vectorize_briefly(photo).render(scale)


@pytest.mark.usefixtures("quick_fit")
def test_save_writes_text_or_gzip_by_the_name(photo: Photo, tmp_path: Path) -> None:
    result = vectorize_briefly(photo)
    result.save(tmp_path / "a.svg")
    result.save(tmp_path / "a.svgz")
    assert (tmp_path / "a.svg").read_text(encoding="utf-8") == result.svg()
    assert gzip.decompress((tmp_path / "a.svgz").read_bytes()).decode() == result.svg()


@pytest.mark.usefixtures("quick_fit")
def test_save_writes_the_picture_of_the_file_as_a_png(photo: Photo, tmp_path: Path) -> None:
    for image in (photo, np.dstack([photo, photo[..., :1]])):
        result = vectorize_briefly(image)
        result.save(tmp_path / "a.PNG")
        with Image.open(tmp_path / "a.PNG") as drawn:
            np.testing.assert_array_equal(drawn, draw_like(result.svg(), result.picture.pixels))


@pytest.mark.usefixtures("quick_fit")
def test_save_warns_of_soft_paths_that_a_file_draws_sharp(photo: Photo, tmp_path: Path) -> None:
    pytest.importorskip("ezdxf")
    result = vectorize_briefly(photo)
    soft = replace(result.scene, softness=Softness(torch.ones(len(result.scene))))
    result = result.with_drawing(Drawing.of(soft, result.encoding, "cpu"))
    with pytest.warns(UserWarning, match=rf"^not kept in \.dxf: the blur of {len(soft)} soft paths$"):
        result.save(tmp_path / "drawing.dxf")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result.save(tmp_path / "drawing.svg")


def test_save_refuses_other_suffixes(photo: Photo, tmp_path: Path) -> None:
    message = f"^path must end in {listed(tuple(WRITERS))}, got .*a.jpg'; rename it$"
    with pytest.raises(warpvec.InputError, match=message):
        vectorize_briefly(photo).save(tmp_path / "a.jpg")


@pytest.mark.usefixtures("quick_fit")
def test_a_notebook_shows_the_picture_and_a_line(photo: Photo) -> None:
    result = vectorize_briefly(photo)
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
    full = vectorize_briefly(photo).svg()
    torch.manual_seed(0)
    bare = vectorize_briefly(photo, metadata=False)
    assert bare.svg() == re.sub("<metadata>.*</metadata>\n", "", full)
    assert len(full) - len(bare.svg()) > 800
    goal = vectorize_briefly(photo, None, max_bytes=1500, metadata=False)
    assert goal.drawing.goal_facts is not None and goal.drawing.goal_facts["bytes"] == len(goal.svg().encode())


@pytest.mark.usefixtures("quick_fit")
@pytest.mark.parametrize("gradients", [0, 3])
def test_metadata_name_gradients_only_where_they_were_asked_for(photo: Photo, gradients: float) -> None:
    result = vectorize_briefly(photo, gradients=gradients)
    found = re.search("<metadata>(.*)</metadata>", result.svg())
    assert found is not None and ("gradients" in found[1]) == (gradients > 0)


@pytest.mark.usefixtures("quick_fit")
def test_a_trimmed_file_has_its_points_on_the_canvas(photo: Photo) -> None:
    scenes = []
    for trim in (False, True):
        torch.manual_seed(0)
        scenes.append(vectorize_briefly(photo, trim=trim).scene)
    size = torch.tensor([48.0, 32.0])
    assert scenes[0].segments.min() < -1
    assert (scenes[1].segments >= -0.051).all() and (scenes[1].segments <= size + 0.051).all()


@pytest.mark.usefixtures("quick_fit")
def test_save_into_a_missing_folder_is_an_input_error(photo: Photo, tmp_path: Path) -> None:
    with pytest.raises(warpvec.InputError, match="path must be in an existing folder"):
        vectorize_briefly(photo).save(tmp_path / "missing" / "a.svg")

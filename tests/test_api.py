"""`vectorize`: inputs, wrong arguments, and fits of small pictures."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image
from short_fits import Photo, vectorize_briefly

import warpvec
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw, evaluate


def _png(photo: Photo) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(photo).save(stream, format="PNG")
    return stream.getvalue()


@pytest.mark.usefixtures("quick_fit")
def test_every_kind_of_image_is_the_same_photo(photo: Photo, tmp_path: Path) -> None:
    path = tmp_path / "photo.png"
    path.write_bytes(_png(photo))
    expected = photo.astype(np.float32) / 255
    for image in (photo, _png(photo), Image.fromarray(photo), path, str(path)):
        np.testing.assert_allclose(vectorize_briefly(image).picture.pixels, expected, atol=1e-7)


@pytest.mark.usefixtures("quick_fit")
def test_file_does_not_depend_on_threads_or_on_how_the_device_was_named(photo: Photo) -> None:
    files = []
    for settings in ({"threads": 1}, {"threads": 2}, {"device": "cpu"}):
        torch.manual_seed(3)
        files.append(vectorize_briefly(photo, **settings).svg())
    assert files[0] == files[1] == files[2]
    assert '"seed": 0' in files[0]


@pytest.mark.usefixtures("quick_fit")
def test_title_is_the_stem_of_the_path_and_nothing_more(photo: Photo, tmp_path: Path) -> None:
    path = tmp_path / "my <photo>.png"
    path.write_bytes(_png(photo))
    text = vectorize_briefly(path).svg()
    assert "<title>my &lt;photo&gt;</title>" in text
    assert str(tmp_path) not in text
    assert "<title>" not in vectorize_briefly(photo).svg()


@pytest.mark.usefixtures("quick_fit")
def test_on_progress_is_called_after_every_iteration(photo: Photo) -> None:
    seen: list[int] = []
    result = vectorize_briefly(photo, on_progress=lambda progress: seen.append(progress.iteration))
    assert seen == [1, 2, 3]
    assert [entry["iteration"] for entry in result.history] == [1, 2, 3]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"curves": 0}, "curves must be"),
        ({"curves": np.array([1, 2])}, "curves must be"),
        ({"max_bytes": 10**400}, "max_bytes must be"),
        ({"preset": "fast"}, "preset must be one of"),
        ({"tempo": 1}, "tempo is not a setting"),
        ({"target_psn": 30}, "target_psn is not a setting; did you mean target_psnr?"),
        ({"flat": True, "one_generation": False}, "one_generation must not be given with its former name flat"),
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


def test_evaluate_measures_any_svg(photo: Photo) -> None:
    svg = '<svg xmlns="http://www.w3.org/2000/svg" width="48" height="32"><path d="M0 0H48V32H0z" fill="gray"/></svg>'
    facts = evaluate(svg, photo / np.float32(255))
    grey = np.full_like(photo, 0x80)
    assert facts["curves"] == 1
    assert facts["segments"] == 4
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


def test_a_drawing_with_gradients_of_many_stops_is_refined_to_more_paths() -> None:
    text = """<svg xmlns="http://www.w3.org/2000/svg" width="48" height="32"><defs>
<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="48" y2="0"><stop offset="0" stop-color="#000"/>
<stop offset=".3" stop-color="#f00" stop-opacity=".5"/><stop offset="1" stop-color="#fff"/></linearGradient></defs>
<path fill="url(#a)" d="M4 4h40v24h-40z"/></svg>"""
    result = warpvec.refine(draw(text, 48, 32), text, curves=3, iterations=4)
    assert 1 <= len(result.scene) <= 3 and "linearGradient" in result.svg()


def test_what_is_no_scene_is_refused_in_one_line() -> None:
    with pytest.raises(warpvec.InputError, match=r"^scene must be a warpvec\.Scene, got str"):
        warpvec.render("x")  # type: ignore[arg-type]

"""Placeholders: their bytes, their text, and that the fit sees what a viewer shows."""

from __future__ import annotations

from urllib.parse import unquote

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from PIL import Image, ImageDraw

import warpvec
from warpvec.errors import InputError
from warpvec.image.metrics import psnr
from warpvec.placeholders.canvas import BlurredCanvas, Shapes, rounded
from warpvec.placeholders.placeholder import _view_box, fit_placeholder
from warpvec.placeholders.text import PREFIX, data_uri, placeholder_svg
from warpvec.svg.measure import draw


@pytest.fixture(scope="module")
def picture() -> Image.Image:
    """A sunset over waves, 300 x 200."""
    image = Image.new("RGB", (300, 200), (250, 190, 120))
    pen = ImageDraw.Draw(image)
    pen.rectangle((0, 120, 300, 200), fill=(40, 60, 110))
    pen.ellipse((180, 60, 250, 130), fill=(255, 240, 200))
    pen.polygon([(0, 150), (60, 60), (130, 150)], fill=(50, 40, 30))
    heights = np.random.default_rng(0).integers(-40, 40, (5, 8, 1)).repeat(3, 2)
    waves = np.asarray(Image.fromarray((120 + heights).astype(np.uint8)).resize((300, 200), Image.Resampling.BICUBIC))
    return Image.fromarray((np.asarray(image) + (waves / 255.0 - 0.5) * 120).clip(0, 255).astype(np.uint8))


def _drawn(uri: str, width: int, height: int) -> NDArray[np.uint8]:
    return draw(unquote(uri.removeprefix(PREFIX)), width, height)


@pytest.fixture(scope="module")
def placeholders(picture: Image.Image) -> dict[int, str]:
    """Data URIs by the bytes that they may have."""
    return {size: warpvec.placeholder(picture, size) for size in (300, 1_000)}


def test_the_bytes_are_used_and_not_exceeded(placeholders: dict[int, str]) -> None:
    for size, uri in placeholders.items():
        assert 0.8 * size <= len(uri) == len(uri.encode()) <= size


def test_more_bytes_show_more_and_a_thousand_are_close(picture: Image.Image, placeholders: dict[int, str]) -> None:
    few, many = (psnr(_drawn(placeholders[size], 300, 200), np.asarray(picture)) for size in (300, 1_000))
    assert few + 2.0 < many > 22.0


def test_the_same_image_gives_the_same_text(picture: Image.Image, placeholders: dict[int, str]) -> None:
    assert warpvec.placeholder(np.asarray(picture), 300) == placeholders[300]


def test_an_empty_picture_needs_a_background_only() -> None:
    found = fit_placeholder(np.full((40, 60, 3), 0.8, np.float32), 300)
    assert found.shape_count == 0 and found.uri == data_uri(found.svg)
    assert (_drawn(found.uri, 60, 40) == 204).all()


def test_a_thread_of_pixels_is_refused_in_a_line() -> None:
    with pytest.raises(InputError, match="^image must be at most 50 times as long as wide .* 5 x 400; crop it$"):
        warpvec.placeholder(Image.new("RGB", (5, 400)))


def test_what_lies_behind_a_transparent_image_shows() -> None:
    clear = Image.new("RGBA", (60, 40), (0, 0, 0, 0))
    assert (_drawn(warpvec.placeholder(clear, 300, background="#0f0"), 60, 40) == (0, 255, 0)).all()


@pytest.mark.parametrize("size", [299, 5_001, 400.5, True])
def test_bytes_out_of_range_are_refused(picture: Image.Image, size: int) -> None:
    with pytest.raises(InputError, match="^max_bytes must be a whole number from 300 to 5000"):
        warpvec.placeholder(picture, size)


def test_the_uri_encodes_what_would_end_it_and_has_no_double_quotes() -> None:
    uri = data_uri("<path fill='#123' d='m0 0'/>%")
    assert uri == PREFIX + "<path fill='%23123' d='m0 0'/>%25"


@pytest.mark.parametrize("size", [(768, 512), (4000, 3000), (1080, 1920), (1234, 567), (1, 1), (500, 10)])
def test_the_view_box_has_the_proportions_of_the_image(size: tuple[int, int]) -> None:
    width, height = _view_box(*size, 96)
    assert max(width, height) in range(86, 97) and min(width, height) >= 1
    assert width / height == pytest.approx(size[0] / size[1], rel=0.5 / min(width, height))


def _shapes() -> Shapes:
    random = torch.Generator().manual_seed(3)
    corners = torch.tensor([[20.0, 14.0]]) + 26.0 * (torch.rand(5, 4, 2, generator=random) - 0.5)
    return Shapes(corners, torch.rand(5, 3, generator=random), torch.tensor([0.3, 0.6, 0.2]))


@pytest.mark.parametrize("deviation", [0.0, 1.0])
def test_the_fit_sees_what_a_viewer_shows(deviation: float) -> None:
    target = torch.zeros(28, 40, 3)
    _, residual = BlurredCanvas(target, deviation).step(rounded(_shapes()))
    seen = draw(placeholder_svg(_shapes(), 40, 28, deviation), 40, 28)
    assert psnr((target - residual).numpy().clip(0.0, 1.0), seen) > 37.0


def test_shapes_without_an_area_are_left_out() -> None:
    shapes = _shapes()
    shapes.corners[2] = torch.tensor([[5.2, 5.0], [5.0, 5.3], [9.0, 7.0], [9.0, 7.1]])
    assert placeholder_svg(shapes, 40, 28, 1.0).count("<path") == 1 + 4


@pytest.mark.parametrize("deviation", [0.0, 1.3])
def test_the_adjoints_are_the_slopes_of_the_error(deviation: float) -> None:
    canvas, shapes = (
        BlurredCanvas(torch.rand(28, 40, 3, generator=torch.Generator().manual_seed(1)), deviation),
        _shapes(),
    )
    adjoints, _ = canvas.step(shapes)
    random = torch.Generator().manual_seed(2)
    for index, step in ((0, 0.02), (1, 0.01), (2, 0.01)):
        direction = torch.randn(shapes[index].shape, generator=random)

        def loss(distance: float, index: int = index, direction: torch.Tensor = direction) -> float:
            moved = shapes._replace(**{Shapes._fields[index]: shapes[index] + distance * direction})
            return float(canvas.step(moved)[1].double().square().mean())

        slope = (loss(step) - loss(-step)) / (2 * step)
        assert float((adjoints[index] * direction).sum()) == pytest.approx(slope, rel=0.05, abs=1e-5)

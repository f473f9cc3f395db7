"""The kernel that a picture was reduced with is told from the rims at its edges, which are undone."""

from __future__ import annotations

import numpy as np
import pytest
from damage import as_jpeg, drawn, enlarged, levels_of
from PIL import Image, ImageDraw, ImageFont
from PIL.Image import Resampling
from scipy import ndimage

import warpvec
from warpvec.arrays import Floats32
from warpvec.condition.condition import measure_condition
from warpvec.condition.reduction import find_reduction
from warpvec.condition.unrimming import without_rims
from warpvec.image.alpha import premultiplied
from warpvec.svg.measure import draw


def reduced(width: int, kernel: Resampling) -> Image.Image:
    """Return a drawing that was drawn large, and reduced to ``width`` by ``kernel``."""
    large = drawn(8 * width)
    return large.resize((width, large.height // 8), kernel)


def error(image: Image.Image | Floats32, truth: Image.Image) -> float:
    """Return the root mean square of the difference, in levels."""
    levels = levels_of(image) if isinstance(image, Image.Image) else 255.0 * image
    return float(np.sqrt(np.mean((levels - levels_of(truth)) ** 2)))


@pytest.mark.parametrize("kernel", [Resampling.BICUBIC, Resampling.LANCZOS])
def test_a_kernel_that_leaves_rims_is_found(kernel: Resampling) -> None:
    assert find_reduction(levels_of(reduced(120, kernel))) == kernel.name.lower()


@pytest.mark.parametrize("kernel", [Resampling.BOX, Resampling.BILINEAR])
def test_edges_without_rims_are_left_alone(kernel: Resampling) -> None:
    assert find_reduction(levels_of(reduced(120, kernel))) is None


def test_a_reduction_is_found_before_an_enlargement_too_but_not_in_a_jpeg() -> None:
    small = reduced(120, Resampling.LANCZOS)
    found = [
        measure_condition(np.asarray(image, np.float32) / 255.0)
        for large in [enlarged(small, 3.0, Resampling.BICUBIC)]
        for image in (small, large, as_jpeg(large, 80, subsampling=0))
    ]
    assert found[2].enlargement is not None
    assert [each.reduction for each in found] == ["lanczos", "lanczos", None]
    assert found[0].words == "reduced (lanczos)"
    assert "reduced before that (lanczos)" in str(found[1].words)


def test_rims_stay_in_a_picture_of_gradients_that_was_not_enlarged() -> None:
    large = drawn(8 * 120)
    ramp = Image.linear_gradient("L").resize(large.size).convert("RGB")
    ramp.paste(large, mask=large.convert("L").point(lambda level: 255 * (level < 200)))
    small = ramp.resize((120, large.height // 8), Resampling.LANCZOS)
    assert find_reduction(levels_of(small)) == "lanczos"
    assert measure_condition(np.asarray(small, np.float32) / 255.0).reduction is None


@pytest.mark.parametrize("kernel", [Resampling.BICUBIC, Resampling.LANCZOS])
def test_rims_are_undone(kernel: Resampling) -> None:
    given, truth = reduced(120, kernel), reduced(120, Resampling.BOX)
    undone = without_rims(levels_of(given).astype(np.float32) / 255.0, kernel.name.lower())
    assert error(undone, truth) < 0.6 * error(given, truth)


@pytest.mark.parametrize("kernel", [Resampling.BICUBIC, Resampling.LANCZOS])
def test_rims_of_a_transparent_picture_are_undone(kernel: Resampling) -> None:
    large = Image.new("RGBA", (8 * 96, 8 * 64))
    pen = ImageDraw.Draw(large)
    pen.rounded_rectangle((70, 60, 690, 450), 90, fill=(30, 90, 200, 255))
    pen.ellipse((200, 130, 480, 410), fill=(255, 220, 90, 255))
    given, truth = (np.asarray(large.resize((96, 64), each), np.float32) / 255.0 for each in (kernel, Resampling.BOX))
    condition = measure_condition(given)
    assert condition.reduction == kernel.name.lower()
    assert measure_condition(truth).reduction is None
    undone = without_rims(premultiplied(given), condition.reduction)
    before, after = (np.abs(each - premultiplied(truth)).mean() for each in (premultiplied(given), undone))
    assert after < 0.5 * before


def test_rims_stay_where_time_is_short() -> None:
    given = levels_of(reduced(120, Resampling.LANCZOS)).astype(np.float32) / 255.0
    assert without_rims(given, "lanczos", seconds=0.1) is given
    assert without_rims(given, "lanczos", seconds=60.0) is not given


def test_steps_of_few_colors_are_no_rims() -> None:
    star = Image.new("RGB", (128, 128), "white")
    for angle in np.arange(12) * np.pi / 6:
        way = np.array([np.cos(angle), np.sin(angle)])
        ImageDraw.Draw(star).line((*(64 + 10 * way), *(64 + 57 * way)), (30, 60, 160), 4)
    ImageDraw.Draw(star).ellipse((38, 38, 90, 90), outline=(220, 60, 40), width=4)
    assert measure_condition(np.asarray(star, np.float32) / 255.0).reduction is None


def test_edges_with_rims_among_as_many_without_are_no_reduction() -> None:
    """Lines beside edges, and letters, look like rims; a reduction leaves some at nearly every edge."""
    rimmed, plain = reduced(120, Resampling.LANCZOS), reduced(80, Resampling.BOX)
    page = Image.new("RGB", (rimmed.width, rimmed.height + plain.height), "white")
    page.paste(rimmed, (0, 0))
    page.paste(plain, (0, rimmed.height))
    assert find_reduction(levels_of(page)) is None


def test_a_drawing_is_made_of_the_picture_without_rims() -> None:
    given, truth = reduced(120, Resampling.LANCZOS), levels_of(reduced(120, Resampling.BOX)) / 255.0
    results = [
        warpvec.vectorize(np.asarray(given), mode="flat", as_is=each, threads=1, iterations=2) for each in (False, True)
    ]
    assert "reduced (lanczos)" in results[0].metrics["condition_words"]
    undone, as_is = (np.abs(each.drawing.encoding.picture.reduced - truth).mean() for each in results)
    assert undone < 0.6 * as_is


def test_small_text_loses_its_rims_and_keeps_its_colors() -> None:
    ground, ink = (233, 239, 216), (68, 68, 68)
    large = Image.new("RGB", (4 * 100, 4 * 40), ground)
    font = ImageFont.load_default(4 * 13)
    ImageDraw.Draw(large).text((4 * 12, 4 * 12), "Harbour St.", ink, font)
    given, truth = (large.resize((100, 40), kernel) for kernel in (Resampling.LANCZOS, Resampling.BOX))
    undone = 255.0 * without_rims(levels_of(given).astype(np.float32) / 255.0, "lanczos")
    is_lighter = (levels_of(given) > np.array(ground) + 5.0).any(2)
    assert is_lighter.sum() > 50
    assert (undone[is_lighter] <= np.array(ground) + 2.0).all()
    assert error(undone / 255.0, truth) < 0.3 * error(given, truth)


@pytest.mark.parametrize(("fill", "outline", "paper"), [("#1f77b4", "#000", "#fff"), ("#346", "#fff", "#eee")])
def test_outlines_of_a_pixel_are_no_rims(fill: str, outline: str, paper: str) -> None:
    blocks = "".join(
        f'<rect x="{8 + 30 * k}" y="{18 + 38 * row}" width="22" height="28" fill="{fill}" stroke="{outline}"/>'
        for k in range(8)
        for row in range(4)
    )
    size = 'width="256" height="180"'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><rect {size} fill="{paper}"/>{blocks}</svg>'
    assert find_reduction(draw(text, 256, 180).astype(np.float64)) is None


def test_a_shadow_beside_a_white_card_is_no_rim() -> None:
    levels = np.full((96, 120, 3), 255.0)
    inside = np.zeros((96, 120))
    inside[24:70, 30:80] = 1.0
    levels -= 150.0 * ndimage.gaussian_filter(inside, 4.0)[..., None]
    levels[22:68, 30:80] = 255.0
    assert find_reduction(levels.round()) is None


def test_bars_with_a_darker_outline_on_whole_pixels_have_no_rims() -> None:
    levels = np.full((280, 400, 3), 255.0)
    for k in range(10):
        top, left = 12 + 26 * k, 20 + 32 * k
        for inset, color in enumerate([(156.0, 182.0, 235.0), (74.0, 127.0, 233.0), (91.0, 143.0, 249.0)]):
            levels[top + inset : top + 18 - inset, left + inset : left + 70 - inset] = color
    assert find_reduction(levels) is None

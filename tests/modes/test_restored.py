"""An enlarged picture is drawn as it was before, at the size that it has now."""

from __future__ import annotations

import numpy as np
import pytest
from cards import card
from damage import blurred, drawn, enlarged, levels_of, noisy, unevenly_lit
from PIL import Image, ImageDraw
from PIL.Image import Resampling

import warpvec
from warpvec.condition.condition import Condition
from warpvec.condition.restoration import before_enlargement
from warpvec.config.fit_config import FitConfig
from warpvec.goals.goal import make_goal
from warpvec.image.metrics import psnr
from warpvec.modes.choice import suited_mode
from warpvec.modes.request import Request
from warpvec.modes.restored import Restoration, measured, restored
from warpvec.svg.measure import draw
from warpvec.watch.progress import Progress

WIDTH, FACTOR = 80, 5


def drawing_of(image: Image.Image, **options: object) -> warpvec.Result:
    return warpvec.vectorize(np.asarray(image), iterations=4, threads=1, strokes="off", **options)


def test_rims_of_a_reduction_before_the_enlargement_are_not_drawn() -> None:
    kept, undone = {}, {}
    for kernel in (Resampling.BOX, Resampling.LANCZOS):
        small = drawn(8 * WIDTH).resize((WIDTH, round(0.8 * WIDTH)), kernel)
        large = levels_of(enlarged(small, FACTOR, Resampling.BICUBIC)) / 255.0
        request = Request.of(large.astype(np.float32), FitConfig())
        condition = measured(request)
        assert condition is not None and condition.enlargement is not None
        kept[kernel] = before_enlargement(request.picture.pixels, condition.enlargement)
        undone[kernel] = restored(request, condition).picture.reduced
    means = kept[Resampling.BOX]
    assert np.array_equal(undone[Resampling.BOX], means)
    assert psnr(undone[Resampling.LANCZOS], means) > psnr(kept[Resampling.LANCZOS], means) + 3.0


@pytest.mark.slow
def test_an_enlarged_drawing_gets_the_edges_of_its_original() -> None:
    original = levels_of(drawn(WIDTH * FACTOR))
    large = enlarged(drawn(WIDTH), FACTOR, Resampling.BICUBIC)
    restored, as_is = drawing_of(large), drawing_of(large, as_is=True, mode="flat")
    size = (large.width, large.height)
    errors = [psnr(draw(result.svg(), *size), original.astype(np.float32) / 255.0) for result in (restored, as_is)]
    assert errors[0] > errors[1] + 2.0
    assert len(restored.scene.segments) < len(as_is.scene.segments)
    assert (restored.picture.width, restored.picture.height) == size
    assert restored.metrics["condition"]["enlarged"]["width"] == WIDTH
    assert restored.metrics["psnr_as_fitted"] > restored.metrics["psnr"]
    assert as_is.metrics["condition"] is None


def test_a_blurred_drawing_gets_sharp_edges() -> None:
    text = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 96 80"><path fill="#06c" d="M9 70 40 9l47 50z"/></svg>'
    original = Image.fromarray(draw(text, 96, 80))
    sharp, as_is = (drawing_of(blurred(original, 1.5), blur=blur) for blur in ("1.5", "0"))
    pixels = np.asarray(original)
    errors = [psnr(draw(result.svg(), 96, 80), pixels) for result in (sharp, as_is)]
    assert errors[0] > errors[1] + 3.0
    assert len(sharp.scene.segments) < len(as_is.scene.segments)
    assert sharp.metrics["blur_undone"] == pytest.approx(1.5) and as_is.metrics["blur_undone"] == 0.0
    assert sharp.metrics["psnr_as_fitted"] > sharp.metrics["psnr"]
    assert "texture" not in sharp.metrics["not_kept"]


def test_a_blurred_drawing_in_black_is_no_photo_and_no_shades() -> None:
    text = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 160 120"><path d="M20 100V20h14l22 55 22-55h14v80H80'
    picture = blurred(
        Image.fromarray(draw(text + 'V44L60 100h-9L31 44v56zM104 20h40v12h-14v68h-12V32h-14z"/></svg>', 160, 120)), 2.0
    )
    found = Restoration.of(Request.of(np.asarray(picture, np.float32) / np.float32(255.0), FitConfig()))
    choice, textures = suited_mode(found.request, found.condition)
    assert (choice.mode, textures) == ("mono", None)


def test_a_given_blur_is_in_pixels_of_the_picture() -> None:
    pixels = (levels_of(enlarged(drawn(WIDTH), FACTOR, Resampling.BICUBIC)) / 255.0).astype(np.float32)
    for as_is, expected in ((False, 1.0), (True, FACTOR)):
        request = Request.of(pixels, FitConfig(blur=str(FACTOR), as_is=as_is))
        assert restored(request, measured(request)).picture.blur == pytest.approx(expected)


def test_a_clean_drawing_is_drawn_as_it_is() -> None:
    clean = drawn(WIDTH)
    result = drawing_of(clean, metadata=False)
    assert result.svg() == drawing_of(clean, as_is=True, metadata=False).svg()
    assert result.metrics["condition_words"] is None


def test_rectangles_on_a_grid_are_no_enlargement() -> None:
    image = Image.new("RGB", (90, 60), "white")
    paint = ImageDraw.Draw(image)
    for box, color in (((20, 10, 39, 29), "#c81e28"), ((40, 30, 59, 49), "#1e28c8")):
        paint.rectangle(box, fill=color)
    result = drawing_of(image)
    assert result.metrics["condition"]["enlarged"] is not None
    assert (draw(result.svg(), 90, 60) == np.asarray(image)).all()


def test_a_goal_for_the_quality_is_about_the_given_picture() -> None:
    pixels = (levels_of(enlarged(drawn(WIDTH), FACTOR, Resampling.BICUBIC)) / 255.0).astype(np.float32)
    for goal, is_restored in ((make_goal(max_bytes=9000), True), (make_goal(target_psnr=20.0), False)):
        request = Request.of(pixels, FitConfig(), goal)
        assert restored(request, measured(request)).picture.is_restored == is_restored


def test_what_is_known_of_a_picture_is_not_measured_again(monkeypatch) -> None:
    pixels = (levels_of(noisy(drawn(160), 9.0)) / 255.0).astype(np.float32)
    request = Request.of(pixels, FitConfig(mode="flat"))
    known = Restoration.of(request)
    assert known.request.picture.is_restored
    monkeypatch.delattr("warpvec.condition.condition.measure_condition")
    again = Restoration.of(Request.of(pixels, FitConfig(mode="mono")), known)
    assert again.request.picture.reduced is known.request.picture.reduced
    assert again.request.settings.mode == "mono"
    for_quality = Request.of(pixels, FitConfig(), make_goal(target_psnr=20.0))
    assert not Restoration.of(for_quality, known).request.picture.is_restored
    stated = Request.of(pixels, FitConfig(mode="mono", blur="3"))
    assert Restoration.of(stated, known).request.picture.blur == 3.0
    with pytest.raises(ImportError):
        Restoration.of(Request.of(pixels.copy(), FitConfig()), known)


def test_paper_is_drawn_in_even_light() -> None:
    sheet = Image.new("RGB", (240, 200), "white")
    ImageDraw.Draw(sheet).line((30, 40, 200, 150), fill="black", width=5)
    pixels = (levels_of(unevenly_lit(sheet, 0.5)) / 255.0).astype(np.float32)
    request = Request.of(pixels, FitConfig())
    picture = restored(request, measured(request)).picture
    assert picture.is_restored
    gray = picture.reduced.mean(2)
    is_paper = levels_of(sheet).min(2) == 255.0
    assert gray[is_paper].min() > 0.8 > 0.4 > gray[levels_of(sheet).max(2) == 0.0].max()


def test_ink_on_unevenly_lit_paper_is_black_and_white_art() -> None:
    sheet = Image.new("RGB", (160, 120), "white")
    pen = ImageDraw.Draw(sheet)
    for k in range(4):
        pen.line((20, 20 + 20 * k, 140, 36 + 16 * k), fill="black", width=4)
    assert drawing_of(unevenly_lit(sheet, 0.5)).config.mode == "mono"
    sheet.paste((200, 30, 30), (20, 98, 70, 114))
    assert drawing_of(unevenly_lit(sheet, 0.5)).config.mode == "flat"


def test_progress_shows_the_size_of_the_given_picture() -> None:
    seen: list[float] = []

    def look(progress: Progress) -> None:
        seen.append(float(progress.scene().segments.max()))

    large = enlarged(drawn(WIDTH), FACTOR, Resampling.BICUBIC)
    drawing_of(large, on_progress=look)
    assert min(seen) > 0.8 * large.height


@pytest.mark.slow
def test_a_noisy_drawing_becomes_flat_art_of_as_few_paths_as_the_clean_one() -> None:
    clean, given = drawn(240), noisy(drawn(240), 10.0)
    results = [drawing_of(image, metadata=False) for image in (clean, given)]
    assert results[1].config.mode == "flat"
    assert len(results[1].scene) <= 1.5 * len(results[0].scene)
    pixels, before = ((levels_of(image) / 255.0).astype(np.float32) for image in (given, clean))
    assert psnr(draw(results[1].svg(), 240, 192), before) > psnr(pixels, before) + 6.0


def test_a_given_threshold_is_a_level_of_the_picture_as_it_is() -> None:
    sheet = Image.new("RGB", (240, 200), "white")
    ImageDraw.Draw(sheet).line((30, 40, 200, 150), fill="black", width=5)
    pixels = (levels_of(unevenly_lit(sheet, 0.5)) / 255.0).astype(np.float32)
    for threshold, is_restored in (("auto", True), ("100", False)):
        request = Request.of(pixels, FitConfig(mode="mono", threshold=threshold))
        assert restored(request, measured(request)).picture.is_restored == is_restored


def test_photos_in_a_drawing_keep_their_rims_and_their_texture() -> None:
    large = Image.fromarray(np.rint(255.0 * card("rectangle")[0]).astype(np.uint8)).resize(
        (800, 640), Resampling.NEAREST
    )
    given = np.asarray(large.resize((200, 160), Resampling.LANCZOS), np.float32) / 255.0
    request = Request.of(given, FitConfig())
    assert restored(request, Condition(reduction="lanczos")).picture.reduced is given


def test_a_large_drawing_is_reduced_without_halos_and_a_photo_sharply() -> None:
    picture = np.ones((60, 1500, 3), np.float32)
    picture[20:40, 301:1201] = (0.5, 0.1, 0.2)
    request = Request.of(picture, FitConfig(fit_size=1000))
    drawn = Restoration.of(request).request.picture.reduced
    assert drawn.shape == request.picture.reduced.shape == (40, 1000, 3)
    assert drawn.min() >= 0.1 - 1e-6 and request.picture.reduced.min() < 0.09
    width = (1.5**2 - 1.0) ** 0.5  # of the window in the picture, around 300.75
    share = (301.0 - 300.75) / width + 0.5
    assert drawn[20, 200] == pytest.approx(share + (1.0 - share) * np.array([0.5, 0.1, 0.2]), abs=1e-5)

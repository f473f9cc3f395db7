"""The choice of the mode, on pictures made here: drawings and photo-like ones, as they are, compressed and reduced."""

from __future__ import annotations

import io

import numpy as np
import pytest
from logo import logo
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter
from scipy.ndimage import maximum_filter

from warpvec.flat import mode_choice
from warpvec.flat.mode_choice import choose_mode

SIDE = 256


def drawing() -> Image.Image:
    """Return flat art: a shaded disc, a letter and a bar, anti-aliased, on white."""
    big = Image.new("RGB", (4 * SIDE, 4 * SIDE), "white")
    pen = ImageDraw.Draw(big)
    for step in range(40):  # a radial shade in steps of two levels
        inset = 80 + 10 * step
        pen.ellipse((inset, inset, 4 * SIDE - inset, 4 * SIDE - inset), fill=(220 - 2 * step, 90 + 2 * step, 40))
    pen.polygon(
        [(300, 300), (724, 300), (724, 400), (560, 400), (560, 760), (464, 760), (464, 400), (300, 400)], "navy"
    )
    pen.rectangle((100, 900, 924, 960), fill=(240, 200, 60))
    return big.resize((SIDE, SIDE), Image.Resampling.BOX)


def landscape() -> Image.Image:
    """Return a picture with the statistics of a photo: amplitudes fall as 1 / frequency, and a quiet sky on top."""
    random = np.random.default_rng(5)
    y, x = np.fft.fftfreq(SIDE)[:, None], np.fft.fftfreq(SIDE)[None]
    falloff = 1.0 / np.maximum(np.hypot(x, y), 1.0 / SIDE)
    waves = [np.fft.ifft2(np.fft.fft2(random.normal(size=(SIDE, SIDE))) * falloff).real for _ in range(3)]
    common = waves[0]
    channels = [common / common.std() + 0.3 * wave / wave.std() for wave in waves]
    picture = 120 + 45 * np.stack(channels, -1)
    sky = np.linspace(200, 170, SIDE // 3)[:, None, None] + random.normal(size=(SIDE // 3, SIDE, 3))
    picture[: SIDE // 3] = sky
    return Image.fromarray(picture.clip(0, 255).astype(np.uint8))


def scan() -> Image.Image:
    """Return ink lines on uneven paper with noise, grey as scanners give it."""
    page = Image.new("L", (SIDE, SIDE), 236)
    pen = ImageDraw.Draw(page)
    pen.line([(20, 200), (60, 60), (110, 190), (150, 70), (235, 180)], fill=40, width=5)
    pen.ellipse((150, 150, 220, 220), outline=40, width=4)
    noise = np.random.default_rng(1).normal(0, 4, (SIDE, SIDE)) + np.linspace(-6, 6, SIDE)
    grey = np.asarray(page.filter(ImageFilter.GaussianBlur(0.7)), float) + noise
    return Image.fromarray(grey.clip(0, 255).astype(np.uint8)).convert("RGB")


PICTURES = {"flat": drawing, "photo": landscape, "mono": scan}


def changed(picture: Image.Image, change: str) -> NDArray[np.float32]:
    """Return the pixels of ``picture`` after a ``change``: a side in pixels, a JPEG quality, blur or noise."""
    kind, _, amount = change.partition(" ")
    if kind == "side":
        picture = picture.resize((int(amount), int(amount)), Image.Resampling.BOX)
    elif kind == "jpeg":
        buffer = io.BytesIO()
        picture.save(buffer, "JPEG", quality=int(amount))
        picture = Image.open(buffer)
    elif kind == "blur":
        picture = picture.filter(ImageFilter.GaussianBlur(float(amount)))
    pixels = np.asarray(picture, np.float32) / 255
    if kind == "noise":
        pixels = pixels + np.random.default_rng(2).normal(0, float(amount), pixels.shape).astype(np.float32)
    return pixels.clip(0, 1)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        *(
            ("flat", change)
            for change in ("none", "jpeg 60", "jpeg 80", "jpeg 95", "side 64", "side 128", "noise 0.01")
        ),
        *(("photo", change) for change in ("none", "jpeg 60", "side 64", "blur 1", "blur 4", "noise 0.05")),
        *(("mono", change) for change in ("none", "jpeg 80")),
    ],
)
def test_the_mode_of_a_picture_and_of_its_copies(name: str, change: str) -> None:
    choice = choose_mode(changed(PICTURES[name](), change))
    assert choice.mode == name, choice.reason


def test_transparent_art_is_flat_even_in_black() -> None:
    assert choose_mode(logo().astype(np.float32) / 255).mode == "flat"
    black = np.zeros((64, 64, 4), np.float32)
    black[16:48, 16:48, 3] = 1.0
    assert choose_mode(black).mode == "flat"
    seen = np.where(black[..., 3:] > 0, black[..., :3], 1.0).astype(np.float32)
    assert choose_mode(seen).mode == "mono"


def test_dark_grey_is_a_colour_of_drawings_but_ink_of_scans() -> None:
    grey = np.full((64, 64, 3), 1.0, np.float32)
    grey[16:48, 16:48] = 0.25
    assert choose_mode(grey).mode == "flat"
    noise = np.random.default_rng(0).normal(0, 0.03, (64, 64, 1)).astype(np.float32)
    assert choose_mode((grey - 0.1 + noise).clip(0, 1)).mode == "mono"


@pytest.mark.parametrize("change", ["none", "jpeg 80"])
def test_black_figures_on_a_light_plate_are_no_black_and_white_art(change: str) -> None:
    plate = Image.new("RGB", (SIDE, SIDE), "white")
    pen = ImageDraw.Draw(plate)
    pen.rounded_rectangle((60, 60, 200, 200), 30, fill=(224, 224, 224))
    pen.ellipse((100, 100, 160, 160), fill="black")
    assert choose_mode(changed(plate, change)).mode == "flat"


@pytest.mark.parametrize("shape", [(1, 1), (1, 300), (300, 1), (2, 3), (9, 7)])
def test_any_shape_and_a_single_colour_have_a_mode(shape: tuple[int, int]) -> None:
    assert choose_mode(np.full((*shape, 3), 0.2, np.float32)).mode == "flat"
    random = np.random.default_rng(0).random((*shape, 4), np.float32)
    assert choose_mode(random).mode in ("flat", "photo")


def test_what_is_as_small_as_an_icon_is_no_photo() -> None:
    photo = landscape()
    modes = [choose_mode(np.asarray(photo.resize((side, side)), np.float32) / 255.0).mode for side in (32, 64)]
    assert modes == ["flat", "photo"]


def test_the_reason_counts_the_colours() -> None:
    assert choose_mode(np.full((40, 40, 3), 0.5, np.float32)).reason == "mostly 1 colour, 100 % of the area is flat"


@pytest.mark.parametrize("shape", [(40, 60), (5, 30), (1, 1)])
def test_the_surroundings_of_edges_end_at_their_reach(shape: tuple[int, int]) -> None:
    mask = np.random.default_rng(0).random(shape) < 0.02
    assert (mode_choice._widened(mask, 6) == maximum_filter(mask, 13)).all()


def test_light_drawings_on_dark_of_two_levels_are_black_and_white_art() -> None:
    picture = Image.new("L", (SIDE, SIDE), 0)
    ImageDraw.Draw(picture).ellipse((60, 60, 200, 170), outline=255, width=9)
    light = np.asarray(picture.convert("RGB"), np.float32) / 255.0
    assert choose_mode(light).mode == "mono"
    dithered = Image.fromarray(np.tile(np.linspace(0, 160, SIDE).astype(np.uint8), (SIDE, 1))).convert("1")
    assert choose_mode(np.asarray(dithered.convert("RGB"), np.float32) / 255.0).mode != "mono"


def test_a_grey_logo_with_noise_keeps_its_grey_and_a_scan_becomes_ink() -> None:
    grey = np.full((SIDE, SIDE, 3), 255.0)
    grey[60:200, 60:200] = 51.0
    noise = np.random.default_rng(3).normal(0.0, 2.0, grey.shape)
    noisy = (np.rint(grey + noise).clip(0.0, 255.0) / 255.0).astype(np.float32)
    assert choose_mode(noisy, was_noisy=True).mode == "flat"
    assert choose_mode(np.asarray(scan(), np.float32) / 255.0, was_noisy=True).mode == "mono"

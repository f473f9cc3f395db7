"""Kinds of files that packages of the extra "formats" read: each is right, and none is read wrongly without a word."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest
from image_files import complaint, encode, srgb_encoded
from PIL import Image, TiffImagePlugin

from warpvec.image.doors import table
from warpvec.image.read import read_image, read_picture

SIDE = 48
COLORS = np.zeros((SIDE, SIDE, 3), np.uint8)
COLORS[:, :24], COLORS[:, 24:], COLORS[:8] = (255, 0, 0), (0, 0, 255), (96, 160, 32)
ALPHA = np.dstack([COLORS, np.full((SIDE, SIDE), 255, np.uint8)])
ALPHA[-8:, :, 3] = 51


def levels(data: bytes, page: int | None = None):
    return (read_picture(data, page=page).pixels * 255).round().astype(int)


def tiff(pixels, **options) -> bytes:
    stream = io.BytesIO()
    pytest.importorskip("tifffile").imwrite(stream, pixels, **options)
    return stream.getvalue()


def pdf(*pages, resolution=96.0) -> bytes:
    stream = io.BytesIO()
    first, *more = (Image.fromarray(page) for page in pages)
    first.save(stream, "PDF", save_all=True, append_images=more, resolution=resolution)
    return stream.getvalue()


def test_jpeg_xl() -> None:
    pytest.importorskip("pillow_jxl")
    assert levels(encode(ALPHA, "JXL", lossless=True)).tolist() == ALPHA.tolist()
    assert levels(encode(COLORS, "JXL", lossless=True)).tolist() == COLORS.tolist()


def test_merged_picture_of_an_archive() -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("mimetype", "image/openraster")
        archive.writestr("data/layer0.png", encode(COLORS[:4]))
        archive.writestr("mergedimage.png", encode(ALPHA))
    assert levels(stream.getvalue()).tolist() == ALPHA.tolist()
    with zipfile.ZipFile(stream := io.BytesIO(), "w") as archive:
        archive.writestr("word/document.xml", "<w/>")
    assert "mergedimage.png" in complaint(read_image, stream.getvalue())


@pytest.mark.parametrize("number", [1, 2, 3])
def test_pages_of_a_pdf_at_the_resolution_of_their_picture(number: int) -> None:
    pytest.importorskip("pypdfium2")
    grey = np.full((30, 40), 96, np.uint8)
    data = pdf(COLORS, grey, COLORS[:, ::-1], resolution=300.0)
    found = read_picture(data, page=number)
    assert found.unread == f"all but page {number} of 3"
    assert found.pixels.shape[:2] == ((30, 40) if number == 2 else (SIDE, SIDE))
    middle = (found.pixels[15, 10] * 255).round()
    assert abs(middle - [(255, 0, 0), (96, 96, 96), (0, 0, 255)][number - 1]).max() <= 5  # it is a JPEG
    assert read_picture(data).unread == "all but page 1 of 3"
    assert "at most 3" in complaint(read_picture, data, page=4)


def test_light_of_exr() -> None:
    exr = pytest.importorskip("OpenEXR")
    light = np.linspace(0.0, 1.0, 60, dtype=np.float32).reshape(4, 5, 3)

    def written(channels: dict[str, object]) -> bytes:
        header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
        exr.File(header, channels).write(stream := io.BytesIO())
        return stream.getvalue()

    np.testing.assert_allclose(read_image(written({"RGB": light})), srgb_encoded(light), atol=2e-4)
    clear = np.dstack([light * 0.5, np.full((4, 5, 1), 0.5, np.float32)])  # colours are times alpha
    np.testing.assert_allclose(read_image(written({"RGBA": clear}))[..., :3], srgb_encoded(light), atol=2e-4)
    assert read_picture(written({"RGB": light})).unread is None
    bright = read_picture(written({"RGB": 4 * light}))
    assert bright.unread == "light that is brighter than white"
    np.testing.assert_allclose(bright.pixels, srgb_encoded((4 * light).clip(0, 1)), atol=2e-4)
    assert "channels Z" in complaint(read_image, written({"Z": light[..., 0]}))


def test_tiff_of_colours_that_pillow_refuses() -> None:
    unit = (COLORS / 255).astype(np.float32)
    for samples in (unit, unit.astype(np.float16), unit.astype(np.float64)):
        assert levels(tiff(samples, photometric="rgb")).tolist() == COLORS.tolist()
    planes = np.ascontiguousarray(COLORS.transpose(2, 0, 1)).astype(np.uint16) * 257
    assert levels(tiff(planes, photometric="rgb", planarconfig="separate")).tolist() == COLORS.tolist()
    inks = np.zeros((SIDE, SIDE, 5), np.uint8)
    inks[:, :24, 1:3] = inks[:, 24:, :2] = 255  # red and blue
    inks[..., 4] = ALPHA[..., 3]
    found = levels(tiff(inks, photometric="separated", extrasamples=["unassalpha"]))
    wanted = ALPHA.copy()
    wanted[:8] = wanted[8]
    assert found.tolist() == wanted.tolist()
    refused = complaint(read_image, tiff(unit * 4, photometric="rgb"))
    assert "numbers outside of [0, 1]" in refused and "TIFF" in refused


def test_pages_of_a_tiff() -> None:
    stream = io.BytesIO()
    first, second = Image.fromarray(COLORS), Image.fromarray(COLORS[:, ::-1])
    first.save(stream, "TIFF", save_all=True, append_images=[second])
    assert levels(stream.getvalue(), 2).tolist() == COLORS[:, ::-1].tolist()
    assert read_picture(stream.getvalue()).unread == "all but page 1 of 2"
    assert "at most 2" in complaint(read_picture, stream.getvalue(), page=3)
    assert "TIFF or PDF" in complaint(read_picture, encode(COLORS), page=1)
    assert "at least 1" in complaint(read_picture, encode(COLORS), page=0)


@pytest.mark.parametrize(("unit", "meters"), [(9001, 24.0), (9002, 7.3152), (None, None)])
def test_width_in_the_world(unit: int | None, meters: float | None) -> None:
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags[33550] = (0.5, 0.5, 0.0)
    tags[34735] = (1, 1, 0, 1, 3076, 0, 1, unit) if unit else (1, 1, 0, 1, 1024, 0, 1, 2)
    tags.tagtype.update({33550: 12, 34735: 3})
    stream = io.BytesIO()
    Image.fromarray(COLORS).save(stream, "TIFF", tiffinfo=tags)
    assert read_picture(stream.getvalue()).meters == pytest.approx(meters)


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table, "find_spec", lambda name: None)
    for start, kind in [(b"%PDF-1.7", "PDF"), (b"\xff\x0a", "JPEG XL"), (b"v/1\x01", "OpenEXR")]:
        words = complaint(read_image, start + bytes(20))
        assert kind in words
        assert "warpvec[formats]" in words

"""Reading every kind of image into one kind of array."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
import torch
from image_files import (
    BLUE,
    GREEN,
    GREY16,
    LINEAR_GREY,
    LINEAR_RGB,
    LOSSLESS,
    RED,
    RGB,
    RGBA,
    RNG,
    SRGB_PROFILE,
    assert_pixels,
    cmyk_profile,
    complaint,
    encode,
    grey_of_lightness,
    png,
    rgb_profile,
    srgb_encoded,
)
from PIL import Image

from warpvec.image.colors import parse_color
from warpvec.image.read import read_image


@pytest.mark.parametrize(("format", "options"), LOSSLESS)
def test_lossless_formats_are_exact_from_every_source(tmp_path, format, options):
    data = encode(RGB, format, **options)
    path = tmp_path / "photo"
    path.write_bytes(data)
    for source in (path, str(path), data, memoryview(data), Image.open(path)):
        assert_pixels(read_image(source), RGB / 255)


def test_jpeg_and_gif_are_close():
    ramp = np.repeat(np.arange(0, 256, 8, dtype=np.uint8)[None, :, None], 16, 0) * np.ones(3, np.uint8)
    assert_pixels(read_image(encode(ramp, "JPEG", quality=95)), ramp / 255, atol=0.02)
    assert_pixels(read_image(encode(ramp, "GIF")), ramp / 255)


@pytest.mark.parametrize("format", ["GIF", "WEBP", "TIFF", "PNG"])
def test_first_frame_of_an_animation(format):
    frames = [Image.new("RGB", (5, 4), color) for color in ("red", "lime", "blue")]
    data = encode(
        frames[0], format, save_all=True, append_images=frames[1:], **({"lossless": True} if format == "WEBP" else {})
    )
    assert Image.open(io.BytesIO(data)).n_frames == 3
    assert_pixels(read_image(data), np.full((4, 5, 3), (1, 0, 0)))


def test_jpeg_with_a_preview_beside_it():
    """Cameras write a JPEG with more pictures after the first, which Pillow calls MPO."""
    photo, preview = Image.new("RGB", (40, 30), "red"), Image.new("RGB", (40, 30), "blue")
    data = encode(photo, "MPO", save_all=True, append_images=[preview])
    assert Image.open(io.BytesIO(data)).format == "MPO"
    assert_pixels(read_image(data), np.full((30, 40, 3), (1, 0, 0)), atol=0.01)


@pytest.mark.parametrize("data", [png(GREY16[..., None], 0), encode(GREY16, "TIFF"), encode(GREY16, "PNG")])
def test_sixteen_bit_grey_keeps_every_level(data):
    pixels = read_image(data)
    assert_pixels(pixels, GREY16[..., None] / 65535)
    assert len(np.unique(pixels)) == GREY16.size


@pytest.mark.parametrize(("color_type", "channel_count"), [(2, 3), (4, 2), (6, 4)])
def test_sixteen_bit_color_keeps_eight(color_type, channel_count):
    samples = RNG.integers(0, 65536, (6, 9, channel_count), np.uint16)
    want = read_image(samples, background="#123")
    assert_pixels(read_image(png(samples, color_type), background="#123"), want, atol=2 / 257)


def test_sixteen_bit_grey_with_a_transparent_level():
    key = int(GREY16[3, 4])
    pixels = read_image(png(GREY16[..., None], 0, (b"tRNS", struct.pack(">H", key))), background="#f00")
    want = np.where((key == GREY16)[..., None], (1.0, 0.0, 0.0), GREY16[..., None] / 65535)
    assert_pixels(pixels, want)


def test_thirty_two_bit_grey():
    assert_pixels(read_image(Image.fromarray(GREY16.astype(np.int32))), GREY16[..., None] / 65535)
    assert "16" in complaint(read_image, encode(np.full((3, 3), 65536, np.int32), "TIFF"))
    assert_pixels(read_image(encode(np.full((2, 3), 0.25, np.float32), "TIFF")), np.full((2, 3, 1), 0.25))
    assert "NaN" in complaint(read_image, encode(np.full((2, 3), np.nan, np.float32), "TIFF"))


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "RGBX", "YCbCr", "HSV", "LAB"])
def test_modes_without_alpha(mode):
    image = Image.fromarray(RGB).convert(mode)
    assert_pixels(read_image(image), np.asarray(image.convert("RGB")) / 255)


def test_palette_with_a_transparency_table():
    image = Image.fromarray(np.array([[0, 1], [2, 3]], np.uint8)).convert("P")
    image.putpalette([255, 0, 0, 0, 255, 0, 0, 0, 255, 10, 20, 30])
    pixels = read_image(encode(image, transparency=bytes([0, 51, 255])), background="white")
    assert_pixels(pixels, [[(1, 1, 1), (0.8, 1, 0.8)], [(0, 0, 1), (10 / 255, 20 / 255, 30 / 255)]])
    one = read_image(encode(image, "GIF", transparency=2), background="black")
    assert_pixels(one, [[(1, 0, 0), (0, 1, 0)], [(0, 0, 0), (10 / 255, 20 / 255, 30 / 255)]])


def test_single_transparent_level_or_color():
    grey = np.array([[7, 8]], np.uint8)
    assert_pixels(read_image(encode(grey, transparency=7), "#00f"), [[(0, 0, 1), (8 / 255,) * 3]])
    color = np.array([[(1, 2, 3), (1, 2, 4)]], np.uint8)
    assert_pixels(read_image(encode(color, transparency=(1, 2, 3)), "#00f"), [[(0, 0, 1), (1 / 255, 2 / 255, 4 / 255)]])


@pytest.mark.parametrize("background", ["#ffffff", "#000", "#fa0510", "Navy"])
def test_alpha_is_blended_as_encoded(background):
    alpha = RGBA[..., 3:] / 255
    backdrop = parse_color(background) * (1 - alpha)
    assert_pixels(read_image(encode(RGBA), background), RGBA[..., :3] / 255 * alpha + backdrop, atol=2e-7)
    assert_pixels(read_image(RGBA[..., 2:], background), RGBA[..., 2:3] / 255 * alpha + backdrop, atol=2e-7)
    assert read_image(encode(RGBA), background).max() <= 1


@pytest.mark.parametrize(("format", "atol"), [("TIFF", 0.006), ("JPEG", 0.03)])
def test_cmyk_without_a_profile(format, atol):
    inks = [(0, 0, 0, 0), (255, 0, 0, 0), (0, 128, 0, 0), (0, 0, 255, 64), (0, 0, 0, 255)]
    for ink in inks:
        want = [(1 - ink[c] / 255) * (1 - ink[3] / 255) for c in range(3)]
        assert_pixels(read_image(encode(Image.new("CMYK", (8, 8), ink), format)), np.full((8, 8, 3), want), atol)


UPRIGHT = {
    1: lambda a: a,
    2: lambda a: a[:, ::-1],
    3: lambda a: a[::-1, ::-1],
    4: lambda a: a[::-1],
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: np.rot90(a, -1),
    7: lambda a: a[::-1, ::-1].swapaxes(0, 1),
    8: lambda a: np.rot90(a, 1),
    9: lambda a: a,
}


@pytest.mark.parametrize("orientation", UPRIGHT)
def test_exif_orientation_is_applied(orientation):
    exif = Image.Exif()
    exif[0x0112] = orientation
    want = UPRIGHT[orientation](RGB / 255)
    for format, options in (("PNG", {}), ("WEBP", {"lossless": True}), ("TIFF", {})):
        assert_pixels(read_image(encode(RGB, format, exif=exif, **options)), want)
    blocks = RGB.repeat(16, 0).repeat(16, 1)
    data = encode(blocks, "JPEG", exif=exif, quality=95, subsampling=0)
    assert_pixels(read_image(data), UPRIGHT[orientation](blocks / 255), atol=0.06)
    assert_pixels(read_image(Image.open(io.BytesIO(data))), read_image(data))


def test_damaged_exif_leaves_the_pixels():
    data = encode(RGB, exif=b"Exif\0\0MM\0*\xff\xff\xff\xff garbage")
    assert_pixels(read_image(data), RGB / 255)


@pytest.mark.parametrize("alpha", [False, True])
def test_icc_profile_is_converted(alpha):
    swapped = rgb_profile(BLUE, GREEN, RED)
    samples = RGBA if alpha else RGB
    blend = RGBA[..., 3:] / 255 if alpha else 1.0
    encoded = srgb_encoded(samples[..., :3] / 255)
    for data, want in ((LINEAR_RGB, encoded), (swapped, encoded[..., ::-1]), (SRGB_PROFILE, samples[..., :3] / 255)):
        assert_pixels(read_image(encode(samples, icc_profile=data), "black"), want * blend, atol=0.6 / 255)


def test_icc_profile_of_palette_and_jpeg():
    image = Image.fromarray(RGB).quantize(8)
    want = srgb_encoded(np.asarray(image.convert("RGB")) / 255)
    assert_pixels(read_image(encode(image, icc_profile=LINEAR_RGB)), want, atol=0.6 / 255)
    flat = np.full((8, 8, 3), 64, np.uint8)
    assert_pixels(read_image(encode(flat, "JPEG", icc_profile=LINEAR_RGB)), srgb_encoded(flat / 255), atol=0.02)


@pytest.mark.parametrize("data", [LINEAR_GREY, LINEAR_RGB])
def test_icc_profile_of_grey(data):
    levels = np.arange(256, dtype=np.uint8).reshape(16, 16)
    want = srgb_encoded(levels[..., None] / 255)
    assert_pixels(read_image(encode(levels, icc_profile=data)), want, atol=0.6 / 255)
    opaque = np.dstack([levels, np.full_like(levels, 255)])
    assert_pixels(read_image(encode(opaque, icc_profile=data)), want, atol=0.6 / 255)
    if data is LINEAR_GREY:
        # The curve is interpolated between 256 rounded levels; in the darks, where it bends, that is off by a level.
        pixels = read_image(encode(GREY16, icc_profile=data))
        assert_pixels(pixels, srgb_encoded(GREY16[..., None] / 65535), atol=1 / 255)
        assert len(np.unique(pixels)) > 256


@pytest.mark.parametrize(("format", "tolerance"), [("TIFF", 0.005), ("JPEG", 0.02)])
def test_icc_profile_of_cmyk(format, tolerance):
    for ink, lightness in (
        ((0, 0, 0, 128), 100 * 127 / 255),
        ((255, 0, 0, 0), 100 * 128 / 255),
        ((0, 255, 255, 0), 100),
    ):
        data = encode(Image.new("CMYK", (8, 8), ink), format, icc_profile=cmyk_profile())
        assert_pixels(read_image(data), np.full((8, 8, 1), grey_of_lightness(lightness)), atol=tolerance)


@pytest.mark.parametrize("data", [b"not a profile", LINEAR_RGB[:200], LINEAR_GREY, cmyk_profile()])
def test_damaged_or_foreign_profile_is_ignored(data):
    assert_pixels(read_image(encode(RGB, icc_profile=data)), RGB / 255)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, ">u2", np.bool_, np.float16, np.float32, np.float64])
@pytest.mark.parametrize("shape", [(5, 4), (5, 4, 1), (5, 4, 3), (1, 1, 3), (1, 30), (30, 1)])
def test_arrays(dtype, shape):
    unit = RNG.random(shape)
    kind = np.dtype(dtype).kind
    samples = unit > 0.5 if kind == "b" else (unit if kind == "f" else unit * np.iinfo(dtype).max).astype(dtype)
    want = samples.astype(np.float64) / (np.iinfo(dtype).max if kind == "u" else 1)
    for layout in (samples, np.asfortranarray(samples), samples[::-1].copy()[::-1]):
        assert_pixels(read_image(layout), want if want.ndim == 3 else want[..., None])


TENSORS = [torch.uint8, torch.bool, torch.float16, torch.bfloat16, torch.float32, torch.float64]


@pytest.mark.parametrize("dtype", TENSORS)
def test_torch_tensors(device, dtype):
    levels = torch.from_numpy(RNG.integers(0, 256, (2, 3, 4)))
    tensor = levels.to(dtype) if dtype == torch.uint8 else (levels / 255).round(decimals=2).to(dtype)
    array = tensor.float().numpy() if dtype.is_floating_point else tensor.numpy()
    assert np.array_equal(read_image(tensor.to(device)), read_image(array))


def test_torch_tensors_of_any_layout_and_with_gradients():
    unit = torch.rand(3, 6, 5)
    want = unit.permute(1, 2, 0).numpy()
    assert_pixels(read_image(unit.permute(1, 2, 0)), want)
    assert_pixels(read_image(unit[0]), unit[0][..., None].numpy())
    assert_pixels(read_image(torch.nn.Parameter(unit.permute(1, 2, 0))), want)
    assert_pixels(read_image(unit.permute(1, 2, 0).clone().requires_grad_().contiguous()), want)


@pytest.mark.parametrize(
    ("tensor", "words"),
    [
        (
            torch.rand(3, 6, 5),
            "must have shape [h, w] or [h, w, 1 to 4], got [3, 6, 5]; its channels come first: give tensor.permute",
        ),
        (torch.full((2, 2), 255.0), "must be in [0, 1], got 255 to 255"),
        (torch.zeros(2, 2, dtype=torch.int32), "int32"),
        (torch.zeros(2, 2).to_sparse(), "can be converted to a numpy array"),
        (torch.zeros(2, 2, device="meta"), "can be converted to a numpy array"),
    ],
)
def test_bad_tensors(tensor, words):
    assert words in complaint(read_image, tensor)


def test_array_is_not_aliased():
    samples = np.full((2, 2, 3), 0.5, np.float32)
    read_image(samples)[:] = 0
    assert (samples == 0.5).all()
    read_image(torch.from_numpy(samples))[:] = 0
    assert (samples == 0.5).all()

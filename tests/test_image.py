"""Every kind of image in, one kind of array out; every bad one, one line."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import subprocess
import sys
import threading
import zlib

import numpy as np
import pytest
from PIL import Image, ImageCms

from warpvec import image as image_module
from warpvec.errors import InputError
from warpvec.image import MAX_PIXELS, fit_image, parse_color, read_image, write_png

RNG = np.random.default_rng(7)
RGB = RNG.integers(0, 256, (6, 9, 3), np.uint8)
RGBA = RNG.integers(0, 256, (6, 9, 4), np.uint8)
GREY16 = np.arange(0, 65536, 97, dtype=np.uint16)[:675].reshape(25, 27)
SRGB_PROFILE = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
LOSSLESS = [("PNG", {}), ("TIFF", {}), ("TIFF", {"compression": "tiff_lzw"}), ("BMP", {}), ("WEBP", {"lossless": True})]


def encode(image, format="PNG", **options):
    stream = io.BytesIO()
    (image if isinstance(image, Image.Image) else Image.fromarray(image)).save(stream, format=format, **options)
    return stream.getvalue()


def png(samples, color_type, *chunks):
    """A 16 bit PNG of ``samples`` [h, w, c], which Pillow cannot write for colour."""
    height, width = samples.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in samples.astype(">u2"))
    header = (b"IHDR", struct.pack(">IIBBBBB", width, height, 16, color_type, 0, 0, 0))
    parts = [header, *chunks, (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(png_chunk(*part) for part in parts)


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_header(width, height):
    """A PNG that ends where its pixels would begin."""
    header = png_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + png_chunk(b"IDAT", b"")


def fixed(*values):
    return b"".join(struct.pack(">i", round(v * 65536)) for v in values)


# sRGB's primaries adapted to D50 (Lindbloom), a column each: they sum to D50 white.
RED, GREEN, BLUE = (
    (0.4360747, 0.2225045, 0.0139322),
    (0.3850649, 0.7168786, 0.0971045),
    (0.1430804, 0.0606169, 0.7141733),
)
LINEAR = b"curv\0\0\0\0" + struct.pack(">IH", 1, 256)


def profile(space, tags, connection=b"XYZ "):
    """An ICC 2.4 profile (ICC.1:2001-04, section 6)."""
    offset, table, body = 132 + 12 * len(tags), struct.pack(">I", len(tags)), b""
    for name, data in tags.items():
        table += name + struct.pack(">II", offset + len(body), len(data))
        body += data + b"\0" * (-len(data) % 4)
    kind = b"prtr" if space == b"CMYK" else b"mntr"
    header = struct.pack(">I4sI4s4s4s", offset + len(body), b"", 0x02400000, kind, space, connection)
    header += struct.pack(">6H4s", 2000, 1, 1, 0, 0, 0, b"acsp").ljust(32, b"\0") + fixed(0.9642, 1.0, 0.8249)
    return header.ljust(128, b"\0") + table + body


def xyz(values):
    return b"XYZ \0\0\0\0" + fixed(*values)


def rgb_profile(red, green, blue):
    colorants = {b"rXYZ": xyz(red), b"gXYZ": xyz(green), b"bXYZ": xyz(blue), b"wtpt": xyz((0.9642, 1.0, 0.8249))}
    return profile(b"RGB ", colorants | {b"rTRC": LINEAR, b"gTRC": LINEAR, b"bTRC": LINEAR})


def cmyk_profile():
    """Neutral whatever the ink: L* = 100 (1 - k), and half of it where there is cyan."""
    nodes = [(1 - k) * (0.5 if c else 1.0) for c in (0, 1) for _ in range(4) for k in (0, 1)]
    table = b"".join(bytes([round(255 * value), 128, 128]) for value in nodes)
    identity = bytes(range(256))
    head = b"mft1\0\0\0\0" + bytes([4, 3, 2, 0]) + fixed(1, 0, 0, 0, 1, 0, 0, 0, 1)
    return profile(b"CMYK", {b"A2B0": head + identity * 4 + table + identity * 3}, b"Lab ")


LINEAR_RGB = rgb_profile(RED, GREEN, BLUE)
LINEAR_GREY = profile(b"GRAY", {b"wtpt": xyz((0.9642, 1.0, 0.8249)), b"kTRC": LINEAR})


def srgb_encoded(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def grey_of_lightness(lightness):
    return srgb_encoded(np.float64(((lightness + 16) / 116) ** 3))


def assert_pixels(got, want, atol=1e-7):
    want = np.asarray(want)
    assert got.dtype == np.float32
    assert got.shape == (*want.shape[:2], 3)
    assert got.flags.c_contiguous
    np.testing.assert_allclose(got, np.broadcast_to(want, got.shape), rtol=0, atol=atol)


def assert_in_range(pixels):
    assert np.isfinite(pixels).all()
    assert pixels.min() >= 0
    assert pixels.max() <= 1


def complaint(call, *args, **options):
    with pytest.raises(InputError) as caught:
        call(*args, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 300
    return message


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
    """What cameras write: a JPEG with more pictures after the first, which Pillow calls MPO."""
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
        # Chords of 256 rounded levels: in the darks, where the curve bends, they stay within one level of it.
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


def test_array_is_not_aliased():
    samples = np.full((2, 2, 3), 0.5, np.float32)
    read_image(samples)[:] = 0
    assert (samples == 0.5).all()


@pytest.mark.parametrize(
    ("samples", "words"),
    [
        (np.zeros((0, 5, 3)), "0"),
        (np.zeros((5, 0), np.uint8), "pixels"),
        (np.zeros((3, 5, 5)), "[3, 5, 5]"),
        (np.zeros((1, 5, 5, 3)), "channels last"),
        (np.zeros(5), "[5]"),
        (np.zeros((2, 2), np.int64), "int64"),
        (np.zeros((2, 2), np.uint32), "uint32"),
        (np.zeros((2, 2), complex), "complex128"),
        (np.zeros((2, 2), object), "object"),
        (np.full((2, 2), np.nan), "NaN"),
        (np.array([[0.5, np.inf]]), "infinite"),
        (np.array([[0.5, np.nan]], np.float16), "NaN"),
        (np.array([[0.0, 255.0]]), "uint8"),
        (np.array([[-0.1, 0.5]]), "[0, 1]"),
        (np.broadcast_to(np.uint8(0), (10_001, 10_000)), "10000 x 10001"),
        (None, "NoneType"),
        ([[0.5]], "list"),
    ],
)
def test_bad_array(samples, words):
    message = complaint(read_image, samples, name="PHOTO")
    assert message.startswith("PHOTO ")
    assert words in message


@pytest.mark.parametrize(
    "color", ["", "#", "#12", "#12345", "#ffff", "#gggggg", "nocolor", "rgb(300,0,0)", "#fff\n", None, 3]
)
def test_bad_background(color):
    message = complaint(read_image, RGB, background=color)
    assert message.startswith("background ")
    assert repr(color) in message


def test_bad_paths(tmp_path):
    (tmp_path / "empty.png").touch()
    (tmp_path / "text.png").write_text("not an image")
    (tmp_path / "drawing.eps").write_text("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\n")
    for name, words in [
        ("missing.png", "No such file"),
        ("", "directory"),
        ("empty.png/below", "directory"),
        ("nul\0.png", "null"),
        ("empty.png", "empty"),
        ("text.png", "not recognised"),
        ("drawing.eps", "not recognised"),
    ]:
        path = tmp_path / name
        message = complaint(read_image, path)
        assert message.startswith("IN ")
        assert words in message
        assert repr(str(path)) in message
    assert "empty" in complaint(read_image, b"")
    assert "0 x 5" in complaint(read_image, Image.new("RGB", (0, 5)))


def test_pipe_is_read(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(encode(RGB),), daemon=True)
    writer.start()
    assert_pixels(read_image(pipe), RGB / 255)
    writer.join()


DAMAGED = [*LOSSLESS, ("JPEG", {}), ("JPEG", {"progressive": True}), ("GIF", {}), ("WEBP", {})]


@pytest.mark.parametrize(("format", "options"), DAMAGED)
def test_truncated_file_is_refused_or_whole(capfd, format, options):
    data = encode(RGB.repeat(2, 0), format, **options)
    whole, messages = read_image(data), []
    for length in range(len(data)):
        try:
            np.testing.assert_array_equal(read_image(data[:length]), whole)
        except InputError as error:
            messages.append(str(error))
    assert len(messages) > 0.8 * len(data)
    assert not any("\n" in message for message in messages)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("format", "options"), DAMAGED)
def test_damaged_file_is_read_or_refused(capfd, format, options):
    data = np.frombuffer(encode(RGB, format, **options), np.uint8)
    rng = np.random.default_rng(11)
    for _ in range(150):
        damaged = data.copy()
        damaged[rng.integers(0, len(data), 3)] = rng.integers(0, 256, 3)
        with contextlib.suppress(InputError):
            assert_in_range(read_image(damaged.tobytes()))
    # libtiff itself writes to the error stream, and no caller of Pillow can stop it.
    assert format == "TIFF" or capfd.readouterr() == ("", "")


@pytest.mark.parametrize("size", [(10_001, 10_000), (15_000, 15_000), (100_000, 100_000)])
def test_too_many_pixels_are_refused_from_the_header(size):
    message = complaint(read_image, png_header(*size))
    assert str(MAX_PIXELS) in message
    assert str(size[0] * size[1]) in message


def test_limit_itself_passes_the_header_check():
    assert "pixels," not in complaint(read_image, png_header(10_000, 10_000))


def test_limit_holds_for_pil_images_and_whoever_set_pillows(monkeypatch):
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10)
    assert_pixels(read_image(encode(RGB)), RGB / 255)
    assert Image.MAX_IMAGE_PIXELS == 10
    monkeypatch.setattr(image_module, "MAX_PIXELS", 53)
    assert "9 x 6" in complaint(read_image, Image.fromarray(RGB))
    assert "54 pixels" in complaint(read_image, encode(RGB))
    assert Image.MAX_IMAGE_PIXELS == 10


@pytest.mark.parametrize("exception", [KeyboardInterrupt, MemoryError])
def test_interrupt_and_lack_of_memory_pass(monkeypatch, exception):
    def load(self):
        raise exception

    data = encode(RGB)
    monkeypatch.setattr(Image.Image, "getexif", load)
    with pytest.raises(exception):
        read_image(data)


@pytest.mark.parametrize(
    ("size", "longest_side", "want"),
    [
        ((40, 30), 20, (20, 15)),
        ((30, 40), 20, (15, 20)),
        ((1, 5000), 1024, (1, 1024)),
        ((5000, 2), 10, (10, 1)),
        ((9, 7), 1, (1, 1)),
    ],
)
def test_fit_image_size_and_constant(size, longest_side, want):
    reduced = fit_image(np.full((*size, 3), (0.0, 0.3, 1.0), np.float32), longest_side)
    assert_pixels(reduced, np.full((*want, 3), (0.0, 0.3, 1.0)), atol=1e-6)
    assert_in_range(reduced)


def test_fit_image_never_enlarges():
    pixels = RNG.random((6, 9, 3)).astype(np.float32)
    assert_pixels(fit_image(pixels, 9), pixels)
    assert_pixels(fit_image(pixels, 10**9), pixels)


def test_fit_image_removes_what_the_smaller_grid_cannot_hold():
    board = np.indices((128, 128)).sum(0) % 2
    pixels = np.repeat(board[..., None].astype(np.float32), 3, -1)
    assert_pixels(fit_image(pixels, 32)[2:-2, 2:-2].copy(), np.full((28, 28, 3), 0.5), atol=0.01)
    step = np.zeros((8, 128, 3), np.float32)
    step[:, 64:] = 1
    reduced = fit_image(step, 32)
    assert (reduced.min(), reduced.max()) == (0, 1)
    np.testing.assert_allclose(reduced.mean(), 0.5, atol=1e-6)


def test_write_png_rounds_and_replaces(tmp_path):
    path = tmp_path / "frame.png"
    path.write_bytes(b"old")
    levels = np.array([[(0.49, 0.51, 254.51), (254.49, 300, -4), (1, 2, 3)]]) / 255
    write_png(path, levels)
    assert_pixels(read_image(path), np.array([[(0, 1, 255), (254, 255, 0), (1, 2, 3)]]) / 255)
    write_png(path, (RGB / 255).astype(np.float32))
    assert_pixels(read_image(path), RGB / 255)
    assert [p.name for p in tmp_path.iterdir()] == ["frame.png"]
    assert complaint(write_png, tmp_path / "no" / "frame.png", levels, name="--save-frames").startswith(
        "--save-frames "
    )


def test_import_is_light():
    code = (
        "import sys, warpvec.image, warpvec.samples; print({'torch', 'warp', 'skimage', 'imageio'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"

"""Bad images are refused in one line."""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
import threading

import numpy as np
import pytest
from image_files import LOSSLESS, RGB, assert_in_range, assert_pixels, complaint, encode, png_header, striped_tiff
from PIL import Image

from warpvec.errors import InputError
from warpvec.image import decode
from warpvec.image import read as image_module
from warpvec.image.decode import MAX_PIXELS
from warpvec.image.read import read_image


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
    "color", ["", "#", "#12", "#12345", "#ffff", "#gggggg", "nocolor", "rgb(300,0,0)", "#fff\n", 3]
)
def test_bad_background(color):
    message = complaint(read_image, RGB, background=color)
    assert message.startswith("background must be #rgb, #rrggbb or a CSS colour name, got ")
    assert repr(color) in message


def test_bad_paths(tmp_path):
    (tmp_path / "empty.png").touch()
    (tmp_path / "text.png").write_text("not an image")
    (tmp_path / "drawing.eps").write_text("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\n")
    for name, words in [
        ("missing.png", "No such file"),
        ("", "folder"),
        ("empty.png/below", "directory"),
        ("nul\0.png", "null"),
        ("empty.png", "empty"),
        ("text.png", "not recognised"),
        ("drawing.eps", "not recognised"),
    ]:
        path = tmp_path / name
        message = complaint(read_image, path)
        assert message.startswith("image ")
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


@pytest.fixture(name="decoded_here")
def decoded_here_fixture(monkeypatch):
    """Decode all files in this process: a child for each of hundreds would take minutes."""
    monkeypatch.setattr(image_module, "is_quick", lambda data: True)


DAMAGED = [*LOSSLESS, ("JPEG", {}), ("JPEG", {"progressive": True}), ("GIF", {}), ("WEBP", {})]


@pytest.mark.parametrize(("format", "options"), DAMAGED)
def test_truncated_file_is_refused_or_whole(decoded_here, capfd, format, options):
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
def test_damaged_file_is_read_or_refused(decoded_here, capfd, format, options):
    data = np.frombuffer(encode(RGB, format, **options), np.uint8)
    rng = np.random.default_rng(11)
    for _ in range(150):
        damaged = data.copy()
        damaged[rng.integers(0, len(data), 3)] = rng.integers(0, 256, 3)
        with contextlib.suppress(InputError):
            assert_in_range(read_image(damaged.tobytes()))
    assert (format == "TIFF" and sys.platform == "win32") or capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("planar", "strip_count"), [(False, 3), (True, 9)])
def test_missing_strips_are_refused(planar, strip_count):
    for count in range(2, strip_count):
        message = complaint(read_image, striped_tiff(RGB, 2, count, planar))
        assert message.endswith("which cannot be decoded (strips are missing); export it again")
    whole = striped_tiff(RGB, 2, strip_count, planar)
    assert_pixels(read_image(whole), RGB / 255)
    with Image.open(io.BytesIO(whole)) as image:
        image.load()
        assert_pixels(read_image(image), RGB / 255)  # Pillow forgets the strips when it has loaded them


def test_files_and_devices_are_limited(tmp_path, monkeypatch):
    monkeypatch.setattr(image_module, "MAX_IMAGE_BYTES", 3000)
    path = tmp_path / "large.png"
    path.write_bytes(encode(RGB) + bytes(3000))
    assert "must have at most 3000 bytes, got more in" in complaint(read_image, path)
    assert "must have at most 3000 bytes, got more in" in complaint(read_image, path.read_bytes())
    if os.path.exists("/dev/zero"):
        assert "must have at most 3000 bytes, got more in '/dev/zero'" in complaint(read_image, "/dev/zero")


@pytest.mark.skipif(not os.path.exists("/proc/self/mem"), reason="needs /proc/self/mem, which only Linux has")
def test_a_file_that_opens_but_cannot_be_read_is_refused():
    assert "must be an image file, got '/proc/self/mem' (Input/output error)" in complaint(read_image, "/proc/self/mem")


@pytest.mark.parametrize("size", [(10_001, 5_000), (15_000, 15_000), (100_000, 100_000)])
def test_too_many_pixels_are_refused_from_the_header(size):
    message = complaint(read_image, png_header(*size))
    assert str(MAX_PIXELS) in message
    assert str(size[0] * size[1]) in message


def test_limit_itself_passes_the_header_check():
    assert "pixels," not in complaint(read_image, png_header(10_000, 5_000))


def test_limit_holds_for_pil_images_and_restores_that_of_pillow(monkeypatch):
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10)
    assert_pixels(read_image(encode(RGB)), RGB / 255)
    assert Image.MAX_IMAGE_PIXELS == 10
    monkeypatch.setattr(decode, "MAX_PIXELS", 53)
    assert "9 x 6" in complaint(read_image, Image.fromarray(RGB))
    assert "54 pixels" in complaint(read_image, encode(RGB))
    assert Image.MAX_IMAGE_PIXELS == 10


@pytest.mark.parametrize("exception", [KeyboardInterrupt, MemoryError])
def test_interrupt_and_lack_of_memory_are_not_caught(monkeypatch, exception):
    def load(self):
        raise exception

    data = encode(RGB)
    monkeypatch.setattr(Image.Image, "getexif", load)
    with pytest.raises(exception):
        read_image(data)


def test_import_is_light():
    code = (
        "import sys, numpy, warpvec.image.read, warpvec.image.colors, warpvec.image.samples;"
        "warpvec.image.read.read_image(numpy.zeros((2, 2))); warpvec.image.colors.parse_color('tomato');"
        "print({'torch', 'warp', 'skimage', 'imageio'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


@pytest.mark.parametrize(
    ("channel_count", "words"), [(4, "at most 10 pixels if it has alpha"), (2, "at most 10 pixels")]
)
def test_images_with_alpha_have_a_limit_of_their_own(channel_count, words, monkeypatch):
    monkeypatch.setattr(decode, "MAX_ALPHA_PIXELS", 10)
    assert words in complaint(read_image, np.zeros((3, 4, channel_count), np.uint8))
    assert "if it has alpha" in complaint(read_image, encode(np.zeros((3, 4, 4), np.uint8)))
    assert read_image(np.zeros((3, 4, 3), np.uint8)).shape == (3, 4, 3)


def test_nothing_is_printed_of_a_tiff_with_too_many_samples(capfd):
    # Pillow logs that there are more than it can decode.
    data = encode(RGB, "TIFF")
    samples = b"\x15\x01\x03\x00\x01\x00\x00\x00"  # the tag SamplesPerPixel, one short number
    assert data.count(samples) == 1
    complaint(read_image, data.replace(samples + b"\x03", samples + b"\x23"))
    assert capfd.readouterr() == ("", "")

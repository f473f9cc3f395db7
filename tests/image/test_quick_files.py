"""Which files are decoded in this process, and that the sandbox gives the same pixels and refuses the rest."""

from __future__ import annotations

import io
import struct
from typing import Any

import numpy as np
import pytest
from image_files import LOSSLESS, RGB, encode
from PIL import Image

from warpvec.errors import InputError
from warpvec.image import read
from warpvec.image.quick_files import MAX_SCANS, is_quick, scan_count
from warpvec.image.read import read_image


def with_scans(count: int) -> bytes:
    """Return a JPEG with so many scans: the last one of a progressive file stands in it again and again."""
    data = encode(RGB, "JPEG", progressive=True)
    own, start = scan_count(data), data.rindex(b"\xff\xda")
    return data[:start] + (count - own + 1) * data[start:-2] + data[-2:]


def with_exif(data: bytes, format: str) -> bytes:
    stream = io.BytesIO()
    with Image.open(io.BytesIO(data)) as image:
        exif = image.getexif()
        exif[0x0112] = 6
        image.save(stream, format, exif=exif, **({"lossless": True} if format == "WEBP" else {}))
    return stream.getvalue()


@pytest.mark.parametrize(
    ("data", "quick"),
    [
        (encode(RGB), True),
        (encode(RGB, "JPEG", progressive=True), True),
        (encode(RGB, "GIF"), True),
        (with_scans(100), False),
        (encode(RGB, "TIFF"), False),
        (with_exif(encode(RGB), "PNG"), False),
        (with_exif(encode(RGB, "WEBP", lossless=True), "WEBP"), False),
        (with_exif(encode(RGB, "JPEG"), "JPEG"), True),
        (encode(np.random.default_rng(0).integers(0, 256, (600, 600, 3), np.uint8)), False),
    ],
)
def test_files_that_may_take_long_are_decoded_in_the_sandbox(
    data: bytes, quick: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert is_quick(data) == quick
    found = read_image(data)
    monkeypatch.setattr(read, "is_quick", lambda data: not quick)
    np.testing.assert_array_equal(read_image(data), found)


@pytest.mark.parametrize(("format", "options"), LOSSLESS)
@pytest.mark.parametrize("mode", ["L", "LA", "RGBA", "P", "I;16", "1"])
def test_the_sandbox_gives_the_same_pixels(
    format: str, options: dict[str, Any], mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    image = Image.fromarray(RGB)
    image = Image.fromarray(RGB[..., 0].astype(np.uint16) * 257) if mode == "I;16" else image.convert(mode)
    stream = io.BytesIO()
    try:
        image.save(stream, format, **options)
    except (OSError, ValueError):
        pytest.skip(f"{format} has no {mode}")
    found = []
    for quick in (True, False):
        monkeypatch.setattr(read, "is_quick", lambda data, quick=quick: quick)
        found.append(read_image(stream.getvalue()))
    np.testing.assert_array_equal(*found)


def test_a_jpeg_has_a_largest_number_of_scans() -> None:
    assert scan_count(with_scans(MAX_SCANS)) == MAX_SCANS
    assert read_image(with_scans(MAX_SCANS)).shape == RGB.shape
    with pytest.raises(InputError, match="must have at most 500 scans"):
        read_image(with_scans(200_000))


def test_markers_outside_of_the_picture_are_no_scans() -> None:
    data = encode(RGB, "JPEG")
    comment = b"\xff\xfe" + struct.pack(">H", 2 + 20_000) + 10_000 * b"\xff\xda"
    assert scan_count(data[:2] + comment + data[2:] + 1000 * b"\xff\xda") == scan_count(data) == 1


@pytest.mark.parametrize("answer", [b"", b"[]\n", b'["object", 1]\n12345678', b'["uint8", -1]\n1', b'["uint8", 9]\n1'])
def test_an_answer_of_the_sandbox_that_is_no_picture_is_refused(answer: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(read, "run_in_sandbox", lambda *_, **__: answer)
    with pytest.raises(InputError, match="cannot be decoded"):
        read_image(encode(RGB, "TIFF"))

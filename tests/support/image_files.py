"""Image files of every kind, made in memory, and assertions on the arrays that are read from them."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image, ImageCms

from warpvec.errors import InputError

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
    """Return a 16-bit PNG of ``samples`` [h, w, c]; Pillow cannot write one in colour."""
    height, width = samples.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in samples.astype(">u2"))
    header = (b"IHDR", struct.pack(">IIBBBBB", width, height, 16, color_type, 0, 0, 0))
    parts = [header, *chunks, (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(png_chunk(*part) for part in parts)


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_header(width, height):
    """Return a PNG that ends where its pixels would start."""
    header = png_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + png_chunk(b"IDAT", b"")


def striped_tiff(samples, rows_per_strip, strip_count, planar=False):
    """Return an uncompressed TIFF of ``samples`` [h, w, 3] that names only its first ``strip_count`` strips."""
    height, width, _ = samples.shape
    planes = [samples[..., k] for k in range(3)] if planar else [samples]
    strips = [plane[y : y + rows_per_strip].tobytes() for plane in planes for y in range(0, height, rows_per_strip)]
    sizes = [len(strip) for strip in strips]
    start = 8 + 2 + 10 * 12 + 4 + 6 + 8 * strip_count
    offsets = [start + sum(sizes[:k]) for k in range(strip_count)]
    after = start - 6 - 8 * strip_count
    entries, values = b"", b""
    for tag, kind, numbers in [
        (256, "I", [width]), (257, "I", [height]), (258, "H", [8, 8, 8]), (259, "H", [1]), (262, "H", [2]),
        (273, "I", offsets), (277, "H", [3]), (278, "I", [rows_per_strip]), (279, "I", sizes[:strip_count]),
        (284, "H", [1 + planar]),
    ]:  # fmt: skip
        data = struct.pack(f"<{len(numbers)}{kind}", *numbers)
        if len(data) > 4:
            data, values = struct.pack("<I", after + len(values)), values + data
        entries += struct.pack("<HHI", tag, {"H": 3, "I": 4}[kind], len(numbers)) + data.ljust(4, b"\0")
    directory = struct.pack("<H", 10) + entries + bytes(4) + values
    return b"II*\0" + struct.pack("<I", 8) + directory.ljust(start - 8, b"\0") + b"".join(strips)


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
    """Return an ICC 2.4 profile (ICC.1:2001-04, section 6)."""
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
    """Return a profile with grey for every ink: L* = 100 (1 - k), halved by cyan."""
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

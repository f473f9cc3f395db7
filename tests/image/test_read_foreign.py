"""Pictures that other programs write: each is read as browsers or tifffile show it, or refused in one line."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from image_files import complaint
from PIL import Image

from warpvec.image.read import read_image

SIDE = 6
COLORS = np.zeros((SIDE, SIDE, 3), np.uint8)
COLORS[:, :3], COLORS[:, 3:] = (255, 0, 0), (0, 0, 255)
GREY = np.full((SIDE, SIDE), 96 * 257, "<u2")


def levels(data):
    return (read_image(data) * 255).round().astype(int)


def png(pixels, *chunks):
    """Return a PNG of 8-bit RGB with ``chunks`` (kind, data) before its samples."""
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    head = struct.pack(">IIBBBBB", *pixels.shape[1::-1], 8, 2, 0, 0, 0)
    parts = [(b"IHDR", head), *chunks, (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    packed = (struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


def tiff(*pages):
    """Return an uncompressed TIFF of ``pages``, each its side, its strips, and its tags as short numbers."""
    data = b"II*\0" + struct.pack("<I", 8)
    for number, (side, strips, tags) in enumerate(pages):
        # The directory comes first, then the values that do not fit into it, then the strips.
        tags = {256: [side], 257: [side], 259: [1], 273: [0] * len(strips), 278: [side], 279: [0] * len(strips), **tags}
        start = len(data)
        outer = start + 2 + 12 * len(tags) + 4
        place = outer + sum(4 * len(values) for values in tags.values() if len(values) > 1)
        tags[273] = [place + sum(map(len, strips[:index])) for index in range(len(strips))]
        tags[279] = [len(strip) for strip in strips]
        entries, more = b"", b""
        for tag, values in sorted(tags.items()):
            packed = struct.pack(f"<{len(values)}I", *values)
            entries += struct.pack("<HHI", tag, 4, len(values))
            entries += packed if len(values) == 1 else struct.pack("<I", outer + len(more))
            more += b"" if len(values) == 1 else packed
        end = place + sum(map(len, strips))
        following = 0 if number == len(pages) - 1 else end
        data += struct.pack("<H", len(tags)) + entries + struct.pack("<I", following) + more + b"".join(strips)
    return data


def grey_tiff(samples, **tags):
    return tiff((SIDE, [samples.tobytes()], {277: [1], **{int(tag[1:]): value for tag, value in tags.items()}}))


@pytest.mark.parametrize("format", ["AVIF", "PPM", "ICO", "TGA", "PCX", "QOI", "DDS", "JPEG2000"])
def test_formats_of_pillow(format):
    stream = io.BytesIO()
    side = 24  # the least that Pillow writes as ICO
    Image.fromarray(np.kron(COLORS, np.ones((4, 4, 1), np.uint8))).save(stream, format)
    found = levels(stream.getvalue())
    assert found.shape == (side, side, 3)
    assert abs(found[12, [2, -3]] - [(255, 0, 0), (0, 0, 255)]).max() <= 3


def test_heic():
    heif = pytest.importorskip("pillow_heif")
    stream = io.BytesIO()
    heif.from_pillow(Image.fromarray(np.kron(COLORS, np.ones((16, 16, 1), np.uint8)))).save(stream, quality=90)
    assert abs(levels(stream.getvalue())[48, [20, -20]] - [(255, 0, 0), (0, 0, 255)]).max() <= 3


def test_pam_with_alpha_and_few_levels():
    head = b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 4\nMAXVAL 15\nTUPLTYPE RGB_ALPHA\nENDHDR\n"
    assert levels(head + bytes([15, 0, 5, 1])).tolist() == [[[255, 0, 85, 17]]]
    assert "MAXVAL" in complaint(read_image, head + bytes([16, 0, 5, 1]))
    assert "pixels" in complaint(read_image, head.replace(b"WIDTH 1", b"WIDTH 99999999"))


def test_white_is_zero():
    assert levels(grey_tiff(GREY, t258=[16], t262=[0])).max() == 255 - 96
    assert levels(grey_tiff(GREY, t258=[16], t262=[1])).max() == 96
    unit = (GREY / 65535).astype("<f4")
    assert levels(grey_tiff(unit, t258=[32], t262=[0], t339=[3])).max() == 255 - 96


def test_samples_that_pillow_takes_for_others_are_refused():
    bands = tiff((SIDE, [GREY.tobytes()] * 4, {258: [16] * 4, 262: [1], 277: [4], 284: [2], 338: [0] * 3}))
    four = np.dstack([COLORS, COLORS[..., 0]]).tobytes()
    unspecified = tiff((SIDE, [four], {258: [8] * 4, 262: [2], 277: [4], 338: [0]}))
    signed = grey_tiff(COLORS[..., 0], t258=[8], t262=[1], t339=[2])
    wide = grey_tiff(GREY.astype("<f4"), t258=[32], t262=[1], t339=[3])
    heights = grey_tiff(GREY // 2, t258=[16], t262=[1], t339=[2])
    cases = [(heights, "sign"), (bands, "4 bands"), (unspecified, "number 4"), (signed, "sign"), (wide, "[0, 1]")]
    for data, words in cases:
        assert words in complaint(read_image, data)


def test_page_that_is_no_thumbnail():
    tags = {258: [8] * 3, 262: [2], 277: [3]}
    small = (2, [bytes(12)], {**tags, 254: [1]})
    assert levels(tiff(small, (SIDE, [COLORS.tobytes()], tags)))[..., :3].tolist() == COLORS.tolist()


def test_what_a_small_first_gif_frame_leaves_open_is_transparent():
    stream = io.BytesIO()
    Image.new("P", (2, 2), 1).save(stream, "GIF")
    data = bytearray(stream.getvalue())
    data[6:10] = struct.pack("<HH", SIDE, SIDE)  # the screen; the frame's place comes after its mark
    place = data.index(b"\x2c") + 1
    data[place : place + 4] = struct.pack("<HH", 1, 2)
    alpha = levels(bytes(data))[..., 3]
    assert alpha[2:4, 1:3].min() == 255
    assert alpha.sum() == 4 * 255


def test_gamma_and_cicp_of_png():
    dark = np.full((1, 1, 3), 30, np.uint8)
    linear = (b"gAMA", struct.pack(">I", 100_000))
    assert levels(png(dark, linear)).max() == 96  # as Chromium
    assert levels(png(dark, linear, (b"sRGB", b"\0"))).max() == 30
    assert levels(png(dark, (b"gAMA", struct.pack(">I", 45_455)))).max() == 30
    red = np.full((1, 1, 3), (200, 0, 0), np.uint8)
    assert levels(png(red, (b"cICP", bytes([12, 13, 0, 1])))).tolist() == [[[219, 0, 0]]]  # as Chromium
    assert "cICP" in complaint(read_image, png(red, (b"cICP", bytes([9, 16, 0, 1]))))


def test_first_frame_of_an_animated_png():
    stream = io.BytesIO()
    frame = Image.new("RGB", (SIDE, SIDE), "#00ff00")
    Image.fromarray(COLORS).save(stream, "PNG", save_all=True, append_images=[frame], default_image=True)
    assert levels(stream.getvalue())[0, 0].tolist() == [0, 255, 0]


def test_remedies_of_what_is_not_read():
    for data, words in [(b"<svg/>", "refine"), (b"junk", "PNG")]:
        assert words in complaint(read_image, data)

"""Damaged image files, files that claim more than they hold, and arrays of any type: read, and sometimes fitted."""

from __future__ import annotations

import os
import re
import struct
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

import numpy as np
import torture_image_files as files
from torture_case import OK, Case, Wrong
from torture_changes import mutate, with_checksums

if TYPE_CHECKING:
    from warpvec import Result

SIDES = (0, 1, 17, 4096, 7071, 7072, 10_001, 65_535, 3_735_565, 2**31 - 1, 2**32 - 1)
"""Widths and heights that a file may claim: around the limit of 5 * 10**7 pixels, and those of 16 and 32 bits."""


MAX_FITTED = 2**22
"""Most samples of a picture that is also fitted: measuring the file takes as long as the picture is large."""

LARGEST_SECONDS = 300.0
"""Time limit of a fit of the largest picture. Most of it goes into the SSIM."""

_SAMPLES = {0: 1, 2: 3, 4: 2, 6: 4}
"""Colour type of a PNG -> samples of a pixel."""


def case(chance: Random) -> Case:
    """Return the reading of one image, and for a few the fit of it."""
    make = chance.choices([_damaged_file, _claiming_file, _array, _large_file], [80, 20, 10, 0.5])[0]
    return make(chance)


def check(data: bytes, folder: Path, how: str) -> str:
    """Read ``data`` in one of the ways `WAYS`.

    Raises:
        Wrong: the result is not an image, or native code wrote to stderr.
    """
    before = os.fstat(2).st_size
    WAYS[how](data, folder)
    if os.fstat(2).st_size > before:
        raise Wrong("native code wrote to stderr")
    return OK


def _damaged_file(chance: Random) -> Case:
    kind = chance.choice(files.KINDS)
    data = mutate(chance.choice(files.seeds(kind)), chance, files.seeds(chance.choice(files.KINDS)))
    if kind == "png" and chance.random() < 0.8:
        data = with_checksums(data)
    return _case(kind, data, chance)


def _claiming_file(chance: Random) -> Case:
    make = chance.choice([_claiming_png, _claiming_tiff, _claiming_other])
    return _case(f"{make.__name__.rpartition('_')[2]} that claims more", make(chance), chance)


def _case(name: str, data: bytes, chance: Random) -> Case:
    how = chance.choices(list(WAYS), [12, 6, 1, 1])[0]
    return Case(f"{name}, {how}", lambda folder: check(data, folder, how), data)


def _claiming_png(chance: Random) -> bytes:
    """Return a PNG of any size, depth and colour type, whose chunks unpack to any number of zeros."""
    depth, color = chance.choice([1, 2, 4, 8, 16]), chance.choice([0, 2, 3, 4, 6])
    header = struct.pack(">IIBBBBB", *_size(chance), depth, color, 0, 0, chance.choice([0, 1]))
    zeros = _deflated(b"\0", chance.choice([0, 100, 10**6, 3 * 10**7]))
    text = _deflated(b"a", chance.choice([1, 10**6, 10**8]))
    before = chance.choice([[], [(b"zTXt", b"k\0\0" + text)], [(b"iCCP", b"k\0\0" + text)], [(b"PLTE", bytes(3))]])
    return _png(header, [*before, (b"IDAT", zeros)])


def _large_file(chance: Random) -> Case:
    """Return the reading of a whole PNG of the largest size that is allowed, and for some the fit and its figures."""
    color = chance.choice(list(_SAMPLES))
    data = largest_png(color)
    if chance.random() < 0.25:
        name = f"largest PNG, colour type {color}, fitted and measured"
        return Case(name, lambda folder: _measure(data), data, LARGEST_SECONDS)
    return Case(f"largest PNG, colour type {color}", lambda folder: check(data, folder, "from bytes"), data)


@cache
def largest_png(color: int) -> bytes:
    """Return a black PNG of the largest size, which has few bytes."""
    side = 6_100 if color in (4, 6) else 7_000  # below the limits of pictures with alpha and without
    packer, rows = zlib.compressobj(1), bytes(100 * (1 + side * _SAMPLES[color]))
    pixels = b"".join([*(packer.compress(rows) for _ in range(side // 100)), packer.flush()])
    return _png(struct.pack(">IIBBBBB", side, side, 8, color, 0, 0, 0), [(b"IDAT", pixels)])


def _png(header: bytes, chunks: list[tuple[bytes, bytes]]) -> bytes:
    whole = [(b"IHDR", header), *chunks, (b"IEND", b"")]
    framed = (struct.pack(">I", len(body)) + name + body + bytes(4) for name, body in whole)
    return with_checksums(b"\x89PNG\r\n\x1a\n" + b"".join(framed))


@cache
def _deflated(byte: bytes, count: int) -> bytes:
    return zlib.compress(byte * count)


def _claiming_tiff(chance: Random) -> bytes:
    """Return a TIFF with some of its numbers replaced: size, strips, samples, compression, offsets."""
    data = bytearray(chance.choice(files.seeds("tiff")))
    order = "<" if data[:2] == b"II" else ">"
    (offset,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, offset)
    for _ in range(chance.choice([1, 1, 2, 3])):
        entry = offset + 2 + 12 * chance.randrange(count)
        value = chance.choice([0, 1, 2, 3, 8, 16, 32, 17, 3_735_565, 65_535, 2**31 - 1, 2**32 - 1])
        place, form = chance.choice([(8, "I"), (8, "I"), (8, "H"), (4, "I"), (2, "H"), (0, "H")])
        struct.pack_into(order + form, data, entry + place, value if form == "I" else value & 0xFFFF)
    return bytes(data)


def _claiming_other(chance: Random) -> bytes:
    """Return a file of another kind whose header states another size."""
    kind = chance.choice(["bmp", "gif", "jpeg", "psd", "netpbm", "other", "jp2"])
    data = bytearray(chance.choice(files.seeds(kind)))
    width, height = _size(chance)
    if kind == "bmp":
        struct.pack_into("<ii", data, 18, width & 0x7FFFFFFF, chance.choice([1, -1]) * (height & 0x7FFFFFFF))
    elif kind == "gif":
        struct.pack_into("<HH", data, 6, width & 0xFFFF, height & 0xFFFF)
    elif kind == "psd":
        struct.pack_into(">II", data, 14, height, width)
    elif kind == "netpbm":
        return re.sub(rb"\d+", lambda found: b"%d" % chance.choice([int(found[0]), width, height]), bytes(data[:60]))
    elif kind == "jp2":
        struct.pack_into(">II", data, data.find(b"\xff\x51") + 6, width, height)
    elif data[:4] == b"qoif":
        struct.pack_into(">II", data, 4, width, height)
    elif data[:4] == b"DDS ":
        struct.pack_into("<II", data, 12, height, width)
    elif kind == "other":  # TGA; PCX states the last column and row
        struct.pack_into("<HH", data, 8 if data[0] == 10 else 12, width & 0xFFFF, height & 0xFFFF)
    else:
        start = max(data.find(b"\xff\xc0"), data.find(b"\xff\xc2"))
        struct.pack_into(">HH", data, start + 5, height & 0xFFFF, width & 0xFFFF)
    return bytes(data)


def _size(chance: Random) -> tuple[int, int]:
    return chance.choice(SIDES), chance.choice(SIDES)


def _array(chance: Random) -> Case:
    """Return the reading of an array of any shape, type and values."""
    random = np.random.default_rng(chance.getrandbits(32))
    shape = [chance.choice([0, 1, 2, 3, 4, 7, 24, 32]) for _ in range(chance.choice([0, 1, 2, 3, 3, 3, 3, 4]))]
    if len(shape) == 3 and chance.random() < 0.7:
        shape[2] = chance.choice([1, 2, 3, 4])
    kind = chance.choice(["u1", "u2", "u4", "i4", "i8", "f2", "f4", "f8", "?", "c8", "O", "U3", "M8[s]", ">u2", ">f4"])
    values = np.array(random.random(shape) * chance.choice([1, 1, 1, 255, -1]))
    if values.size and chance.random() < 0.1:
        values.flat[chance.randrange(values.size)] = chance.choice([np.nan, np.inf, -np.inf, 1e30, -1e-30])
    with np.errstate(all="ignore"):
        array = np.asarray(values.astype("i8" if kind == "M8[s]" else kind).astype(kind))
    if array.ndim > 1 and chance.random() < 0.2:
        array = array[::-1] if chance.random() < 0.5 else np.asfortranarray(array)
    is_fitted = chance.random() < 0.3
    return Case(f"array {shape} {kind}", lambda folder: _read(array, fitted=is_fitted))


def _read(source: Any, *, fitted: bool = False, background: str | None = None) -> str:
    from warpvec.image.read import read_image

    with np.errstate(over="ignore"):
        pixels = read_image(source, background)
    is_image = pixels.ndim == 3 and pixels.shape[2] in (3, 4) and pixels.dtype == np.float32
    if not (is_image and pixels.size and pixels.min() >= 0 and pixels.max() <= 1):  # NaN fails both comparisons
        raise Wrong(f"read as {pixels.dtype} {pixels.shape}, {pixels.min():g} to {pixels.max():g}")
    if fitted and pixels.size <= MAX_FITTED:
        _fit(source, background)
    return OK


def _measure(source: bytes) -> str:
    _fit(source).metrics  # noqa: B018 - a property that is computed here
    return OK


def _fit(source: Any, background: str | None = None) -> Result:
    from warpvec import vectorize

    result = vectorize(source, 8, iterations=3, fit_size=32, threads=1, background=background)
    if not result.svg().startswith("<"):
        raise Wrong("the file of the fit is no SVG")
    return result


def _as_file(data: bytes, folder: Path) -> str:
    path = folder / "photo.png"
    path.write_bytes(data)
    return _read(path)


WAYS: dict[str, Callable[[bytes, Path], str]] = {
    "from bytes": lambda data, folder: _read(data),
    "from a file": _as_file,
    "over a colour": lambda data, folder: _read(data, background="#123"),
    "fitted": lambda data, folder: _read(data, fitted=True),
}
"""How an image is read."""

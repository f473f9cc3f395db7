"""Files of a photo in few bytes, by every method that `bench/rate.py` compares."""

from __future__ import annotations

import io
import subprocess
import time
from collections.abc import Callable
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, features

from warpvec import vectorize
from warpvec.files import gzip_bytes
from warpvec.image.metrics import psnr, ssim
from warpvec.svg.measure import file_quality

MODES, SPECKLES, DIFFERENCES = ("spline", "polygon"), (8, 16, 32, 64, 128), (16, 32, 64, 96)
"""Settings of vtracer that decide the size of its file: curves or lines, side of the smallest area in pixels, and
difference of the colours of two layers. All combinations are traced once a photo, with whole coordinates. Fewer bits a
channel than the six of its default, more than these layers, and its simplifying fitter have fewer decibels a byte."""

TEXT_MAX = 600_000
"""Bytes of a tracing above which it is left out: svgo would not bring it down to the sizes of the bench."""

QUALITY_MAX = 100

QUALITY_STEPS = 7
"""Halvings of the range of qualities: 2^7 is more than ``QUALITY_MAX``."""


class Point(NamedTuple):
    """A file of a photo: its bytes, those of its gzip, PSNR in dB, SSIM, and the CPU seconds of making it."""

    bytes: int
    gzip_bytes: int
    psnr: float
    ssim: float
    seconds: float


def of_warpvec(path: Path, size: int, settings: dict[str, Any], *, gzip: bool) -> Point:
    """Fit the photo at ``path`` to a file of ``size`` bytes, after gzip if ``gzip``."""
    start = time.process_time()
    metrics = vectorize(path, max_bytes=size, gzip=gzip, mode="photo", **settings).metrics
    seconds = time.process_time() - start
    return Point(metrics["bytes"], metrics["gzip_bytes"], metrics["psnr"], metrics["ssim"], seconds)


def of_raster(image: Image.Image, kind: str, size: int) -> Point | None:
    """Return the file of the highest quality in at most ``size`` bytes; ``kind`` is JPEG, WEBP or AVIF.

    None if Pillow lacks the format, or if even the lowest quality has more bytes.
    """
    if kind != "JPEG" and not features.check(kind.lower()):
        return None
    start = time.process_time()
    data = _largest(lambda quality: _encoded(image, kind, quality), size)
    seconds = time.process_time() - start
    if data is None:
        return None
    drawn, pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGB")), np.asarray(image)
    return Point(len(data), len(gzip_bytes(data)), psnr(drawn, pixels), ssim(drawn, pixels), seconds)


def _encoded(image: Image.Image, kind: str, quality: int) -> bytes:
    options: dict[str, Any] = {"JPEG": {"optimize": True, "progressive": True}, "WEBP": {"method": 6}}.get(kind, {})
    file = io.BytesIO()
    image.save(file, kind, quality=quality, **options)
    return file.getvalue()


def _largest(encode: Callable[[int], bytes], size: int) -> bytes | None:
    """Return the file of the highest quality within ``size`` bytes, by halving the range of qualities."""
    low, high, best = 0, QUALITY_MAX, None
    for _ in range(QUALITY_STEPS):
        middle = (low + high + 1) // 2
        data = encode(middle)
        if len(data) <= size:
            low, best = middle, data
        else:
            high = middle - 1
        if low >= high:
            break
    if best is None:
        lowest = encode(0)
        return lowest if len(lowest) <= size else None
    return best


def of_vtracer(image: Image.Image, svgo: str | None) -> list[Point]:
    """Trace a photo by vtracer with all settings, and minify each file by the command ``svgo`` if there is one.

    Raises:
        ImportError: vtracer is not installed.
    """
    vtracer = import_module("vtracer")
    pixels, data = np.asarray(image), image.convert("RGBA").tobytes()
    points = []
    for mode, speckle, difference in product(MODES, SPECKLES, DIFFERENCES):
        start = time.process_time()
        config = vtracer.Config(mode=mode, filter_speckle=speckle, layer_difference=difference, path_precision=0)
        text = vtracer.convert_pixels(data, *image.size, config)
        seconds = time.process_time() - start
        if len(text) <= TEXT_MAX:
            points.append(_point_of(_minified(text, svgo), pixels, seconds))
    return points


def best_within(points: list[Point], size: int, *, gzip: bool) -> Point | None:
    """Return the point of the highest PSNR with at most ``size`` bytes, None if none is so small."""
    small = [point for point in points if (point.gzip_bytes if gzip else point.bytes) <= size]
    return max(small, key=lambda point: point.psnr, default=None)


def _minified(text: str, svgo: str | None) -> str:
    if svgo is None:
        return text
    done = subprocess.run([svgo, "-i", "-", "-o", "-"], input=text, capture_output=True, text=True)
    return done.stdout if done.returncode == 0 and done.stdout.startswith("<svg") else text


def _point_of(text: str, pixels: NDArray[np.uint8], seconds: float) -> Point:
    data = text.encode()
    quality = file_quality(text, pixels)
    return Point(len(data), len(gzip_bytes(data)), quality["psnr"], quality["ssim"], seconds)

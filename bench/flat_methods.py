"""Tracers that `bench/flat.py` compares: `warpvec run` with any options, vtracer, potrace, and bicubic scaling."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np
from flat_originals import SCALE, Original, Pixels
from PIL import Image

OPTIONS = {
    "auto": [],
    "flat": ["--mode", "flat"],
    "photo": ["--mode", "photo", "--curves", "64"],
    "cutout": ["--mode", "flat", "--cutout"],
}
"""Options of `warpvec run` by the name of the method."""

_RUN_SECONDS = 600


class Traced(NamedTuple):
    """A tracing: its file, or for a method that only scales, its picture at ``SCALE`` times the size over white."""

    svg: str | None
    scaled: Pixels | None
    seconds: float


class SkippedError(Exception):
    """A method cannot trace a picture; the text says why."""


Method = Callable[[Original, Path, Path], Traced]
"""It takes the original, the path of its picture, and a path for the file to write."""


def method_named(name: str, options: dict[str, list[str]]) -> Method:
    """Return the method ``name``; ``options`` has the names that stand for `warpvec run`.

    Raises:
        KeyError: there is no such method.
    """
    if name in options:
        return lambda original, picture, out: _run_warpvec(picture, out, options[name])
    return {"vtracer": _run_vtracer, "potrace": _run_potrace, "bicubic": _scale}[name]


def _run_warpvec(picture: Path, out: Path, options: list[str]) -> Traced:
    command = [sys.executable, "-m", "warpvec", "run", str(picture), str(out), *options]
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, timeout=_RUN_SECONDS)
    seconds = time.perf_counter() - start
    if done.returncode:
        raise SkippedError(f"warpvec run {' '.join(options)}: {(done.stderr.strip() or 'failed').splitlines()[-1]}")
    return Traced(out.read_text(), None, seconds)


def _run_vtracer(original: Original, picture: Path, out: Path) -> Traced:
    """Trace the picture over white with vtracer's simplifying fitter; it takes pixels with alpha for colours."""
    try:
        vtracer = import_module("vtracer")
    except ImportError:
        raise SkippedError("vtracer: skipped, the package is not installed") from None
    pixels = over_white(picture).convert("RGBA")
    start = time.perf_counter()
    svg = vtracer.convert_pixels(pixels.tobytes(), *pixels.size, vtracer.Config(simplify=2.0))
    return Traced(svg, None, time.perf_counter() - start)


def _run_potrace(original: Original, picture: Path, out: Path) -> Traced:
    """Trace a picture of one flat colour over nothing or white with potrace at its defaults."""
    if original.counts.colors != 1 or original.counts.has_gradients:
        raise SkippedError("potrace: skipped, the original has more than one colour")
    pixels = np.asarray(over_white(picture))
    gray = pixels.mean(2)
    is_dark = gray < 0.5 * (gray.min() + 255)
    color = np.median(pixels[is_dark], axis=0)
    bitmap = out.with_suffix(".pgm")
    Image.fromarray((~is_dark).astype(np.uint8) * 255).save(bitmap)
    start = time.perf_counter()
    trace_by_potrace(bitmap, out, "#" + "".join(f"{int(value):02x}" for value in color))
    return Traced(out.read_text(), None, time.perf_counter() - start)


def trace_by_potrace(bitmap: Path, out: Path, color: str = "#000000") -> None:
    """Write the outlines of the black pixels of ``bitmap`` with potrace at its defaults, one pixel a unit.

    Raises:
        SkippedError: potrace is not installed.
    """
    command = ["potrace", "--svg", "--color", color, "--output", str(out), str(bitmap)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except OSError:
        raise SkippedError("potrace: skipped, no such command (Debian package potrace)") from None


def _scale(original: Original, picture: Path, out: Path) -> Traced:
    """Scale the picture over white by bicubic interpolation."""
    start = time.perf_counter()
    pixels = over_white(picture)
    scaled = pixels.resize((SCALE * pixels.width, SCALE * pixels.height), Image.Resampling.BICUBIC)
    return Traced(None, np.asarray(scaled), time.perf_counter() - start)


def over_white(picture: Path) -> Image.Image:
    """Return the picture at a path over white."""
    with Image.open(picture) as image:
        pixels = image.convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", pixels.size, "white"), pixels).convert("RGB")

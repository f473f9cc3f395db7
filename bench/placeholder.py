"""Compare placeholders of the same bytes: warpvec's, SQIP's, and small WebP and AVIF pictures, scaled up.

Bytes are those of what a page contains: the whole data URI. SQIP counts its SVG text alone, an advantage for SQIP. PSNR
and SSIM are of the picture at full size. SQIP (npm install sqip) runs with its defaults; its shapes are random. The
small pictures have the side and the quality that give the highest PSNR within the bytes, and are scaled by a bicubic
filter, smoother than browsers do it.
"""

from __future__ import annotations

import io
import json
import subprocess
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from fits import find_images
from harness import machine_facts, machine_line, markdown_table
from numpy.typing import NDArray
from PIL import Image, features

from warpvec.image.metrics import psnr, ssim
from warpvec.image.read import read_image
from warpvec.placeholders.placeholder import BYTES_MAX, BYTES_MIN, fit_placeholder
from warpvec.svg.measure import draw

SIDES = (8, 12, 16, 20, 24, 32, 40, 48, 64)
"""Longest sides of the small pictures that are tried."""

QUALITIES = (0, 2, 5, 10, 20, 30, 40, 50, 60, 75, 90)

Pixels = NDArray[np.uint8]


class Quality(NamedTuple):
    """Figures of one placeholder; ``seconds`` of CPU are those of making it, None if that is another process."""

    bytes: int
    psnr: float
    ssim: float
    seconds: float | None


def of_warpvec(photo: NDArray[np.float32], pixels: Pixels, max_bytes: int) -> Quality:
    """Return the figures of our placeholder of at most ``max_bytes``."""
    start = time.process_time()
    found = fit_placeholder(photo, max_bytes)
    seconds = time.process_time() - start
    return _quality(len(found.uri), draw(found.svg, pixels.shape[1], pixels.shape[0]), pixels, seconds)


def of_sqip(command: str, path: Path, pixels: Pixels) -> Quality:
    """Return the figures of SQIP's SVG of the photo at ``path``."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "out.svg")
        subprocess.run([command, "-o", out, path], check=True, capture_output=True)
        text = out.read_text(encoding="utf-8")
    return _quality(len(text.encode()), draw(text, pixels.shape[1], pixels.shape[0]), pixels, None)


def of_raster(image: Image.Image, kind: str, max_bytes: int) -> Quality | None:
    """Return the best figures of a small picture of that kind, "WEBP" or "AVIF"; None if none is small enough."""
    pixels, prefix = np.asarray(image), f"data:image/{kind.lower()};base64,"
    start, best, bytes_of_best = time.process_time(), None, 0
    for data in _small_files(image, kind):
        size = len(prefix) + 4 * -(-len(data) // 3)
        if size <= max_bytes:
            large = np.asarray(Image.open(io.BytesIO(data)).convert("RGB").resize(image.size, Image.Resampling.BICUBIC))
            if best is None or psnr(large, pixels) > psnr(best, pixels):
                best, bytes_of_best = large, size
    return None if best is None else _quality(bytes_of_best, best, pixels, time.process_time() - start)


def _small_files(image: Image.Image, kind: str) -> Iterator[bytes]:
    for side in SIDES:
        factor = side / max(image.size)
        size = (max(1, round(image.width * factor)), max(1, round(image.height * factor)))
        small = image.resize(size, Image.Resampling.LANCZOS)
        for quality in QUALITIES:
            file = io.BytesIO()
            small.save(file, kind, quality=quality, method=6) if kind == "WEBP" else small.save(
                file, kind, quality=quality
            )
            yield file.getvalue()


def _quality(size: int, drawn: Pixels, pixels: Pixels, seconds: float | None) -> Quality:
    return Quality(size, psnr(drawn, pixels), ssim(drawn, pixels), seconds)


def measure(path: Path, max_bytes: int, sqip: str | None) -> dict[str, Quality]:
    """Return the figures of every kind of placeholder of one photo."""
    image = Image.open(path).convert("RGB")
    pixels, photo = np.asarray(image), read_image(path, "white", name="FOLDER")
    found = {f"warpvec, {max_bytes:,} bytes": of_warpvec(photo, pixels, max_bytes)}
    if sqip is not None:
        found["SQIP, its default"] = theirs = of_sqip(sqip, path, pixels)
        same = min(max(theirs.bytes, BYTES_MIN), BYTES_MAX)
        found["warpvec, SQIP's bytes"] = of_warpvec(photo, pixels, same)
    for kind in ("WEBP", "AVIF"):
        small = of_raster(image, kind, max_bytes) if features.check(kind.lower()) else None
        if small is not None:
            found[f"{kind}, scaled up"] = small
    return found


def table(found: dict[str, list[Quality]]) -> str:
    """Return the means of each kind as a Markdown table."""
    rows = []
    for name, qualities in found.items():
        size, decibels, similarity = (float(np.mean([quality[index] for quality in qualities])) for index in range(3))
        seconds = [quality.seconds for quality in qualities if quality.seconds is not None]
        cells = [f"{size:.0f}", f"{decibels:.2f}", f"{similarity:.3f}", f"{np.mean(seconds):.1f}" if seconds else "-"]
        rows.append([name, str(len(qualities)), *cells])
    return markdown_table(["placeholder", "photos", "bytes", "PSNR", "SSIM", "CPU s"], rows)


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--bytes", "max_bytes", type=click.IntRange(BYTES_MIN, BYTES_MAX), default=1_000, show_default=True)
@click.option(
    "--sqip", metavar="COMMAND", help="SQIP's command, such as node_modules/.bin/sqip; left out if not given."
)
@click.option("--limit", type=click.IntRange(min=1), help="Number of photos, by default all.")
def main(folder: Path, max_bytes: int, sqip: str | None, limit: int | None) -> None:
    """Compare placeholders of the photos in FOLDER."""
    found: dict[str, list[Quality]] = defaultdict(list)
    photos: dict[str, Any] = {}
    for path in find_images(folder)[:limit]:
        photos[path.name] = measure(path, max_bytes, sqip)
        for name, quality in photos[path.name].items():
            found[name].append(quality)
        click.echo(f"{path.name}: " + "; ".join(f"{n} {q.psnr:.2f} dB" for n, q in photos[path.name].items()), err=True)
    click.echo(table(found) + "\n")
    click.echo(machine_line(machine_facts()))
    line = {"bench": "placeholder", "max_bytes": max_bytes, **machine_facts()}
    line["photos"] = {name: {kind: each._asdict() for kind, each in kinds.items()} for name, kinds in photos.items()}
    click.echo(json.dumps(line))


if __name__ == "__main__":
    main()

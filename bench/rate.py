"""Measure decibels and SSIM over the bytes of a file, beside other tracers and image formats.

Rows: warpvec with `--max-bytes`; vtracer, the best of 40 settings, minified by svgo if that is given; JPEG, WebP and
AVIF of Pillow at the highest quality that fits. Bytes are those of the file, or with `--gzip` those after gzip.

The image formats win: a drawing of paths is for editing and for scaling, not for compression.

Every result goes to the file --out at once, and a second run takes it from there. --compare reads such a file of
another version and prints the Bjontegaard gain over it.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from fits import find_images
from harness import (
    comma_separated,
    comma_separated_counts,
    default_cache,
    machine_facts,
    machine_line,
    parse_settings,
    settings_option,
    source_digest,
)
from paper_values import TABLE_1
from PIL import Image
from rate_curves import Panel, write_curves
from rate_methods import Point, best_within, of_raster, of_vtracer, of_warpvec
from rate_report import gain, means, table

from warpvec.files import write_atomic

METHODS = ("warpvec", "vtracer", "JPEG", "WEBP", "AVIF")

SIZES = "5000,20000,50000,80000,100000,150000"


class Records:
    """Results by photo, method and size, kept in a JSON file.

    Raises:
        click.UsageError: the file is of other sources or settings.
    """

    def __init__(self, path: Path, settings: dict[str, Any]) -> None:
        self._path = path
        self.facts: dict[str, Any] = {"source": source_digest(), "settings": settings, **machine_facts()}
        self.points: dict[str, list[list[float]]] = {}
        if path.exists():
            found = json.loads(path.read_text())
            if any(found["facts"][name] != self.facts[name] for name in ("source", "settings")):
                raise click.UsageError(f"--out {path} is of another version or of other settings; name a new file")
            self.points = found["points"]

    def take(self, key: str, make: Callable[[], Sequence[Point]]) -> list[Point]:
        """Return the points at ``key``, made and written now if they are not there."""
        if key not in self.points:
            self.points[key] = [list(point) for point in make()]
            self._path.parent.mkdir(parents=True, exist_ok=True)
            write_atomic(self._path, json.dumps({"facts": self.facts, "points": self.points}).encode())
        return points_of(self.points[key])


def points_of(rows: list[list[float]]) -> list[Point]:
    """Return the points of rows of JSON."""
    return [Point(int(row[0]), int(row[1]), *row[2:]) for row in rows]


def measure(records: Records, path: Path, method: str, size: int, options: dict[str, Any]) -> Point | None:
    """Return the point of a photo, a method and a size; None if the method has no file so small."""
    gzip = options["gzip"]
    image = Image.open(path).convert("RGB")
    if method == "warpvec":
        key = f"{path.name} {method}{' gzip' if gzip else ''} {size}"
        return records.take(key, lambda: [of_warpvec(path, size, options["settings"], gzip=gzip)])[0]
    if method == "vtracer":
        name = f"{path.name} vtracer{' svgo' if options['svgo'] else ''}"
        return best_within(records.take(name, lambda: of_vtracer(image, options["svgo"])), size, gzip=gzip)
    found = records.take(f"{path.name} {method} {size}", lambda: [*filter(None, [of_raster(image, method, size)])])
    return found[0] if found else None


def curves_of(
    found: dict[str, dict[int, list[Point]]], value: str, *, gzip: bool
) -> dict[str, dict[int, tuple[float, float]]]:
    """Return the mean (bytes, ``value``) of each method and size over the photos; sizes that a photo lacks are out."""
    most = max((len(points) for sizes in found.values() for points in sizes.values()), default=0)
    pairs = {
        method: {
            size: [(point.gzip_bytes if gzip else point.bytes, getattr(point, value)) for point in points]
            for size, points in sizes.items()
            if len(points) == most
        }
        for method, sizes in found.items()
    }
    return means(pairs)


def gain_over(path: Path, found: dict[str, dict[int, list[Point]]], names: list[str], *, gzip: bool) -> str:
    """Return a line with the Bjontegaard gain of warpvec over the record at ``path``, on the photos ``names``."""
    recorded = json.loads(path.read_text())
    before: dict[str, dict[int, list[Point]]] = {"warpvec": defaultdict(list)}
    for key, rows in recorded["points"].items():
        name, method, *rest = key.split()
        if name in names and method == "warpvec" and ("gzip" in rest) == gzip:
            before["warpvec"][int(rest[-1])] += points_of(rows)
    parts = []
    for value, unit in (("psnr", "dB"), ("ssim", "SSIM")):
        old, new = (
            [*curves_of(each, value, gzip=gzip)["warpvec"].values()] for each in (before, {"warpvec": found["warpvec"]})
        )
        parts.append(f"{gain(old, new):+.3f} {unit}")
    return f"Bjontegaard gain over commit {recorded['facts'].get('commit')}: {', '.join(parts)}"


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--sizes", default=SIZES, show_default=True, callback=comma_separated_counts, help="Bytes of the files.")
@click.option("--methods", default=",".join(METHODS), show_default=True, callback=comma_separated)
@click.option("--gzip", is_flag=True, help="Count the bytes after gzip.")
@click.option("--limit", type=click.IntRange(min=1), help="Number of photos, by default all.")
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="JSON file [rate.json in a temp folder].")
@click.option("--curves", "picture", type=click.Path(dir_okay=False, path_type=Path), help="SVG file of the curves.")
@click.option("--compare", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="An older JSON file.")
@click.option("--svgo", metavar="COMMAND", help="svgo's command, such as node_modules/.bin/svgo.")
@settings_option
def main(folder: Path, sizes: list[int], methods: list[str], limit: int | None, **options: Any) -> None:
    """Measure the quality of the photos in FOLDER over the bytes of their files."""
    options["settings"] = parse_settings(options.pop("assignments"))
    gzip: bool = options["gzip"]
    records = Records(options["out"] or default_cache() / "rate.json", options["settings"])
    paths = find_images(folder, limit)
    found: dict[str, dict[int, list[Point]]] = {method: defaultdict(list) for method in methods}
    for path in paths:
        for method in methods:
            for size in sizes:
                point = measure(records, path, method, size, options)
                if point is not None:
                    found[method][size].append(point)
                    click.echo(f"{path.name} {method} {size:,}: {point.bytes:,} bytes, {point.psnr:.2f} dB", err=True)
    kind = "after gzip" if gzip else "of the file"
    click.echo(f"Means of {len(paths)} photos; bytes {kind}. We claim editing and scaling, not compression.\n")
    panels = []
    for value, name, title in (("psnr", "PSNR", "PSNR in dB"), ("ssim", "SSIM", "SSIM")):
        curves = curves_of(found, value, gzip=gzip)
        click.echo(table(curves, sizes, name) + "\n")
        panels.append(Panel(title, {method: list(curve.values()) for method, curve in curves.items()}, sizes))
    if options["picture"] is not None:
        write_curves(panels, options["picture"])
    seconds = [point.seconds for points in found.get("warpvec", {}).values() for point in points]
    if seconds:
        click.echo(f"warpvec: {np.mean(seconds):.1f} CPU seconds a file")
    papers = ", ".join(f"{count} curves {TABLE_1['paper', count].psnr:.2f} dB" for count in (256, 512, 1024))
    click.echo(f"the paper, all 24 photos, its soft image, no bytes given: {papers}")
    if options["compare"] is not None and "warpvec" in found:
        click.echo(gain_over(options["compare"], found, [path.name for path in paths], gzip=gzip))
    click.echo(machine_line(machine_facts()))


if __name__ == "__main__":
    main()

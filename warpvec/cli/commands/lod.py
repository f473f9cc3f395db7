"""``warpvec lod``: list, select and split the levels of detail of an SVG."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import click

from warpvec.checks import in_one_line
from warpvec.cli.arguments import (
    background_option,
    check_background,
    check_one_stdin,
    check_out,
    json_option,
    read_photo,
    read_svg_bytes,
    write_drawing,
)
from warpvec.cli.paths import check_distinct_files
from warpvec.cli.summary import finite
from warpvec.errors import InputError

_HEADS = ["level", "paths", "up to it", "bytes", "PSNR"]
"""Names of the figures of a level; the last one is of an image."""


@click.command(short_help="List the levels of detail of an SVG, or keep some.")
@click.argument("svg", metavar="SVG")
@click.option("--levels", help="Levels to keep: 2, 0-3, -3, 2- or a list with commas; needs -o.")
@click.option("-o", "--output", metavar="FILE", help="File for the kept levels: .svg, .svgz or - for stdout.")
@click.option("--split", is_flag=True, help="Write SVG-level-K.svg, with all levels up to K, for each level K.")
@click.option("--list", "as_list", is_flag=True, help="List the levels. This is the default.")
@click.option("--image", metavar="IMAGE", help="For each level, also list the PSNR of the picture up to that level.")
@background_option
@json_option
def lod(
    svg: str,
    levels: str | None,
    output: str | None,
    split: bool,
    as_list: bool,
    image: str | None,
    background: str | None,
    as_json: bool,
) -> None:
    """List the levels of detail of the file SVG (- for stdin), or keep some of them.

    In a file of warpvec a level is a layer: one generation of paths. In other files a level is a top-level group.
    Levels count from 0. Kept levels are not changed. The levels 0 to K make a picture of their own.
    """
    _check_options(svg, levels, output, split)
    check_background(background, image)
    check_one_stdin({"SVG": svg, "--image": image})
    check_distinct_files({"SVG": svg, "--image": image, "-o": output})
    data = read_svg_bytes(svg)
    if levels is not None and output is not None:
        _write_levels(data, levels, output)
    if split:
        _write_prefixes(data, svg, echo=output != "-")
    if as_list or image is not None or not (split or levels):
        rows = _rows(data, image, background)
        click.echo(json.dumps(finite(rows)) if as_json else _table(rows), err=output == "-")


def _check_options(svg: str, levels: str | None, output: str | None, split: bool) -> None:
    if (levels is None) != (output is None):
        given, missing = ("--levels", "-o") if output is None else ("-o", "--levels")
        raise InputError(given, f"must be given with {missing}", remedy=f"add {missing}")
    if split and svg == "-":
        raise InputError("SVG", "must be a file with --split, which names files after it", "- for stdin", "save it")


def _write_levels(data: bytes, levels: str, output: str) -> None:
    from warpvec.svg.layers import check_has_levels, parse_levels, read_layers, select_levels

    check_out(output, "-o")
    layers = read_layers(data)
    check_has_levels(layers)
    write_drawing(select_levels(data, parse_levels(levels, {layer.level for layer in layers})), output)


def _write_prefixes(data: bytes, svg: str, echo: bool) -> None:
    from warpvec.svg.layers import prefixes

    path = Path(svg)
    files = {str(path.with_name(f"{path.stem}-level-{level}{path.suffix}")): text for level, text in prefixes(data)}
    for target in files:
        check_out(target)
    for target, text in files.items():
        write_drawing(text, target)
        click.echo(in_one_line(target), err=not echo)


def _rows(data: bytes, image: str | None, background: str | None) -> list[dict[str, Any]]:
    """Return for each level its path count, and the path count and bytes of the file with all levels up to it.

    With ``image`` the row has the PSNR of that file too.
    """
    from warpvec.image.metrics import psnr
    from warpvec.svg.layers import prefixes, read_layers
    from warpvec.svg.measure import draw_like

    photo = None if image is None else read_photo(image, background)
    path_counts: Counter[int] = Counter()
    for layer in read_layers(data):
        path_counts[layer.level] += layer.painted_count
    rows: list[dict[str, Any]] = []
    for level, text in prefixes(data):
        total = sum(count for other, count in path_counts.items() if other <= level)
        row = {"level": level, "paths": path_counts[level], "prefix_paths": total, "prefix_bytes": len(text.encode())}
        rows.append(row if photo is None else {**row, "prefix_psnr": psnr(draw_like(text, photo), photo)})
    return rows


def _table(rows: list[dict[str, Any]]) -> str:
    """Return a line for each level, with figures right-aligned under their names."""
    lines = [_HEADS[: len(rows[0])], *(list(map(_shown, row, row.values())) for row in rows)]
    return "\n".join("  ".join(f"{word:>9}" for word in line) for line in lines)


def _shown(name: str, value: float) -> str:
    return f"{value:.2f} dB" if name == "prefix_psnr" else f"{value:,}"

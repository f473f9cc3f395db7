"""Measure `warpvec refine`: on the tracings of vtracer, on disturbed originals, and on originals as they stand.

    python bench/refine.py FOLDER [--tracings FOLDER] [--iterations 500] [--gradients auto] [--names a,b]

FOLDER has NAME.png and NAME.svg, such as the flat art. The tracings are NAME.svg in a folder of their own, made with
``vtracer.convert_pixels(rgba, width, height, vtracer.Config(simplify=2.0))`` from the pictures over white.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
import torch
from flat_methods import over_white
from numpy.typing import NDArray

import warpvec
from warpvec.cli.settings_command import ValueOf
from warpvec.config.fit_config import SETTINGS
from warpvec.geometry.crossings import self_crossings
from warpvec.geometry.forms.form import ANGLE, SIZES
from warpvec.geometry.joints import Joints, with_lines
from warpvec.geometry.paints.registry import FLAT, RADIAL
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

GRADIENTS = ValueOf("gradients", SETTINGS["gradients"].kind)
"""Values of --gradients."""

COLOR_NOISE = 0.1
"""Noise of the stops of a disturbed gradient, with colours in [0, 1]."""


class Row(NamedTuple):
    """A refined drawing: PSNR in dB and bytes before and after, and counts of what must stay."""

    name: str
    before: float
    after: float
    start_bytes: int
    bytes: int
    cpu_seconds: float
    added_crossings: int
    lost_kinds: int


def disturbed(scene: Scene, points: float, gradients: bool, seed: int = 0) -> Scene:
    """Return ``scene`` with nodes, forms and widths moved by normal noise of ``points`` px; ``gradients`` too.

    A smooth node stays smooth with its handles, a line straight, and a form stays one.
    """
    generator = torch.Generator().manual_seed(seed)
    joints = Joints.of(scene)
    anchor, leaving, arriving = joints.values(scene)
    moved = anchor + points * torch.randn(anchor.shape, generator=generator)
    forms = None if scene.forms is None else _disturbed_forms(scene.forms, points, generator)
    scene = replace(scene, segments=joints.segments(moved, leaving, arriving), forms=None).with_forms(forms)
    if scene.strokes is not None:
        noise = points * torch.randn(scene.strokes.width.shape, generator=generator)
        width = torch.maximum(scene.strokes.width + noise, scene.strokes.width / 2)
        width = torch.where(scene.strokes.is_stroked, width, scene.strokes.width)
        scene = replace(scene, strokes=replace(scene.strokes, width=width))
    return _with_disturbed_gradients(scene, points, generator) if gradients else scene


def _disturbed_forms(forms: Forms, points: float, generator: torch.Generator) -> Forms:
    """Return ``forms`` with noise of ``points`` px in the places and sizes that they have."""
    parameters, noise = forms.parameters.clone(), points * torch.randn(forms.parameters.shape, generator=generator)
    for _, form, paths in forms.groups():
        for place in sorted({*form.free} - {ANGLE}):
            old = forms.parameters[paths, place]
            new = old + noise[paths, place]
            parameters[paths, place] = torch.maximum(new, old / 2) if place in SIZES else new
    return replace(forms, parameters=parameters)


def _with_disturbed_gradients(scene: Scene, points: float, generator: torch.Generator) -> Scene:
    """Return ``scene`` with noise of ``points`` px in the ends of its gradients, and some in their end colours."""
    paints = scene.gradients
    if paints is None:
        return scene
    ends = paints.geometry + points * torch.randn(paints.geometry.shape, generator=generator)
    colors = [
        (color + COLOR_NOISE * torch.randn(color.shape, generator=generator)).clamp(0, 1)
        for color in (scene.color, paints.end_color)
    ]
    is_painted = (paints.kind != FLAT)[:, None]
    ends[:, 3] = torch.where(paints.kind == RADIAL, paints.geometry[:, 3], ends[:, 3])
    color = torch.where(is_painted, colors[0], scene.color)
    return replace(scene, color=color, gradients=replace(paints, geometry=ends, end_color=colors[1]))


def drawing_of(path: Path, photo: NDArray[np.uint8]) -> Scene:
    """Return the drawing at ``path`` in pixels of ``photo``."""
    loaded, (height, width) = read_svg(path.read_bytes()), photo.shape[:2]
    return loaded.scene.scaled(width / loaded.width, height / loaded.height)


def refined(name: str, photo: NDArray[np.uint8], svg: str, settings: dict[str, Any], threads: int = 2) -> Row:
    """Refine ``svg`` with the ``settings`` of `warpvec.refine` and return the figures."""
    seconds = time.process_time()
    result = warpvec.refine(photo, svg, **settings, threads=threads, metadata=False)
    seconds = time.process_time() - seconds
    start, end = (drawing_from(text, photo) for text in (svg, result.svg()))
    added = (self_crossings(end) - self_crossings(start)).clamp_min(0).sum() if len(start) == len(end) else -1
    return Row(
        name,
        result.drawing.start_psnr or 0.0,
        result.metrics["psnr"],
        len(svg.encode()),
        result.metrics["bytes"],
        seconds,
        int(added),
        lost_kinds(start, end),
    )


def drawing_from(text: str, photo: NDArray[np.uint8]) -> Scene:
    """Return the drawing in ``text`` in pixels of ``photo``, with straight curves as lines."""
    loaded, (height, width) = read_svg(text), photo.shape[:2]
    return with_lines(loaded.scene.scaled(width / loaded.width, height / loaded.height))


def lost_kinds(start: Scene, end: Scene) -> int:
    """Return how many lines, smooth nodes, forms and strokes ``end`` has lost; -1 if its segments are others."""
    before, after = Joints.of(start), Joints.of(end)
    if len(before.is_line) != len(after.is_line):
        return -1
    lost = (before.is_line & ~after.is_line).sum() + (before.is_smooth & ~after.is_smooth).sum()
    forms = [Forms.none(scene.color) if scene.forms is None else scene.forms for scene in (start, end)]
    lost += (forms[0].is_form & (forms[0].kind != forms[1].kind)).sum()
    if start.strokes is not None:
        stays = torch.zeros_like(start.strokes.is_stroked) if end.strokes is None else end.strokes.is_stroked
        lost += (start.strokes.is_stroked & ~stays).sum()
    return int(lost)


def drawings(folder: Path, tracings: Path | None, kind: str, names: list[str]) -> Iterator[tuple[str, str]]:
    """Yield name and text of each drawing of a ``kind``: tracing, original, noise or noise-gradients."""
    for path in sorted(folder.glob("*.svg")):
        if names and path.stem not in names:
            continue
        if kind == "tracing" and tracings is not None:
            yield path.stem, (tracings / path.name).read_text()
        elif kind == "original":
            yield path.stem, path.read_text()
        elif kind != "tracing":
            photo = np.asarray(over_white(path.with_suffix(".png")))
            scene = disturbed(drawing_of(path, photo), 1.0, kind == "noise-gradients")
            yield path.stem, write_svg(scene, photo.shape[1], photo.shape[0])


@click.command()
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
@click.option("--tracings", type=click.Path(exists=True, path_type=Path))
@click.option("--kinds", default="tracing,original,noise,noise-gradients", show_default=True)
@click.option("--iterations", default=500, show_default=True)
@click.option("--gradients", type=GRADIENTS, default=0.0, help="Paths that may have one, as in warpvec refine.")
@click.option("--names", default="", help="Only these drawings.")
def main(folder: Path, tracings: Path | None, kinds: str, names: str, **settings: Any) -> None:
    """Print a row for each drawing of FOLDER and the means."""
    for kind in kinds.split(","):
        rows = []
        for name, text in drawings(folder, tracings, kind, [each for each in names.split(",") if each]):
            row = refined(name, np.asarray(over_white(folder / f"{name}.png")), text, settings)
            rows.append(row)
            click.echo(
                f"| {kind} | {name} | {row.before:.2f} | {row.after:.2f} | {row.bytes / row.start_bytes:.2f}"
                f" | {row.cpu_seconds:.1f} | {row.added_crossings} | {row.lost_kinds} |"
            )
        if rows:
            values = [[min(row.before, 99.0), min(row.after, 99.0), row.cpu_seconds] for row in rows]
            means = np.mean(values, 0)
            ratio = sum(row.bytes for row in rows) / sum(row.start_bytes for row in rows)
            click.echo(f"| {kind} | mean | {means[0]:.2f} | {means[1]:.2f} | {ratio:.2f} | {means[2]:.1f} |")


if __name__ == "__main__":
    main()

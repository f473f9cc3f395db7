"""Draw the paper's figures: pictures side by side, animations, colouring by generation, and a plot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from warpvec.geometry.scene import Scene

Pixels = NDArray[np.uint8]

TILE_WIDTH, CAPTION_WIDTH = 384, 200
"""Pixels: max width of a picture in a sheet, so that six fit side by side on a screen, and min width of a tile."""

FRAME_MILLISECONDS, LAST_FRAME_MILLISECONDS = 80, 2000
"""Duration of a frame of an animation, and of its last frame."""

_TEXT_SIZE, _LINE_HEIGHT, _GAP = 14, 18, 6

# Viridis in equal steps, from dark to light, so that lightness alone shows the order.
_RAMP = ((68, 1, 84), (72, 40, 120), (62, 74, 137), (49, 104, 142), (38, 130, 142),
         (31, 158, 137), (53, 183, 121), (110, 206, 88), (181, 222, 43), (253, 231, 37))  # fmt: skip


class Tile(NamedTuple):
    """A picture [h, w, 3] and the lines of text under it."""

    pixels: Pixels
    caption: str


def sheet(rows: Sequence[Sequence[Tile]], tile_width: int = TILE_WIDTH) -> Image.Image:
    """Place the tiles in rows on white; reduce pictures that are wider than ``tile_width``."""
    images = [[_tile_image(tile, tile_width) for tile in row] for row in rows]
    width = max(sum(image.width + _GAP for image in row) for row in images) - _GAP
    canvas = Image.new("RGB", (width, sum(max(image.height for image in row) for row in images)), "white")
    top = 0
    for row in images:
        left = 0
        for image in row:
            canvas.paste(image, (left, top))
            left += image.width + _GAP
        top += max(image.height for image in row)
    return canvas


def _tile_image(tile: Tile, width: int) -> Image.Image:
    picture = Image.fromarray(tile.pixels)
    if picture.width > width:
        height = max(1, round(picture.height * width / picture.width))
        picture = picture.resize((width, height), Image.Resampling.LANCZOS)
    lines = tile.caption.count("\n") + 1
    size = (max(picture.width, CAPTION_WIDTH), picture.height + lines * _LINE_HEIGHT + _GAP)
    canvas = Image.new("RGB", size, "white")
    canvas.paste(picture, (0, 0))
    font = ImageFont.load_default(_TEXT_SIZE)
    ImageDraw.Draw(canvas).multiline_text((0, picture.height), tile.caption, "black", font)
    return canvas


def save_animation(path: Path, frames: Sequence[Image.Image]) -> None:
    """Write ``frames``, all of one size, as an animated WebP that repeats forever."""
    durations = [FRAME_MILLISECONDS] * (len(frames) - 1) + [LAST_FRAME_MILLISECONDS]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=80)


def by_generation(scene: Scene) -> Scene:
    """Colour every path of ``scene`` by its generation, the first the darkest, over black."""
    count = int(scene.generation.max()) + 1 if len(scene) else 1
    colors = torch.tensor(np.array([ramp(k / max(count - 1, 1)) for k in range(count)]) / 255.0, dtype=torch.float32)
    return replace(scene, color=colors[scene.generation], background=torch.zeros_like(scene.background))


def ramp(share: float) -> tuple[float, ...]:
    """Return the colour at ``share`` (0 to 1) of the colour map, with channels from 0 to 255."""
    positions = np.linspace(0.0, 1.0, len(_RAMP))
    return tuple(float(np.interp(share, positions, channel)) for channel in zip(*_RAMP, strict=True))


def plot_histories(path: Path, histories: Mapping[str, Sequence[Mapping[str, float]]], title: str) -> None:
    """Plot PSNR over iterations and over seconds, with a line for each label.

    Raises:
        click.ClickException: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise click.ClickException(
            f"{path.name} was left out, it needs matplotlib; pip install 'warpvec[paper]' and run again, fits are kept"
        ) from error
    figure = Figure(figsize=(10, 4), layout="constrained")
    for axes, name in zip(figure.subplots(1, 2, sharey=True), ("iteration", "seconds"), strict=True):
        for label, history in histories.items():
            axes.plot([entry[name] for entry in history], [entry["psnr"] for entry in history], label=label)
        axes.set(xlabel=name, ylabel="PSNR of the soft image [dB]")
        axes.grid(alpha=0.3)
        axes.legend()
    figure.suptitle(title)
    figure.savefig(path, dpi=120)

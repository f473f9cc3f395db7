"""Draw pictures with one shadow or glow of our own making, and compare what warpvec finds with what was drawn.

    python bench/shadows.py [--ground flat|card|ramp|two|none] [--form same|ellipse] [--count 30] [--seed 0]

Each seed is a drawing: one to three shapes, their shadow or glow below them, and a ground. With ``--form ellipse`` the
shadow is an ellipse at their feet. The pictures are drawn with an exact Gaussian. Offset, sigma and colour are read
from the soft paths of the file. Its colour is that of a full shadow over each colour of the ground, or over black and
white if there is none; PSNR is that of the file as warpvec draws it, and as resvg does, whose blur is an
approximation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np
from harness import markdown_table
from numpy.typing import NDArray

import warpvec
from warpvec.geometry.scene import Scene
from warpvec.image.colors import parse_color
from warpvec.image.metrics import psnr
from warpvec.rendering.draw import draw_8_bits
from warpvec.svg.read import read_svg

GROUNDS = ("flat", "card", "ramp", "two", "none")
"""What is below a shadow: one colour, a card on a page, a gradient, two colours, or a transparent picture's nothing."""

FORMS = ("same", "ellipse")
"""Outline of a shadow: that of the shapes, or an ellipse."""

SIGMAS = (1.0, 20.0)
"""Range of the standard deviations in pixels; their logarithms are spread evenly."""

SIDES = (200, 400)
"""Range of the side of a picture in pixels."""

GLOW_SHARE = 0.3
"""Share of drawings with a glow, which is not moved, in place of a shadow."""

CONTRAST = 0.12
"""Least difference of a shape and its shade in one channel. Without an edge, nobody sees where a glow begins."""

SIGMA_LIMIT, OFFSET_LIMIT, COLOR_LIMIT, PSNR_LIMIT = 0.1, 0.3, 2.0, 45.0
"""What a drawing must reach: a share of sigma, pixels, levels, and dB."""


@dataclass(frozen=True)
class Shade:
    """A shadow: its blur and offset in pixels, its colour, and its opacity."""

    sigma: float
    offset: tuple[float, float]
    color: str
    opacity: float


@dataclass(frozen=True)
class Original:
    """A drawing.

    Attributes:
        side: of its picture in pixels.
        data: the outline of the shadow, before it is moved.
        ground: the elements of the ground.
        grounds: its colours.
        shapes: the elements of the shapes.
        shade: their shadow.
    """

    side: int
    data: str
    ground: str
    grounds: list[str]
    shapes: str
    shade: Shade

    @property
    def svg(self) -> str:
        """The file."""
        shade = self.shade
        x, y = shade.offset
        head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.side}" height="{self.side}"><defs>'
        region = f'filterUnits="userSpaceOnUse" x="-200" y="-200" width="{self.side + 400}" height="{self.side + 400}"'
        blur = f'<feGaussianBlur stdDeviation="{shade.sigma}"/>'
        blurred = f'<filter id="b" {region} color-interpolation-filters="sRGB">{blur}</filter></defs>'
        look = f'filter="url(#b)" fill="{shade.color}" fill-opacity="{shade.opacity}"'
        below = f'<path transform="translate({x} {y})" {look} d="{self.data}"/>'
        return f"{head}{blurred}{self.ground}{below}{self.shapes}</svg>"


@dataclass(frozen=True)
class Row:
    """How far what was found is from what was drawn: shares, pixels, levels and dB; NaN for a shadow not found."""

    seed: int
    original: Original
    paths: int
    soft: int
    sigma: float
    offset: float
    color: float
    psnr: float
    resvg: float

    @property
    def within(self) -> tuple[bool, bool, bool, bool]:
        """Which limits it keeps."""
        return (
            self.sigma <= SIGMA_LIMIT, self.offset <= OFFSET_LIMIT, self.color <= COLOR_LIMIT, self.psnr >= PSNR_LIMIT,
        )  # fmt: skip


def original(seed: int, ground: str, form: str = "same") -> Original:
    """Return the drawing of a seed."""
    random = np.random.default_rng(seed)
    side = int(random.integers(*SIDES))
    sigma = float(np.exp(random.uniform(*np.log(SIGMAS))))
    is_glow = random.random() < GLOW_SHARE
    # A ground that is far from black or white tells shadow and glow from itself.
    level = random.uniform(0.05, 0.35) if is_glow else random.uniform(0.65, 1.0)
    below = _tinted(random, level)
    reach = 0.0 if is_glow else random.uniform(0.3, 2.0) * sigma + 1.0
    turn = random.uniform(0.0, 2.0 * math.pi)
    color = _tinted(random, random.uniform(0.75, 1.0) if is_glow else random.uniform(0.0, 0.25))
    offset = (reach * math.cos(turn), reach * math.sin(turn))
    shade = Shade(sigma, offset, color, round(random.uniform(0.4, 0.95), 2))
    shapes = [_shape(random, side, place) for place in _places(random, sigma)]
    fills = [_unlike(random, below, shade) for _ in shapes]
    drawn = "".join(f'<path fill="{fill}" d="{data}"/>' for fill, data in zip(fills, shapes, strict=True))
    other = _tinted(random, level)
    grounds = {"none": ["#000000", "#ffffff"], "flat": [below], "card": [below]}.get(ground, [below, other])
    if form == "ellipse":
        data, shade = _at_the_feet(random, side, sigma), replace(shade, offset=(0.0, 0.0))
    else:
        data = "".join(shapes)
    return Original(side, data, _ground(ground, below, other, side), grounds, drawn, shade)


def _tinted(random: np.random.Generator, level: float) -> str:
    channels = np.clip(255.0 * (level + random.uniform(-0.12, 0.12, 3)), 0, 255).astype(int)
    return "#" + "".join(f"{value:02x}" for value in channels)


def _unlike(random: np.random.Generator, below: str, shade: Shade) -> str:
    """Return the fill of a shape whose edge shows: it is neither the shade nor the half of it at its own edge."""
    ground, color = np.array(parse_color(below)), np.array(parse_color(shade.color))
    shades = [ground + share * shade.opacity * (color - ground) for share in (0.25, 0.5, 0.75, 1.0)]
    while True:
        fill = _tinted(random, random.uniform(0.25, 0.7))
        if min(np.abs(parse_color(fill) - each).max() for each in shades) >= CONTRAST:
            return fill


def _places(random: np.random.Generator, sigma: float) -> list[tuple[float, float, float]]:
    """Return centre and radius of each shape, as shares of the side."""
    if sigma > 8.0 or random.random() < 0.5:
        return [(0.5, 0.5, random.uniform(0.18, 0.25))]
    return [(0.3, 0.35, random.uniform(0.12, 0.16)), (0.68, 0.62, random.uniform(0.12, 0.18))]


def _shape(random: np.random.Generator, side: int, place: tuple[float, float, float]) -> str:
    """Return the data of a disk, a rounded box or a star."""
    x, y, r = (round(side * share, 2) for share in place)  # or the arcs of a disk, as written, are no half circles
    kind = random.integers(3)
    if kind == 0:
        return f"M{x - r:.2f} {y:.2f}a{r:.2f} {r:.2f} 0 1 0 {2 * r:.2f} 0a{r:.2f} {r:.2f} 0 1 0 {-2 * r:.2f} 0z"
    if kind == 1:
        w, h, c = r * random.uniform(0.8, 1.3), r * random.uniform(0.6, 1.0), 0.3 * r
        along, up, turn = 2 * (w - c), 2 * (h - c), f"a{c:.2f} {c:.2f} 0 0 1"
        top = f"M{x - w + c:.2f} {y - h:.2f}h{along:.2f}{turn} {c:.2f} {c:.2f}v{up:.2f}{turn} {-c:.2f} {c:.2f}"
        return f"{top}h{-along:.2f}{turn} {-c:.2f} {-c:.2f}v{-up:.2f}{turn} {c:.2f} {-c:.2f}z"
    count, inner = int(random.integers(4, 8)), random.uniform(0.5, 0.7)
    turns = np.arange(2 * count) * math.pi / count + random.uniform(0.0, 1.0)
    radii = r * np.where(np.arange(2 * count) % 2, inner, 1.0)
    points = np.stack([x + radii * np.cos(turns), y + radii * np.sin(turns)], 1)
    return "M" + "L".join(f"{a:.2f} {b:.2f}" for a, b in points) + "z"


def _at_the_feet(random: np.random.Generator, side: int, sigma: float) -> str:
    """Return the data of an ellipse below the middle, with a smaller radius of at least two standard deviations."""
    x, y, wide = 0.5 * side, 0.72 * side, side * random.uniform(0.2, 0.3)
    high = max(2.0 * sigma, wide * random.uniform(0.15, 0.4))
    half = f"a{wide:.2f} {high:.2f} 0 0 1"
    return f"M{x - wide:.2f} {y:.2f}{half} {2 * wide:.2f} 0{half} {-2 * wide:.2f} 0z"


def _ground(kind: str, below: str, other: str, side: int) -> str:
    """Return the elements of a ground of one or two colours."""
    if kind == "none":
        return ""
    whole = f'<rect width="{side}" height="{side}" fill="{below}"/>'
    if kind == "flat":
        return whole
    if kind == "card":
        edge, size = round(0.03 * side), side - 2 * round(0.03 * side)
        card = f'<rect x="{edge}" y="{edge}" width="{size}" height="{size}" rx="{0.1 * side:.2f}" fill="{below}"/>'
        return f'<rect width="{side}" height="{side}" fill="#ffffff"/>{card}'
    if kind == "two":
        # Its edge runs below the shapes.
        return f'{whole}<rect y="{0.5 * side:.2f}" width="{side}" height="{side}" fill="{other}"/>'
    stops = f'<stop stop-color="{below}"/><stop offset="1" stop-color="{other}"/>'
    axis = 'gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="0"'
    ramp = f'<linearGradient id="r" {axis} y2="{side}">{stops}</linearGradient>'
    return f'{ramp}<rect width="{side}" height="{side}" fill="url(#r)"/>'


def measured(seed: int, ground: str, form: str, folder: Path | None = None) -> Row:
    """Draw a seed, let warpvec turn it into a file, and compare."""
    truth = original(seed, ground, form)
    scene = read_svg(truth.svg).scene
    side = truth.side
    picture = draw_8_bits(scene, side, side, 1)
    result = warpvec.vectorize(picture, mode="flat", threads=1, device="cpu")
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{seed:02d}.svg").write_text(truth.svg)
        result.save(folder / f"{seed:02d}_ours.svg")
    found = read_svg(result.svg()).scene
    drawn = draw_8_bits(found, side, side, 1)
    file, resvg = psnr(_over_white(drawn), _over_white(picture)), float(result.metrics["psnr"])
    soft = [] if found.softness is None else found.softness.is_soft.nonzero().flatten().tolist()
    if not soft:
        return Row(seed, truth, len(found), 0, math.nan, math.nan, math.nan, file, resvg)
    # The best soft path stands for all; more than one is a fault that the row shows.
    true = _only(scene, int((scene.softness.sigma > 0).nonzero()[0]))  # type: ignore[union-attr]
    rows = [_compared(true, _only(found, path), side, truth.grounds) for path in soft]
    return Row(seed, truth, len(found), len(soft), *min(rows), file, resvg)


def _compared(true: Scene, found: Scene, side: int, grounds: list[str]) -> tuple[float, float, float]:
    """Return the errors of sigma (a share), offset (pixels) and colour (levels) of one soft path."""
    assert true.softness is not None and found.softness is not None
    sigma = float(found.softness.sigma / true.softness.sigma) - 1.0
    offset = math.dist(_middle(true, side), _middle(found, side))
    colors = [
        [
            float(each.opacity) * each.color[0].numpy() + (1.0 - float(each.opacity)) * np.array(below)
            for each in (true, found)
        ]
        for below in map(parse_color, grounds)
    ]
    return abs(sigma), offset, max(255.0 * float(np.abs(one - two).max()) for one, two in colors)


def _only(scene: Scene, path: int) -> Scene:
    return scene.select(scene.color.new_tensor([path]).long())


def _middle(path: Scene, side: int) -> tuple[float, float]:
    """Return the middle of the area of a path, in pixels."""
    plain = replace(
        path, softness=None, color=path.color * 0.0, opacity=path.opacity * 0.0 + 1.0, gradients=None,
        background=path.background * 0.0 + 1.0, transparent=False,
    )  # fmt: skip
    margin = side // 4
    area = 255.0 - draw_8_bits(plain.moved(margin, margin), 2 * side, 2 * side, 1)[..., 0].astype(float)
    y, x = np.indices(area.shape)
    return float((area * x).sum() / area.sum()) - margin, float((area * y).sum() / area.sum()) - margin


def _over_white(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    if pixels.shape[2] == 3:
        return pixels
    alpha = pixels[..., 3:] / 255.0
    return np.round(alpha * pixels[..., :3] + 255.0 * (1.0 - alpha)).astype(np.uint8)


@click.command()
@click.option("--ground", type=click.Choice(GROUNDS), default="flat", show_default=True)
@click.option("--form", type=click.Choice(FORMS), default="same", show_default=True, help="Outline of the shadow.")
@click.option("--count", default=30, show_default=True, help="Drawings.")
@click.option("--seed", default=0, show_default=True, help="Seed of the first drawing.")
@click.option("--save", type=click.Path(file_okay=False, path_type=Path), help="Folder of originals and drawings.")
def main(ground: str, form: str, count: int, seed: int, save: Path | None) -> None:
    """Count how many shadows are found as they were drawn."""
    rows = []
    for each in range(seed, seed + count):
        row = measured(each, ground, form, save)
        rows.append(row)
        shade = row.original.shade
        click.echo(
            f"{each}: sigma {shade.sigma:.2f}, {row.soft} soft of {row.paths} paths; off by {100 * row.sigma:.1f} %, "
            f"{row.offset:.2f} px, {row.color:.1f} levels; {row.psnr:.2f} dB, by resvg {row.resvg:.2f}"
            f"{'' if all(row.within) else '  <-- misses'}"
        )
    counts = [sum(kept) for kept in zip(*(row.within for row in rows), strict=True)]
    names = ("ground", "drawings", "sigma", "offset", "colour", "file", "all")
    whole = sum(all(row.within) for row in rows)
    click.echo("\n" + markdown_table(names, [(ground, len(rows), *counts, whole)]))


if __name__ == "__main__":
    main()

"""Read a drawing as parts for a machine: outlines in millimetres of lines, arcs and cubics, or whole circles.

The page is not a part: neither the background nor a path that covers nearly all of the canvas.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch

from warpvec.arrays import Floats, Mask
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.forms.form import ANGLE, CORNER, FIRST, SECOND, X, Y
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, ROUND_RECT
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import CAPS, JOINS
from warpvec.making.curves import CHORD_ERROR, Piece, arc_through, straight
from warpvec.svg.arcs import turn_of
from warpvec.svg.document import parse_svg
from warpvec.svg.path_data import Loop, arcs_of
from warpvec.svg.read import read_svg
from warpvec.svg.units import MM_PER_PIXEL, physical_size, stated_size
from warpvec.svg.write import hex_colors

PAGE_SHARE = 0.98
"""Share of the canvas above which the outline of a path is the page: no part fills a sheet to its edges."""

_SAME_CIRCLE = 0.01
"""Distance in millimetres by which the centres and radii of arcs of one circle may differ: files round arcs to their
last decimal, such as 0.0026 mm."""


class Circle(NamedTuple):
    """A circle, in millimetres; ``turn`` is 1 if the angle grows along it, else -1, as of a hole in such a circle."""

    x: float
    y: float
    radius: float
    turn: int = 1

    @property
    def outline(self) -> Outline:
        """Its two halves."""
        start, end = np.array([[self.x + self.radius, self.y], [self.x - self.radius, self.y]])
        halves = np.stack([start, end]), np.stack([end, start])
        return Outline(tuple(Piece(half, float(self.turn)) for half in halves), True)

    def chords(self, error: float = CHORD_ERROR) -> Floats:
        """Return points [K, 2] along it whose chords are at most ``error`` off."""
        return Ellipse(self.x, self.y, self.radius, self.radius, 0.0).chords(error)[:: self.turn]

    def moved(self, x: float, y: float) -> Circle:
        """Return it moved."""
        return self._replace(x=self.x + x, y=self.y + y)

    def mirrored(self, width: float) -> Circle:
        """Return it with left and right exchanged on a sheet of this width."""
        return self._replace(x=width - self.x, turn=-self.turn)


class Ellipse(NamedTuple):
    """An ellipse, in millimetres: its centre, its half axes, and the angle of the first in radians."""

    x: float
    y: float
    first: float
    second: float
    angle: float

    def chords(self, error: float = CHORD_ERROR) -> Floats:
        """Return points [K, 2] along it whose chords are at most ``error`` off."""
        step = 2.0 * math.acos(max(1.0 - error / max(self.first, self.second), 0.5))
        place = np.linspace(0.0, 2.0 * math.pi, max(8, math.ceil(2.0 * math.pi / step)), endpoint=False)
        u, v = self.first * np.cos(place), self.second * np.sin(place)
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return np.stack([self.x + u * cosine - v * sine, self.y + u * sine + v * cosine], 1)

    @property
    def axis(self) -> tuple[float, float]:
        """The end of the first half axis, from the centre."""
        return self.first * math.cos(self.angle), self.first * math.sin(self.angle)

    @property
    def degrees(self) -> float:
        """The angle of the first half axis."""
        return math.degrees(self.angle)

    def moved(self, x: float, y: float) -> Ellipse:
        """Return it moved."""
        return self._replace(x=self.x + x, y=self.y + y)

    def mirrored(self, width: float) -> Ellipse:
        """Return it with left and right exchanged on a sheet of this width."""
        return self._replace(x=width - self.x, angle=-self.angle)


class Outline(NamedTuple):
    """Consecutive pieces, each of which starts where the one before ends."""

    pieces: tuple[Piece, ...]
    is_closed: bool

    def moved(self, x: float, y: float) -> Outline:
        """Return it moved."""
        return self._replace(
            pieces=tuple(piece._replace(points=piece.points + np.array([x, y])) for piece in self.pieces)
        )

    def mirrored(self, width: float) -> Outline:
        """Return it with left and right exchanged on a sheet of this width."""
        return self._replace(
            pieces=tuple(Piece(piece.points * (-1, 1) + (width, 0), -piece.bulge) for piece in self.pieces)
        )


Shape = Circle | Ellipse | Outline


class Stroke(NamedTuple):
    """A stroke: its width in millimetres, its cap and join as SVG calls them, and the limit of its miters in widths."""

    width: float
    cap: str
    join: str
    miter_limit: float


@dataclass(frozen=True)
class Part:
    """A path of a drawing.

    Attributes:
        color: "#rrggbb"; that of a gradient is the mean of its stops.
        shapes: its outlines, or the centre lines of a stroke.
        stroke: how it is stroked; None for a filled path.
        has_gradient: whether it has more than one colour.
        is_opaque: whether nothing shows through it.
        layer: name of its layer; None for its colour.
        is_soft: whether it is blurred.
    """

    color: str
    shapes: tuple[Shape, ...]
    stroke: Stroke | None = None
    has_gradient: bool = False
    is_opaque: bool = True
    layer: str | None = None
    is_soft: bool = False

    def mapped(self, change: Callable[[Shape], Shape]) -> Part:
        """Return the part with what ``change`` makes of each shape."""
        return replace(self, shapes=tuple(map(change, self.shapes)))


@dataclass(frozen=True)
class Sheet:
    """The parts of a drawing, from bottom to top, on a canvas of ``width`` x ``height`` millimetres; y points down."""

    parts: tuple[Part, ...]
    width: float
    height: float


def read_parts(svg: str, per_inch: float = 96.0) -> Sheet:
    """Return the parts of the drawing ``svg``, in its stated size; there are ``per_inch`` pixels in an inch.

    Raises:
        InputError: as `warpvec.svg.read.read_svg`.
    """
    loaded = read_svg(svg)
    scale = millimeters_of_a_unit(svg, loaded.width, per_inch)
    width, height = loaded.width * scale, loaded.height * scale
    parts = parts_of(loaded.scene.cpu(), loaded.precision, scale)
    return Sheet(tuple(part for part in parts if part.shapes and not _is_page(part, width, height)), width, height)


def parts_of(scene: Scene, precision: int | None, scale: float) -> list[Part]:
    """Return the paths of a scene, whose file has so many decimals, as parts; a unit is ``scale`` millimetres."""
    shapes = list(_shapes(scene, precision, scale))
    has_gradient = torch.zeros(len(scene), dtype=torch.bool)
    opacity = scene.opacity
    if scene.gradients is not None:
        has_gradient, opacity = scene.gradients.kind != FLAT, opacity * scene.gradients.least_opacity()
    looks = (has_gradient.tolist(), (opacity >= 1.0).tolist())
    is_soft = [False] * len(scene) if scene.softness is None else scene.softness.is_soft.tolist()
    rows = (_colors(scene), shapes, _strokes(scene, scale), *looks, [None] * len(scene), is_soft)
    return [Part(*each) for each in zip(*rows, strict=True)]


def millimeters_of_a_unit(svg: str, width: float, per_inch: float) -> float:
    """Return the millimetres of a unit of the drawing ``svg``, which is ``width`` units wide."""
    root = parse_svg(svg).root
    pixel = MM_PER_PIXEL if physical_size(root) else 25.4 / per_inch
    return pixel * stated_size(root)[0] / width


def _is_page(part: Part, width: float, height: float) -> bool:
    """Return whether a filled part has an outline that covers nearly all of the canvas."""
    if part.stroke is not None:
        return False
    return any(
        abs(_area(np.clip(_corners(shape), 0.0, (width, height)))) >= PAGE_SHARE * width * height
        for shape in part.shapes
        if isinstance(shape, Outline)
    )


def _corners(outline: Outline) -> Floats:
    return np.array([piece.points[0] for piece in outline.pieces])


def _area(corners: Floats) -> float:
    """Return the signed area of a polygon [K, 2]."""
    x, y = corners.T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2.0)


# Colours


def _colors(scene: Scene) -> list[str]:
    color = scene.color
    if scene.gradients is not None:
        stops = scene.gradients.all_stops()
        used = stops.is_used()[..., None]
        mean = (stops.colors(color, scene.gradients.end_color) * used).sum(1) / used.sum(1)
        color = torch.where((scene.gradients.kind == FLAT)[:, None], color, mean)
    names = (name.removeprefix("#") for name in hex_colors(color))
    return ["#" + (name if len(name) == 6 else "".join(2 * digit for digit in name)) for name in names]


def _strokes(scene: Scene, scale: float) -> list[Stroke | None]:
    strokes = scene.strokes
    if strokes is None:
        return [None] * len(scene)
    widths = (strokes.width.double() * scale).tolist()
    rows = zip(widths, strokes.cap.tolist(), strokes.join.tolist(), strokes.miter_limit.tolist(), strict=True)
    return [Stroke(width, CAPS[cap], JOINS[join], limit) if width else None for width, cap, join, limit in rows]


# Shapes


def _shapes(scene: Scene, precision: int | None, scale: float) -> Iterator[tuple[Shape, ...]]:
    """Yield the shapes of each path."""
    loops = list(_loops(scene, precision, scale))
    kinds = [0] * len(scene) if scene.forms is None else scene.forms.kind.tolist()
    for path, (first, stop) in enumerate(pairwise(scene.structure.path_first_loop.tolist())):
        form = None
        if scene.forms is not None:
            form = _form(kinds[path], scene.forms.parameters[path].double().tolist(), scale)
        found = loops[first:stop] if form is None else [form]
        yield tuple(shape for shape in found if not isinstance(shape, Outline) or shape.pieces)


def _form(kind: int, parameters: list[float], scale: float) -> Shape | None:
    """Return a form with these ``parameters``; None for one whose rows are its exact outline."""
    x, y, first, second, corner = (scale * parameters[place] for place in (X, Y, FIRST, SECOND, CORNER))
    if kind == CIRCLE:
        return Circle(x, y, first)
    if kind == ELLIPSE:
        return Ellipse(x, y, first, second, parameters[ANGLE])
    return _round_rect(x, y, first, second, parameters[ANGLE], corner) if kind == ROUND_RECT else None


def _round_rect(x: float, y: float, width: float, height: float, angle: float, radius: float) -> Outline:
    """Return a rectangle whose corners are quarters of circles."""
    u = np.array([math.cos(angle), math.sin(angle)])
    v = np.array([-u[1], u[0]])
    center, pieces = np.array([x, y]), []
    sides = [(u, v, width, height), (v, -u, height, width), (-u, -v, width, height), (-v, u, height, width)]
    for along, inward, length, depth in sides:
        middle, half = center - inward * depth / 2.0, along * (length / 2.0 - radius)
        pieces.append(Piece(np.stack([middle - half, middle + half])))
        corner = np.stack([middle + half, middle + half + radius * (along + inward)])
        pieces.append(Piece(corner, math.tan(math.pi / 8.0)))
    return Outline(tuple(piece for piece in pieces if piece.length > 0.0), True)


def _loops(scene: Scene, precision: int | None, scale: float) -> Iterator[Shape]:
    """Yield the shape of each loop."""
    structure, curves = scene.structure, whole_curves(scene).double().numpy()
    is_line = structure.lines.numpy()
    rows = structure.loop_first_segment.tolist()
    is_open = [False] * structure.loop_count if structure.is_open is None else structure.is_open.tolist()
    per_unit = 10 ** (precision or 0)
    for (first, stop), opened in zip(pairwise(rows), is_open, strict=True):
        cubics, lines = curves[first:stop], is_line[first:stop]
        arcs: dict[int, tuple[int, float]] = {}
        if precision is not None:  # the file states arcs where its cubics are those of one
            ticks = np.rint(cubics[:, :3] * per_unit).astype(np.int64)
            found = arcs_of(Loop(ticks, lines, opened))
            arcs = {row: (last, turn_of(step, arc)) for row, (last, step, arc) in found.items()}
        pieces = tuple(pieces_of(cubics[: len(cubics) - opened] * scale, lines, arcs))
        yield circle_of(pieces) or Outline(pieces, not opened)


def pieces_of(cubics: Floats, is_line: Mask, arcs: dict[int, tuple[int, float]]) -> Iterator[Piece]:
    """Yield the pieces of ``cubics`` [S, 4, 2].

    ``arcs`` has the arcs by their first row: the row after the last, and the turn.
    """
    done = 0
    for row, cubic in enumerate(cubics):
        if row < done:
            continue
        if row in arcs:
            done, turn = arcs[row]
            yield Piece(np.stack([cubic[0], cubics[done - 1, 3]]), math.tan(turn / 4.0))
        elif is_line[row] or straight(cubic):
            if len(cubics) == 1 or (cubic[0] != cubic[3]).any():
                yield Piece(cubic[[0, 3]])
        else:
            yield arc_through(cubic) or Piece(cubic)


def circle_of(pieces: tuple[Piece, ...]) -> Circle | None:
    """Return the circle that arcs go round once; None if they do not."""
    if not pieces or not all(piece.bulge for piece in pieces):
        return None
    turn = sum(4.0 * math.atan(piece.bulge) for piece in pieces)
    is_closed = np.hypot(*(pieces[-1].points[-1] - pieces[0].points[0])) <= _SAME_CIRCLE
    found = np.array([piece.circle for piece in pieces])
    spread = np.abs(found - found.mean(0)).max()
    if not is_closed or abs(abs(turn) - 2.0 * math.pi) > 0.1 or spread > _SAME_CIRCLE:
        return None
    x, y, radius = found.mean(0).tolist()
    return Circle(x, y, radius, 1 if turn > 0.0 else -1)

"""Read strokes, and turn those that a scene cannot have into filled loops, with the help of Skia."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.strokes import BUTT, CAPS, JOINS, MITER, MITER_LIMIT, MITER_LIMIT_MAX
from warpvec.svg.foreign.shapes import Loop, Subpath, loop_of
from warpvec.svg.foreign.skia import read_path, skia_path
from warpvec.svg.foreign.style import Properties
from warpvec.svg.units import parse_length

RESOLUTION = 2048.0
"""Units of the longer side of the canvas in which strokes are made. Skia's outlines are within a quarter of a unit."""

MAX_DASHES = 2**16
"""Largest number of dashes of all strokes of a file. Each is a loop of at least four segments."""

MAX_DASH_ENTRIES = 256
"""Most numbers in a list of dashes. Icons have up to about ten."""

_EXTENT_MAX = 2.0**20
"""Largest extent of a path in those units; float32 keeps a sixteenth of a unit there."""

_SIMILARITY = 1e-4
"""Largest share by which the scales of a transform may differ, and sine of the angle by which its axes may lean,
for a stroke to keep one width."""

_CAPS = {name: number for number, name in CAPS.items()}
_JOINS = {name: number for number, name in JOINS.items()} | {"miter-clip": MITER, "arcs": MITER}


@dataclass(frozen=True)
class Stroke:
    """How a stroke runs along a path, in user space.

    Attributes:
        width: its width, above 0.
        cap, join: as in `warpvec.geometry.strokes.Strokes`.
        miter_limit: at least 1.
        dashes: lengths of dashes and gaps in turn, an even number of them; () for a solid line.
        dash_offset: where in the pattern the line starts.
    """

    width: float
    cap: int
    join: int
    miter_limit: float
    dashes: tuple[float, ...]
    dash_offset: float


def read_stroke(properties: Properties, viewport: tuple[float, float]) -> Stroke | None:
    """Return the stroke that ``properties`` state; None without width. Percentages refer to ``viewport``."""
    diagonal = math.hypot(*viewport) / math.sqrt(2)
    is_stated = re.match(r"[+-]?\.?\d", properties["stroke-width"], re.ASCII)
    width = parse_length(properties["stroke-width"], diagonal) if is_stated else 1.0
    if not 0.0 < width < math.inf:
        return None
    limit, offset = parse_length(properties["stroke-miterlimit"], 1.0), properties["stroke-dashoffset"]
    return Stroke(
        width,
        _CAPS.get(properties["stroke-linecap"], BUTT),
        _JOINS.get(properties["stroke-linejoin"], MITER),
        min(max(limit, 1.0), MITER_LIMIT_MAX) if limit > 0.0 else MITER_LIMIT,
        _dashes(properties["stroke-dasharray"], diagonal),
        parse_length(offset, diagonal),
    )


def similarity_scale(matrix: NDArray[np.float64]) -> float | None:
    """Return the scale of a matrix [2, 3] that turns, mirrors, moves and scales evenly; None for any other."""
    across, down = matrix[:, 0], matrix[:, 1]
    if not np.isfinite(matrix).all():
        return None
    scale, other = float(np.hypot(*across)), float(np.hypot(*down))
    if scale <= 0.0 or abs(scale - other) > _SIMILARITY * scale:
        return None
    return scale if abs(float(across @ down)) <= _SIMILARITY * scale * other else None


def stroked_loop(subpath: Subpath) -> Loop:
    """Return the rows of a line that is stroked; the last row of an open one is only its end."""
    if subpath.is_closed:
        return loop_of(subpath)
    end = subpath.points[-1]
    return Loop(np.concatenate([subpath.points, [end, end]]), np.append(subpath.is_line, True))


def dash_count(subpaths: list[Subpath], stroke: Stroke) -> float:
    """Return at least as many dashes as ``subpaths`` have, 0 for a solid stroke."""
    if not stroke.dashes:
        return 0.0
    with np.errstate(all="ignore"):
        length = sum(float(np.hypot(*np.diff(subpath.points, axis=0).T).sum()) for subpath in subpaths)
    return len(stroke.dashes) / 2 * (length / sum(stroke.dashes) + 2.0 * len(subpaths))


def outline(subpaths: list[Subpath], stroke: Stroke, scale: float, skia: ModuleType) -> list[Loop]:
    """Return the loops of a stroke, to be filled by the non-zero rule, in the user space of ``subpaths``.

    Args:
        subpaths: what is stroked.
        stroke: how.
        scale: units of ``RESOLUTION`` per unit of user space.
        skia: the result of `load_skia`.

    Raises:
        ValueError: a number is out of reach.
    """
    points = np.concatenate([subpath.points for subpath in subpaths])
    if not np.isfinite(points).all():
        raise ValueError("points are not finite")
    low, high = points.min(0), points.max(0)
    extent = float((high - low).max()) + stroke.width * max(stroke.miter_limit, 1.0)
    scale, center = min(scale, _EXTENT_MAX / extent), (low + high) / 2
    width = scale * stroke.width
    if not (scale > 0.0 and 1e-6 < width < _EXTENT_MAX and np.isfinite(center).all()):
        raise ValueError("size is out of reach")
    path = skia_path([s._replace(points=(s.points - center) * scale) for s in subpaths], skia)
    dashes, offset = [scale * length for length in stroke.dashes], 0.0
    if dashes:
        offset = math.fmod(scale * stroke.dash_offset, sum(dashes))
    cap, join = skia.LineCap[f"{CAPS[stroke.cap]}_cap".upper()], skia.LineJoin[f"{JOINS[stroke.join]}_join".upper()]
    path.stroke(width, cap, join, stroke.miter_limit, dashes or None, offset)
    return [Loop(loop.points / scale + center, loop.is_line) for loop in read_path(path)]


def _dashes(text: str, whole: float) -> tuple[float, ...]:
    """Return an even number of lengths; () if ``text`` states none, too many, or what SVG draws as a solid line."""
    words = text.replace(",", " ").split()[: MAX_DASH_ENTRIES + 1]
    lengths = tuple(parse_length(word, whole) for word in words)
    is_dashed = len(lengths) <= MAX_DASH_ENTRIES and min(lengths, default=-1.0) >= 0.0
    if not is_dashed or not 0.0 < sum(lengths) < math.inf:
        return ()
    return lengths if len(lengths) % 2 == 0 else 2 * lengths

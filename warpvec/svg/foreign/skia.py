"""Work on paths by skia-pathops: Skia's strokes and operations of sets.

It is chosen because curves stay curves, and because its strokes are those of Skia: caps, joins, miters and dashes are
as in resvg and Chromium, which use the same code. It is well kept (fontTools), needs no other package, and one
wheel per system serves Python 3.10 and all later ones (abi3). Shapely works on polygons only and knows no dashes;
picosvg calls skia-pathops itself. What is given to the native library must be finite, and bounded in size and number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.svg.foreign.budget import WorkBudget
from warpvec.svg.foreign.polygons import crossing_count, polygon_of, windings
from warpvec.svg.foreign.shapes import Cubic, Loop, Subpath, closed_loop

_SPAN = 4096.0
"""Units that the larger extent of shapes has when they are combined. Skia drops what is smaller than about 1e-3."""

MAX_EFFORT = 2**28
"""Most pairs of straight pieces that are compared for a file, some 20 s of work; other work counts as pairs."""

_CALL_EFFORT, _CROSSING_EFFORT = 2**14, 2**10
"""Cost of a call of Skia, and of its work at a crossing, in pairs of pieces."""

_PIECES_MAX = 3000
"""Most straight pieces of shapes that are examined: every piece is compared with every other one."""

_CROSSINGS_MAX = 500
"""Most crossings of shapes that Skia takes apart; 3000 take it half a second, 11,000 take 13 s."""

_TRIALS = 400
"""Number of places at which the result of taking a path apart is compared with it."""

_MISSES_MAX = 4
"""Most of these places that may differ: those between a curve and its polygon."""


def load_skia() -> ModuleType | None:
    """Import skia-pathops; None if it is not installed."""
    try:
        import pathops  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError:
        return None
    return pathops  # type: ignore[no-any-return, unused-ignore]


def skia_path(subpaths: Sequence[Subpath], skia: ModuleType) -> Any:
    """Return a path of Skia with ``subpaths``."""
    path = skia.Path()
    for subpath in subpaths:
        rows = subpath.points.tolist()
        path.moveTo(*rows[0])
        for row, is_line in enumerate(subpath.is_line.tolist()):
            leaving, arriving, end = rows[3 * row + 1 : 3 * row + 4]
            if is_line:
                path.lineTo(*end)
            else:
                path.cubicTo(*leaving, *arriving, *end)
        if subpath.is_closed:
            path.close()
    return path


def read_path(path: Any) -> list[Loop]:
    """Return the loops of a path of Skia; open contours are closed."""
    return [closed_loop(cubics) for cubics in _contours(path)]


class Combiner:
    """Combines the shapes of one file, with limited effort.

    Attributes:
        skia: the module, None if it is not installed; then shapes are compared, but not combined.
    """

    def __init__(self) -> None:
        self.skia = load_skia()
        self._budget = WorkBudget(MAX_EFFORT)

    def crossing_count(self, loops: Sequence[Loop]) -> int | None:
        """Return how many pairs of pieces of ``loops`` cross; None if there are too many pieces to tell."""
        polygons = [polygon_of(loop) for loop in loops]
        piece_count = sum(map(len, polygons))
        if piece_count > _PIECES_MAX or not all(np.isfinite(polygon).all() for polygon in polygons):
            return None
        if not self._budget.takes(piece_count**2):
            return None
        return crossing_count(polygons)

    def even_odd(self, loops: list[Loop]) -> list[Loop] | None:
        """Return loops that fill, by the non-zero rule, what ``loops`` fill by the even-odd rule; None without Skia."""

        def simplify(skia: ModuleType, path: Any) -> Any:
            path = skia.Path(path, fillType=skia.FillType.EVEN_ODD)
            path.simplify(fix_winding=True)
            return path

        found = self._combined(simplify, loops)
        return found if found is not None and _is_same(loops, found) else None

    def common(self, one: list[Loop], two: list[Loop]) -> list[Loop] | None:
        """Return what two shapes have in common, both under the non-zero rule; None if Skia cannot tell."""

        def intersect(skia: ModuleType, first: Any, second: Any) -> Any:
            return skia.op(first, second, skia.PathOp.INTERSECTION, fix_winding=True)

        return self._combined(intersect, one, two)

    def without(self, one: list[Loop], two: list[Loop]) -> list[Loop] | None:
        """Return what one shape has beside another, both under the non-zero rule; None if Skia cannot tell."""

        def subtract(skia: ModuleType, first: Any, second: Any) -> Any:
            return skia.op(first, second, skia.PathOp.DIFFERENCE, fix_winding=True)

        return self._combined(subtract, one, two)

    def together(self, one: list[Loop], two: list[Loop]) -> list[Loop] | None:
        """Return what two shapes cover together, both under the non-zero rule; None if Skia cannot tell."""

        def unite(skia: ModuleType, first: Any, second: Any) -> Any:
            return skia.op(first, second, skia.PathOp.UNION, fix_winding=True)

        return self._combined(unite, one, two)

    def _combined(self, combine: Callable[..., Any], *shapes: list[Loop]) -> list[Loop] | None:
        loops = [loop for shape in shapes for loop in shape]
        if self.skia is None or not loops:
            return None
        count = self.crossing_count(loops)
        if count is None or count > _CROSSINGS_MAX:
            return None
        if not self._budget.takes(_CALL_EFFORT + _CROSSING_EFFORT * count):
            return None
        points = np.concatenate([loop.points for loop in loops])
        low, scale = points.min(0), _SPAN / max(float(np.ptp(points, axis=0).max()), 1e-9)
        paths = [skia_path([_scaled(loop, low, scale) for loop in shape], self.skia) for shape in shapes]
        try:
            result = combine(self.skia, *paths)
        except Exception:  # Skia gives up on some paths
            return None
        return [Loop(loop.points / scale + low, loop.is_line) for loop in read_path(result)]


def _scaled(loop: Loop, low: NDArray[np.float64], scale: float) -> Subpath:
    points = (np.concatenate([loop.points, loop.points[:1]]) - low) * scale
    return Subpath(points, loop.is_line, True)


def _is_same(even_odd: list[Loop], nonzero: list[Loop]) -> bool:
    """Return whether two notations of a shape agree, at random places."""
    if not nonzero:
        return False
    before, after = ([polygon_of(loop) for loop in loops] for loops in (even_odd, nonzero))
    points = np.concatenate(before)
    places = np.random.default_rng(0).uniform(points.min(0), points.max(0), (_TRIALS, 2))
    differs = (windings(before, places) % 2 == 1) != (windings(after, places) != 0)
    return int(differs.sum()) <= _MISSES_MAX


def _contours(path: Any) -> Iterator[list[Cubic]]:
    """Yield the cubics of each contour of a path of Skia that has any."""
    cubics: list[Cubic] = []
    at = 0j
    for verb, points in path:
        name = verb.name
        ends = [complex(*point) for point in points if isinstance(point, tuple)]
        if name == "MOVE":
            yield from [cubics] if cubics else []
            cubics, at = [], ends[0]
        elif ends:
            weight = points[-1] if name == "CONIC" else 1.0
            cubics.append((_cubic(name, at, ends, weight), name == "LINE"))
            at = ends[-1]
    yield from [cubics] if cubics else []


def _cubic(verb: str, start: complex, ends: list[complex], weight: float) -> list[complex]:
    """Return the cubic of a segment of Skia. The cubic of a conic, such as an arc, touches it in the middle."""
    if verb == "CUBIC":
        return [start, *ends]
    end = ends[-1]
    if verb == "LINE":
        return [start, (2 * start + end) / 3, (start + 2 * end) / 3, end]
    share = 4 * weight / (3 * (1 + weight))  # 2/3 for a quadratic
    return [start, start + share * (ends[0] - start), end + share * (ends[0] - end), end]

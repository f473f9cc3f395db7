"""Turn the shapes of SVG into closed loops of cubics, with the help of svgelements.

Of the SVG readers in Python, picosvg is the best maintained, but it is made for icon fonts: it does not know style
sheets, units, percentages, ``href`` without a prefix or numbers like "1.", and it hands the whole file to lxml, one
more native library. svgelements is one Python file and reads all of these. Its own walk over the tree passes positions
on to children and draws the content of masks and symbols, so `warpvec.svg.foreign.reader` walks the tree, and
svgelements reads path data, transforms, view boxes and colours only.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.svg.units import parse_length


class Loop(NamedTuple):
    """A closed loop of k cubics.

    Attributes:
        points: control points [3 k, 2], three a cubic: its anchor and its two handles.
        is_line: the cubics that are straight lines [k].
    """

    points: NDArray[np.float64]
    is_line: NDArray[np.bool_]


class Subpath(NamedTuple):
    """A line of k cubics, open or closed, as path data draws it.

    Attributes:
        points: control points [3 k + 1, 2]; the last one is the end.
        is_line: the cubics that are straight lines [k].
        is_closed: whether "z" ends it, so that a stroke joins its ends.
    """

    points: NDArray[np.float64]
    is_line: NDArray[np.bool_]
    is_closed: bool


SHAPES = frozenset({"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"})

_READABLE = re.compile(r"\s*+(?:[Mm][MLHVCSQTAZmlhvcsqtaz0-9eE+\-.,\s]*+)?", re.ASCII)

_ARGUMENTS = "[^MLHVCSQTAZmlhvcsqtaz]*+"
_MORE_CLOSES = re.compile(r"[zZ](?:\s*+[zZ]){2,}+")
"""The second of several closes draws a point, and the others draw it again, which may take a tenth of a millisecond."""

_QUADRATIC_TO_CUBIC = re.compile(f"([QqTt]{_ARGUMENTS})(?=[Ss])")
_CUBIC_TO_QUADRATIC = re.compile(f"([CcSs]{_ARGUMENTS})(?=[Tt])")

# Two ends are the same if they are closer than this fraction of the largest coordinate: sums of decimals in float64 are
# off by 1e-16 of it per step.
_SAME = 1e-12


def load_parser() -> ModuleType:
    """Import svgelements.

    Raises:
        InputError: it is not installed.
    """
    try:
        import svgelements  # type: ignore[import-untyped]
    except ImportError:
        rule = "must be written by warpvec, because svgelements, which reads other files, is not installed"
        raise InputError("SVG", rule, remedy="pip install 'warpvec[refine]'") from None
    return svgelements


@cache
def _path_class() -> Any:
    """Return the Path of svgelements with a start of its subpath that is kept, and not searched for at every "z".

    The search goes back to the last move, so that 30 kB of "z" would take a minute.
    """
    parser = load_parser()

    class Path(parser.Path):  # type: ignore[name-defined, misc]
        seen_count, last_move = 0, None

        @property
        def z_point(self) -> Any:
            for segment in self._segments[self.seen_count :]:
                self.last_move = segment if isinstance(segment, parser.Move) else self.last_move
            self.seen_count = len(self._segments)
            return super().z_point if self.last_move is None else self.last_move.end

        def _validate_close(self, index: int) -> None:
            """Keep the end of a "z", which is `z_point` already; the original searches for it once more."""

    return Path


def shape_data(name: str, attributes: Mapping[str, str], width: float, height: float) -> str:
    """Return path data of the shape ``name`` in a viewport of ``width`` x ``height`` units; "" if it draws nothing."""
    if name == "path":
        return attributes.get("d", "")
    if name in ("polygon", "polyline"):
        return f"M{attributes.get('points', '')}{'z' if name == 'polygon' else ''}"
    sizes = shape_sizes(attributes, width, height)
    if name == "rect":
        return _rectangle(**{key: sizes[key] for key in ("x", "y", "width", "height", "rx", "ry")})
    if name in ("circle", "ellipse"):
        rx, ry = (sizes["r"], sizes["r"]) if name == "circle" else (sizes["rx"], sizes["ry"])
        return _ellipse(sizes["cx"], sizes["cy"], rx, ry)
    return f"M{sizes['x1']!r},{sizes['y1']!r}L{sizes['x2']!r},{sizes['y2']!r}"


def shape_sizes(attributes: Mapping[str, str], width: float, height: float) -> dict[str, float]:
    """Return the lengths that ``attributes`` of a shape state in a viewport of ``width`` x ``height``; 0 without."""
    wholes = dict.fromkeys(("x", "cx", "rx", "width", "x1", "x2"), width)
    wholes["r"] = math.hypot(width, height) / math.sqrt(2)
    sizes = {key: parse_length(attributes.get(key, ""), wholes.get(key, height)) for key in _LENGTHS}
    # A missing radius is that of the other axis.
    return sizes | {key: sizes[other] for key, other in (("rx", "ry"), ("ry", "rx")) if not attributes.get(key)}


def read_subpaths(data: str) -> tuple[list[Subpath], bool]:
    """Return the subpaths of path data, and whether the data could be read to its end.

    The data counts up to its first error, as SVG draws it (SVG 1.1, appendix F.2).
    """
    readable = _READABLE.match(data)
    text = readable[0] if readable else ""
    path = _path_class()()
    drawn: list[_Drawn] = []
    complete = len(text) == len(data)
    try:
        path.parse(_without_false_mirrors(_usual_numbers(_MORE_CLOSES.sub("zz", text))))
    except Exception:
        complete = False
    try:
        _collect(path, drawn)
    except Exception:
        complete = False
    return [_subpath(cubics, is_closed) for cubics, is_closed in drawn if cubics], complete


def closed_loops(subpaths: list[Subpath]) -> list[Loop]:
    """Return the loops that a fill of ``subpaths`` has: open ones are closed, those without an inside are left out."""
    loops = [loop_of(subpath) for subpath in subpaths]
    return [loop for loop in loops if _has_inside(loop)]


def closed_loop(cubics: list[Cubic]) -> Loop:
    """Return the loop of consecutive ``cubics``."""
    return loop_of(_subpath(cubics, True))


def reversed_loop(loop: Loop) -> Loop:
    """Return ``loop`` run the other way."""
    points = np.concatenate([loop.points[:1], loop.points[:0:-1]])
    return Loop(points, loop.is_line[::-1])


def moved(loops: list[Loop], matrix: NDArray[np.float64]) -> list[Loop]:
    """Return ``loops`` transformed by ``matrix`` [2, 3]."""
    return [Loop(apply(matrix, loop.points), loop.is_line) for loop in loops]


def curves_of(loop: Loop) -> NDArray[np.float64]:
    """Return the control points [k, 4, 2] of the cubics of ``loop``, ends included."""
    rows = loop.points.reshape(-1, 3, 2)
    return np.concatenate([rows, np.roll(rows[:, :1], -1, axis=0)], 1)


def open_curves(subpath: Subpath) -> NDArray[np.float64]:
    """Return the control points [k, 4, 2] of the cubics of ``subpath``, ends included."""
    return np.concatenate([subpath.points[:-1].reshape(-1, 3, 2), subpath.points[3::3, None]], 1)


def bounding_box(curves: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Return left, top, right and bottom of cubics with the control points ``curves`` [k, 4, 2]."""
    a, b, c, d = np.moveaxis(curves, 1, 0)
    # The derivative is 3 ((d - a + 3 b - 3 c) t^2 + 2 (a - 2 b + c) t + b - a).
    with np.errstate(all="ignore"):
        square, linear, constant = d - a + 3.0 * (b - c), 2.0 * (a - 2.0 * b + c), b - a
        root = np.sqrt(linear * linear - 4.0 * square * constant)
        # Citardauq's form of one root is exact where the other one cancels.
        q = -0.5 * (linear + np.where(linear < 0.0, -root, root))
        found = [np.nan_to_num(t, nan=0.0, posinf=0.0, neginf=0.0) for t in (q / square, constant / q)]
        inside = [np.clip(t, 0.0, 1.0) for t in found]
        extremes = [(1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d for t in inside]
    candidates = np.concatenate([a, d, *extremes])
    (left, top), (right, bottom) = candidates.min(0).tolist(), candidates.max(0).tolist()
    return left, top, right, bottom


def read_matrix(transform: str) -> NDArray[np.float64]:
    """Return the matrix [2, 3] of an SVG transform; the identity for "none".

    Raises:
        ValueError: the transform cannot be read.
    """
    if transform in ("", "none"):
        return np.eye(2, 3)
    try:
        matrix = load_parser().Matrix(_usual_numbers(transform))
        values = [float(getattr(matrix, name)) for name in "acebdf"]
    except InputError:
        raise
    except Exception as error:
        raise ValueError(transform) from error
    return np.array(values).reshape(2, 3)


# Files may hold any numbers, infinite ones too. Both functions take them; the reader checks the resulting points.


def apply(matrix: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``points`` [..., 2] transformed by ``matrix`` [2, 3]."""
    with np.errstate(all="ignore"):
        return points @ matrix[:, :2].T + matrix[:, 2]


def compose(outer: NDArray[np.float64], inner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix [2, 3] that applies ``inner`` first, then ``outer``."""
    with np.errstate(all="ignore"):
        composed = outer[:, :2] @ inner
        composed[:, 2] += outer[:, 2]
    return composed


# Largest angle for one cubic: its error for a quarter of a circle is 0.03 % of the radius.
_ARC = math.pi / 2

_LENGTHS = ("x", "y", "width", "height", "rx", "ry", "cx", "cy", "r", "x1", "y1", "x2", "y2")


def _rectangle(x: float, y: float, width: float, height: float, rx: float, ry: float) -> str:
    if not (width > 0 and height > 0):
        return ""
    if not (rx > 0 and ry > 0):
        return f"M{x!r},{y!r}h{width!r}v{height!r}h{-width!r}z"
    rx, ry = min(rx, width / 2), min(ry, height / 2)
    across, down, arc = width - 2 * rx, height - 2 * ry, f"a{rx!r},{ry!r} 0 0 1 "
    return (
        f"M{x + rx!r},{y!r}h{across!r}{arc}{rx!r},{ry!r}v{down!r}{arc}{-rx!r},{ry!r}"
        f"h{-across!r}{arc}{-rx!r},{-ry!r}v{-down!r}{arc}{rx!r},{-ry!r}z"
    )


def _ellipse(cx: float, cy: float, rx: float, ry: float) -> str:
    arc = f"a{rx!r},{ry!r} 0 0 1 "
    return f"M{cx - rx!r},{cy!r}{arc}{2 * rx!r},0{arc}{-2 * rx!r},0z" if rx > 0 and ry > 0 else ""


def _without_false_mirrors(data: str) -> str:
    """Part "s" from a quadratic before it, and "t" from a cubic, by a line of no length.

    svgelements mirrors their handles; SVG has no handle there to mirror.
    """
    return _QUADRATIC_TO_CUBIC.sub(r"\1l0 0", _CUBIC_TO_QUADRATIC.sub(r"\1l0 0", data))


def _usual_numbers(text: str) -> str:
    """Remove points that end a number ("1." and "1.e2"), because svgelements stops reading there."""
    return re.sub(r"(\d)\.(?!\d)", r"\1 ", re.sub(r"(\d)\.(?=[eE])", r"\1", text))


Cubic = tuple[list[complex], bool]
"""The four control points x + iy of a cubic, and whether it is a line."""

_Drawn = tuple[list[Cubic], bool]
"""The cubics of a subpath, and whether it is closed."""


def _collect(path: Iterable[Any], drawn: list[_Drawn]) -> None:
    """Add the subpaths of ``path`` to ``drawn``, as far as its segments can be read.

    What follows a close without a move starts where the closed subpath did.
    """
    is_begun = False
    for segment in path:
        kind = type(segment).__name__
        if kind == "Move":
            is_begun = False
            continue
        if not is_begun:
            drawn.append(([], False))
        is_line = kind not in ("CubicBezier", "QuadraticBezier", "Arc")
        drawn[-1][0].extend((cubic, is_line) for cubic in _cubics(segment, kind))
        is_begun = kind != "Close"
        if kind == "Close":
            drawn[-1] = drawn[-1][0], True


def _cubics(segment: Any, kind: str) -> Iterator[list[complex]]:
    """Yield the cubics of a segment, each as its four control points x + iy."""
    ends = [complex(point.x, point.y) for point in (segment.start, segment.end)]
    if kind == "CubicBezier":
        handles = [complex(point.x, point.y) for point in (segment.control1, segment.control2)]
        yield [ends[0], *handles, ends[1]]
    elif kind == "QuadraticBezier":
        handle = complex(segment.control.x, segment.control.y)
        yield [ends[0], *(end + 2 / 3 * (handle - end) for end in ends), ends[1]]
    elif kind == "Arc":
        count = max(math.ceil(abs(segment.sweep) / _ARC - _SAME), 1)
        longer = _arm_factor(abs(segment.sweep) / count)
        for curve in segment.as_cubic_curves(count):
            ((start, *handles, end),) = _cubics(curve, "CubicBezier")
            yield [start, start + longer * (handles[0] - start), end + longer * (handles[1] - end), end]
    else:
        yield [ends[0], (2 * ends[0] + ends[1]) / 3, (ends[0] + 2 * ends[1]) / 3, ends[1]]


def _arm_factor(angle: float) -> float:
    """Return by how much the handles of svgelements' cubic for an arc of ``angle`` must grow.

    Its handles, which other programs use for half an arc, miss a quarter of a circle by 0.2 % of the radius. These miss
    it by 0.03 %, and are what resvg and browsers draw.
    """
    own = math.sin(angle) * (math.sqrt(4 + 3 * math.tan(angle / 2) ** 2) - 1) / 3
    return 4 / 3 * math.tan(angle / 4) / own if own > _SAME else 1.0


def _subpath(cubics: list[Cubic], is_closed: bool) -> Subpath:
    """Return the subpath of ``cubics``, without those of no length; one is kept if there is no other."""
    values, is_line = np.array([points for points, _ in cubics]), np.array([line for _, line in cubics])
    drawn = (values[:, 1:] != values[:, :1]).any(1)
    rows = drawn if drawn.any() else np.arange(len(drawn)) == 0
    kept = np.append(values[rows, :3].ravel(), values[-1, 3])
    return Subpath(np.stack([kept.real, kept.imag], -1), is_line[rows], is_closed)


def loop_of(subpath: Subpath) -> Loop:
    """Return the loop of ``subpath``, with a closing line if one is missing."""
    points, end, is_line = subpath.points[:-1], subpath.points[-1], subpath.is_line
    with np.errstate(all="ignore"):  # the reader checks the points
        is_open = np.hypot(*(end - points[0])) > _SAME * np.abs(subpath.points).max()
    if is_open:
        return Loop(np.concatenate([points, _line(end, points[0])]), np.append(is_line, True))
    return Loop(points, is_line)


def _has_inside(loop: Loop) -> bool:
    """Return whether its control points are not all on one line."""
    with np.errstate(all="ignore"):
        arms = loop.points - loop.points[0]
        longest = arms[np.abs(arms).sum(1).argmax()]
        return bool((arms[:, 0] * longest[1] != arms[:, 1] * longest[0]).any())


def _line(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(all="ignore"):  # the reader checks the points
        return np.stack([start, (2 * start + end) / 3, (start + 2 * end) / 3])

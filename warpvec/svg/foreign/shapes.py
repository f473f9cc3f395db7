"""Turn the shapes of SVG into closed loops of cubics, with the help of svgelements.

Of the SVG readers in Python, picosvg is the best maintained, but it is made for icon fonts: it does not know style
sheets, units, percentages, ``href`` without a prefix or numbers like "1.", and it runs two native libraries on files
that may be hostile. svgelements is one Python file and reads all of these. Its own walk over the tree passes positions
on to children and draws the content of masks and symbols, so `warpvec.svg.foreign.reader` walks the tree, and
svgelements reads path data, transforms, view boxes and colours only.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.svg.units import parse_length

Loop = NDArray[np.float64]
"""Control points [3 k, 2] of k cubics that end where they start."""

SHAPES = frozenset({"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"})

_READABLE = re.compile(r"\s*+(?:[Mm][MLHVCSQTAZmlhvcsqtaz0-9eE+\-.,\s]*+)?", re.ASCII)

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
    """Return path data of the shape ``name`` in a viewport of ``width`` x ``height`` units; "" if it has no inside."""
    if name == "path":
        return attributes.get("d", "")
    if name in ("polygon", "polyline"):
        return f"M{attributes.get('points', '')}z"
    wholes = {"x": width, "cx": width, "rx": width, "width": width, "r": math.hypot(width, height) / math.sqrt(2)}
    sizes = {key: parse_length(attributes.get(key, ""), wholes.get(key, height)) for key in _LENGTHS}
    # A missing radius is that of the other axis.
    sizes |= {key: sizes[other] for key, other in (("rx", "ry"), ("ry", "rx")) if not attributes.get(key)}
    if name == "rect":
        return _rectangle(**{key: sizes[key] for key in ("x", "y", "width", "height", "rx", "ry")})
    if name in ("circle", "ellipse"):
        rx, ry = (sizes["r"], sizes["r"]) if name == "circle" else (sizes["rx"], sizes["ry"])
        return _ellipse(sizes["cx"], sizes["cy"], rx, ry)
    return ""


def read_loops(data: str) -> tuple[list[Loop], bool]:
    """Return the closed subpaths of path data that enclose an area, and whether the data could be read to its end.

    The data counts up to its first error, as SVG draws it (SVG 1.1, appendix F.2).
    """
    readable = _READABLE.match(data)
    text = readable[0] if readable else ""
    path = _path_class()()
    subpaths: list[list[list[complex]]] = []
    complete = len(text) == len(data)
    try:
        path.parse(_usual_numbers(text))
    except Exception:
        complete = False
    try:
        for cubics, begins in _drawn(path):
            if begins or not subpaths:
                subpaths.append([])
            subpaths[-1] += cubics
    except Exception:
        complete = False
    loops = [_closed(cubics) for cubics in subpaths if cubics]
    return [loop for loop in loops if _has_inside(loop)], complete


def join(loops: list[Loop]) -> Loop:
    """Join ``loops`` into one loop with the same winding numbers: a line leads to each loop and back from it.

    The lines enclose no area, so that they have no effect under the non-zero rule.
    """
    first, *others = loops
    parts = [first]
    for loop in others:
        parts += [_line(first[0], loop[0]), loop, _line(loop[0], first[0])]
    return np.concatenate(parts)


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
        return outer[:, :2] @ inner + np.pad(outer[:, 2:], ((0, 0), (2, 0)))


# Largest angle for one cubic: its error for a quarter of a circle is 0.03 % of the radius.
_ARC = math.pi / 2

_LENGTHS = ("x", "y", "width", "height", "rx", "ry", "cx", "cy", "r")


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


def _usual_numbers(text: str) -> str:
    """Remove points that end a number ("1." and "1.e2"), because svgelements stops reading there."""
    return re.sub(r"(\d)\.(?!\d)", r"\1 ", re.sub(r"(\d)\.(?=[eE])", r"\1", text))


def _drawn(path: Iterable[Any]) -> Iterator[tuple[list[list[complex]], bool]]:
    """Yield the cubics of each segment, and whether it starts a subpath. A segment after a close does not."""
    begins = True
    for segment in path:
        kind = type(segment).__name__
        if kind != "Move":
            yield list(_cubics(segment, kind)), begins
        begins = kind == "Move"


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
        for curve in segment.as_cubic_curves(max(math.ceil(abs(segment.sweep) / _ARC - _SAME), 1)):
            yield from _cubics(curve, "CubicBezier")
    else:
        yield [ends[0], (2 * ends[0] + ends[1]) / 3, (ends[0] + 2 * ends[1]) / 3, ends[1]]


def _closed(cubics: list[list[complex]]) -> Loop:
    """Return control points of ``cubics``, without those of no length, with a closing line if one is missing."""
    values = np.array(cubics)
    drawn = (values[:, 1:] != values[:, :1]).any(1)
    start, end = cubics[0][0], cubics[-1][3]
    kept = values[drawn if drawn.any() else slice(1), :3].ravel()
    loop = np.stack([kept.real, kept.imag], -1)
    if abs(end - start) > _SAME * np.abs(values).max():
        return np.concatenate([loop, _line(np.array([end.real, end.imag]), loop[0])])
    return loop


def _has_inside(loop: Loop) -> bool:
    """Return whether its control points are not all on one line."""
    with np.errstate(all="ignore"):
        arms = loop - loop[0]
        longest = arms[np.abs(arms).sum(1).argmax()]
        return bool((arms[:, 0] * longest[1] != arms[:, 1] * longest[0]).any())


def _line(start: NDArray[np.float64], end: NDArray[np.float64]) -> Loop:
    with np.errstate(all="ignore"):  # the reader checks the points
        return np.stack([start, (2 * start + end) / 3, (start + 2 * end) / 3])

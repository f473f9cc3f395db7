"""Write parts as DXF, by ezdxf (MIT, Manfred Moitzi), the extra "cut".

Lengths are in millimetres, and a layer holds the parts of one colour. Circles and arcs are true ones; ellipses
and cubics become arcs, or true ellipses and splines on request. The stroke of a part is drawn as its centre line: see
`warpvec.making.regions.stroke_edges` for its edges.
"""

from __future__ import annotations

import math
from io import StringIO
from typing import Any

import ezdxf
import numpy as np
from ezdxf.colors import aci2rgb

from warpvec.arrays import Floats
from warpvec.making.arcs import FINE_ERROR, closed_shape, with_arcs
from warpvec.making.curves import Piece, line_cubic
from warpvec.making.parts import Circle, Ellipse, Outline, Part, Shape, Sheet

_VERSION = "R2010"
"""Version of the format: the first that ezdxf recommends for new files, and that cutters' programs of today read."""


def encode_sheet(sheet: Sheet, *, splines: bool = False) -> bytes:
    """Return the bytes of a DXF file of the parts of ``sheet``; equal parts give equal bytes.

    Args:
        sheet: the parts.
        splines: write outlines with cubics as splines.
    """
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True  # no times and no random numbers
    try:
        document = ezdxf.new(_VERSION, units=ezdxf.units.MM)
        space = document.modelspace()
        extents = (0.0, 0.0, 0.0), (sheet.width, sheet.height, 0.0)
        space.reset_extents(*extents)
        # Inkscape places all parts by the header, which ezdxf 1.4 does not set from extents that begin at 0.
        document.header["$EXTMIN"], document.header["$EXTMAX"] = extents
        space.reset_limits((0.0, 0.0), (sheet.width, sheet.height))
        document.set_modelspace_vport(1.1 * sheet.height, (sheet.width / 2.0, sheet.height / 2.0))
        for name, color in {part.layer or part.color: part.color for part in sheet.parts}.items():
            document.layers.add(name, color=_nearest_index(color), true_color=int(color[1:], 16))
        drawer = _Drawer(space, sheet.height, splines)
        for part in sheet.parts:
            drawer.draw(part)
        return _bytes_of(document)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def _bytes_of(document: Any) -> bytes:
    text = StringIO()
    document.write(text)
    data: bytes = document.encode(text.getvalue())
    return data


def _nearest_index(color: str) -> int:
    """Return the number of the colour of AutoCAD's table that is nearest: programs of cutters choose tools by it."""
    wanted = np.frombuffer(bytes.fromhex(color[1:]), np.uint8).astype(np.int64)
    table = np.array([aci2rgb(index) for index in range(1, 256)], np.int64)
    return 1 + int(np.square(table - wanted).sum(1).argmin())


class _Drawer:
    """Draws parts into a space of a document, where y points up."""

    def __init__(self, space: Any, height: float, splines: bool) -> None:
        self._space, self._height, self._splines = space, height, splines

    def draw(self, part: Part) -> None:
        """Draw a part on its layer."""
        for shape in part.shapes:
            self._draw_shape(shape, {"layer": part.layer or part.color})

    def _draw_shape(self, shape: Shape, where: dict[str, str]) -> None:
        if isinstance(shape, Circle):
            self._space.add_circle((shape.x, self._height - shape.y), shape.radius, dxfattribs=where)
        elif isinstance(shape, Ellipse) and self._splines:
            self._draw_ellipse(shape, where)
        elif isinstance(shape, Ellipse):  # Inkscape 1.2 reads a turned one as its mirror image
            self._draw_shape(closed_shape(shape.chords(FINE_ERROR)), where)
        elif self._splines and any(piece.is_cubic for piece in shape.pieces):
            self._draw_spline(shape, where)
        elif any(piece.is_cubic for piece in shape.pieces):
            self._draw_shape(with_arcs(shape), where)
        else:
            self._draw_outline(shape, where)

    def _draw_ellipse(self, ellipse: Ellipse, where: dict[str, str]) -> None:
        is_first = ellipse.first >= ellipse.second
        longer, shorter = sorted((ellipse.first, ellipse.second), reverse=True)
        angle = -ellipse.angle + (0.0 if is_first else math.pi / 2.0)
        axis = longer * math.cos(angle), longer * math.sin(angle)
        center = ellipse.x, self._height - ellipse.y
        self._space.add_ellipse(center, axis, max(shorter / longer, 1e-6), dxfattribs=where)

    def _draw_outline(self, outline: Outline, where: dict[str, str]) -> None:
        vertices = [(*self._up(piece.points[:1])[0], -piece.bulge) for piece in outline.pieces]
        last = outline.pieces[-1]
        if not outline.is_closed and len(vertices) == 1:
            self._draw_single(last, where)
            return
        if not outline.is_closed:
            vertices.append((*self._up(last.points[-1:])[0], 0.0))
        self._space.add_lwpolyline(vertices, format="xyb", close=outline.is_closed, dxfattribs=where)

    def _draw_single(self, piece: Piece, where: dict[str, str]) -> None:
        """Draw an open line of one piece: a point, a line or an arc."""
        start, end = self._up(piece.points[[0, -1]])
        if not piece.length:
            self._space.add_point(start, dxfattribs=where)
        elif not piece.bulge:
            self._space.add_line(start, end, dxfattribs=where)
        else:
            x, y, radius = piece.circle
            y = self._height - y
            angles = [math.degrees(math.atan2(point[1] - y, point[0] - x)) for point in (start, end)]
            angles = angles if piece.bulge < 0.0 else angles[::-1]  # an ARC goes counterclockwise
            self._space.add_arc((x, y), radius, *angles, dxfattribs=where)

    def _draw_spline(self, outline: Outline, where: dict[str, str]) -> None:
        cubics = [cubic for piece in outline.pieces for cubic in piece.cubics()]
        if outline.is_closed and (cubics[-1][3] != cubics[0][0]).any():
            cubics.append(line_cubic(cubics[-1][3], cubics[0][0]))
        points = np.concatenate([cubics[0][:1], *(cubic[1:] for cubic in cubics)])
        inner = [knot for knot in range(1, len(cubics)) for _ in range(3)]
        knots = [0.0] * 4 + [float(knot) for knot in inner] + [float(len(cubics))] * 4
        spline = self._space.add_open_spline(self._up(points), degree=3, knots=knots, dxfattribs=where)
        if outline.is_closed:
            spline.dxf.flags |= spline.CLOSED

    def _up(self, points: Floats) -> list[tuple[float, float]]:
        return [(x, self._height - y) for x, y in points.tolist()]

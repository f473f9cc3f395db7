"""The contact sheet of flat art: original, tracing at twice the size, its nodes, and its error times eight."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from flat_corners import scene_of
from flat_originals import Original, Pixels, stretched
from PIL import Image, ImageDraw

from warpvec.geometry.joints import Joints, with_lines
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw

GAIN = 8
"""Factor of the error that is shown."""

_MARGIN, _TEXT_HEIGHT = 8, 18
_FADED = 0.35
"""Share of the drawing that remains behind its nodes."""


class Sheet:
    """Rows of pictures that are written as one."""

    def __init__(self, cell: int) -> None:
        """``cell`` is the largest side of a picture in pixels; what is larger is made smaller."""
        self._cell = cell
        self._rows: list[Image.Image] = []

    def add(self, original: Original, size: int, svg: str, title: str) -> None:
        """Add a row for the tracing ``svg`` of ``original``, both drawn at twice the ``size``."""
        width, height = (2 * side for side in original.extent(size))
        truth = original.drawn(size, 2)
        ours = draw(stretched(svg, width, height), width, height)
        error = 255 - np.clip(GAIN * np.abs(truth.astype(int) - ours).max(2), 0, 255).astype(np.uint8)
        cells = [truth, ours, with_nodes(svg, ours), np.repeat(error[..., None], 3, 2)]
        self._rows.append(self._row([Image.fromarray(each) for each in cells], title))

    def _row(self, cells: list[Image.Image], title: str) -> Image.Image:
        factor = min(1.0, self._cell / max(cells[0].size))
        size = tuple(round(factor * side) for side in cells[0].size)
        pitch = self._cell + _MARGIN
        row = Image.new("RGB", (len(cells) * pitch, size[1] + _TEXT_HEIGHT + _MARGIN), "white")
        ImageDraw.Draw(row).text((2, 2), title, fill="black")
        for index, cell in enumerate(cells):
            shrunk = cell.resize(size, Image.Resampling.LANCZOS) if factor < 1 else cell
            row.paste(shrunk, (index * pitch, _TEXT_HEIGHT))
        return row

    def save(self, path: Path) -> None:
        """Write all rows, one below the other."""
        size = (max(row.width for row in self._rows), sum(row.height for row in self._rows))
        sheet, top = Image.new("RGB", size, "white"), 0
        for row in self._rows:
            sheet.paste(row, (0, top))
            top += row.height
        path.parent.mkdir(parents=True, exist_ok=True)
        sheet.save(path)


def with_nodes(svg: str, drawn: Pixels) -> Pixels:
    """Return the drawing ``drawn`` of ``svg``, faded, with outlines, handles and nodes: squares at corners."""
    height, width = drawn.shape[:2]
    scene = with_lines(scene_of(svg, width, height))
    faded = Image.fromarray((255 - _FADED * (255 - drawn.astype(float))).astype(np.uint8)).convert("RGBA")
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">{_marks(scene)}</svg>'
    faded.alpha_composite(Image.fromarray(draw(text, width, height, transparent=True)))
    return np.asarray(faded.convert("RGB"))


def _marks(scene: Scene) -> str:
    joints = Joints.of(scene)
    rows = scene.segments.numpy().round(2).tolist()
    outlines = [
        f"M{_pair(rows[first][0])}"
        + "".join(f"C{_pair(rows[k][1])} {_pair(rows[k][2])} {_pair(rows[end][0])}" for k, end in _steps(first, stop))
        for first, stop in pairwise(scene.structure.loop_first_segment.tolist())
    ]
    following, is_line = joints.following.tolist(), joints.is_line.tolist()
    handles = [
        f"M{_pair(row[0])}L{_pair(row[1])}M{_pair(row[2])}L{_pair(rows[end][0])}"
        for row, end, line in zip(rows, following, is_line, strict=True)
        if not line
    ]
    nodes = [_node(row[0], smooth) for row, smooth in zip(rows, joints.is_smooth.tolist(), strict=True)]
    lines = f'<path d="{"".join(outlines)}" fill="none" stroke="#333"/>'
    return lines + f'<path d="{"".join(handles)}" fill="none" stroke="#08f" stroke-width=".8"/>' + "".join(nodes)


def _steps(first: int, stop: int) -> list[tuple[int, int]]:
    return [(k, k + 1 if k + 1 < stop else first) for k in range(first, stop)]


def _node(place: list[float], is_smooth: bool) -> str:
    x, y = place
    if is_smooth:
        return f'<circle cx="{x}" cy="{y}" r="3.5" fill="#08f"/>'
    return f'<rect x="{x - 3.5:.2f}" y="{y - 3.5:.2f}" width="7" height="7" fill="#e11"/>'


def _pair(point: list[float]) -> str:
    return f"{point[0]},{point[1]}"

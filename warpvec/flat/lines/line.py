"""A line of a drawing: a centre line with a width and ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch

from warpvec.arrays import Floats
from warpvec.flat.simplification.form_candidates import Candidate
from warpvec.flat.simplification.forms import forms_of
from warpvec.flat.strokes.line_fitting import Rows, curves_of
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.strokes import MITER_LIMIT, ROUND, Strokes
from warpvec.geometry.structure import Structure


@dataclass(frozen=True, eq=False)
class DrawnLine:
    """A line of a drawing.

    Attributes:
        rows: its centre line.
        width: in pixels.
        cap: at its ends, a key of `warpvec.geometry.strokes.CAPS`.
        is_dot: whether its round caps draw a dot.
        color: sRGB-encoded.
        form: the circle, ellipse or rectangle that it is; None for none.
    """

    rows: Rows
    width: float
    cap: int = ROUND
    is_dot: bool = False
    color: tuple[float, float, float] = (0.0, 0.0, 0.0)
    form: Candidate | None = None

    @property
    def length(self) -> float:
        """Length of the polygon of its control points in pixels."""
        return float(np.linalg.norm(np.diff(curves_of(self.rows), axis=1), axis=2).sum())

    def ends(self) -> tuple[Floats, Floats]:
        """Return where it starts and ends [2] px."""
        return self.rows.control[0, 0], self.rows.control[-1 if self.rows.is_open else 0, 0]

    def reversed(self) -> DrawnLine:
        """Return the line the other way round. A form has no other way."""
        if self.form is not None:
            return self
        curves = curves_of(self.rows)[::-1, ::-1]
        is_line, control = self.rows.is_line, curves[:, :3]
        if self.rows.is_open:
            control = np.concatenate([control, np.repeat(curves[-1:, 3:], 3, 1)])
            is_line = np.append(is_line[:-1][::-1], True)
        else:
            is_line = is_line[::-1]
        return replace(self, rows=Rows(control, is_line, self.rows.is_open))


def scene_of(paths: list[list[DrawnLine]]) -> Scene:
    """Return a scene of strokes with a path for each list of lines, which have one width, cap and colour.

    A line that is a form is alone in its list.
    """
    rows = [line.rows for path in paths for line in path]
    control = np.concatenate([np.zeros((0, 3, 2)), *(each.control for each in rows)])
    is_line = torch.from_numpy(np.concatenate([np.zeros(0, bool), *(each.is_line for each in rows)]))
    is_open = torch.tensor([each.is_open for each in rows], dtype=torch.bool)
    counts = [[len(line.rows.control) for line in path] for path in paths]
    structure = Structure.of_loops(counts, is_line if is_line.any() else None, is_open if is_open.any() else None)
    count = len(paths)
    width = torch.tensor([path[0].width for path in paths], dtype=torch.float32)
    cap = torch.tensor([path[0].cap for path in paths], dtype=torch.int32)
    join = torch.full((count,), ROUND, dtype=torch.int32)
    scene = Scene(
        straightened(torch.from_numpy(control).float(), structure), structure,
        color=torch.tensor([path[0].color for path in paths]).reshape(count, 3),
        opacity=torch.ones(count), background=torch.zeros(3),
        generation=torch.zeros(count, dtype=torch.int64), transparent=True,
        strokes=Strokes(width, cap, join, torch.full_like(width, MITER_LIMIT)),
    )  # fmt: skip
    forms = forms_of([path[0].form for path in paths]) if paths else None
    return scene if forms is None else scene.with_forms(forms.or_none())


def read_back(scene: Scene, paths: list[list[DrawnLine]]) -> list[list[DrawnLine]]:
    """Return the lines of ``paths`` as they are in a scene of `scene_of`, whose loops may have other rows."""
    assert scene.strokes is not None
    control, first = scene.segments.double().numpy(), scene.structure.loop_first_segment.tolist()
    is_line, widths, number, found = scene.structure.lines.numpy(), scene.strokes.width.tolist(), 0, []
    for path, width in zip(paths, widths, strict=True):
        lines = []
        for line in path:
            own = slice(first[number], first[number + 1])
            rows = line.rows._replace(control=control[own], is_line=is_line[own])
            lines.append(replace(line, rows=rows, width=width))
            number += 1
        found.append(lines)
    return found

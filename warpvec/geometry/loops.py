"""Outlines read from files, and the scene that they make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.forms.form import PARAMETERS
from warpvec.geometry.forms.registry import OUTLINE, form_of
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.kind import GEOMETRY_SIZE
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.softness import Softness
from warpvec.geometry.stops import Stops
from warpvec.geometry.strokes import BUTT, MITER, MITER_LIMIT, Strokes
from warpvec.geometry.structure import Structure

MAX_CUBICS = 2**22
"""Maximum number of cubics of a scene: 100 MB of control points."""

Color = tuple[float, float, float]

BLACK: Color = (0.0, 0.0, 0.0)


class OutlineStop(NamedTuple):
    """A stop of a gradient: its offset, its sRGB-encoded colour and its opacity, each in [0, 1]."""

    offset: float
    color: Color
    opacity: float = 1.0


class OutlineGradient(NamedTuple):
    """A gradient of an outline; its first stop has the outline's colour.

    Attributes:
        kind, geometry: as in `warpvec.geometry.gradients.Gradients`, in pixels; five numbers of an elliptic one.
        end_color: of the last stop, sRGB-encoded, in [0, 1].
        stops: all stops, at most ``STOPS_MAX``; None for two opaque ones at the ends.
    """

    kind: int
    geometry: tuple[float, ...]
    end_color: Color
    stops: tuple[OutlineStop, ...] | None = None


class OutlineForm(NamedTuple):
    """The form of an outline.

    Attributes:
        kind, parameters: as in `warpvec.geometry.path_forms.Forms`, in pixels.
    """

    kind: int
    parameters: tuple[float, ...]


class OutlineStroke(NamedTuple):
    """How an outline is stroked; the fields are those of `warpvec.geometry.strokes.Strokes`, the width in pixels."""

    width: float
    cap: int
    join: int
    miter_limit: float


@dataclass(frozen=True)
class Outline:
    """A path of one or more loops of cubics, filled or stroked.

    Attributes:
        points: control points [3 k, 2] in pixels (float64) of the k cubics of all loops, three a cubic: its anchor and
            its two handles.
        color: sRGB-encoded, in [0, 1].
        opacity: in [0, 1].
        generation: level of detail.
        segment_counts: cubics of each loop; None for a single loop.
        is_line: the cubics that are straight lines [k]; None if there are none.
        gradient: None for a flat fill.
        form: None unless the outline is a circle, an ellipse or a rectangle.
        stroke: None for a fill.
        is_open: the loops that are open lines, of which the last cubic is only the end; None if there are none.
        softness: standard deviation of its blur in pixels, 0 for none.
    """

    points: NDArray[np.float64]
    color: Color
    opacity: float
    generation: int
    segment_counts: tuple[int, ...] | None = None
    is_line: NDArray[np.bool_] | None = None
    gradient: OutlineGradient | None = None
    form: OutlineForm | None = None
    stroke: OutlineStroke | None = None
    is_open: tuple[bool, ...] | None = None
    softness: float = 0.0

    @staticmethod
    def of_form(form: OutlineForm, color: Color, opacity: float, generation: int) -> Outline:
        """Return the outline of a ``form``."""
        kind = form_of(form.kind)
        points = kind.segments(torch.tensor([form.parameters], dtype=torch.float64)).reshape(-1, 2).numpy()
        return Outline(points, color, opacity, generation, None, np.array(kind.is_line), form=form)

    @property
    def counts(self) -> tuple[int, ...]:
        """The number of cubics of each loop."""
        return (len(self.points) // 3,) if self.segment_counts is None else self.segment_counts


def make_scene(outlines: Sequence[Outline], background: Color | None) -> Scene:
    """Return the scene of ``outlines`` over ``background``, or a transparent scene if that is None.

    It is uniform if all outlines have one loop of equally many cubics and no lines.

    Raises:
        InputError: the scene would have more than ``MAX_CUBICS``, or a coordinate exceeds float32.
    """
    total = sum(len(outline.points) // 3 for outline in outlines)
    if total > MAX_CUBICS:
        raise InputError("SVG", f"must have at most {MAX_CUBICS} curves", str(total), "simplify it")
    points = np.concatenate([np.zeros((0, 2)), *(outline.points for outline in outlines)])
    structure = _structure_of(outlines)
    segments = straightened(torch.from_numpy(points).reshape(-1, 3, 2), structure).float()
    if not segments.isfinite().all():
        raise InputError("SVG", "must have coordinates below 3e38", "larger ones", "scale it down")
    scene = Scene(
        segments=segments,
        structure=structure,
        color=_colors([outline.color for outline in outlines]),
        opacity=torch.tensor([outline.opacity for outline in outlines], dtype=torch.float64).float(),
        background=torch.tensor(background or BLACK, dtype=torch.float64).float(),
        generation=torch.tensor([outline.generation for outline in outlines], dtype=torch.int64),
        transparent=background is None,
        gradients=_gradients_of(outlines),
        strokes=_strokes_of(outlines),
        softness=_softness_of(outlines),
    )
    return scene.with_forms(_forms_of(outlines))


def _structure_of(outlines: Sequence[Outline]) -> Structure:
    counts = [outline.counts for outline in outlines]
    has_lines = any(outline.is_line is not None and outline.is_line.any() for outline in outlines)
    has_ends = any(outline.is_open is not None and any(outline.is_open) for outline in outlines)
    if not has_lines and not has_ends and len(set(counts)) <= 1 and all(len(each) == 1 for each in counts):
        return Structure.uniform(len(outlines), counts[0][0] if counts else 1)
    masks = [np.zeros(len(o.points) // 3, np.bool_) if o.is_line is None else o.is_line for o in outlines]
    is_line = torch.from_numpy(np.concatenate(masks)) if has_lines else None
    opened = [end for outline in outlines for end in outline.is_open or [False] * len(outline.counts)]
    return Structure.of_loops(counts, is_line, torch.tensor(opened) if has_ends else None)


def _gradients_of(outlines: Sequence[Outline]) -> Gradients | None:
    if all(outline.gradient is None for outline in outlines):
        return None
    flat = OutlineGradient(FLAT, (0.0, 0.0, 0.0, 0.0), BLACK)
    paints = [outline.gradient or flat._replace(end_color=outline.color) for outline in outlines]
    kind = torch.tensor([paint.kind for paint in paints], dtype=torch.int32)
    geometry = torch.tensor([paint.geometry[:4] for paint in paints], dtype=torch.float64).float()
    end_color = _colors([paint.end_color for paint in paints])
    return Gradients(kind, geometry, end_color, _stops_of(paints, end_color)).without_plain_stops()


def _stops_of(paints: Sequence[OutlineGradient], end_color: Tensor) -> Stops | None:
    if all(paint.stops is None and len(paint.geometry) == GEOMETRY_SIZE for paint in paints):
        return None
    stops = Stops.two(end_color)
    for row, paint in enumerate(paints):
        if len(paint.geometry) > GEOMETRY_SIZE:
            stops.breadth[row] = paint.geometry[GEOMETRY_SIZE]
        if paint.stops is not None:
            count = len(paint.stops)
            stops.count[row] = count
            stops.offset[row, :count] = torch.tensor([stop.offset for stop in paint.stops])
            stops.opacity[row, :count] = torch.tensor([stop.opacity for stop in paint.stops])
            stops.inner_color[row, : count - 2] = _colors([stop.color for stop in paint.stops[1:-1]])
    return stops


def _forms_of(outlines: Sequence[Outline]) -> Forms | None:
    if all(outline.form is None for outline in outlines):
        return None
    none = OutlineForm(OUTLINE, (0.0,) * PARAMETERS)
    forms = [outline.form or none for outline in outlines]
    kind = torch.tensor([form.kind for form in forms], dtype=torch.int32)
    return Forms(kind, torch.tensor([form.parameters for form in forms], dtype=torch.float64).float())


def _strokes_of(outlines: Sequence[Outline]) -> Strokes | None:
    if all(outline.stroke is None for outline in outlines):
        return None
    fill = OutlineStroke(0.0, BUTT, MITER, MITER_LIMIT)
    strokes = [outline.stroke or fill for outline in outlines]
    width, limit = (
        torch.tensor([getattr(stroke, name) for stroke in strokes], dtype=torch.float64).float()
        for name in ("width", "miter_limit")
    )
    cap, join = (
        torch.tensor([getattr(stroke, name) for stroke in strokes], dtype=torch.int32) for name in ("cap", "join")
    )
    return Strokes(width, cap, join, limit)


def _softness_of(outlines: Sequence[Outline]) -> Softness | None:
    sigma = torch.tensor([outline.softness for outline in outlines], dtype=torch.float64).float()
    return Softness(sigma).or_none()


def _colors(colors: Sequence[Color]) -> Tensor:
    return torch.tensor(colors, dtype=torch.float64).reshape(-1, 3).float()

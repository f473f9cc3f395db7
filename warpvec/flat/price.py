"""Price the words of a drawing in nats. The error that a drawing leaves of its picture has the same unit.

A drawing of flat art is the shorter, the fewer numbers its file says. A number costs the logarithm of how many values
it can have. What is said already costs little. Source: Rissanen, Modeling by shortest data description,
1978; the numbers of each word are those that SVG states.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.geometry.forms.form import ANGLE
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, RECT, ROUND_RECT
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene

PRECISION = 0.1
"""Precision of a coordinate in pixels: the largest move of an outline that nobody asked about, `FitConfig.detail`."""

COLOR_NATS = 3.0 * math.log(256.0)
"""Nats of a colour of three channels of 256 levels."""

LINE, ARC, CUBIC = 2, 3, 6
"""Numbers of a segment of an outline, as SVG states them. Its start is the end of the one before, and the bulge of an
arc is its radius."""

FORM_NUMBERS = {CIRCLE: 3, ELLIPSE: 4, RECT: 4, ROUND_RECT: 5}
"""Numbers of a form that is not turned; the turn is one more."""

RAMP_NUMBERS = 4
"""Numbers that place a gradient: two points, or a centre with two radii."""

SHADOW_NUMBERS = 6
"""Numbers of a shadow that copies a path. The offset has two, the colour two, the blur one and the opacity one."""

STROKE_NUMBERS = 1
SOFT_NUMBERS = 1
"""Numbers of a stroke beside its centre line, and of a blur."""


class Words(NamedTuple):
    """What a drawing says: the numbers of its outlines and paints, and its colours, each counted once."""

    number_count: int
    color_count: int
    repeat_count: int

    def nats(self, side: float) -> float:
        """Return the nats of the words of a drawing of this longest ``side`` in pixels."""
        again = self.repeat_count * math.log(max(self.color_count, 1) + 1.0)
        return self.number_count * number_nats(side) + self.color_count * COLOR_NATS + again


def number_nats(side: float) -> float:
    """Return the nats of a coordinate in a picture of this longest ``side`` in pixels: 8.5 at 512."""
    return math.log(max(side / PRECISION, 2.0))


def words_of(scene: Scene) -> Words:
    """Return what ``scene`` says. A colour that another path has said is a repeat."""
    if not len(scene):
        return Words(0, int(not scene.transparent), 0)
    numbers = int(_outline_numbers(scene).sum())
    numbers += int((scene.opacity < 1.0).sum())
    if scene.strokes is not None:
        numbers += STROKE_NUMBERS * int((scene.strokes.width > 0).sum())
    if scene.softness is not None:
        numbers += SOFT_NUMBERS * int(scene.softness.is_soft.sum())
    ramps, stops = _ramps(scene)
    said = torch.cat([scene.color, scene.background[None]]) if not scene.transparent else scene.color
    levels = (255.0 * said).round()
    distinct = len(torch.unique(levels, dim=0))
    return Words(numbers + ramps, distinct + stops, len(levels) - distinct)


def _outline_numbers(scene: Scene) -> Tensor:
    """Return the numbers of the outline of each path [N]."""
    structure, forms = scene.structure, scene.forms
    rows = torch.where(structure.lines, LINE, CUBIC)
    numbers = torch.zeros(len(scene), dtype=torch.int64).index_add_(0, structure.segment_path.long(), rows)
    if forms is None:
        return numbers
    for kind, count in FORM_NUMBERS.items():
        numbers = torch.where(forms.kind == kind, count, numbers)
    return numbers + (forms.is_form & (forms.parameters[:, ANGLE] != 0.0)).long()


def _ramps(scene: Scene) -> tuple[int, int]:
    """Return the numbers of the gradients of ``scene``, and the colours of their stops but the first."""
    if scene.gradients is None:
        return 0, 0
    is_ramp = scene.gradients.kind != FLAT
    count = int(is_ramp.sum())
    if scene.gradients.stops is None:
        return RAMP_NUMBERS * count, count
    stops = int(scene.gradients.stops.count[is_ramp].sum())
    return RAMP_NUMBERS * count + max(stops - 2 * count, 0), stops - count

"""Which forms an outline may have: those near all that the picture shows of it, the simplest first."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.geometry.forms.form import FIRST, SECOND
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, RECT, ROUND_RECT, form_of

_TRIED = (
    (CIRCLE, True), (RECT, True), (ELLIPSE, True), (ROUND_RECT, True), (ELLIPSE, False), (RECT, False),
    (ROUND_RECT, False),
)  # fmt: skip
"""Forms, and whether they are level; those of fewer numbers first."""

_ROUND, _SHARP = {CIRCLE, ELLIPSE}, {RECT}


class Candidate(NamedTuple):
    """A form that a loop may have: its number, and its parameters [6]."""

    kind: int
    parameters: Floats

    @property
    def curves(self) -> Floats:
        """Its rows [S, 3, 2]."""
        rows: Floats = form_of(self.kind).segments(torch.from_numpy(self.parameters)[None])[0].numpy()
        return rows


def candidates(points: Floats, weights: Floats, is_line: Mask, detail: float) -> Iterator[Candidate]:
    """Yield the forms that a loop of S segments may have.

    Args:
        points: points along each segment [S, P, 2].
        weights: visible length that each stands for [S, P]; 0 where the outline is hidden.
        is_line: segments that are lines [S].
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
    """
    flat, weight = points.reshape(-1, 2), weights.reshape(-1)
    size = float(np.ptp(flat, axis=0).min())
    if len(is_line) > SIMPLIFICATION.form_rows_max or size < SIMPLIFICATION.form_size_min:
        return
    if weight.sum() <= 0.0 or (weight > 0.0).mean() < SIMPLIFICATION.form_points_min:
        return
    kinds = _kinds(is_line, has_hidden=bool((weight == 0.0).any()))
    near = SIMPLIFICATION.peak * detail
    for kind, is_level in _TRIED:
        form = form_of(kind)
        fitted = form.fit(flat, weight, is_level=is_level, near=near) if kind in kinds else None
        if fitted is None or fitted.distance > near:
            continue
        found = Candidate(kind, fitted.parameters)
        distances = form.distances(fitted.parameters, flat)
        is_near = float(np.average(np.square(distances), weights=weight)) <= detail**2
        if is_near and _is_evident(found, flat, weight, is_level):
            yield found


def whole_canvas(points: Floats, size: tuple[int, int]) -> Candidate | None:
    """Return the rectangle around a picture of this ``size`` if the ``points`` [S, P, 2] of a loop reach all its sides.

    An outline beyond the picture shows nowhere, so its points say nothing of its form.
    """
    near, (width, height) = SIMPLIFICATION.canvas_near, size
    low, high = points.reshape(-1, 2).min(0), points.reshape(-1, 2).max(0)
    if (low > near).any() or (high < np.array(size) - near).any():
        return None
    return Candidate(RECT, np.array([width / 2, height / 2, width, height, 0.0, 0.0]))


def _kinds(is_line: Mask, has_hidden: bool) -> set[int]:
    """Return the forms that an outline with such segments can have; what is hidden can have any."""
    if is_line.all():
        return _SHARP | ({CIRCLE, ELLIPSE, ROUND_RECT} if has_hidden else set())
    if not is_line.any():
        return _ROUND | ({ROUND_RECT} if has_hidden else set())
    return {ROUND_RECT} | (_ROUND | _SHARP if has_hidden else set())


def _is_evident(found: Candidate, points: Floats, weights: Floats, is_level: bool) -> bool:
    """Return whether the picture shows enough of a form to tell all of its numbers."""
    form, sizes = form_of(found.kind), found.parameters[[FIRST, SECOND]]
    if sizes[sizes > 0.0].min() < SIMPLIFICATION.form_size_min / 2:
        return False
    if form.determined(found.parameters, points, weights, is_level=is_level) < SIMPLIFICATION.form_determined:
        return False
    return bool((weights > 0.0).all()) or _seen_share(found, points[weights > 0.0]) >= SIMPLIFICATION.form_seen_min


def _seen_share(found: Candidate, seen: Floats) -> float:
    """Return the share of the outline of a form that has a point that is ``seen`` [K, 2] nearby."""
    rows = found.curves
    curves = np.concatenate([rows, np.roll(rows[:, :1], -1, axis=0)], 1)
    samples = cubic_points(curves, (np.arange(16) + 0.5) / 16)
    lengths = np.linalg.norm(curves[:, 3] - curves[:, 0], axis=1)
    near = np.linalg.norm(samples[:, :, None] - seen, axis=-1).min(2) <= np.maximum(lengths, 2.0)[:, None] / 4
    return float((near.mean(1) * lengths).sum() / max(lengths.sum(), 1e-9))

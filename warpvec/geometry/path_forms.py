"""The forms of the paths of a scene: which paths are a circle, an ellipse or a rectangle, and their parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.forms.form import ANGLE, CORNER, FIRST, PARAMETERS, SECOND, Form
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, FORMS, OUTLINE, ROUND_RECT, form_of
from warpvec.geometry.gradients import check_shape
from warpvec.geometry.structure import Structure

UNEVEN_MAX = 0.02
"""Largest distance in pixels by which a form may miss what it would be after a scale that differs across and down: a
picture that is reduced to whole pixels has such a scale. Beyond it a form becomes another one or an outline."""

SIZE_MIN = 0.1
"""Smallest size of a form in pixels that a fit may give it: one of no size has no outline."""


@dataclass(frozen=True)
class Forms:
    """Which form each of N paths has. The rows of a path with a form are those that its parameters give.

    Attributes:
        kind: form of each path [N] (int32): ``OUTLINE`` or a key of ``FORMS`` of `warpvec.geometry.forms.registry`.
        parameters: numbers of each form [N, 6]; those of outlines are unused.

    Raises:
        InputError: the shapes do not agree.
    """

    kind: Tensor
    parameters: Tensor

    def __post_init__(self) -> None:
        check_shape("forms.parameters", self.parameters, (len(self.kind), PARAMETERS), len(self.kind))

    @staticmethod
    def none(color: Tensor) -> Forms:
        """Return the forms of paths of ``color`` [N, 3] that have none."""
        kind = torch.full((len(color),), OUTLINE, dtype=torch.int32, device=color.device)
        return Forms(kind, color.new_zeros(len(color), PARAMETERS))

    def __len__(self) -> int:
        return len(self.kind)

    @property
    def is_form(self) -> Tensor:
        """Which paths have a form [N] (bool)."""
        return self.kind != OUTLINE

    def groups(self) -> Iterator[tuple[int, Form, Tensor]]:
        """Yield each form that a path has, by its number, and the paths that have it (int64).

        Raises:
            InputError: a number is not in the registry.
        """
        for number in sorted(set(self.kind.tolist()) - {OUTLINE}):
            yield number, form_of(number), (self.kind == number).nonzero().flatten()

    def check(self, structure: Structure) -> None:
        """Refuse forms whose paths are not one loop of their number of rows.

        Raises:
            InputError: there is one.
        """
        if len(self) != structure.path_count:
            rule = f"must have {structure.path_count} entries"
            raise InputError("forms", rule, str(len(self)), "give one a path")
        rows, loops = structure.path_first_segment.diff(), structure.path_first_loop.diff()
        for _, form, paths in self.groups():
            is_right = (rows[paths] == form.row_count) & (loops[paths] == 1)
            if structure.is_open is not None:
                is_right &= ~structure.is_open[structure.path_first_loop.long()[paths]]
            if not bool(is_right.all()):
                rule = f"must have one closed loop of {form.row_count} rows for a {form.name}"
                raise InputError("structure", rule, "other rows", "make it an outline")

    def placed(self, segments: Tensor, structure: Structure) -> Tensor:
        """Return ``segments`` [R, 3, 2] with the rows of forms as their parameters give them."""
        segments = segments.clone()
        for _, form, paths in self.groups():
            rows = form_rows(structure, paths, form)
            segments[rows] = form.segments(self.parameters[paths].double()).to(segments.dtype)
        return segments

    def bounded(self) -> Forms:
        """Return the forms with sizes of at least ``SIZE_MIN`` and corners that have room."""
        parameters = self.parameters.clone()
        sizes = parameters[:, FIRST : SECOND + 1]
        sizes.clamp_(min=SIZE_MIN)
        corner = parameters[:, CORNER].clamp_min(0.0)
        parameters[:, CORNER] = torch.minimum(corner, sizes.amin(1) / 2)
        return replace(self, parameters=torch.where(is_used(parameters, self.kind), parameters, 0.0))

    def without(self, paths: Tensor) -> Forms | None:
        """Return the forms with ``paths`` (indices or a mask [N]) as outlines; None if none is left."""
        kind = self.kind.clone()
        kind[paths] = OUTLINE
        return replace(self, kind=kind).or_none()

    def or_none(self) -> Forms | None:
        """Return the forms, or None if all paths are outlines."""
        return self if bool(self.is_form.any()) else None

    def map(self, change: Callable[[Tensor], Tensor]) -> Forms:
        """Return the forms with each tensor replaced by what ``change`` makes of it."""
        return Forms(change(self.kind), change(self.parameters))

    def joined(self, other: Forms) -> Forms:
        """Return these forms and those of ``other``."""
        return Forms(torch.cat([self.kind, other.kind]), torch.cat([self.parameters, other.parameters]))

    def moved(self, x: float, y: float) -> Forms:
        """Return the forms moved by ``x`` and ``y`` pixels."""
        return replace(self, parameters=self.parameters + self.parameters.new_tensor([x, y, 0, 0, 0, 0]))

    def scaled(self, x_factor: float, y_factor: float) -> Forms | None:
        """Return the forms scaled about the origin; what is no form any more becomes an outline.

        A circle may become an ellipse. None if no form is left.
        """
        old = self.parameters
        if min(x_factor, y_factor) <= 0.0:
            return None
        mean = (x_factor * y_factor) ** 0.5
        sizes = torch.where(self.kind[:, None] == CIRCLE, old[:, [FIRST, FIRST]], old[:, [FIRST, SECOND]])
        is_even = sizes.amax(1) * abs(x_factor - y_factor) / 2 <= UNEVEN_MAX
        parameters = old * old.new_tensor([x_factor, y_factor, mean, mean, 1.0, mean])
        stretched = torch.cat([parameters[:, :2], sizes * old.new_tensor([x_factor, y_factor]), parameters[:, 4:]], 1)
        is_level = (old[:, ANGLE] == 0.0) & (self.kind != ROUND_RECT) & self.is_form
        is_ellipse = ~is_even & (self.kind == CIRCLE)
        kind = torch.where(is_ellipse, ELLIPSE, self.kind)
        kind = torch.where(is_even | is_level, kind, OUTLINE)
        parameters = torch.where((~is_even & is_level)[:, None], stretched, parameters)
        return Forms(kind.int(), parameters).or_none()


def form_rows(structure: Structure, paths: Tensor, form: Form) -> Tensor:
    """Return the rows [K, S] (int64) of ``paths`` [K], which have the same ``form``."""
    first = structure.path_first_segment[:-1].long()[paths]
    return first[:, None] + torch.arange(form.row_count, device=first.device)


def is_used(parameters: Tensor, kind: Tensor) -> Tensor:
    """Return which numbers the forms of each ``kind`` [N] have: a mask [N, 6]."""
    mask = torch.zeros_like(parameters, dtype=torch.bool)
    for number, form in FORMS.items():
        for place in form.free:
            mask[:, place] |= kind == number
    return mask

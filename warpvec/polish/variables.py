"""A drawing as one vector of free values, with the loss, its gradient, and how strongly each value shows.

The drawing keeps its structure: paths, loops, kinds of segments and nodes, and kinds of paint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.forms.form import ANGLE, CORNER, FIRST, SECOND
from warpvec.geometry.joints import Joints
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.path_forms import is_used
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import SIGMA_MAX
from warpvec.polish.curve_rows import CurveRows, RowSlopes
from warpvec.polish.stop_variables import bound_stops, bounded_offset_step, free_stops, stop_parts
from warpvec.polish.tension import tension_of

if TYPE_CHECKING:  # photos need no matrix, and loading scipy takes a tenth of a second
    from scipy import sparse

OPAQUE = 1.0 - 1e-3
"""A path of at least this opacity is opaque and stays so, unless all values are free."""

OPACITY_MIN = 0.01
"""A translucent path stays visible: with less, its file would leave it out."""

WIDTH_MIN = 0.1
"""Least width of a stroke in pixels. A thinner one can hardly be seen, and one of no width would be filled."""

SIGMA_FIT_MIN = 0.2
"""Least standard deviation of a soft path in pixels: with less it could never become soft again."""

STRENGTH_MIN = 0.01
"""Smallest strength of a value, as a share of the mean strength of its kind. Without this, values that hardly show,
such as the points of a hidden path, would take steps without a bound."""


@dataclass(frozen=True)
class Evaluation:
    """The loss at ``x``, and its gradient [K]."""

    x: Tensor
    loss: float
    gradient: Tensor


class Variables:
    """The free values of ``scene``: a vector of anchors, handles, colours, opacities, background, gradients and forms.

    The points of a path with a form are not free: they follow from its parameters. ``locked`` paths [N] (bool) keep all
    their values. With ``keeps_stops``, gradients keep the colours and opacities of their stops, and with
    ``keeps_softness`` soft paths their standard deviations. Without ``keeps_smooth``, smooth nodes may become corners.
    The loss grows with the lengths of outlines by ``tension`` [R], if there is one.

    Attributes:
        start: the values of ``scene`` [K].
        point_count: the first values are the coordinates of so many points, two each.
        is_free: values that a fit may change [K].
        opacity_range: first value that is an opacity, and the one after the last.
        target, joints: the image, and the kinds of the nodes.
        locked: paths [N] (bool) that keep their values; None for none.
        tension: rise of the loss with each pixel of length of each segment [R]; None for none.
    """

    def __init__(
        self, scene: Scene, target: Target, config: FitConfig, *, free: bool = False, locked: Tensor | None = None,
        keeps_stops: bool = False, keeps_softness: bool = False, keeps_smooth: bool = True,
        tension: Tensor | None = None,
    ) -> None:  # fmt: skip
        self._scene, self.target, self.joints = scene, target, Joints.of(scene, keep=keeps_smooth and not free)
        parts = [*self.joints.values(scene), scene.color, scene.opacity, scene.background]
        if scene.gradients is not None:
            parts += [scene.gradients.end_color, scene.gradients.geometry, *stop_parts(scene.gradients)]
        self._width_part = len(parts)
        if scene.strokes is not None:
            parts.append(scene.strokes.width)
        self._sigma_part = len(parts)
        if scene.softness is not None:
            parts.append(scene.softness.sigma)
        if scene.forms is not None:
            parts.append(scene.forms.parameters)
        self._shapes = [part.shape for part in parts]
        self._sizes = [part.numel() for part in parts]
        self._bounds = [0, *accumulate(self._sizes)]
        self.start = torch.cat([part.flatten() for part in parts])
        self.point_count = self._bounds[3] // 2
        self.opacity_range = self._bounds[4], self._bounds[5]
        self.is_free = torch.ones_like(self.start, dtype=torch.bool)
        is_translucent = torch.full_like(scene.opacity, config.opacity == "free", dtype=torch.bool)
        self._part(self.is_free, 4).copy_(is_translucent & ((scene.opacity < OPAQUE) | free))
        self._part(self.is_free, 5).fill_(config.backdrop != "white" and not scene.transparent)
        if scene.gradients is not None and scene.gradients.stops is not None:
            masks = free_stops(scene.gradients, are_translucent_free=config.opacity == "free", free=free)
            for part, mask in zip(self._stops_of(self.is_free), masks, strict=True):
                part.copy_(mask)
        if scene.strokes is not None:
            self._part(self.is_free, self._width_part).copy_(scene.strokes.is_stroked)
        if scene.softness is not None:
            self._part(self.is_free, self._sigma_part).copy_(scene.softness.is_soft & (not keeps_softness))
        if scene.forms is not None:
            own = scene.forms.is_form
            self.is_free &= ~self.points_of(own[scene.structure.segment_path.long()])
            self._part(self.is_free, -1).copy_(is_used(scene.forms.parameters, scene.forms.kind))
        if keeps_stops and scene.gradients is not None:
            self.is_free &= ~self._stop_colors_of(scene.gradients.kind != FLAT)
        self.locked, self.tension = locked, tension
        self._locked = None if locked is None else self._values_of(locked)
        if self._locked is not None:
            self.is_free &= ~self._locked
        self._memory = scene.copied()
        first_form = self._bounds[-2] if scene.forms is not None else self._bounds[-1]
        first_width = -1 if scene.strokes is None else self._bounds[self._width_part]
        self._rows = CurveRows(scene, self.joints, first_width, first_form)
        self._seen: tuple[Tensor, int] | None = None

    def fix(self, values: Tensor) -> None:
        """Keep ``values`` (a mask [K]) as they are from now on."""
        self.is_free &= ~values

    def scene(self, x: Tensor) -> Scene:
        """Return the scene of ``x``, in memory of its own."""
        return self.shown(x).copied()

    def start_change(self) -> float:
        """Return by how much its bounds change the start at most: values, or control points."""
        pairs = [(self.limited(self.start), self.start), (self.shown(self.start).segments, self._scene.segments)]
        return max(float((now - before).abs().max()) for now, before in pairs if len(now))

    def evaluate(self, x: Tensor) -> Evaluation:
        """Return the loss at ``x`` and its gradient. The gradient of fixed values is zero."""
        scene = self.shown(x)
        adjoints = self.target.whole_step(scene)
        loss = float(adjoints.loss)
        if self.tension is not None:
            more, adj_segments = tension_of(scene, self.tension)
            loss, adjoints = loss + more, replace(adjoints, segments=adjoints.segments + adj_segments)
        return Evaluation(x, loss, self._gradient(self.row_slopes(x), adjoints))

    def loss_of(self, scene: Scene) -> float:
        """Return the loss of ``scene``, which has the structure of this one."""
        loss = float(self.target.fit_step(scene, False).loss)
        return loss if self.tension is None else loss + tension_of(scene, self.tension)[0]

    def strength(self, x: Tensor, probes: int, generator: torch.Generator) -> Tensor:
        """Estimate how strongly each value shows: the diagonal of the Gauss-Newton matrix of the loss [K].

        The square of the adjoint of a random image is, on average over random signs, that diagonal times a constant.
        """
        total = torch.zeros_like(x)
        slopes = self.row_slopes(x)
        for adjoints in self.target.random_adjoints(self.shown(x), generator, probes):
            total += self._gradient(slopes, adjoints).square()
        total *= 2.0 * self.target.error_scale / probes
        parts = self._of(total)
        first, last = 8 + len(stop_parts(self._scene.gradients)), len(parts) - (self._scene.forms is not None)
        for index, part in enumerate(parts[:last]):
            if not 8 <= index < first:
                part += STRENGTH_MIN * part.mean() + 1e-12
        for part, own in zip(self._stops_of(total), self._stops_of(self.is_free), strict=True):
            part += STRENGTH_MIN * part.sum() / own.sum().clamp_min(1) + 1e-12
        return total + self.form_floor(total) if self._scene.forms is not None else total

    def form_floor(self, diagonal: Tensor) -> Tensor:
        """Return what must be added to a ``diagonal`` [K] of a matrix so that no number of a form takes endless steps.

        An angle shows far more than a place, so each number is compared with those of its kind.
        """
        floor = torch.zeros_like(diagonal)
        if self._scene.strokes is not None:
            widths = self._part(diagonal, self._width_part)
            self._part(floor, self._width_part).fill_(STRENGTH_MIN * widths.mean() + 1e-12)
        if self._scene.softness is not None:
            sigmas = self._part(diagonal, self._sigma_part)
            self._part(floor, self._sigma_part).fill_(STRENGTH_MIN * sigmas.mean() + 1e-12)
        if self._scene.forms is not None:
            part, own = self._part(diagonal, -1), self._part(self.is_free, -1)
            mean = (part * own).sum(0) / own.sum(0).clamp_min(1)
            self._part(floor, -1).copy_(STRENGTH_MIN * mean + 1e-12)
        return floor

    def row_slopes(self, x: Tensor, held: Tensor | None = None) -> RowSlopes:
        """Return how curves follow the values at ``x``, in memory that the next call overwrites.

        Handles that are ``held`` [R, 2] keep their length.
        """
        return self._rows.slopes(self._points(x), held, self._form_derivative(x))

    def _form_derivative(self, x: Tensor) -> sparse.csr_matrix | None:
        """Return the derivative of the curves by the parameters of forms [8 R, 6 N]; None without forms."""
        forms = self._scene.forms
        if forms is None:
            return None
        from warpvec.geometry.form_slopes import form_derivative

        return form_derivative(replace(forms, parameters=self._part(x, -1)), self._scene.structure)

    def with_bounded_forms(self, step: Tensor, most: float) -> Tensor:
        """Return ``step`` [K] with each form moving by at most ``most`` pixels."""
        if self._scene.forms is None:
            return step
        step = step.clone()
        moves, parameters = self._part(step, -1), self._part(self.start, -1)
        reach = parameters[:, FIRST : SECOND + 1].abs().amax(1)
        sizes = moves[:, :2].norm(dim=1) + moves[:, FIRST : SECOND + 1].abs().amax(1) + moves[:, CORNER].abs()
        moves *= (most / (sizes + moves[:, ANGLE].abs() * reach).clamp_min(1e-9)).clamp_max(1.0)[:, None]
        return step

    def with_bounded_stops(self, x: Tensor, step: Tensor) -> Tensor:
        """Return ``step`` [K] from ``x`` on with stops of gradients that stay apart; see `bounded_offset_step`."""
        if not self._stops_of(step):
            return step
        gradients = self._scene.gradients
        assert gradients is not None
        step = step.clone()
        moves = self._stops_of(step)[1]
        moves.copy_(bounded_offset_step(self._stops_of(x)[1], moves, gradients.all_stops().count))
        return step

    def held(self, found: Evaluation) -> tuple[Tensor, Tensor]:
        """Return which handles [R, 2] must not move along themselves, and the gradient [K] without such moves."""
        gradient = found.gradient.clone()
        points, adjoints = self._points(found.x), self._points(gradient)
        held, direction = self.joints.held(points, adjoints), self.joints.directions(*points)
        for side, adjoint in zip(held.unbind(1), adjoints[1:], strict=True):
            along = (adjoint * direction).sum(1, keepdim=True) * direction
            adjoint -= torch.where(side[:, None], along, torch.zeros_like(along))
        return held, gradient

    def limited(self, x: Tensor) -> Tensor:
        """Return ``x`` with smooth nodes smooth, colours in [0, 1] and free opacities in [``OPACITY_MIN``, 1]."""
        return self._limited(x, self._rows.place(self._points(x))[:2])

    def _limited(self, x: Tensor, aligned: Sequence[Tensor]) -> Tensor:
        """Return `limited` with the handles ``aligned``."""
        x = x.clone()
        _, leaving, arriving, color, opacity, background, *paints = self._of(x)
        for part, handles in zip((leaving, arriving), aligned, strict=True):
            part.copy_(handles)
        end_color = paints[:1] if self._scene.gradients is not None else []
        for part in (color, background, *end_color):
            part.clamp_(0.0, 1.0)
        if self._scene.strokes is not None:
            width = self._part(x, self._width_part)
            width.copy_(torch.where(self._scene.strokes.is_stroked, width.clamp_min(WIDTH_MIN), 0.0))
        if self._scene.softness is not None:
            sigma, is_soft = self._part(x, self._sigma_part), self._scene.softness.is_soft
            sigma.copy_(torch.where(is_soft, sigma.clamp(SIGMA_FIT_MIN, SIGMA_MAX), 0.0))
        if self._scene.forms is not None:
            paints[-1].copy_(replace(self._scene.forms, parameters=paints[-1]).bounded().parameters)
        if self._scene.gradients is not None:
            bound_stops(self._stops_of(x), self._stops_of(self.is_free), self._scene.gradients)
        opacity.copy_(torch.where(self._part(self.is_free, 4), opacity.clamp(OPACITY_MIN, 1.0), opacity))
        return x if self._locked is None else torch.where(self._locked, self.start, x)

    def points_of(self, rows: Tensor) -> Tensor:
        """Return which values are points of the segments ``rows`` (a mask [R]) or of their nodes: a mask [K]."""
        mask = torch.zeros_like(self.is_free)
        for part in self._points(mask):
            part.copy_(rows[:, None].expand_as(part))
        return mask

    def _values_of(self, paths: Tensor) -> Tensor:
        """Return which values belong to ``paths`` (a mask [N]): a mask [K]."""
        mask = self.points_of(paths[self._scene.structure.segment_path.long()])
        _, _, _, color, opacity, _, *paints = self._of(mask)
        for part in (color, opacity, *paints):
            part[paths] = True
        return mask

    def _stop_colors_of(self, paths: Tensor) -> Tensor:
        """Return which values are colours or opacities of the stops of ``paths`` (a mask [N]): a mask [K]."""
        mask = torch.zeros_like(self.is_free)
        stops = self._stops_of(mask)
        for part in (self._part(mask, 3), self._part(mask, 6), *stops[:1], *stops[2:3]):
            part[paths] = True
        return mask

    def whole_paths(self, rows: Tensor) -> Tensor:
        """Return the segments [R] (bool) of all paths that have one of the segments ``rows`` (a mask [R])."""
        owner = self._scene.structure.segment_path.long()
        paths = torch.zeros(len(self._scene), dtype=torch.bool, device=rows.device)
        paths[owner[rows]] = True
        return paths[owner]

    @property
    def estimated_values(self) -> Tensor:
        """Which values the Gauss-Newton matrix leaves out, as they act through opacity: a mask [K].

        They are opacities of paths and of stops, and the places of translucent stops.
        """
        mask = torch.zeros_like(self.is_free)
        self._part(mask, 4).fill_(True)
        if self._stops_of(mask):
            gradients = self._scene.gradients
            assert gradients is not None
            is_translucent = gradients.least_opacity() < OPAQUE
            _, offset, opacity, breadth = self._stops_of(mask)
            opacity.fill_(True)
            for part in (self._part(mask, 7), offset, breadth):
                part[is_translucent] = True
        return mask

    @property
    def value_count(self) -> int:
        """Number of values without those of stops that no path has, or that are fixed."""
        return len(self.start) - sum(int((~part).sum()) for part in self._stops_of(self.is_free))

    def _stops_of(self, x: Tensor) -> list[Tensor]:
        """Return the parts of a vector [K] that are values of stops; none in a scene without."""
        return [self._part(x, 8 + k) for k in range(len(stop_parts(self._scene.gradients)))]

    def _of(self, x: Tensor) -> list[Tensor]:
        """Return the parts of a vector [K] in their shapes; they share its memory."""
        return [part.view(shape) for part, shape in zip(x.split_with_sizes(self._sizes), self._shapes, strict=True)]

    def _points(self, x: Tensor) -> list[Tensor]:
        """Return the first three of these: anchors and handles, each [R, 2]."""
        return [self._part(x, k) for k in range(3)]

    def _part(self, x: Tensor, number: int) -> Tensor:
        """Return one of these."""
        begin = self._bounds[number if number >= 0 else number - 1]
        return x[begin : begin + self._sizes[number]].view(self._shapes[number])

    def shown(self, x: Tensor) -> Scene:
        """Return the scene of ``x``, in memory that the next call overwrites.

        The memory stays the same because a recorded step on a GPU reads it.
        """
        if self._seen is not None and self._seen[0] is x and self._seen[1] == x._version:
            return self._memory
        self._seen = None  # an interruption may leave half of the memory written
        *aligned, segments = self._rows.place(self._points(x))
        if self._scene.forms is not None:
            forms = replace(self._scene.forms, parameters=self._part(x, -1))
            segments = forms.placed(segments, self._scene.structure)
        scene, limited = self._memory, self._of(self._limited(x, aligned))
        _, _, _, color, opacity, background, *paints = limited
        shown = [(scene.segments, segments), (scene.color, color), (scene.opacity, opacity)]
        shown.append((scene.background, background))
        if scene.gradients is not None:
            own = (scene.gradients.end_color, scene.gradients.geometry, *stop_parts(scene.gradients))
            shown += zip(own, paints[: len(own)], strict=True)
        if scene.strokes is not None:
            shown.append((scene.strokes.width, limited[self._width_part]))
        if scene.softness is not None:
            shown.append((scene.softness.sigma, limited[self._sigma_part]))
        if scene.forms is not None:
            shown.append((scene.forms.parameters, paints[-1]))
        for memory, values in shown:
            memory.copy_(values)
        self._seen = x, x._version
        return scene

    def _gradient(self, slopes: RowSlopes, adjoints: Any) -> Tensor:
        points = self.start.new_zeros(self._bounds[3])
        parts = [points, adjoints.color.flatten(), adjoints.opacity, adjoints.background]
        if self._scene.gradients is not None:
            parts += [adjoints.end_color.flatten(), adjoints.geometry.flatten()]
            if self._scene.gradients.stops is not None:
                of_stops = (adjoints.inner_color, adjoints.offset, adjoints.stop_opacity, adjoints.breadth)
                parts += [adjoint.flatten() for adjoint in of_stops]
        if self._scene.strokes is not None:
            parts.append(adjoints.width)
        if self._scene.softness is not None:
            parts.append(adjoints.softness)
        if self._scene.forms is not None:
            parts.append(self.start.new_zeros(self._bounds[-1] - self._bounds[-2]))
        adj_curves = self._rows.adjoint(slopes, adjoints.segments, len(self.start))
        return (torch.cat(parts) + adj_curves).to(self.start.dtype) * self.is_free

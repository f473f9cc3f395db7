"""The scene: closed paths of Bezier curves, painted in order over a background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import torch
from torch import Tensor

from warpvec.checks import counted
from warpvec.errors import InputError
from warpvec.geometry.gradients import Gradients, check_shape
from warpvec.geometry.lines import thirds
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.side_opacity import SideOpacity
from warpvec.geometry.softness import Softness
from warpvec.geometry.strokes import Strokes
from warpvec.geometry.structure import Structure


@dataclass(frozen=True)
class Scene:
    """N closed paths of one or more loops of Bezier curves of degree M, the first path at the bottom.

    A row of ``segments`` is one curve: its start (the anchor) and its inner control points (for a cubic the handle that
    leaves the anchor and the handle that arrives at the next one). It ends at the anchor of the next row of its loop.
    In a *uniform* scene every path is one loop of S curves; `uniform` makes one from control points [N, M S, 2].

    Attributes:
        segments: control points [R, M, 2] in pixels, x right, y down.
        structure: which segments make up each loop, and which loops each path. It moves to the device of the segments.
        color: sRGB-encoded fill [N, 3] in [0, 1].
        opacity: fill opacity [N] in [0, 1].
        background: sRGB-encoded background colour [3] in [0, 1].
        generation: level of detail [N] (int64), 0 for the first; it becomes the layer in the file.
        transparent: whether the scene has no background. ``background`` is then black, over which an image is
            premultiplied.
        gradients: the paints of paths that are not flat; None if all are flat. ``color`` is that of the first stop.
        strokes: the widths, caps and joins of stroked paths; None if all are filled.
        forms: the paths that are a circle, an ellipse or a rectangle; None if there are none. Their rows always are
            those of their parameters. `outlined` drops the forms, for code that moves rows.
        softness: how far a Gaussian blurs each path; None if all are sharp.
        side_opacity: the opacities of paths of two sides at these; None if ``opacity`` is that of the whole path.

    Raises:
        InputError: the shapes do not agree.
    """

    segments: Tensor
    structure: Structure
    color: Tensor
    opacity: Tensor
    background: Tensor
    generation: Tensor
    transparent: bool = False
    gradients: Gradients | None = None
    strokes: Strokes | None = None
    forms: Forms | None = None
    softness: Softness | None = None
    side_opacity: SideOpacity | None = None

    def __post_init__(self) -> None:
        if self.structure.loop_first_segment.device != self.segments.device:
            object.__setattr__(self, "structure", self.structure.to(self.segments.device))
        shape, segment_count = tuple(self.segments.shape), self.structure.segment_count
        if len(shape) != 3 or shape[0] != segment_count or shape[1] < 1 or shape[2] != 2:
            rule = f"must have shape [{segment_count}, degree, 2] for this structure"
            raise InputError("segments", rule, str(list(shape)), "reshape it")
        count = self.structure.path_count
        expected = {"color": (count, 3), "opacity": (count,), "background": (3,), "generation": (count,)}
        for name, wanted in expected.items():
            check_shape(name, getattr(self, name), wanted, count)
        for name in _GROUPS:
            group = getattr(self, name)
            if group is not None and len(group) != count:
                raise InputError(name, f"must have {count} entries", str(len(group)), "give one a path")
        if self.forms is not None and not self.segments.is_cuda:  # there it would wait for the work of the GPU
            self.forms.check(self.structure)

    @staticmethod
    def uniform(
        points: Tensor,
        color: Tensor,
        opacity: Tensor,
        background: Tensor,
        generation: Tensor,
        degree: int = 3,
        transparent: bool = False,
    ) -> Scene:
        """Return a scene of paths of one loop of S curves each.

        Args:
            points: control points [N, M S, 2] in pixels. Curve s of a path has the points M s, M s + 1, ..., M s + M
                (modulo M S), so the anchors are 0, M, 2 M, ...
            color, opacity, background, generation, transparent: as in the scene.
            degree: M of every curve, 3 for cubics.

        Raises:
            InputError: the degree is not positive, or the shapes do not agree.
        """
        if degree < 1:
            raise InputError("degree", "must be at least 1", str(degree), "give 3 for cubics")
        shape = list(points.shape)
        if len(shape) != 3 or shape[1] == 0 or shape[1] % degree or shape[2] != 2:
            rule = f"must have shape [N, {degree} S, 2], S at least 1, for degree {degree}"
            raise InputError("points", rule, str(shape), "reshape it or give its degree")
        structure = Structure.uniform(points.shape[0], points.shape[1] // degree, points.device)
        segments = points.reshape(-1, degree, 2)
        return Scene(segments, structure, color, opacity, background, generation, transparent)

    def __repr__(self) -> str:
        structure = self.structure
        counts = [counted(len(self), "path"), counted(structure.segment_count, "segment")]
        masks = {
            "gradient": None if self.gradients is None else self.gradients.kind != FLAT,
            "stroke": None if self.strokes is None else self.strokes.is_stroked,
            "form": None if self.forms is None else self.forms.is_form,
            "soft path": None if self.softness is None else self.softness.is_soft,
        }
        counts += [counted(int(mask.sum()), noun) for noun, mask in masks.items() if mask is not None]
        backdrop = "transparent" if self.transparent else f"background {self.background.tolist()}"
        return f"<Scene: {', '.join(counts)} of degree {self.degree}, {backdrop}, on {self.segments.device}>"

    def __len__(self) -> int:
        return self.structure.path_count

    @property
    def soft_count(self) -> int:
        """Number of soft paths."""
        return 0 if self.softness is None else int(self.softness.is_soft.sum())

    @property
    def degree(self) -> int:
        """Degree of every curve, M: 3 for cubics."""
        return self.segments.shape[1]

    @property
    def is_uniform(self) -> bool:
        """Whether every path is one loop of the same number of curves, and no curve is marked as a line."""
        return self.structure.uniform_count is not None

    @property
    def points(self) -> Tensor:
        """Control points [N, M S, 2] of a uniform scene, as in `uniform`.

        Raises:
            InputError: the scene is not uniform.
        """
        if self.structure.uniform_count is None:
            raise InputError("scene", "must have paths of one loop of equally many curves", "other paths")
        return self.segments.reshape(len(self), self.structure.uniform_count * self.degree, 2)

    @property
    def piece_count(self) -> int:
        """Number of curves per path of a uniform scene, S."""
        return self.points.shape[1] // self.degree

    def detach(self) -> Scene:
        """Return the scene outside autograd."""
        return self._mapped(torch.Tensor.detach)

    def cpu(self) -> Scene:
        """Return the scene in host memory."""
        return self.to("cpu")

    def to(self, device: torch.device | str) -> Scene:
        """Return the scene in the memory of ``device``."""
        return self._mapped(lambda tensor: tensor.to(device))

    def copied(self) -> Scene:
        """Return the scene in memory of its own."""
        return self._mapped(torch.Tensor.clone)

    def scaled(self, x_factor: float, y_factor: float | None = None) -> Scene:
        """Return the scene scaled by ``x_factor`` horizontally and ``y_factor`` (default: the same) vertically."""
        factors = (x_factor, x_factor if y_factor is None else y_factor)
        groups = self._groups(lambda group: group.scaled(*factors))
        return replace(self, segments=self.segments * self.segments.new_tensor(factors), **groups)._with_form_rows()

    def moved(self, x: float, y: float) -> Scene:
        """Return the scene moved by ``x`` and ``y`` pixels."""
        groups = self._groups(lambda group: group.moved(x, y))
        return replace(self, segments=self.segments + self.segments.new_tensor([x, y]), **groups)._with_form_rows()

    def with_forms(self, forms: Forms | None) -> Scene:
        """Return the scene with these ``forms``, and their rows; the other rows stay.

        Raises:
            InputError: a path with a form has another number of rows or loops.
        """
        return replace(self, forms=forms)._with_form_rows()

    def outlined(self) -> Scene:
        """Return the scene with outlines in place of forms. It looks the same."""
        return self if self.forms is None else replace(self, forms=None)

    def _with_form_rows(self) -> Scene:
        """Return the scene with the rows of forms as their parameters give them."""
        if self.forms is None:
            return self
        return replace(self, segments=self.forms.placed(self.segments, self.structure))

    def select(self, rows: Tensor, chosen: tuple[Structure, Tensor] | None = None) -> Scene:
        """Return the paths ``rows`` (indices or a mask [N]), in that order, over the same background.

        ``chosen`` is what `Structure.select` has returned for them, if that is known.
        """
        structure, segments = self.structure.select(rows) if chosen is None else chosen
        return self._with_paths(structure, self.segments[segments], lambda tensor: tensor[rows])

    def prefix(self, count: int) -> Scene:
        """Return the lowest ``count`` paths, in memory of their own, over the same background."""
        structure = self.structure.prefix(count)
        segments = self.segments[: structure.segment_count].clone()
        return self._with_paths(structure, segments, lambda tensor: tensor[:count].clone())

    def joined(self, other: Scene) -> Scene:
        """Return these paths and, on top, those of ``other``, over the background of this scene."""
        names = ("segments", "color", "opacity", "generation")
        tensors: dict[str, Any] = {name: torch.cat([getattr(self, name), getattr(other, name)]) for name in names}
        structure = self.structure.joined(other.structure)
        return replace(self, structure=structure, **self._joined_groups(other), **tensors)

    def to_dict(self) -> dict[str, Any]:
        """Return the scene as tensors, numbers and None by name; `from_dict` takes it back.

        The values are not copied. Numbers of rows are int64, as files have them, and masks uint8. Strokes and
        softness are not among them: no fit of a photo has any.
        """
        structure, gradients, forms = self.structure, self.gradients, self.forms
        loops = None if self.is_uniform else structure.loop_first_segment.long()
        return {
            **{name: getattr(self, name) for name in _TENSORS},
            "uniform_count": structure.uniform_count,
            "loop_first_segment": loops,
            "path_first_loop": None if self.is_uniform else structure.path_first_loop.long(),
            "is_line": None if structure.is_line is None else structure.is_line.byte(),
            "transparent": self.transparent,
            "gradients": None if gradients is None else gradients.to_dict(),
            **({} if forms is None else {"forms": {**vars(forms), "kind": forms.kind.long()}}),
            **({} if self.side_opacity is None else {"side_opacity": self.side_opacity.value}),
        }

    @staticmethod
    def from_dict(values: dict[str, Any]) -> Scene:
        """Return the scene whose `to_dict` is ``values``."""
        own = {name: values[name] for name in _TENSORS}
        if values["uniform_count"] is not None:
            device = values["segments"].device
            structure = Structure.uniform(len(values["color"]), values["uniform_count"], device)
        else:
            is_line = None if values["is_line"] is None else values["is_line"].bool()
            structure = Structure(values["loop_first_segment"].int(), values["path_first_loop"].int(), is_line)
        paints = values["gradients"]
        gradients = None if paints is None else Gradients.from_dict(paints)
        found = values.get("forms")
        forms = None if found is None else Forms(**{**found, "kind": found["kind"].int()})
        sides = None if values.get("side_opacity") is None else SideOpacity(values["side_opacity"])
        return Scene(
            **own, structure=structure, transparent=values["transparent"], gradients=gradients, forms=forms,
            side_opacity=sides,
        )  # fmt: skip

    def _mapped(self, change: Callable[[Tensor], Tensor]) -> Scene:
        """Return the scene with what ``change`` makes of each tensor; the structure follows to another device."""
        tensors: dict[str, Any] = {name: change(getattr(self, name)) for name in _TENSORS}
        return replace(self, **self._groups(lambda group: group.map(change)), **tensors)

    def _with_paths(self, structure: Structure, segments: Tensor, change: Callable[[Tensor], Tensor]) -> Scene:
        """Return the scene with the outlines of other paths, and what ``change`` makes of the values of each path."""
        paths: dict[str, Any] = {name: change(getattr(self, name)) for name in ("color", "opacity", "generation")}
        groups = self._groups(lambda group: group.map(change))
        for name in ("forms", "softness"):
            groups[name] = None if groups[name] is None else groups[name].or_none()
        return replace(self, segments=segments, structure=structure, **groups, **paths)

    def _groups(self, change: Callable[[Any], Any]) -> dict[str, Any]:
        """Return what ``change`` makes of each group of values that only some scenes have, by name."""
        values = {name: getattr(self, name) for name in _GROUPS}
        return {name: None if value is None else change(value) for name, value in values.items()}

    def _joined_groups(self, other: Scene) -> dict[str, Any]:
        joined: dict[str, Any] = {}
        for name, group in _GROUPS.items():
            own, others = getattr(self, name), getattr(other, name)
            if own is not None or others is not None:
                joined[name] = (own or group.none(self.color)).joined(others or group.none(other.color))
        return joined


def over_white(scene: Scene) -> Scene:
    """Return ``scene`` with a visible canvas; one without any is seen over white."""
    if not scene.transparent:
        return scene
    return replace(scene, background=torch.ones_like(scene.background), transparent=False)


def of_one_color(scene: Scene, color: Tensor) -> Scene:
    """Return ``scene`` with paths of one ``color`` [N, 3] each, which cover as much of each pixel as before."""
    gradients = None if scene.gradients is None else scene.gradients.of_one_color(color)
    return replace(scene, color=color, gradients=gradients)


def straightened(segments: Tensor, structure: Structure) -> Tensor:
    """Return cubic ``segments`` [R, 3, 2] with the handles of lines at thirds between their ends."""
    if structure.is_line is None:
        return segments
    start, end = segments[:, 0], segments[structure.segment_next.long(), 0]
    line = torch.stack([start, *thirds(start, end)], 1)
    return torch.where(structure.is_line[:, None, None], line, segments)


_TENSORS = ("segments", "color", "opacity", "background", "generation")

_GROUPS: dict[str, Any] = {
    "gradients": Gradients,
    "strokes": Strokes,
    "forms": Forms,
    "softness": Softness,
    "side_opacity": SideOpacity,
}
"""Values of each path that only some scenes have: a field of the scene -> its class. Each class has ``none``, ``map``,
``joined``, ``scaled`` and ``moved``."""

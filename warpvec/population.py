"""The paths under optimisation: free parameters, their optimizer, and paths that come and go."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.adan import Adan
from warpvec.config import FitConfig
from warpvec.scene import Scene, bernstein, circle_points, circle_sides

# Opacities and logit colours are kept this far from 0 and 1, where the logit is infinite.
_LOGIT_MARGIN = 1e-4


# Points along a curve from which its bounding box is taken: half a circle leaves their box by 0.5 % of its radius.
_BOX_SAMPLES = 17


class Population:
    """N paths as free parameters.

    Points are in units of half the canvas's longer side, as learning rates are; opacities are logits; colours are
    themselves or logits, as ``config.color_parameter`` says. The background takes part unless ``config.backdrop`` fixes
    it, or the scene is transparent.

    Attributes:
        scene: the paths as they stand; a new object after every change, which never changes itself.
        generation: level of detail of each path [N].
        serial: place of each path [N] in the order of creation, which the z-order by area loses.
    """

    def __init__(self, scene: Scene, config: FitConfig, half_side: float) -> None:
        self._half_side = half_side
        self._logit_color = config.color_parameter == "logit"
        self._points, self._color, self._opacity = self._to_raw(scene)
        self._background = self._raw_color(scene.background)
        self._transparent = scene.transparent
        self._fixed_background = scene.background if config.backdrop == "white" or scene.transparent else None
        self._degree = scene.degree
        self.generation = scene.generation
        self.serial = torch.arange(len(scene), device=scene.points.device)
        self._created = len(scene)
        rates = (config.lr_points, config.lr_color, config.lr_opacity, config.lr_color)
        parameters = (self._points, self._color, self._opacity, self._background)
        groups = [{"params": [p], "lr": lr, "base_lr": lr} for p, lr in zip(parameters, rates, strict=True)]
        self._optimizer = Adan(groups)
        self.scene = self._to_scene()

    def __len__(self) -> int:
        return len(self._points)

    def step(
        self, adj_points: Tensor, adj_color: Tensor, adj_opacity: Tensor, adj_background: Tensor, factor: float
    ) -> None:
        """One optimizer step from the adjoints of ``scene``'s values, learning rates multiplied by ``factor``."""
        self._points.grad = adj_points * self._half_side
        self._opacity.grad = adj_opacity * self.scene.opacity * (1.0 - self.scene.opacity)
        self._color.grad = self._color_adjoint(adj_color, self.scene.color)
        if self._fixed_background is None:
            self._background.grad = self._color_adjoint(adj_background, self.scene.background)
        for group in self._optimizer.param_groups:
            group["lr"] = group["base_lr"] * factor
        self._optimizer.step()
        if not self._logit_color:
            self._color.clamp_(0.0, 1.0)
            self._background.clamp_(0.0, 1.0)
        self.scene = self._to_scene()

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows`` (a mask, or indices in their new order)."""
        self._points, self._color, self._opacity = (
            self._optimizer.keep_rows(p, rows) for p in (self._points, self._color, self._opacity)
        )
        self.generation, self.serial = self.generation[rows], self.serial[rows]
        self.scene = self._to_scene()

    def sort_by_area(self) -> None:
        """Order the paths by the area of their bounding box, the smallest on top."""
        box = curve_boxes(self.scene.points, self._degree)
        order = (box[:, 2:] - box[:, :2]).prod(-1).argsort(descending=True, stable=True)
        if not torch.equal(order, torch.arange(len(order), device=order.device)):
            self.keep(order)

    def append(self, scene: Scene) -> None:
        """Add the paths of ``scene`` on top, with fresh optimizer state."""
        rows = zip((self._points, self._color, self._opacity), self._to_raw(scene), strict=True)
        self._points, self._color, self._opacity = (self._optimizer.append_rows(p, new) for p, new in rows)
        self.generation = torch.cat([self.generation, scene.generation])
        self.serial = torch.cat([self.serial, torch.arange(len(scene), device=self.serial.device) + self._created])
        self._created += len(scene)
        self.scene = self._to_scene()

    def _to_raw(self, scene: Scene) -> tuple[Tensor, Tensor, Tensor]:
        return scene.points / self._half_side, self._raw_color(scene.color), scene.opacity.logit(_LOGIT_MARGIN)

    def _raw_color(self, color: Tensor) -> Tensor:
        return color.logit(_LOGIT_MARGIN) if self._logit_color else color.clone()

    def _to_scene(self) -> Scene:
        # Copies: the optimizer goes on changing the parameters in place.
        color, background = (
            value.sigmoid() if self._logit_color else value.clone() for value in (self._color, self._background)
        )
        if self._fixed_background is not None:
            background = self._fixed_background
        points, opacity = self._points * self._half_side, self._opacity.sigmoid()
        return Scene(points, color, opacity, background, self.generation, self._degree, self._transparent)

    def _color_adjoint(self, adj: Tensor, color: Tensor) -> Tensor:
        return adj * color * (1.0 - color) if self._logit_color else adj.contiguous()


def new_paths(
    center: Tensor,
    radius: tuple[float, float],
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    generation: int,
    config: FitConfig,
) -> Scene:
    """A scene of ellipses in the path model of ``config``.

    Args:
        center: centres [N, 2] in pixels.
        radius: half their width and half their height in pixels.
        color, opacity, background: [N, 3], [N] and [3], as in the scene.
        generation: that of all of them.
    """
    spawn, size = (circle_sides, config.degree) if config.path_model == "sides" else (circle_points, config.segments)
    unit = spawn(torch.zeros_like(center), torch.ones_like(center[:, 0]), size)
    points = center[:, None, :] + unit * center.new_tensor(radius)
    generations = torch.full((len(center),), generation, device=center.device)
    return Scene(points, color, opacity, background, generations, config.point_degree)


def colors_at(target: Tensor, center: Tensor) -> Tensor:
    """Colours [N, 3] of ``target`` [h, w, 3] in the pixels that hold ``center`` [N, 2], or the nearest to it."""
    height, width = target.shape[:2]
    columns, rows = center.long().unbind(-1)
    return target[rows.clamp(0, height - 1), columns.clamp(0, width - 1)]


def curve_boxes(points: Tensor, degree: int) -> Tensor:
    """Left, top, right and bottom [N, 4] of closed paths with control points [N, M S, 2], from points along them."""
    point_count = points.shape[1]
    first = torch.arange(0, point_count, degree, device=points.device)
    pieces = points[:, (first[:, None] + torch.arange(degree + 1, device=points.device)) % point_count]
    parameters = torch.linspace(0.0, 1.0, _BOX_SAMPLES, dtype=points.dtype, device=points.device)
    outline = (bernstein(degree, parameters) @ pieces).flatten(1, 2)
    return torch.cat([outline.amin(1), outline.amax(1)], -1)

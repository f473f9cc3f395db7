"""The free parameters that stand for paths, and the way back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.geometry.side_opacity import SideOpacity

PLANES = 5
"""Planes of a parameter: its values, three averages of its gradient, and the previous gradient."""

COMMON_OPACITY = 0.7
"""Opacity of all paths if it is the same for all. From 0.65 to 0.75 the PSNR changes by less than 0.05 dB (kodim07 and
kodim23, at 384 x 256, 25 KB); 0.6 is worse by 0.1 dB."""

FIXED_OPACITIES = {"common": COMMON_OPACITY, "opaque": 1.0}
"""Setting ``opacity`` -> the opacity that all paths have."""

_LOGIT_MARGIN = 1e-4
"""Opacities and logit colours stay this far from 0 and 1, where the logit is infinite."""


@dataclass(frozen=True)
class Parametrization:
    """The units of the parameters. Opacities are logits.

    Attributes:
        half_side: half the canvas's longer side in pixels, the unit of points and gradients.
        logit_color: whether colours are logits, or themselves.
        half_sides: half the width and half the height, the units of points; None for ``half_side`` on both axes.
    """

    half_side: float
    logit_color: bool
    half_sides: tuple[float, float] | None = None

    @property
    def by_axis(self) -> bool:
        """Whether the units of points may differ across and down."""
        return self.half_sides is not None

    @property
    def unit(self) -> tuple[float, float]:
        """Unit of points in pixels, across and down."""
        return self.half_sides or (self.half_side, self.half_side)

    def _unit_of(self, segments: Tensor) -> Tensor | float:
        return self.half_side if self.half_sides is None else segments.new_tensor(self.half_sides)

    def fresh_rows(self, scene: Scene) -> tuple[Tensor, ...]:
        """Return planes for segments [5, R, 2 M], colours [5, N, 3] and opacities, with a state of zeros.

        Opacities are [5, N, 1], or [5, N, 3] if paths have others at their sides.
        """
        opacity = all_opacities(scene).logit(_LOGIT_MARGIN)
        return tuple(fresh_planes(raw) for raw in (self.raw_segments(scene), self.raw_color(scene.color), opacity))

    def raw_segments(self, scene: Scene) -> Tensor:
        """Return the parameters [R, 2 M] of the segments of ``scene``."""
        return (scene.segments / self._unit_of(scene.segments)).flatten(1)

    def raw_color(self, color: Tensor) -> Tensor:
        """Return the parameters of ``color`` [..., 3]."""
        return color.logit(_LOGIT_MARGIN) if self.logit_color else color

    def to_color(self, raw: Tensor) -> Tensor:
        """Return the colours that ``raw`` stands for, in memory of their own."""
        return raw.sigmoid() if self.logit_color else raw.clone()

    def to_scene(self, rows: tuple[Tensor, ...], scene: Scene) -> Scene:
        """Return the scene that the parameters in ``rows`` stand for, in the shapes of ``scene``."""
        segments, color, opacity = (values[0] for values in rows)
        segments = segments.reshape(scene.segments.shape) * self._unit_of(scene.segments)
        shown = opacity.sigmoid()
        sides = None if scene.side_opacity is None else SideOpacity(shown[:, 1:].contiguous())
        return replace(
            scene, segments=segments, color=self.to_color(color), opacity=shown[:, 0].contiguous(), side_opacity=sides
        )


def fresh_planes(raw: Tensor) -> Tensor:
    """Return planes [5, rows, width]: the parameters ``raw`` [rows, width] and a state of zeros."""
    rows = raw.new_zeros(PLANES, *raw.shape)
    rows[0] = raw
    return rows


def all_opacities(scene: Scene) -> Tensor:
    """Return the opacities of ``scene`` [N, 1], or [N, 3] with those at the sides of paths."""
    middle = scene.opacity[:, None]
    return middle if scene.side_opacity is None else torch.cat([middle, scene.side_opacity.value], 1)

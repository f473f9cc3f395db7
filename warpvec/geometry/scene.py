"""The scene: closed paths of Bezier curves, painted in order over a background."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from torch import Tensor

from warpvec.errors import InputError


@dataclass(frozen=True)
class Scene:
    """N closed paths of S Bezier curves of degree M each, row 0 at the bottom.

    Two shapes are in use: S cubics ("segments", what a file holds), and the paper's two curves of degree 5 ("sides").

    Attributes:
        points: control points [N, M S, 2] in pixels, x right, y down; curve s of a path has its
            points M s, M s + 1, ..., M s + M (modulo M S), so anchors stand at 0, M, 2 M, ...
        color: sRGB-encoded fill [N, 3] in [0, 1].
        opacity: fill opacity [N] in [0, 1].
        background: sRGB-encoded canvas colour [3] in [0, 1].
        generation: level of detail [N] (int64), 0 for the first; becomes the layer in the file.
        degree: M of every curve, 3 for cubics.
        transparent: whether no canvas is painted. The background is black then: an image over it is premultiplied.

    Raises:
        InputError: the degree is not positive or the shapes do not agree.
    """

    points: Tensor
    color: Tensor
    opacity: Tensor
    background: Tensor
    generation: Tensor
    degree: int = 3
    transparent: bool = False

    def __post_init__(self) -> None:
        if self.degree < 1:
            raise InputError(f"degree must be at least 1, got {self.degree}; 3 is that of cubics")
        _check_points(self.points, self.degree)
        count = len(self.points)
        expected = {"color": (count, 3), "opacity": (count,), "background": (3,), "generation": (count,)}
        for name, shape in expected.items():
            got = tuple(getattr(self, name).shape)
            if got != shape:
                raise InputError(f"{name} must have shape {list(shape)} beside {count} paths, got {list(got)}")

    def __len__(self) -> int:
        return len(self.points)

    @property
    def piece_count(self) -> int:
        """Curves per path, S: its segments if they are cubics."""
        return self.points.shape[1] // self.degree

    def detach(self) -> Scene:
        """The same scene outside autograd."""
        return replace(self, **{name: getattr(self, name).detach() for name in _FLOAT_FIELDS})

    def cpu(self) -> Scene:
        """The same scene in host memory."""
        return self.to("cpu")

    def to(self, device: str) -> Scene:
        """The same scene in the memory of ``device``."""
        return replace(self, **{name: getattr(self, name).to(device) for name in (*_FLOAT_FIELDS, "generation")})

    def to_dict(self) -> dict[str, Any]:
        """The fields by name, without copies."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def scaled(self, x_factor: float, y_factor: float | None = None) -> Scene:
        """The scene on a canvas ``x_factor`` times as wide and ``y_factor``, the same if left out, times as high."""
        factors = [x_factor, x_factor if y_factor is None else y_factor]
        return replace(self, points=self.points * self.points.new_tensor(factors))

    def select(self, rows: Tensor) -> Scene:
        """The paths ``rows`` (indices or a mask [N]), in that order, over the same background."""
        names = ("points", "color", "opacity", "generation")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


def _check_points(points: Tensor, degree: int) -> None:
    shape = list(points.shape)
    if len(shape) != 3 or shape[1] == 0 or shape[1] % degree or shape[2] != 2:
        raise InputError(f"points must have shape [N, {degree} S, 2], S at least 1, for degree {degree}, got {shape}")


_FLOAT_FIELDS = ("points", "color", "opacity", "background")

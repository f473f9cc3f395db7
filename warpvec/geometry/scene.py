"""The scene: closed paths of Bezier curves, painted in order over a background."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from torch import Tensor

from warpvec.errors import InputError


@dataclass(frozen=True)
class Scene:
    """N closed paths of S Bezier curves of degree M each, row 0 at the bottom.

    Two kinds are in use: S cubics ("segments"), as in a file, and the paper's two curves of degree 5 ("sides").

    Attributes:
        points: control points [N, M S, 2] in pixels, x right, y down. Curve s of a path has the points M s, M s + 1,
            ..., M s + M (modulo M S), so the anchors are 0, M, 2 M, ...
        color: sRGB-encoded fill [N, 3] in [0, 1].
        opacity: fill opacity [N] in [0, 1].
        background: sRGB-encoded background colour [3] in [0, 1].
        generation: level of detail [N] (int64), 0 for the first; it becomes the layer in the file.
        degree: M of every curve, 3 for cubics.
        transparent: whether the scene has no background. ``background`` is then black, over which an image is
            premultiplied.

    Raises:
        InputError: the degree is not positive, or the shapes do not agree.
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
            raise InputError("degree", "must be at least 1", str(self.degree), "give 3 for cubics")
        _check_points(self.points, self.degree)
        count = len(self.points)
        expected = {"color": (count, 3), "opacity": (count,), "background": (3,), "generation": (count,)}
        for name, shape in expected.items():
            got = tuple(getattr(self, name).shape)
            if got != shape:
                raise InputError(name, f"must have shape {list(shape)} for {count} paths", str(list(got)), "reshape it")

    def __len__(self) -> int:
        return len(self.points)

    @property
    def piece_count(self) -> int:
        """Number of curves per path, S."""
        return self.points.shape[1] // self.degree

    def detach(self) -> Scene:
        """Return the scene outside autograd."""
        return replace(self, **{name: getattr(self, name).detach() for name in _FLOAT_FIELDS})

    def cpu(self) -> Scene:
        """Return the scene in host memory."""
        return self.to("cpu")

    def to(self, device: str) -> Scene:
        """Return the scene in the memory of ``device``."""
        return replace(self, **{name: getattr(self, name).to(device) for name in (*_FLOAT_FIELDS, "generation")})

    def to_dict(self) -> dict[str, Any]:
        """Return the fields by name, without copies."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def scaled(self, x_factor: float, y_factor: float | None = None) -> Scene:
        """Return the scene scaled by ``x_factor`` horizontally and ``y_factor`` (default: the same) vertically."""
        factors = [x_factor, x_factor if y_factor is None else y_factor]
        return replace(self, points=self.points * self.points.new_tensor(factors))

    def select(self, rows: Tensor) -> Scene:
        """Return the paths ``rows`` (indices or a mask [N]), in that order, over the same background."""
        names = ("points", "color", "opacity", "generation")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


def _check_points(points: Tensor, degree: int) -> None:
    shape = list(points.shape)
    if len(shape) != 3 or shape[1] == 0 or shape[1] % degree or shape[2] != 2:
        rule = f"must have shape [N, {degree} S, 2], S at least 1, for degree {degree}"
        raise InputError("points", rule, str(shape), "reshape it or give its degree")


_FLOAT_FIELDS = ("points", "color", "opacity", "background")

"""Elliptic gradients: t = |(u / a, v / b)|, with u and v along and across the axis from the centre to the place."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

import numpy as np
import torch
from torch import Tensor

from warpvec.geometry.paints.kind import RAMP_EXTENT_MIN, Geometry, GradientKind, Reals

FILE_DECIMALS = 1
"""Decimals of the centre, the axis and the radius across it that a file tells."""

_DIGITS = 4
"""Digits of a matrix beyond those of the largest number that it multiplies, so that places are within ``_ERROR``."""

_ERROR, _ERROR_SHARE = 0.002, 1e-9
"""Distance, and share of a place, by which a matrix may differ from the numbers that it tells."""

_NUMBER = r"(-?(?:\d+(?:\.\d+)?|\.\d+))"
_MATRIX = re.compile(rf"matrix\({' '.join([_NUMBER] * 6)}\)", re.ASCII)

_SHARE_MIN = 1e-9
"""Share at the centre, where t has no derivative, below which it is taken as this."""


class Elliptic(GradientKind):
    """A gradient from the centre cx, cy to an ellipse about it: the axis ax, ay to its end, and the radius b across.

    An SVG states it as the circle about the centre through the end of the axis, and the matrix that makes the ellipse
    of it: programs that ignore the matrix show this circle. Files of before have a circle of radius 1 about 0, 0.
    """

    name, element, sides = "elliptic", "radialGradient", ("cx", "cy", "r", "gradientTransform")
    has_free_start, needs_stops = False, True

    def share(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return t [M]; see `GradientKind.share`."""
        u, v = self._place(geometry, x, y)
        return np.hypot(u, v)

    def slopes(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return the derivative of t [5, M]."""
        ax, ay, b = geometry[2:]
        a, b = np.maximum(np.hypot(ax, ay), RAMP_EXTENT_MIN), np.maximum(b, RAMP_EXTENT_MIN)
        (ex, ey), (u, v) = (ax / a, ay / a), self._place(geometry, x, y)
        t = np.maximum(np.hypot(u, v), _SHARE_MIN)
        along, across = u / t, v / t
        by_length, by_turn = -along * u / a, (along * v * b / a - across * u * a / b) / a
        rows: list[Reals] = [
            -along * ex / a + across * ey / b,
            -along * ey / a - across * ex / b,
            by_length * ex - by_turn * ey,
            by_length * ey + by_turn * ex,
            -across * v / b,
        ]
        return np.stack(rows)

    def is_drawn(self, geometry: Tensor) -> Tensor:
        """Return whether both radii are not too small, and all is finite [N]."""
        shortest = torch.minimum(geometry[:, 2:4].norm(dim=1), geometry[:, 4])
        return (shortest >= RAMP_EXTENT_MIN) & geometry.sum(1).isfinite()

    def scaled(self, geometry: Tensor, x_factor: float, y_factor: float) -> Tensor:
        """Return the geometries [N, 5] scaled about the origin; of a uniform scaling if the two factors differ in one.

        With other factors the axis is scaled as a vector, and the area of the ellipse as an area.
        """
        x, y = abs(x_factor), abs(y_factor)
        axis = geometry[:, 2:4] * geometry.new_tensor([x_factor, y_factor])
        stretch = axis.norm(dim=1) / geometry[:, 2:4].norm(dim=1).clamp_min(RAMP_EXTENT_MIN)
        breadth = geometry[:, 4] * (math.sqrt(x * y) if x == y else x * y / stretch.clamp_min(1e-30))
        center = geometry[:, :2] * geometry.new_tensor([x_factor, y_factor])
        return torch.cat([center, axis, breadth[:, None]], 1)

    def moved(self, geometry: Tensor, x: float, y: float) -> Tensor:
        """Return the geometries [N, 5] of the gradients moved by ``x`` and ``y`` pixels."""
        return geometry + geometry.new_tensor([x, y, 0.0, 0.0, 0.0])

    def form(self, geometry: Tensor) -> Tensor:
        """Return the centre, and e e' / a^2 + n n' / b^2 with e along and n across the axis [N, 5]."""
        along, across, ex, ey = _axes(geometry)
        p, q = along.reciprocal().square(), across.reciprocal().square()
        rows = [ex * ex * p + ey * ey * q, ex * ey * (p - q), ey * ey * p + ex * ex * q]
        return torch.stack([geometry[:, 0], geometry[:, 1], *rows], 1)

    def form_adjoint(self, geometry: Tensor, adj_form: Tensor) -> Tensor:
        """Return dL/d(geometry) [N, 5]."""
        along, across, ex, ey = _axes(geometry)
        p, q = along.reciprocal().square(), across.reciprocal().square()
        xx, xy, yy = adj_form[:, 2:].unbind(1)
        adj_p = xx * ex * ex + xy * ex * ey + yy * ey * ey
        adj_q = xx * ey * ey - xy * ex * ey + yy * ex * ex
        adj_turn = (p - q) * (2.0 * (yy - xx) * ex * ey + xy * (ex * ex - ey * ey))
        adj_along, adj_sideways = -2.0 * adj_p * p / along, adj_turn / along
        axis = [adj_along * ex - adj_sideways * ey, adj_along * ey + adj_sideways * ex]
        return torch.stack([adj_form[:, 0], adj_form[:, 1], *axis, -2.0 * adj_q * q / across], 1)

    def between(self, geometry: Geometry, start: float, end: float) -> Geometry:
        """Return the geometry up to a t."""
        del start
        cx, cy, ax, ay, b = geometry
        return cx, cy, ax * end, ay * end, b * end

    def attributes(self, numbers: Sequence[str]) -> dict[str, str]:
        """Return the attributes of a circle and its matrix."""
        cx, cy, ax, ay, b = (float(text) for text in numbers)
        length = max(math.hypot(ax, ay), RAMP_EXTENT_MIN)
        radius = max(round(length, FILE_DECIMALS), 10.0**-FILE_DECIMALS)
        columns = [part / radius for part in (ax, ay, -ay * b / length, ax * b / length)]
        moved = [cx - columns[0] * cx - columns[2] * cy, cy - columns[1] * cx - columns[3] * cy]
        decimals = _DIGITS + math.ceil(math.log10(max(abs(cx), abs(cy), radius, 1.0)))
        matrix = " ".join([*(_text(part, decimals) for part in columns), *(_text(part, _DIGITS) for part in moved)])
        circle = dict(zip(self.sides, [*numbers[:2], _text(radius, FILE_DECIMALS)], strict=False))
        return circle | {"gradientTransform": f"matrix({matrix})"}

    def numbers(self, attributes: Mapping[str, str]) -> list[str]:
        """Return the numbers of a geometry, as texts, from its `attributes`; none if these are not of this form."""
        match = _MATRIX.fullmatch(attributes["gradientTransform"])
        circle = [attributes[side] for side in self.sides[:3]]
        if match is None or not all(re.fullmatch(_NUMBER, text, re.ASCII) for text in circle):
            return []
        (a, b, c, d, e, f), (x, y, r) = map(float, match.groups()), map(float, circle)
        stated = [a * x + c * y + e, b * x + d * y + f, r * a, r * b, r * c, r * d]
        found = [_text(value, FILE_DECIMALS) for value in (*stated[:4], math.hypot(*stated[4:]))]
        cx, cy, ax, ay, breadth = map(float, found)
        stretch = breadth / max(math.hypot(ax, ay), RAMP_EXTENT_MIN)
        exact = [cx, cy, ax, ay, -ay * stretch, ax * stretch]
        return found if np.allclose(stated, exact, _ERROR_SHARE, _ERROR) else []

    @staticmethod
    def _place(geometry: Reals, x: Reals, y: Reals) -> tuple[Reals, Reals]:
        """Return u / a and v / b."""
        cx, cy, ax, ay, b = geometry
        a = np.maximum(np.hypot(ax, ay), RAMP_EXTENT_MIN)
        ex, ey = ax / a, ay / a
        return ((x - cx) * ex + (y - cy) * ey) / a, ((y - cy) * ex - (x - cx) * ey) / np.maximum(b, RAMP_EXTENT_MIN)


def _is_number(text: str) -> bool:
    return re.fullmatch(_NUMBER, text, re.ASCII) is not None


def _text(value: float, decimals: int = _DIGITS) -> str:
    """Return the shortest text of a number with so many decimals."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    text = text.removeprefix("0") if text.startswith("0.") else text.replace("-0.", "-.", 1)
    return "0" if text in ("-0", "") else text


def _axes(geometry: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Return both radii, and the direction of the axis: [N] each."""
    along = geometry[:, 2:4].norm(dim=1)
    return along, geometry[:, 4], geometry[:, 2] / along, geometry[:, 3] / along

"""Curves of any degree as cubics, the highest degree that a file can hold."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import torch
from torch import Tensor

from warpvec.geometry.bezier import bernstein
from warpvec.geometry.scene import Scene

CUBICS_MAX = 16
"""Cubics per curve at most: the deviation falls by 2**4 when their number doubles, so this is 65,000 times closer than
one cubic, and a single wild path, which all others are padded to, cannot make the scene any longer."""

# Parameters along one cubic: where it is fitted, and where it is compared, more densely. Between two of the latter the
# difference, a polynomial with a handful of extrema, rises by less than a thousandth of the largest value.
_FITTED_PARAMETERS = 17
_COMPARED_PARAMETERS = 129


def to_cubics(scene: Scene, tolerance: float = 0.05) -> tuple[Scene, float]:
    """A scene of cubics with the same outlines, and the largest deviation from them in pixels.

    Each curve of a path is cut at equal shares of its parameter into as many pieces as the path needs, the same number
    for each curve, and each piece replaced by the cubic with its ends that is closest by least squares. The deviation
    is the largest distance of points with equal parameters, hence no less than the distance of the outlines. A path
    has the fewest cubics that keep it within ``tolerance`` pixels, or ``CUBICS_MAX`` per curve where none does: then
    the deviation says so. Paths with fewer cubics than others end in cubics of no length at their first point.

    A scene of cubics comes back as it is. Otherwise all is computed in float64 and then rounded to the dtype of the
    scene, which the deviation leaves out, and gradients are not kept.
    """
    if scene.degree == 3:
        return scene, 0.0
    curves = _curves(scene.detach())
    count, deviation = _fewest(curves, tolerance)
    points = curves[:, :1, 0].repeat(1, 3 * curves.shape[1] * max(count.tolist(), default=1), 1)
    for number in sorted(set(count.tolist())):
        rows = count == number
        points[rows, : 3 * curves.shape[1] * number] = _fitted(curves[rows], number)
    largest = deviation.max().item() if len(scene) else 0.0
    return replace(scene.detach(), points=points.to(scene.points.dtype), degree=3), largest


def _curves(scene: Scene) -> Tensor:
    """Control points of every curve, both ends included [N, S, M + 1, 2] (float64)."""
    points = scene.points.double()
    closed = torch.cat([points, points[:, :1]], 1)
    return closed.unfold(1, scene.degree + 1, scene.degree).transpose(-1, -2)


def _fewest(curves: Tensor, tolerance: float) -> tuple[Tensor, Tensor]:
    """Cubics per curve that each path needs [N] (int64) and the deviation in pixels that they leave [N]."""
    count = torch.zeros(len(curves), dtype=torch.int64, device=curves.device)
    deviation = curves.new_zeros(len(curves))
    rows = torch.arange(len(curves), device=curves.device)
    for number in range(1, CUBICS_MAX + 1):
        count[rows] = number
        deviation[rows] = _deviation(curves[rows], number)
        rows = rows[deviation[rows] > tolerance]
    return count, deviation


def _fitted(curves: Tensor, number: int) -> Tensor:
    """Control points [N, 3 S number, 2] of ``number`` cubics for each curve."""
    fit, _ = _conversion(curves.shape[2] - 1, number)
    return (fit.to(curves.device) @ curves).flatten(1, 2)


def _deviation(curves: Tensor, number: int) -> Tensor:
    """Largest distance in pixels [N] from ``number`` cubics for each curve to that curve."""
    _, difference = _conversion(curves.shape[2] - 1, number)
    return (difference.to(curves.device) @ curves).norm(dim=-1).amax((1, 2))


@cache
def _conversion(degree: int, number: int) -> tuple[Tensor, Tensor]:
    """From the control points of a curve to those of its cubics [3 number, M + 1] and to their differences [K, M + 1].

    Both are linear, so that one matrix each serves all curves.
    """
    share = torch.linspace(0.0, 1.0, _COMPARED_PARAMETERS, dtype=torch.float64)
    cubics = _closest_cubics(degree, number)
    differences = bernstein(3, share) @ cubics - _pieces(degree, number, share)
    return cubics[:, :3].flatten(0, 1), differences.flatten(0, 1)


def _closest_cubics(degree: int, number: int) -> Tensor:
    """What each control point of a curve counts in those of its cubics [number, 4, M + 1]."""
    share = torch.linspace(0.0, 1.0, _FITTED_PARAMETERS, dtype=torch.float64)
    pieces, weights = _pieces(degree, number, share), bernstein(3, share)
    ends = pieces[:, [0, -1]]
    handles = torch.linalg.pinv(weights[:, 1:3]) @ (pieces - weights[:, [0, 3]] @ ends)
    return torch.cat([ends[:, :1], handles, ends[:, 1:]], 1)


def _pieces(degree: int, number: int, share: Tensor) -> Tensor:
    """What each control point of a curve counts [number, K, M + 1] at ``share`` [K] of each of its equal pieces."""
    piece = torch.arange(number, dtype=torch.float64)[:, None]
    return bernstein(degree, (piece + share) / number)

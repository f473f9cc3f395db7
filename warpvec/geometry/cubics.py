"""Convert curves of any degree to cubics, the highest degree that a file can hold."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import torch
from torch import Tensor

from warpvec.geometry.bezier import bernstein
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

CUBICS_MAX = 16
"""Maximum number of cubics per curve. The deviation falls by 2**4 when the number doubles, so this is 65,000 times
closer than one cubic. As all paths are padded to the longest, it also bounds what one wild path adds to the scene."""

# Number of parameters along one cubic at which it is fitted, and at which it is compared. The difference is a
# polynomial with few extrema: between two compared parameters it rises by less than a thousandth of its maximum.
_FITTED_PARAMETERS = 17
_COMPARED_PARAMETERS = 129


def to_cubics(scene: Scene, tolerance: float = 0.05) -> tuple[Scene, float]:
    """Return a scene of cubics with the same outlines, and the largest deviation from them in pixels.

    Every curve of a path is cut into the same number of pieces, at equal steps of the parameter. Each piece is replaced
    by the cubic with the same ends that is closest by least squares. The deviation is the largest distance between
    points with equal parameters, so the outlines are at most that far apart. A path gets the fewest cubics that keep it
    within ``tolerance`` pixels. If ``CUBICS_MAX`` per curve are not enough, it gets these and the deviation is larger.
    Paths with fewer cubics than others end in cubics of zero length at their first point.

    A scene of cubics is returned unchanged. Otherwise everything is computed in float64 and then rounded to the dtype
    of the scene; the deviation does not include that rounding. Torch does not
    differentiate through it.
    """
    if scene.degree == 3:
        return scene, 0.0
    curves = _curves(scene.detach())
    count, deviation = _min_counts(curves, tolerance)
    points = curves[:, :1, 0].repeat(1, 3 * curves.shape[1] * max(count.tolist(), default=1), 1)
    for number in sorted(set(count.tolist())):
        rows = count == number
        points[rows, : 3 * curves.shape[1] * number] = _fit_cubics(curves[rows], number)
    max_deviation = deviation.max().item() if len(scene) else 0.0
    structure = Structure.uniform(len(scene), points.shape[1] // 3, points.device)
    segments = points.to(scene.segments.dtype).reshape(-1, 3, 2)
    return replace(scene.detach(), segments=segments, structure=structure), max_deviation


def _curves(scene: Scene) -> Tensor:
    """Return the control points of every curve, both ends included [N, S, M + 1, 2] (float64)."""
    points = scene.points.double()
    closed = torch.cat([points, points[:, :1]], 1)
    return closed.unfold(1, scene.degree + 1, scene.degree).transpose(-1, -2)


def _min_counts(curves: Tensor, tolerance: float) -> tuple[Tensor, Tensor]:
    """Return the number of cubics per curve that each path needs [N] (int64), and their deviation in pixels [N]."""
    count = torch.zeros(len(curves), dtype=torch.int64, device=curves.device)
    deviation = curves.new_zeros(len(curves))
    rows = torch.arange(len(curves), device=curves.device)
    for number in range(1, CUBICS_MAX + 1):
        count[rows] = number
        deviation[rows] = _deviation(curves[rows], number)
        rows = rows[deviation[rows] > tolerance]
    return count, deviation


def _fit_cubics(curves: Tensor, number: int) -> Tensor:
    """Return the control points [N, 3 S number, 2] of ``number`` cubics for each curve."""
    fit, _ = _conversion(curves.shape[2] - 1, number)
    return (fit.to(curves.device) @ curves).flatten(1, 2)


def _deviation(curves: Tensor, number: int) -> Tensor:
    """Return the largest distance in pixels [N] between each path's curves and ``number`` cubics for each of them."""
    _, difference = _conversion(curves.shape[2] - 1, number)
    return (difference.to(curves.device) @ curves).norm(dim=-1).amax((1, 2))


@cache
def _conversion(degree: int, number: int) -> tuple[Tensor, Tensor]:
    """Return matrices that take a curve's control points to those of its cubics and to differences from these.

    Their shapes are [3 number, M + 1] and [K, M + 1]. Both maps are linear, so the same matrices serve all curves.
    """
    share = torch.linspace(0.0, 1.0, _COMPARED_PARAMETERS, dtype=torch.float64)
    cubics = _closest_cubics(degree, number)
    differences = bernstein(3, share) @ cubics - _pieces(degree, number, share)
    return cubics[:, :3].flatten(0, 1), differences.flatten(0, 1)


def _closest_cubics(degree: int, number: int) -> Tensor:
    """Return the weights of a curve's control points in those of its cubics [number, 4, M + 1]."""
    share = torch.linspace(0.0, 1.0, _FITTED_PARAMETERS, dtype=torch.float64)
    pieces, weights = _pieces(degree, number, share), bernstein(3, share)
    ends = pieces[:, [0, -1]]
    handles = torch.linalg.pinv(weights[:, 1:3]) @ (pieces - weights[:, [0, 3]] @ ends)
    return torch.cat([ends[:, :1], handles, ends[:, 1:]], 1)


def _pieces(degree: int, number: int, share: Tensor) -> Tensor:
    """Return a curve's control point weights [number, K, M + 1] at ``share`` [K] of each of its equal pieces."""
    piece = torch.arange(number, dtype=torch.float64)[:, None]
    return bernstein(degree, (piece + share) / number)

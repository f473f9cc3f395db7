"""The splat renderer in float64 torch: de Casteljau, one Gaussian at a time against every pixel, autograd.

A path is a closed loop of Bezier curves. Its first half, side A, and its other half run backwards, side B, go from the
first anchor to the one in the middle; rows of Gaussians blend from A to B. After Bezier Splatting, with the spacing
rules and clamps that the constants here restate: they are not taken from the kernels, whose copy they check.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from reference.compositing import composite

ALPHA_MIN, ALPHA_MAX = 1 / 255, 0.999
BOUNDARY_SIGMA_X_MIN, BOUNDARY_SIGMA_Y_MIN, BOUNDARY_SIGMA_Y_MAX = 0.3, 0.75, 1.0
THIN_SIGMA, THIN_RATIO, INTERIOR_SIGMA_MIN = 0.1, 3.0, 1e-2
TANGENT_MIN = 1e-6
PARAMETER_MIN, PARAMETER_MAX = 0.007, 0.993
LINE_REACH, LINE_SPREAD = 2.0, 0.85
END_FACTOR, NEXT_TO_END_FACTOR = 0.4, 0.9


@dataclass(frozen=True)
class Settings:
    """Settings of the renderer, with the names of its arguments."""

    samples: int = 64
    lines: int = 40
    degree: int = 3
    interior_gradient: bool = True
    covariance_gradient: bool = False
    color_falloff: bool = False


class Gaussians(NamedTuple):
    """Gaussians of N paths in rows from side A (row 0) over the interior lines to side B (the last row)."""

    mean: Tensor
    """[N, rows, samples, 2] px."""
    frame: Tensor
    """Unit tangent and unit normal, the columns of a matrix [N, rows, samples, 2, 2]."""
    scale: Tensor
    """Standard deviations along the tangent and the normal [N, rows, samples, 2] px, clamped."""
    free_scale: Tensor
    """The standard deviations before clamping."""

    @property
    def covariance(self) -> Tensor:
        """The covariance R S S^T R^T [N, rows, samples, 2, 2]."""
        factor = self.frame * self.scale[..., None, :]
        return factor @ factor.mT


def render(
    points: Tensor,
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    height: int,
    width: int,
    settings: Settings = Settings(),
) -> Tensor:
    """Return the image [h, w, 3] of N paths, row 0 at the bottom; hidden paths are not skipped.

    Args:
        points: control points [N, degree * pieces, 2] in pixels.
        color: fill [N, 3] in [0, 1].
        opacity: opacity of each Gaussian of a path [N], or of each row of a path [N, rows], in [0, 1].
        background: background colour [3] in [0, 1].
        height: rows of the canvas.
        width: columns of the canvas.
        settings: how paths are sampled and what their gradients see.
    """
    found = gaussians(points, settings)
    coverage = path_alpha(found, opacity, height, width)
    image = composite(
        coverage, color.detach() if settings.color_falloff else color, torch.ones_like(color[:, 0]), background
    )
    if settings.color_falloff:
        with torch.no_grad():
            share, light = color_shares(found, opacity, height, width), torch.ones(height, width, dtype=color.dtype)
            for row in reversed(range(len(color))):
                share[row] *= light
                light = light * (1 - coverage[row])
        image = image + (share[..., None] * (color - color.detach())[:, None, None]).sum(0)
    return image


def gaussians(points: Tensor, settings: Settings) -> Gaussians:
    """Return the Gaussians of paths [N, degree * pieces, 2]; the settings detach some of their values."""
    side_a, side_b = sides(points, settings.degree)
    u = torch.linspace(PARAMETER_MIN, PARAMETER_MAX, settings.samples, dtype=points.dtype)
    a, b = chain_point(side_a, settings.degree, u), chain_point(side_b, settings.degree, u)
    weight = row_weights(settings.lines).to(points)
    mean = (1 - weight[:, None, None]) * a[:, None] + weight[:, None, None] * b[:, None]
    free_scale = torch.stack([_tangent_scale(mean), _normal_scale(weight, a, b)], -1)
    scale, frame = _clamped(free_scale), _frame(mean)
    if not settings.covariance_gradient:
        scale, frame = scale.detach(), frame.detach()
    if not settings.interior_gradient:
        mean, frame, scale = (_detach_interior(tensor) for tensor in (mean, frame, scale))
    return Gaussians(mean, frame, scale, free_scale.detach())


def sides(points: Tensor, degree: int) -> tuple[Tensor, Tensor]:
    """Return the control points of side A and of side B, both from the first anchor to that of piece pieces // 2."""
    closed = torch.cat([points, points[:, :1]], 1)
    middle = degree * (points.shape[1] // degree // 2)
    return closed[:, : middle + 1], closed[:, middle:].flip(1)


def chain_point(chain: Tensor, degree: int, u: Tensor) -> Tensor:
    """Return points [N, K, 2] at ``u`` [K] in [0, 1] of n joined curves [N, degree * n + 1, 2], with equal shares."""
    count = (chain.shape[1] - 1) // degree
    piece = (u * count).floor().clamp(max=count - 1)
    t = (u * count - piece)[:, None, None]
    level = chain[:, degree * piece.long()[:, None] + torch.arange(degree + 1)]
    while level.shape[2] > 1:
        level = (1 - t) * level[:, :, :-1] + t * level[:, :, 1:]
    return level[:, :, 0]


def row_weights(lines: int) -> Tensor:
    """Return the share of side B in each row [lines + 2]: 0 on side A, 1 on side B, denser towards both."""
    reach = LINE_REACH if lines > 1 else 0.0
    x = torch.linspace(-reach, reach, lines, dtype=torch.float64)
    inner = [0.5 * (1 + math.erf(value / LINE_SPREAD / math.sqrt(2))) for value in x.tolist()]
    return torch.tensor([0.0, *inner, 1.0], dtype=torch.float64)


def end_factors(samples: int) -> Tensor:
    """Return the factors [samples] on the spacing along a row; rows taper off towards both ends."""
    factor = torch.ones(samples, dtype=torch.float64)
    factor[[min(1, samples - 1), max(0, samples - 2)]] = NEXT_TO_END_FACTOR
    factor[[0, samples - 1]] = END_FACTOR
    return factor


def peak(gaussians: Gaussians, row: int, opacity: Tensor, height: int, width: int) -> Tensor:
    """Return o exp(-q / 2) of each Gaussian of path ``row`` at each pixel centre [rows, samples, h, w], not clipped."""
    mean, frame, scale = (tensor[row, :, :, None] for tensor in gaussians[:3])
    own = opacity[row].reshape(-1, 1, 1)
    values = _bell(mean, frame, scale, own, _pixel_centers(height, width).to(mean))
    return values.reshape(*values.shape[:2], height, width)


def path_alpha(gaussians: Gaussians, opacity: Tensor, height: int, width: int) -> Tensor:
    """Return the coverage [N, h, w] of each path: 1 - prod (1 - alpha) over its Gaussians."""
    layers = [_one_path(gaussians, row, opacity[row], height, width) for row in range(len(opacity))]
    return torch.stack(layers) if layers else opacity.new_zeros(0, height, width)


def color_shares(gaussians: Gaussians, opacity: Tensor, height: int, width: int) -> Tensor:
    """Return for which share [N, h, w] of each pixel the colour of a path answers: what its Gaussians add, weighted.

    They are drawn one after another: side A, side B, and the lines from A to B.
    """
    shares = opacity.new_zeros(len(opacity), height, width)
    lines, samples = gaussians.mean.shape[1] - 2, gaussians.mean.shape[2]
    for path in range(len(opacity)):
        alpha = peak(gaussians, path, opacity, height, width)
        alpha = torch.where(alpha < ALPHA_MIN, 0.0, alpha.clamp(max=ALPHA_MAX))
        left = torch.ones_like(shares[path])
        for row in [0, lines + 1, *range(1, lines + 1)]:
            for k in range(samples):
                u, v = 2 * k / (samples - 1) - 1, (2 * (row - 1) / (lines - 1) - 1 if lines > 1 else -1)
                weight = 1.0 if row in (0, lines + 1) else 1 - math.exp(-4 * (abs(u) + abs(v)))
                shares[path] += weight * left * alpha[row, k]
                left = left * (1 - alpha[row, k])
    return shares


def _one_path(gaussians: Gaussians, row: int, opacity: Tensor, height: int, width: int) -> Tensor:
    mean, frame, scale = (tensor[row].flatten(0, 1) for tensor in gaussians[:3])
    opacity = opacity.reshape(-1, 1).expand(gaussians.mean.shape[1], gaussians.mean.shape[2]).reshape(-1)
    pixels = _pixel_centers(height, width).to(mean)
    with torch.no_grad():
        # Every Gaussian at every pixel; dropped ones have no gradient either.
        found = [
            (_bell(*(tensor[block, None] for tensor in (mean, frame, scale, opacity)), pixels) >= ALPHA_MIN).nonzero()
            + block.new_tensor([int(block[0]), 0])
            for block in torch.arange(len(mean)).split(64)
        ]
    which, where = torch.cat(found).T
    alpha = _bell(mean[which], frame[which], scale[which], opacity[which], pixels[where]).clamp(max=ALPHA_MAX)
    # The product is computed with logarithms, whose arguments are at least 1 - ALPHA_MAX.
    total = alpha.new_zeros(len(pixels)).index_add(0, where, torch.log1p(-alpha))
    return (1 - total.exp()).reshape(height, width)


def _bell(mean: Tensor, frame: Tensor, scale: Tensor, opacity: Tensor, pixels: Tensor) -> Tensor:
    """Return o exp(-q / 2) with q = |S^-1 R^T (v - X)|^2, broadcast over the leading axes."""
    dx, dy = (pixels - mean).unbind(-1)
    along = (dx * frame[..., 0, 0] + dy * frame[..., 1, 0]) / scale[..., 0]
    across = (dx * frame[..., 0, 1] + dy * frame[..., 1, 1]) / scale[..., 1]
    return opacity * torch.exp(-0.5 * (along.square() + across.square()))


def _pixel_centers(height: int, width: int) -> Tensor:
    """Return (x, y) of the pixel centres [h * w, 2] in raster order."""
    y, x = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    return torch.stack([x, y], -1).reshape(-1, 2) + 0.5


def _tangent_scale(mean: Tensor) -> Tensor:
    gap = (mean[:, :, 1:] - mean[:, :, :-1]).norm(dim=-1)
    return 2 / 3 * torch.cat([gap, gap[..., -1:]], -1) * end_factors(mean.shape[2]).to(mean)


def _normal_scale(weight: Tensor, a: Tensor, b: Tensor) -> Tensor:
    """Return two thirds of the distance to the next row; side B takes side A's."""
    gap = torch.cat([weight.diff(), weight[1:2]])
    return 2 / 3 * gap[:, None] * (b - a).norm(dim=-1)[:, None]


def scale_limits(row_count: int) -> tuple[Tensor, Tensor]:
    """Return the minimum and maximum standard deviations [rows, 1, 2] along the tangent and the normal."""
    low = torch.full((row_count, 1, 2), INTERIOR_SIGMA_MIN, dtype=torch.float64)
    high = torch.full((row_count, 1, 2), math.inf, dtype=torch.float64)
    low[[0, -1]] = torch.tensor([BOUNDARY_SIGMA_X_MIN, BOUNDARY_SIGMA_Y_MIN], dtype=torch.float64)
    high[[0, -1], :, 1] = BOUNDARY_SIGMA_Y_MAX
    return low, high


def _clamped(scale: Tensor) -> Tensor:
    low, high = scale_limits(scale.shape[1])
    scale = torch.cat([scale[:, :1], limited(scale[:, 1:-1]), scale[:, -1:]], 1)
    return torch.where(scale < low, low, torch.where(scale > high, high, scale))


def limited(scale: Tensor) -> Tensor:
    """Return interior deviations [..., 2], the longer one limited where that across the curve is small."""
    most = THIN_RATIO * torch.minimum(scale[..., :1], scale[..., 1:])
    return torch.where((scale[..., 1:] < THIN_SIGMA) & (scale > most), most, scale)


def tangents(mean: Tensor) -> Tensor:
    """Return central differences along each row [N, rows, samples, 2]; the ends take their neighbour's."""
    if mean.shape[2] < 3:
        return (mean[:, :, -1:] - mean[:, :, :1]).expand_as(mean)
    inner = mean[:, :, 2:] - mean[:, :, :-2]
    return torch.cat([inner[:, :, :1], inner, inner[:, :, -1:]], 2)


def _frame(mean: Tensor) -> Tensor:
    tangent = tangents(mean)
    short = tangent.norm(dim=-1, keepdim=True) < TANGENT_MIN
    tangent = torch.where(short, tangent.new_tensor([1.0, 0.0]), tangent)
    unit = tangent / tangent.norm(dim=-1, keepdim=True)
    return torch.stack([unit, torch.stack([-unit[..., 1], unit[..., 0]], -1)], -1)


def _detach_interior(rows: Tensor) -> Tensor:
    return torch.cat([rows[:, :1], rows[:, 1:-1].detach(), rows[:, -1:]], 1)

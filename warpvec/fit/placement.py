"""Place new paths: where the residual is large, in the colours of the image there."""

from __future__ import annotations

import math

import torch
from torch import Tensor
from torch.nn.functional import pad

from warpvec.config.fit_config import FitConfig
from warpvec.fit.path_models import path_model
from warpvec.geometry.circles import arc_points
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

BLUR_SIGMA = 1.0
"""Sigma of the blur of the residual, in pixels. With the blur, paths go to errors that they can cover, not to single
noisy pixels. Better by 0.07 dB than 2 at 256 paths (two photos), and by 0.08 dB than 4 at 512."""

BLUR_REACH = 3
"""Radius of the blur in sigmas; 0.3 % of a Gaussian lie beyond."""

CLOSED_ARC = 5.0 / 6.0
"""Share of a circle that the cubics of a new path draw if a line closes it."""

BLOCK = 1024
"""Pixels in a block of the two-level draw: the square root of a megapixel, so that both levels stay small."""


def sample_positions(residual: Tensor, count: int, generator: torch.Generator) -> Tensor:
    """Draw positions [count, 2] in pixels, each uniform within a pixel drawn in proportion to the blurred ``residual``.

    No pixel is drawn twice, unless there are fewer pixels than positions. If no residual is left, all remaining pixels
    are equally likely. The order is random, so that it can serve as the z-order.

    Args:
        residual: squared error of each pixel [height, width]; negative and non-finite values count as 0.
        count: number of positions.
        generator: the source of all random numbers.
    """
    weights = _blur(residual.nan_to_num(0.0, 0.0, 0.0).clamp_min_(0.0)).flatten()
    if count > len(weights):
        pixels = _draw(weights, count, generator)
    else:
        pixels = _draw_distinct(weights, count, generator)
    pixels = pixels[torch.randperm(count, generator=generator, device=generator.device).to(pixels.device)]
    corner = torch.stack([pixels % residual.shape[1], pixels // residual.shape[1]], 1)
    return (corner + uniform_numbers((count, 2), generator).to(corner.device)).to(residual.dtype)


def colors_at(image: Tensor, center: Tensor) -> Tensor:
    """Return the colours [N, 3] of ``image`` [h, w, 3] in the pixels at, or nearest to, ``center`` [N, 2]."""
    height, width = image.shape[:2]
    columns, rows = center.long().unbind(-1)
    return image[rows.clamp(0, height - 1), columns.clamp(0, width - 1)]


def new_paths(
    center: Tensor,
    radius: tuple[float, float],
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    generation: int,
    config: FitConfig,
) -> Scene:
    """Return a scene of ellipses in the path model of ``config``.

    Args:
        center: centres [N, 2] in pixels.
        radius: half the width and half the height of all, in pixels.
        color, opacity, background: [N, 3], [N] and [3], as in the scene.
        generation: the generation of all paths.
        config: gives the path model and its size.
    """
    generations = torch.full((len(center),), generation, device=center.device)
    fills = (color, opacity, background, generations)
    if config.closing_line:
        unit, structure = _closed_arcs(len(center), config.segments, center.device)
        points = center[:, None, :] + unit.to(center) * center.new_tensor(radius)
        return Scene(points.reshape(-1, 3, 2), structure, *fills)
    model = path_model(config)
    unit = model.circles(torch.zeros_like(center), torch.ones_like(center[:, 0]))
    return Scene.uniform(center[:, None, :] + unit * center.new_tensor(radius), *fills, model.degree)


def _closed_arcs(count: int, curve_count: int, device: torch.device) -> tuple[Tensor, Structure]:
    """Return a circle of ``curve_count`` cubics with a line in place of a small arc, and the structure of ``count``."""
    rows, loops = curve_count + 1, torch.arange(count + 1, dtype=torch.int32, device=device)
    is_line = torch.arange(rows, device=device).repeat(count) == curve_count
    return arc_points(curve_count, CLOSED_ARC), Structure(loops * rows, loops, is_line)


def blur_weights() -> list[float]:
    """Return the weights of the blur of the residual in a row of pixels; their sum is 1."""
    reach = math.ceil(BLUR_REACH * BLUR_SIGMA)
    kernel = [math.exp(-0.5 * (offset / BLUR_SIGMA) ** 2) for offset in range(-reach, reach + 1)]
    return [weight / sum(kernel) for weight in kernel]


def _blur(image: Tensor) -> Tensor:
    """Blur ``image`` [height, width] by a Gaussian of ``BLUR_SIGMA``; pixels at the border continue beyond it."""
    # Shifted sums instead of conv1d, which took 80 bytes a pixel and several times as long.
    kernel = blur_weights()
    reach = len(kernel) // 2
    for _ in range(2):
        padded = pad(image[None], (reach, reach), mode="replicate")[0]
        image = torch.zeros_like(image)
        for offset, weight in enumerate(kernel):
            image.add_(padded[:, offset : offset + image.shape[1]], alpha=weight)
        image = image.T.contiguous()
    return image


def _draw_distinct(weights: Tensor, count: int, generator: torch.Generator) -> Tensor:
    """Draw distinct indices [count], ascending, distributed as if drawn one by one without replacement."""
    # Repeats in a batch are dropped and drawn again from the rest. That equals drawing one by one, ignoring repeats.
    free = torch.ones_like(weights, dtype=torch.bool)
    drawn = free[:0].long()
    while len(drawn) < count:
        free[_draw(weights.where(free, 0.0), count - len(drawn), generator, free)] = False
        drawn = (~free).nonzero().flatten()  # the host waits for a GPU here, and in `_draw`
    return drawn


def _draw(weights: Tensor, count: int, generator: torch.Generator, free: Tensor | None = None) -> Tensor:
    """Draw indices [count], with repeats, in proportion to ``weights`` [n]: first the block, then the place in it.

    torch.multinomial would stop at 2^24 categories. Sums are in float64; a weight of 0 is never drawn. If no weight is
    left, all indices that are ``free`` [n] are equally likely; None: all.
    """
    blocks = pad(weights, (0, -len(weights) % BLOCK)).view(-1, BLOCK)
    # On CUDA a cumsum of one long row adds in no fixed order.
    block_ends = blocks.sum(1, dtype=torch.float64).cpu().cumsum(0)
    if not block_ends[-1]:
        return _draw(torch.ones_like(weights) if free is None else free.to(weights.dtype), count, generator)
    block = _invert(block_ends, uniform_numbers((count,), generator)).to(weights.device)
    place = _invert(blocks[block].cumsum(1, dtype=torch.float64), uniform_numbers((count, 1), generator))
    return block * BLOCK + place[:, 0]


def _invert(cumulative: Tensor, uniform: Tensor) -> Tensor:
    """Return the index of the first entry of ``cumulative`` above ``uniform`` times its last entry."""
    return torch.searchsorted(cumulative, uniform.to(cumulative.device) * cumulative[..., -1:], right=True)


def uniform_numbers(shape: tuple[int, ...], generator: torch.Generator) -> Tensor:
    """Return random numbers in [0, 1) (float64) where the ``generator`` is."""
    return torch.rand(shape, generator=generator, device=generator.device, dtype=torch.float64)

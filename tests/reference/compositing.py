"""Source-over compositing, back to front, one path at a time."""

from __future__ import annotations

from torch import Tensor


def composite(coverage: Tensor, color: Tensor, opacity: Tensor, background: Tensor) -> Tensor:
    """Return the image [h, w, 3] of paths painted in row order: C = a c + (1 - a) C with a = opacity * coverage.

    Args:
        coverage: area of each path in each pixel [N, h, w], in [0, 1].
        color: fill [N, 3], or in each pixel [N, h, w, 3].
        opacity: fill opacity [N], or in each pixel [N, h, w].
        background: background colour [3].
    """
    image = background.expand(*coverage.shape[1:], 3)
    for path_coverage, path_color, path_opacity in zip(coverage, color, opacity, strict=True):
        alpha = (path_opacity * path_coverage)[..., None]
        image = alpha * path_color + (1 - alpha) * image
    return image

"""What of each path is to be seen, and scenes without the paths of which nothing is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import torch
from torch import Tensor

from warpvec.autograd import draw_adjoint
from warpvec.scene import Scene

SHOWN_MIN = 1.0
"""Pixels, at full opacity and nothing above: what shows less than this in all is a candidate for removal. Spread over
500 pixels it is less than half a level of 255; whether it changes one is then seen by drawing without it."""

DRAWINGS_MAX, DRAWN_BYTES_MAX = 8, 2**26
"""Drawings that the search for what changes no pixel may take, and bytes of all of them: each costs what drawing the
file costs, and most candidates do change a pixel. 31 of 4096 paths took 62 drawings, half a minute, to keep them all.
"""

Drawing = Callable[[Scene], bytes]
"""The pixels of a scene as a viewer shows them."""


def shown_areas(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """Of each path [N], the sum over the pixels of coverage, opacity, and the transmittance of all that is above."""
    # The sum of the image's reds, as it changes with the red of each path.
    adj_image = scene.points.new_zeros((height, width, 3))
    adj_image[..., 0] = 1.0
    return draw_adjoint(scene, adj_image, threads=threads).color[:, 0]


def canvas_areas(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """Area [N] in pixels of each path by itself, as far as it lies on the canvas."""
    faint = 1e-6
    alone = replace(scene, opacity=torch.full_like(scene.opacity, faint))
    return shown_areas(alone, height, width, threads) / faint


def without_invisible(scene: Scene, shown: Tensor, draw: Drawing) -> Scene:
    """``scene`` without the paths that change no pixel of ``draw``, as far as ``DRAWINGS_MAX`` drawings find them.

    Args:
        scene: N paths.
        shown: what is seen of each [N], as `shown_areas` gives it; only the least are tried.
        draw: the judge: what goes must leave its pixels as they are.
    """
    order = shown.argsort(stable=True)
    candidates = order[shown[order] < SHOWN_MIN]
    if not len(candidates):
        return scene
    return scene.select(_kept(scene, candidates, draw, draw(scene)))


def _kept(scene: Scene, candidates: Tensor, draw: Drawing, pixels: bytes) -> Tensor:
    """Which paths stay [N]: halves of ``candidates``, in their order, go together where that changes no pixel."""
    keep = torch.ones(len(scene), dtype=torch.bool)
    pending = [candidates]
    for _ in range(min(DRAWINGS_MAX, DRAWN_BYTES_MAX // len(pixels))):
        if not pending:
            break
        group = pending.pop()
        keep[group] = False
        if draw(scene.select(keep)) == pixels:
            continue
        keep[group] = True
        if len(group) > 1:
            middle = len(group) // 2
            pending += [group[middle:], group[:middle]]
    return keep

"""What of each path is to be seen, and scenes without the paths of which nothing is.

What goes is proven to change no pixel, by drawing without it. What may stay although it changes none: a path that by
`visible_areas` and `changes_alone` is above both `SHOWN_MIN` and `CHANGE_MIN`, and any path once the drawings are used
up. Hidden paths are the first to be tried, and once in any photo, however large.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.rendering.operator import draw_adjoint

SHOWN_MIN = 1.0
"""Pixels, at full opacity and nothing above: what shows less than this in all is a candidate for removal. Spread over
500 pixels it is less than half a level of 255; whether it changes one is then seen by drawing without it."""

CHANGE_MIN = 1.0 / 255.0**2
"""Squared, over pixels and channels: a path whose going changes less than one level of 255 in one pixel is a candidate
too, however much of it shows: it has the colour of what is below."""

DRAWINGS_MAX, DRAWN_BYTES_MAX = 8, 2**26
"""Drawings that the search for what changes no pixel may take, and bytes of all of them: each costs what drawing the
file costs, and most candidates do change a pixel: 31 of 4096 paths took 62 drawings, half a minute, to keep them all.
Without all that shows nothing one is made in any case.
"""

FAINT = 1e-6
"""An opacity at which even a thousand paths in one place let all but 0.1 % through."""

DrawScene = Callable[[Scene], bytes]
"""The pixels of a scene as a viewer shows them."""


def visible_areas(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """Of each path [N], the sum over the pixels of coverage, opacity, and the transmittance of all that is above."""
    # The sum of the image's reds, as it changes with the red of each path.
    adj_image = scene.points.new_zeros((height, width, 3))
    adj_image[..., 0] = 1.0
    return draw_adjoint(scene, adj_image, threads=threads).color[:, 0]


def canvas_areas(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """Area [N] in pixels of each path by itself, as far as it lies on the canvas."""
    return visible_areas(faint(scene), height, width, threads) / FAINT


def faint(scene: Scene) -> Scene:
    """``scene`` with the opacity ``FAINT`` for every path: no path hides another."""
    return replace(scene, opacity=torch.full_like(scene.opacity, FAINT))


def changes_alone(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """How much the image changes as each path [N] alone goes: squared, summed over the pixels and channels."""
    target = scene.points.new_full((height, width, 4 if scene.transparent else 3), 0.5)
    adjoints = Target(target, FitConfig(threads=threads), "cpu").fit_step(scene, True)
    # The loss is a parabola in the opacity. Less its slope, which depends on the target, it is the change of the image.
    changes: Tensor = 3 * height * width * (adjoints.removal_cost + scene.opacity * adjoints.opacity)
    return changes.clamp_min(0.0)


def without_invisible(scene: Scene, shown: Tensor, changes: Tensor, draw: DrawScene) -> Scene:
    """``scene`` without the paths that change no pixel of ``draw``, as far as ``DRAWINGS_MAX`` drawings find them.

    Args:
        scene: N paths.
        shown: what is seen of each [N], as `visible_areas` gives it.
        changes: what each changes [N], as `changes_alone` gives it; only those least in one of the two are tried.
        draw: the judge: what goes must leave its pixels as they are.
    """
    hidden, little, alike = shown == 0.0, shown < SHOWN_MIN, changes < CHANGE_MIN
    masks = (hidden, little & ~hidden, alike & ~little)
    measures = (changes, shown, changes)
    groups = [order[mask[order]] for mask, order in zip(masks, (m.argsort(stable=True) for m in measures), strict=True)]
    if not any(len(group) for group in groups):
        return scene
    return scene.select(_kept(scene, groups, draw))


def _kept(scene: Scene, groups: list[Tensor], draw: DrawScene) -> Tensor:
    """Which paths stay [N]: ``groups``, the hidden ones first, or halves of them go where that changes no pixel.

    The groups take turns, and in each what is in front goes first.
    """
    keep = torch.ones(len(scene), dtype=torch.bool)
    pixels = draw(scene)
    turns = deque([group] for group in groups if len(group))
    for _ in range(max(int(len(groups[0]) > 0), min(DRAWINGS_MAX, DRAWN_BYTES_MAX // len(pixels)))):
        while turns and not turns[0]:
            turns.popleft()
        if not turns:
            break
        pending = turns[0]
        turns.rotate(-1)
        group = pending.pop()
        keep[group] = False
        if draw(scene.select(keep)) == pixels:
            continue
        keep[group] = True
        if len(group) > 1:
            middle = len(group) // 2
            pending += [group[middle:], group[:middle]]
    return keep

"""Measure each path's visible area; drop invisible paths.

A path is dropped only if a rendering without it has the same pixels. Some invisible paths may stay: those above both
`VISIBLE_AREA_MIN` and `CHANGE_MIN`, which are not tried, and those left when no more renderings are allowed. Hidden
paths are tried first. If there are any, at least one rendering tries to drop them, however large the image is.
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

VISIBLE_AREA_MIN = 1.0
"""A path with a smaller visible area, in pixels, is a candidate. Spread over 500 pixels this area is less than half a
level of 255, so the path may change no pixel; a rendering without it tells."""

CHANGE_MIN = 1.0 / 255.0**2
"""Largest change of the image by the removal of a path that may be invisible, squared and summed over pixels and
channels: one level of 255 in one pixel. Such a path may be large, in the colour of the paths below."""

RENDERINGS_MAX, RENDERED_BYTES_MAX = 8, 2**26
"""Max number of renderings in the search for invisible paths, and max bytes of all their pixels. Each costs as much as
drawing the file, and most candidates do change a pixel: 31 candidates among 4096 paths took 62 renderings, half a
minute, and all of them stayed. If paths are hidden, one rendering without all of them is made in any case."""

FAINT = 1e-6
"""An opacity so low that even a thousand paths in one place let 99.9 % of the light through."""

DrawScene = Callable[[Scene], bytes]
"""A function that returns the pixels of a scene as a viewer shows them."""


def visible_areas(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """Measure each path's visible area [N]: the sum over the pixels of coverage, opacity and transmittance above."""
    # This is the derivative of the sum of the image's reds with respect to all reds of each path.
    adj_image = scene.segments.new_zeros((height, width, 3))
    adj_image[..., 0] = 1.0
    return draw_adjoint(scene, adj_image, threads=threads).whole_color[:, 0]


def canvas_areas(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """Measure the area [N] in pixels of each path by itself, inside the canvas."""
    return visible_areas(faint(scene), height, width, threads) / FAINT


def faint(scene: Scene) -> Scene:
    """Return ``scene`` with the opacity ``FAINT`` for every path, so that no path hides another."""
    return replace(scene, opacity=torch.full_like(scene.opacity, FAINT), side_opacity=None)


def removal_changes(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """Measure the image's change when each path [N] alone is removed: squared, summed over pixels and channels."""
    target = scene.segments.new_full((height, width, 4 if scene.transparent else 3), 0.5)
    adjoints = Target(target, FitConfig(threads=threads), "cpu").fit_step(scene, True)
    # The loss is a parabola in the opacity. Without its slope, which depends on the target, it is the image's change.
    changes = 3 * height * width * adjoints.contrast(scene.opacity)
    return changes.clamp_min(0.0)


def without_invisible(
    scene: Scene, visible_area: Tensor, changes: Tensor, draw: DrawScene, is_late: bool = False
) -> Scene:
    """Return ``scene`` without the paths that change no pixel of ``draw``.

    Only paths with a small ``visible_area`` or small ``changes`` are tried. The search may end before it has found all
    invisible paths, because it makes ``RENDERINGS_MAX`` renderings at most.

    Args:
        scene: N paths.
        visible_area: the area [N] that `visible_areas` measures.
        changes: the changes [N] that `removal_changes` measures.
        draw: draws a scene; a path is removed only if the pixels stay the same.
        is_late: whether the time of the run is over: one rendering must then do.
    """
    hidden, small, alike = visible_area == 0.0, visible_area < VISIBLE_AREA_MIN, changes < CHANGE_MIN
    masks = (hidden, small & ~hidden, alike & ~small)
    measures = (changes, visible_area, changes)
    groups = [order[mask[order]] for mask, order in zip(masks, (m.argsort(stable=True) for m in measures), strict=True)]
    if not any(len(group) for group in groups):
        return scene
    return scene.select(_visible_mask(scene, groups, draw, 1 if is_late else RENDERINGS_MAX))


def _visible_mask(scene: Scene, groups: list[Tensor], draw: DrawScene, renderings_max: int) -> Tensor:
    """Return a mask [N] of the paths to keep.

    Remove whole groups, or else their halves, if that changes no pixel. The first group holds the hidden paths. The
    groups take turns; each is sorted so that the paths that matter least are tried first.
    """
    keep = torch.ones(len(scene), dtype=torch.bool)
    pixels = draw(scene)
    turns = deque([group] for group in groups if len(group))
    for _ in range(max(int(len(groups[0]) > 0), min(renderings_max, RENDERED_BYTES_MAX // len(pixels)))):
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

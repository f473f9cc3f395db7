"""Cut windows into a drawing: what lies below some of its paths is cut away, and so are these paths.

What is laid below the drawing then shows in the windows, and nowhere else.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.flat.cutting.arrangement import sheet
from warpvec.flat.cutting.cutout import cut_out
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.scene import Scene


def with_windows(scene: Scene, is_window: Tensor, width: int, height: int) -> Scene:
    """Return ``scene`` with the paths ``is_window`` [N] (bool) cut out of all that lies below them.

    Its background becomes a path. Paths above a window stay. Paths that reach below none stay as they are.

    Args:
        scene: sharp paths over a background, on a canvas of ``width`` x ``height`` pixels.
        is_window: the paths in place of which something else is to be seen.
    """
    page = sheet(scene.background.cpu(), width, height)
    stacked = page.joined(replace(scene.detach().cpu(), transparent=True, background=torch.zeros(3)))
    marks = torch.cat([torch.zeros(1, dtype=torch.bool), is_window.cpu()])
    whole = cut_windows(stacked, marks, width, height)
    return replace(whole, background=scene.background.cpu(), transparent=False)


def cut_windows(scene: Scene, is_window: Tensor, width: int, height: int) -> Scene:
    """Return ``scene`` without the paths ``is_window`` [N] (bool), cut out of the paths below; see `with_windows`."""
    boxes = path_boxes(scene)
    parts = [_cut(scene, path, is_window, boxes, (width, height)) for path in range(len(scene)) if not is_window[path]]
    whole = scene.select(torch.zeros(0, dtype=torch.int64))
    for part in parts:
        whole = whole.joined(part)
    return whole


def _cut(scene: Scene, path: int, is_window: Tensor, boxes: Tensor, size: tuple[int, int]) -> Scene:
    """Cut the windows that lie above a ``path`` of ``scene``, and meet it, out of it. Return what is left."""
    own = scene.select(torch.tensor([path]))
    above = torch.arange(len(scene)) > path
    meets = (boxes[:, :2] < boxes[path, 2:]).all(1) & (boxes[:, 2:] > boxes[path, :2]).all(1)
    rows = (is_window & above & meets).nonzero().flatten()
    if not len(rows) or _is_stroked(own):
        return own
    # The colours only tell which part is which.
    pair = own.outlined().joined(scene.select(rows).outlined())
    marked = torch.cat([torch.zeros(1, 3), torch.ones(len(rows), 3)])
    plain = replace(pair, color=marked, opacity=torch.ones(len(marked)), gradients=None, strokes=None, softness=None)
    parts = cut_out(plain, *size).scene
    left = parts.select((parts.color.amax(1) < 0.5).nonzero().flatten())
    count = torch.zeros(len(left), dtype=torch.int64)
    names = ("color", "opacity", "generation")
    values = {name: getattr(own, name)[count] for name in names}
    gradients = None if own.gradients is None else own.gradients.map(lambda each: each[count])
    return replace(left, gradients=gradients, **values)


def _is_stroked(scene: Scene) -> bool:
    return scene.strokes is not None and bool(scene.strokes.is_stroked.any())

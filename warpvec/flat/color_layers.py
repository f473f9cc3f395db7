"""Layers of a drawing for its file: one for each colour, where the order of the paths allows it, with a readable name.

A designer recolours a drawing colour by colour, and a cutter or plotter loads one material or pen after another. How
deep a shape lies in others is in the order of the paths already.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import torch

from warpvec.arrays import Floats
from warpvec.flat.constants.drawing import DRAWING
from warpvec.geometry.paints.registry import FLAT, kind_of
from warpvec.geometry.scene import Scene


def layered(scene: Scene) -> tuple[Scene, dict[int, str]]:
    """Return ``scene`` with its paths in layers of one paint each, which are its generations, and the layers' names.

    A path joins the highest layer of its paint if its box overlaps none of the paths above that layer, so that the
    picture stays the same.
    """
    boxes, paints = path_boxes(scene), [_paint(scene, path) for path in range(len(scene))]
    layers: list[list[int]] = []
    of_paint: dict[str, int] = {}
    for path, paint in enumerate(paints):
        place = of_paint.get(paint)
        above = [] if place is None else [other for layer in layers[place + 1 :] for other in layer]
        if place is None or _overlaps(boxes[path], boxes[above]):
            of_paint[paint] = place = len(layers)
            layers.append([])
        layers[place].append(path)
    order = torch.tensor([path for layer in layers for path in layer], dtype=torch.int64)
    generation = torch.tensor([place for place, layer in enumerate(layers) for _ in layer], dtype=torch.int64)
    names = _unique([paints[layer[0]] for layer in layers])
    return replace(scene.select(order), generation=generation), dict(enumerate(names))


def color_name(color: Floats) -> str:
    """Return the CSS name of the colour that looks most like ``color`` [3] in [0, 1], and its code: "red #e4002b"."""
    names, places = _css_colors()
    nearest = int(np.square(places - _oklab(color[None])).sum(1).argmin())
    code = bytes(np.rint(255.0 * color.clip(0.0, 1.0)).astype(np.uint8)).hex()
    return f"{names[nearest]} #{code}"


def path_boxes(scene: Scene) -> Floats:
    """Return a box around each path [N, 4]: left, top, right, bottom of its control points."""
    points = scene.segments.double().numpy()
    first = scene.structure.path_first_segment.long().numpy()[:-1]
    if not len(scene):
        return np.zeros((0, 4))
    low = np.minimum.reduceat(points.min(1), first, axis=0)
    return np.concatenate([low, np.maximum.reduceat(points.max(1), first, axis=0)], 1)


def _overlaps(box: Floats, others: Floats) -> bool:
    apart = (others[:, :2] > box[2:] + DRAWING.boxes_touch) | (others[:, 2:] < box[:2] - DRAWING.boxes_touch)
    return bool((~apart.any(1)).any())


def _paint(scene: Scene, path: int) -> str:
    """Return the name of a path's paint; equal paints have equal names."""
    color = scene.color[path].double().numpy()
    opacity = round(100 * float(scene.opacity[path]))
    suffix = "" if opacity == 100 else f", {opacity} % opaque"
    if scene.gradients is None or int(scene.gradients.kind[path]) == FLAT:
        return color_name(color) + suffix
    kind = kind_of(int(scene.gradients.kind[path])).name
    end = scene.gradients.end_color[path].double().numpy()
    return f"{kind} {color_name(color)} to {color_name(end)}{suffix}"


def _unique(names: list[str]) -> list[str]:
    """Return ``names`` with a running number after each that occurs again."""
    seen: Counter[str] = Counter()
    found = []
    for name in names:
        seen[name] += 1
        found.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return found


@cache
def _css_colors() -> tuple[list[str], Floats]:
    """Return the names of CSS colours, and their places [C, 3] in OKLab. Of two spellings, the American one stays."""
    from PIL import ImageColor

    names = [name for name in ImageColor.colormap if "grey" not in name]
    levels = [ImageColor.getrgb(name)[:3] for name in names]
    return names, _oklab(np.array(levels, np.float64) / 255.0)


def _oklab(colors: Floats) -> Floats:
    """Return sRGB-encoded ``colors`` [C, 3] in OKLab, where equal distances look equal.

    Source: Bjorn Ottosson, "A perceptual color space for image processing", 2020.
    """
    linear = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    cones = linear @ np.array([[0.4122214708, 0.2119034982, 0.0883024619],
                               [0.5363325363, 0.6806995451, 0.2817188376],
                               [0.0514459929, 0.1073969566, 0.6299787005]])  # fmt: skip
    return np.cbrt(cones) @ np.array([[0.2104542553, 1.9779984951, 0.0259040371],
                                               [0.7936177850, -2.4285922050, 0.7827717662],
                                               [-0.0040720468, 0.4505937099, -0.8086757660]])  # fmt: skip

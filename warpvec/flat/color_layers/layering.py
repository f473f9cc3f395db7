"""Layers of a drawing for its file: one for each colour, where the paths that overlap allow it, with a readable name.

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
from warpvec.flat.color_layers.order import few_layers
from warpvec.flat.color_layers.overlaps import overlapping_paths
from warpvec.flat.color_layers.shades import shade_groups
from warpvec.flat.constants.drawing import DRAWING
from warpvec.geometry.paints.registry import FLAT, kind_of
from warpvec.geometry.scene import Scene
from warpvec.image.oklab import to_oklab

HUE_GAP = np.pi / 4.0
"""Largest difference in hue of a colour and its name: eight hues go around the circle, from red to purple. Without it a
dark brown is nearest to "darkslategray", as dark colours have little chroma."""


def layered(scene: Scene, height: int, width: int, *, joins_shades: bool = True) -> tuple[Scene, dict[int, str]]:
    """Return ``scene`` with its paths in layers of one colour each, and the names of the layers by their generations.

    Paths that overlap keep their order, so that the picture of ``height`` x ``width`` pixels stays the same. A colour
    has more than one layer only if this order asks for it.

    Args:
        scene: the paths.
        height, width: size of the canvas in the pixels of the scene.
        joins_shades: whether shades that differ little share a layer.
    """
    paints = [_paint(scene, path) for path in range(len(scene))]
    numbers = {paint: number for number, paint in enumerate(dict.fromkeys(paints))}
    group = shade_groups(scene) if joins_shades else np.array([numbers[paint] for paint in paints], np.int64)
    layers = few_layers(group, overlapping_paths(scene, height, width))
    order = torch.tensor([path for layer in layers for path in layer], dtype=torch.int64)
    generation = torch.tensor([place for place, layer in enumerate(layers) for _ in layer], dtype=torch.int64)
    names = _unique([_layer_name(scene, [paints[path] for path in layer], layer) for layer in layers])
    return replace(scene.select(order), generation=generation), dict(enumerate(names))


def _layer_name(scene: Scene, paints: list[str], layer: list[int]) -> str:
    """Return the name of a layer of paths, in at most three words, such as "darkorange #ea7600, shaded".

    The name states the colour of most of the ``paints``, its code, and whether it is shaded or translucent.
    """
    counted = Counter(paints)
    path = layer[paints.index(counted.most_common(1)[0][0])]
    is_shaded = len(counted) > 1 or (scene.gradients is not None and int(scene.gradients.kind[path]) != FLAT)
    opacity = round(100 * float(scene.opacity[path]))
    suffix = ", shaded" if is_shaded else f", {opacity}%" if opacity < 100 else ""
    return color_name(scene.color[path].double().numpy()) + suffix


def color_name(color: Floats) -> str:
    """Return the CSS name of the colour that looks most like ``color`` [3] in [0, 1], and its code: "red #e4002b".

    Names tell hue and vividness, so that lightness counts for less than in OKLab. A grey has the name of a grey, and
    another colour that of one within ``HUE_GAP``.
    """
    names, places = _css_colors()
    place = to_oklab(color[None])
    chroma, own = np.hypot(*places[:, 1:].T), float(np.hypot(*place[0, 1:]))
    apart = np.square((places - place) * [DRAWING.shade_lightness, 1.0, 1.0]).sum(1)
    apart += (DRAWING.name_vividness**2 - 1.0) * np.square(chroma - own)
    is_gray = chroma < DRAWING.gray_chroma
    along = places[:, 1:] @ place[0, 1:]
    fits = is_gray if own < DRAWING.gray_chroma else ~is_gray & (along >= np.cos(HUE_GAP) * chroma * own)
    nearest = int(np.where(fits, apart, np.inf).argmin())
    code = bytes(np.rint(255.0 * color.clip(0.0, 1.0)).astype(np.uint8)).hex()
    return f"{names[nearest]} #{code}"


def _paint(scene: Scene, path: int) -> str:
    """Return a path's paint in words; equal paints have equal ones."""
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
    return names, to_oklab(np.array(levels, np.float64) / 255.0)

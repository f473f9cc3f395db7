"""Draw pictures that are drawings with photos in them: a screenshot, a card with a portrait, a product on plain ground.

The photos are painted in one colour and outlined with the rest of the drawing. Then what they hide is cut away, so that
the drawing has a window for each, and the paths of the photos lie below it. No clip is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import torch

from warpvec.arrays import Floats32, Mask
from warpvec.drawing.drawing import Drawing
from warpvec.errors import InputError
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.target import opaque_colors
from warpvec.flat.color_layers.layering import layered
from warpvec.flat.constants.textures import TEXTURES
from warpvec.flat.cutting.simple_outlines import with_simple_outlines
from warpvec.flat.cutting.windows import with_windows
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.regions.regions import NotFlatArtError
from warpvec.flat.texture_outlines import Keyed, with_key
from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.scene import Scene
from warpvec.image.picture import Picture
from warpvec.modes.flat import Flat, reduced_settings
from warpvec.modes.photo import Photo
from warpvec.modes.request import Request
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Watch


@dataclass(frozen=True)
class Mixed:
    """The mode of drawings with photos in them.

    Attributes:
        is_texture: pixels [h, w] of the copy of the picture that belong to photos; None if it has none, or is
            transparent, and is to be drawn as flat art.
    """

    is_texture: Mask | None

    def draw(self, request: Request) -> Drawing:
        """Return the drawing. The flat art takes the paths that it needs, and the photos share the others.

        Raises:
            InputError: there is a goal. It would have to be shared among the drawing and its photos.
            NotFlatArtError: the photos have no outline of their own in the drawing.
        """
        if request.goal:
            rule = "must be another one for a file of a given size or quality"
            raise InputError("mode", rule, "mixed", "leave the goal out, or give --mode photo")
        if self.is_texture is None:
            return Flat().draw(request)
        keyed = with_key(request.picture.reduced, self.is_texture)
        drawing = _drawing_with_windows(request, keyed)
        photo, device = _photos(request, keyed, max(len(drawing), 1))
        height, width = request.picture.reduced_size
        upper, names = layered(drawing, height, width)
        upper = replace(upper, generation=upper.generation + 1)
        layer_names = {0: "photo"} | {number + 1: name for number, name in names.items()}
        encoding = replace(request.encoding.of_drawing(), layer_names=layer_names, simplify=_with_simple_drawing)
        lower = replace(photo, generation=torch.zeros_like(photo.generation))
        return Drawing.of(lower.joined(upper), encoding, device)


def _with_simple_drawing(scene: Scene, tick: tuple[float, float]) -> Scene:
    """Return ``scene`` with simple outlines of all but its photos, which lie below."""
    is_photo = scene.generation == 0
    return scene.select(is_photo).joined(with_simple_outlines(scene.select(~is_photo), tick))


def _drawing_with_windows(request: Request, keyed: Keyed) -> Scene:
    """Return the flat art with a window in place of each photo, in pixels of the copy of the picture."""
    settings, watch = reduced_settings(request), request.watch
    most = round((1.0 - TEXTURES.paths_min) * settings.curves)
    settings = replace(settings, mode="flat", curves=max(most, 1))
    key, mean = torch.from_numpy(keyed.color), torch.from_numpy(keyed.photo[keyed.is_seen].mean(0))

    def shown(scene: Scene) -> Scene:
        return replace(scene, color=torch.where(_is_key(scene, key)[:, None], mean, scene.color))

    with single_torch_thread(), torch.no_grad(), _shown(watch, shown):
        work = FlatDrawing(torch.from_numpy(keyed.image), settings, watch, blur=request.picture.blur)
        scene, _ = work.draw(settings.detail)
        is_window = _is_key(scene, key)
        if not bool(is_window.any()) or bool((scene.background - key).abs().amax() <= TEXTURES.key_distance):
            raise NotFlatArtError("its photos have no outline of their own")
        height, width = request.picture.reduced_size
        return with_windows(scene, is_window, width, height)


def _is_key(scene: Scene, key: torch.Tensor) -> torch.Tensor:
    """Return which paths [N] of ``scene`` stand for photos, by their colour ``key`` [3]."""
    return (scene.color - key.to(scene.color)).abs().amax(1) <= TEXTURES.key_distance


def _photos(request: Request, keyed: Keyed, used: int) -> tuple[Scene, str]:
    """Return the paths of the photos, which may reach beyond their outlines, and the device of their fit.

    Args:
        request: what to draw.
        keyed: the drawing with its photos outlined.
        used: number of paths of the drawing.
    """
    settings, part = request.settings, _box(keyed.is_seen)
    pixels = _continued(keyed.photo[part], keyed.is_seen[part])
    least = max(round(TEXTURES.paths_min * settings.curves), 1)
    settings = replace(settings, mode="photo", curves=max(settings.curves - used, least), min_area=0.0, minify=False)
    encoding = replace(request.encoding, picture=Picture(pixels, pixels), size=pixels.shape[:2])
    inner = replace(request, encoding=encoding).with_settings(settings)
    x, y = float(part[1].start), float(part[0].start)
    with _shown(request.watch, lambda scene: scene.moved(x, y)):
        drawing = Photo().draw(inner)
    return to_cubics(drawing.fitted)[0].moved(x, y), drawing.device


def _box(mask: Mask) -> tuple[slice, slice]:
    """Return the rows and columns of the part of ``mask`` [h, w] around all that it has, with a margin."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    spans = [
        slice(max(int(each[0]) - TEXTURES.margin, 0), int(each[-1]) + 1 + TEXTURES.margin) for each in (rows, columns)
    ]
    return spans[0], spans[1]


def _continued(image: Floats32, is_seen: Mask) -> Floats32:
    """Return ``image`` [h, w, 3] with softly continued colours in place of what is not ``is_seen`` [h, w]."""
    alpha = is_seen[..., None].astype(np.float32)
    filled: Floats32 = opaque_colors(torch.from_numpy(np.concatenate([image, alpha], 2))).numpy()
    return np.where(is_seen[..., None], image, filled).clip(0.0, 1.0)


@contextmanager
def _shown(watch: Watch, change: Callable[[Scene], Scene]) -> Iterator[None]:
    """Show what ``change`` makes of the scenes of the ``watch``."""
    show = watch.on_progress
    if show is None:
        yield
        return

    def show_changed(progress: Progress) -> None:
        show(replace(progress, scene=lambda: change(progress.scene())))

    watch.on_progress = show_changed
    try:
        yield
    finally:
        watch.on_progress = show

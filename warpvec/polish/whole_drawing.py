"""Polish a whole drawing: its outlines and paints, gradients if asked for, and the edges as resvg draws them.

The result is the fitted drawing or the one at the start, whichever file resvg draws better.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene, over_white
from warpvec.polish.drawn_rounds import polish_as_drawn
from warpvec.polish.gradient_rounds import polish_with_gradients
from warpvec.polish.rounds import Rounds
from warpvec.rendering.launch import resolve_device
from warpvec.watch.watch import Watch


def polish_drawing(
    start: Scene,
    encoding: Encoding,
    watch: Watch,
    iterations: int,
    *,
    free: bool = False,
    locked: Tensor | None = None,
    exact: bool = True,
) -> Drawing:
    """Fit ``start``, in pixels of the picture, and return it or what was fitted, whichever is better.

    If the picture states a blur, the drawing is blurred by it before it is compared with the picture.

    If the settings ask for opaque paths, ``start`` is made opaque before; the file may then be worse than the drawing
    was.

    Args:
        start: the drawing to begin with.
        encoding: how the drawing becomes a file; its settings are those of the fit.
        watch: progress, stop, clock and history of the run.
        iterations: most iterations.
        free: as in `warpvec.polish.polish.polish`.
        locked: paths [N] (bool) that keep their form and paint; None for none.
        exact: as in `Rounds`.
    """
    settings, picture = encoding.settings, encoding.picture
    device = resolve_device(settings.device)
    begun = _with_opacity(_on_canvas(start.scaled(*picture.reduction), picture.is_transparent), settings.opacity)
    with watch:
        target = Target(torch.from_numpy(picture.reduced), settings, device, picture.blur)
        rounds = Rounds(target, settings, watch, iterations, free, locked, exact)
        fitted = polish_with_gradients(begun, rounds) if settings.gradients else rounds.polished(begun)
        drawing = polish_as_drawn(Drawing.of(fitted, encoding, device), rounds)
    first = Drawing.of(begun, encoding, device)
    return drawing if drawing.psnr_as_fitted >= first.psnr_as_fitted else first


def drawing_as_read(start: Scene, encoding: Encoding) -> Drawing:
    """Return ``start``, in pixels of the picture, as it was read, with opaque paths if the settings ask for these.

    The file keeps its canvas, and states settings only if the given file did.
    """
    picture, device = encoding.picture, resolve_device(encoding.settings.device)
    encoding = replace(encoding, picture=replace(picture, reduced=picture.pixels))
    if encoding.metadata is None:
        encoding = replace(encoding, options=replace(encoding.options, no_metadata=True))
    return Drawing.of(_with_opacity(start, encoding.settings.opacity), encoding, device)


def _on_canvas(scene: Scene, transparent: bool) -> Scene:
    """Return ``scene`` without a canvas for a transparent picture, else with one."""
    if transparent:
        return replace(scene, background=torch.zeros_like(scene.background), transparent=True)
    return over_white(scene)


def _with_opacity(scene: Scene, opacity: str) -> Scene:
    """Return ``scene`` with opaque paths if the setting ``opacity`` asks for them."""
    if opacity != "opaque":
        return scene
    gradients = None if scene.gradients is None else scene.gradients.opaque()
    return replace(scene, opacity=torch.ones_like(scene.opacity), gradients=gradients)

"""Fit the stroked circles of a drawing to a picture that was drawn as resvg and browsers draw strokes.

They draw the sides of a curved stroke by chords, which lie up to an eighth of a pixel inside of a circle. A fit by
exact areas takes that for a smaller radius: a circle of 150 px and a width of 24 px, drawn by resvg or Chromium, is
0.1 px smaller, which a cutter sees. Which of the two the picture has, the picture says itself.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.drawing.drawing import Drawing
from warpvec.fit.target import Target
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE
from warpvec.geometry.scene import Scene, over_white
from warpvec.image.metrics import psnr
from warpvec.polish.drawn_rounds import as_fitted, is_comparable, plain_file
from warpvec.polish.rounds import Rounds
from warpvec.rendering.draw import draw_8_bits
from warpvec.watch.watch import Watch

ROUNDS, ITERATIONS = 2, 12
"""Rounds, and most iterations of each: the second one knows how the circles of the first are drawn."""


def with_drawn_circles(drawing: Drawing, watch: Watch) -> Drawing:
    """Return ``drawing`` with stroked circles and ellipses whose file in pixels, by resvg, is the picture.

    If exact areas explain the picture better, it stays as it is, and so does one of a picture that is transparent,
    was fitted in a smaller copy, or whose damage was undone. Only places, sizes and widths of the circles move.
    """
    picture, is_circle = drawing.encoding.picture, _stroked_circles(drawing.fitted)
    if not bool(is_circle.any()) or not is_comparable(picture) or picture.is_damage_undone or watch.is_over():
        return drawing
    found = _fitted(drawing, watch, ~is_circle)
    return found if plain_file(found).psnr > _psnr_by_areas(drawing) else drawing


def _fitted(drawing: Drawing, watch: Watch, locked: Tensor) -> Drawing:
    """Return ``drawing`` with paths but the ``locked`` ones [N] fitted as resvg draws them; their colours stay."""
    settings, first = drawing.encoding.settings, drawing.fitted
    plain = Target(torch.from_numpy(drawing.encoding.picture.reduced), settings, "cpu")
    rounds = Rounds(plain, settings, watch, watch.iterations + ROUNDS * ITERATIONS, locked=locked)
    for _ in range(ROUNDS):
        target = Target(as_fitted(drawing, plain), settings, "cpu")
        scene = rounds.polished(over_white(drawing.fitted), ITERATIONS, target)
        drawing = drawing.with_fitted(replace(first, segments=scene.segments, forms=scene.forms, strokes=scene.strokes))
    return drawing


def _psnr_by_areas(drawing: Drawing) -> float:
    picture, threads = drawing.encoding.picture, drawing.encoding.settings.threads
    return psnr(draw_8_bits(over_white(drawing.scene), picture.height, picture.width, threads), picture.pixels)


def _stroked_circles(scene: Scene) -> Tensor:
    """Return which paths [N] are stroked circles or ellipses."""
    if scene.forms is None or scene.strokes is None:
        return torch.zeros(len(scene), dtype=torch.bool)
    is_round = (scene.forms.kind == CIRCLE) | (scene.forms.kind == ELLIPSE)
    return is_round & scene.strokes.is_stroked

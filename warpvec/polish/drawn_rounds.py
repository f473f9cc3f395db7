"""Polish a drawing on with the edges that resvg draws, which differ a little from exact areas.

resvg draws an edge with few samples a pixel. The difference to exact areas is about 50 dB, so it counts where a drawing
is nearly as good. It hardly changes with the small moves that are left, so the fit goes on with the image minus it.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.drawing.drawing import Drawing
from warpvec.drawing.file_options import DEFAULT_FILE_OPTIONS
from warpvec.fit.target import Target
from warpvec.geometry.scene import over_white
from warpvec.image.picture import Picture
from warpvec.polish.rounds import Rounds
from warpvec.rendering.draw import draw_exactly
from warpvec.svg.measure import draw_like

ROUNDS, ITERATIONS = 8, 12
"""Most rounds, and the iterations of each. On sixteen tracings three rounds gain 0.4 dB on average, the first one 0.2.
On drawings with strokes, whose sides resvg approximates, eight rounds gain 0.5 dB more."""

GAIN_MIN = 0.01
"""Gain in dB below which a round is the last one, from the third on: the second may undo what the first moved."""


def polish_as_drawn(drawing: Drawing, rounds: Rounds) -> Drawing:
    """Return the best file of some rounds after ``drawing``, or ``drawing`` if it is better than theirs.

    It does nothing if no iterations are left, or if the picture was reduced or is transparent.
    """
    picture = drawing.encoding.picture
    if not is_comparable(picture):
        return drawing
    best, last = drawing, drawing
    for number in range(ROUNDS):
        if not rounds.are_left:
            break
        target = Target(as_fitted(last, rounds.target), rounds.config, rounds.target.device, picture.blur)
        last = drawing.with_fitted(rounds.polished(last.fitted, ITERATIONS, target))
        gain = last.psnr_as_fitted - best.psnr_as_fitted
        if gain > 0.0:
            best = last
        if rounds.watch.is_stopped() or (number >= 2 and gain < GAIN_MIN):
            break
    return best


def is_comparable(picture: Picture) -> bool:
    """Return whether a ``picture`` is opaque and fitted at its own size, so that its file has the pixels of the fit."""
    return picture.reduced.shape == picture.pixels.shape and not picture.is_transparent


def as_fitted(drawing: Drawing, target: Target) -> Tensor:
    """Return the picture minus the difference between the plain file of ``drawing`` and the exact areas of its paths.

    The difference is as blurred as the picture of ``target``.
    """
    encoding, picture = drawing.encoding, drawing.encoding.picture
    plain = plain_file(drawing)
    drawn = torch.from_numpy(draw_like(plain.text, picture.pixels)).float() / 255.0
    scene = over_white(plain.scene)
    exact = torch.from_numpy(draw_exactly(scene, picture.height, picture.width, encoding.settings.threads))
    difference = drawn - exact
    return torch.from_numpy(picture.reduced) - (difference if target.blur is None else target.blur(difference))


def plain_file(drawing: Drawing) -> Drawing:
    """Return ``drawing`` as a file in pixels, without what the options of its own file change."""
    return Drawing.of(drawing.fitted, replace(drawing.encoding, options=DEFAULT_FILE_OPTIONS), drawing.device)

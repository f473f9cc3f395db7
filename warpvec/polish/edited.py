"""Fit an edited drawing to its picture again: its paths stay, and deleted parts of a photo are filled."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.drawing.given import encoding_like, place_on_picture, precision_of, read_drawing
from warpvec.errors import InputError
from warpvec.fit.placement import colors_at
from warpvec.geometry.circles import circle_points
from warpvec.geometry.joints import with_lines
from warpvec.geometry.scene import Scene, over_white
from warpvec.polish.erasing import hole_of
from warpvec.polish.whole_drawing import polish_drawing
from warpvec.svg.measure import file_facts
from warpvec.svg.read import LoadedSvg
from warpvec.watch.watch import Watch

BY_HAND: dict[str, Any] = {"edited": True}
"""What a file states that goes on from a drawing without settings; from others, it has theirs."""

ITERATIONS = 300
"""Most iterations. A drawing whose edits are small ends earlier."""

FILLED_MAX = 64
"""Most paths that are added where others were deleted: what is filled in is smooth."""

SEGMENTS = 4
"""Cubics of such a path, those of the fit of a photo."""

OVERLAP = 1.3
"""Radius of the added circles, in those of circles that would have the area of the hole together."""

CANDIDATES_MAX = 4000
"""Most pixels of the hole that are looked at for centres of circles."""


@dataclass(frozen=True)
class Edited:
    """An edited drawing.

    Attributes:
        text: its SVG.
        locked: places of shapes in the text, whose paths keep their form and paint.
        filled: SVG text of deleted shapes that new paths are to fill; None for none.
        is_photo: whether it is a drawing of a photo. Its paths overlap and touch everywhere, so that nearly each
            Gauss-Newton step would fold some: 100 paths of a photo took three minutes, and take five seconds by
            gradients.
    """

    text: str
    locked: tuple[int, ...] = ()
    filled: str | None = None
    is_photo: bool = False


def fit_again(edited: Edited, usual: Encoding, watch: Watch) -> tuple[Drawing, Tensor]:
    """Fit the paths of an edited drawing to its picture, without the deleted shapes.

    Args:
        edited: the drawing.
        usual: the usual encoding of a drawing of the picture, with the settings of the fit.
        watch: progress, stop, clock and history of the run.

    Returns:
        The drawing, and the mask [N] of the locked ones of its fitted paths.

    Raises:
        InputError: the drawing cannot be read, or has no shape at one of the locked places.
    """
    data, picture, settings = edited.text.encode(), usual.picture, usual.settings
    given = read_drawing(data)
    scene = with_lines(place_on_picture(given, picture))
    locked = _locked(edited, given)
    if not picture.is_transparent:
        scene = over_white(scene)
    if edited.filled is not None:
        hole, count = hole_of(picture.pixels, edited.filled), file_facts(edited.filled)["paths"]
        scene = scene.joined(_filling(hole, picture.pixels, count, scene))
        locked = torch.cat([locked, torch.zeros(len(scene) - len(locked), dtype=torch.bool)])
    precision = precision_of(given)
    precision = settings.precision if precision is None else precision
    settings = replace(settings, curves=max(1, len(scene)), precision=precision)
    encoding = encoding_like(given, data, replace(usual, settings=settings))
    encoding = replace(encoding, title=picture.title, metadata=encoding.metadata or BY_HAND)
    held = locked if bool(locked.any()) else None
    return polish_drawing(scene, encoding, watch, ITERATIONS, locked=held, exact=not edited.is_photo), locked


def _locked(edited: Edited, given: LoadedSvg) -> Tensor:
    """Return the mask [N] of the paths of the drawing, read as ``given``, that are of locked shapes."""
    count = len(given.scene) if given.shape_count is None else given.shape_count
    last = max(edited.locked, default=-1)
    if last >= count:
        raise InputError("locked", f"must be places below {count}, the number of shapes", str(last), "reload the page")
    sources = torch.arange(len(given.scene)) if given.sources is None else torch.tensor(given.sources)
    return torch.isin(sources, torch.tensor(edited.locked, dtype=torch.int64))


def _filling(hole: NDArray[np.bool_], photo: NDArray[np.float32], count: int, scene: Scene) -> Scene:
    """Return ``count`` circles that cover the ``hole`` [h, w] together, in the colours of ``photo`` there."""
    center = torch.from_numpy(_spread(hole, min(count, FILLED_MAX)))
    radius = OVERLAP * float(np.sqrt(hole.sum() / (np.pi * len(center))))
    color = colors_at(torch.from_numpy(np.ascontiguousarray(photo[..., :3])), center)
    generation = torch.full((len(center),), int(scene.generation.max()) + 1)
    circles = circle_points(center, torch.full((len(center),), radius), SEGMENTS)
    return Scene.uniform(circles, color, torch.ones(len(center)), scene.background, generation)


def _spread(hole: NDArray[np.bool_], count: int) -> NDArray[np.float32]:
    """Return ``count`` centres [K, 2] of pixels in the ``hole`` [h, w], each as far from those before as can be."""
    rows, columns = np.nonzero(hole if hole.any() else np.ones_like(hole))
    step = max(1, len(rows) // CANDIDATES_MAX)
    points = np.stack([columns[::step], rows[::step]], 1).astype(np.float32) + 0.5
    chosen = [int(((points - points.mean(0)) ** 2).sum(1).argmin())]
    distance = ((points - points[chosen[0]]) ** 2).sum(1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, ((points - points[chosen[-1]]) ** 2).sum(1))
    return points[chosen]

"""Say a shape in other words, as the page asks: a stroke as its outline and back, a form in place of an outline.

A shape comes and goes as the text of a small SVG, in pixels of its own canvas. Its paint does not matter, as the page
keeps it: only the shapes of the answer, and the width, ends and joins of its strokes, are used.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import torch

from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.outline_samples import control_points, cubic_points, cubic_slopes
from warpvec.flat.strokes.recognition import find_strokes
from warpvec.flat.strokes.stroke import with_strokes
from warpvec.geometry.forms.form import Fitted
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, RECT, ROUND_RECT, form_of
from warpvec.geometry.loops import Outline, make_scene
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.image.read import read_image
from warpvec.image.write import png_bytes
from warpvec.svg.foreign.shapes import Loop
from warpvec.svg.foreign.skia import Combiner, load_skia
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.stroke_outlines import without_strokes
from warpvec.svg.write import write_svg
from warpvec.watch.watch import Watch

SIDE_MAX = 2048
"""Longest side in pixels of the canvas of a shape; the page sends at most half of it."""

SHAPES_MAX = 64
"""Most shapes of a request: to find a stroke takes seconds."""

PRECISION = 4
"""Decimals of the answer. The page scales it back, and rounds it when it saves."""

STROKE_DETAIL = 0.2
"""Root mean square in pixels by which an outline may move to become a stroke. That of flat art is half of it, but there
the picture is exact, and here the outline has been rounded and perhaps edited by hand."""

SAME_DISTANCE = 0.05
"""Two forms whose largest distances from a shape differ by less, in pixels, are as good: the one of fewer numbers is
taken."""

CUT = "cut"
"""What the page asks for to erase a part of shapes."""

_SAMPLES = 16
"""Points of each segment to which a form is fitted."""

_LOCK = threading.Lock()
"""One request at a time: fits share the threads of the machine."""


class Reshaped(NamedTuple):
    """A shape in other words.

    Attributes:
        svg: what replaces it, on the same canvas.
        distance: largest distance of the shape from its form in pixels; None for strokes and outlines.
    """

    svg: str
    distance: float | None = None


def reshape(texts: list[str], to: str) -> list[dict[str, Any]]:
    """Return the answer for each shape: `Reshaped` as a dictionary, or ``refused`` with the reason.

    Args:
        texts: an SVG of one shape each.
        to: a key of ``WAYS``, or ``CUT``: then each shape is followed by the area to take out, on the same canvas.

    Raises:
        InputError: ``to`` is unknown, there are too many shapes, a text is no SVG, or a package is missing.
    """
    if to not in (*WAYS, CUT):
        raise InputError("to", f"must be one of {', '.join((*WAYS, CUT))}", repr(to), "reload the page")
    if len(texts) > SHAPES_MAX:
        raise InputError("shapes", f"must be at most {SHAPES_MAX} at a time", str(len(texts)), "select fewer")
    with _LOCK:
        if to == CUT:
            return _cut_all(texts)
        return [_answer(text, WAYS[to]) for text in texts]


def _cut_all(texts: list[str]) -> list[dict[str, Any]]:
    """Cut an area out of each shape, which stands before it in ``texts``.

    An answer has the rest of the shape as "svg", or says that the shape is "gone" or the "same".
    """
    if load_skia() is None:
        rule = "need skia-pathops to be cut, which is not installed"
        raise InputError("shapes", rule, str(len(texts) // 2), "pip install 'warpvec[refine]'")
    combiner = Combiner()
    return [_cut(*pair, combiner) for pair in zip(texts[::2], texts[1::2], strict=False)]


def _cut(text: str, area: str, combiner: Combiner) -> dict[str, Any]:
    scene, cutter = (read_svg(each).scene for each in (text, area))
    if len(scene) != 1 or len(cutter) != 1:
        return {"refused": "A shape of several parts in one cannot be cut."}
    whole = without_strokes(scene.outlined())
    one, two = _loops(whole), _loops(cutter.outlined())
    common = combiner.common(one, two)
    rest = combiner.without(one, two)
    if common is None or rest is None:
        return {"refused": "A shape is too intricate to be cut."}
    if not common:
        return {"same": True}
    if not rest:
        return {"gone": True}
    points = np.concatenate([loop.points for loop in rest])
    counts, is_line = tuple(len(loop.is_line) for loop in rest), np.concatenate([loop.is_line for loop in rest])
    drawn = make_scene([Outline(points, (0.0, 0.0, 0.0), 1.0, 0, counts, is_line)], (1.0, 1.0, 1.0))
    return {"svg": _written(drawn, text)}


def _loops(scene: Scene) -> list[Loop]:
    """Return the loops of a scene of one filled path."""
    rows, is_line = scene.segments.double().numpy(), scene.structure.lines.numpy()
    bounds = pairwise(scene.structure.loop_first_segment.tolist())
    return [Loop(rows[start:stop].reshape(-1, 2), is_line[start:stop]) for start, stop in bounds]


def _answer(text: str, way: Callable[[str, Scene], Reshaped | str]) -> dict[str, Any]:
    loaded = read_svg(text)
    if max(loaded.width, loaded.height) > SIDE_MAX:
        raise InputError("SVG", f"must have sides of at most {SIDE_MAX} pixels", text[:40], "reload the page")
    if len(loaded.scene) != 1:
        return {"refused": "A shape of several parts in one cannot be changed so."}
    found = way(text, loaded.scene)
    return {"refused": found} if isinstance(found, str) else found._asdict()


def _written(scene: Scene, text: str) -> str:
    loaded = read_svg(text)
    size = round(loaded.width), round(loaded.height)
    return write_svg(scene, *size, precision=PRECISION, closes_exactly=loaded.closes_exactly)


# Strokes


def to_outline(text: str, scene: Scene) -> Reshaped | str:
    """Return the filled outline of a stroke."""
    if scene.strokes is None or not bool(scene.strokes.is_stroked.any()):
        return "This shape is filled: it is an outline already."
    return Reshaped(_written(without_strokes(scene.outlined()), text))


def to_stroke(text: str, scene: Scene) -> Reshaped | str:
    """Return the strokes that an outline is, if the recognition of flat art accepts it."""
    if scene.strokes is not None and bool(scene.strokes.is_stroked.any()):
        return "This shape is a stroke already."
    image = torch.from_numpy(read_image(png_bytes(draw(text)), name="shape"))
    config = FitConfig(strokes="all")
    given = scene.outlined()
    white = replace(given, background=torch.ones(3), transparent=False, generation=torch.arange(len(given)))
    apart, found = find_strokes(white, Critic(image, config), Watch(), STROKE_DETAIL, len(white))
    if not found:
        return "This shape is no stroke: no line of one width draws it with fewer numbers."
    drawn = with_strokes(apart, found)
    return Reshaped(_written(replace(drawn, generation=given.generation[drawn.generation % len(given)]), text))


# Forms


def to_form(words: str, *kinds: int) -> Callable[[str, Scene], Reshaped | str]:
    """Return the way to the nearest form of one of these ``kinds``, those of fewer numbers first; ``words`` name it."""

    def way(text: str, scene: Scene) -> Reshaped | str:
        if scene.structure.loop_count != 1:
            return "This shape has more than one outline, and a form has one. For a ring try Outline to stroke."
        fits = {(kind, level): _fitted(scene, kind, level) for level in (True, False) for kind in kinds}
        found = {key: fit for key, fit in fits.items() if fit is not None}
        if not found:
            return f"This shape is too unlike {words}."
        nearest = min(fit.distance for fit in found.values())
        (kind, _), fit = next(item for item in found.items() if item[1].distance <= nearest + SAME_DISTANCE)
        return Reshaped(_written(_with_form(scene, kind, fit), text), fit.distance)

    return way


def _fitted(scene: Scene, kind: int, is_level: bool) -> Fitted | None:
    """Return the form nearest to a scene of one loop."""
    control = control_points(scene)
    if scene.structure.is_open is not None and bool(scene.structure.is_open[0]):
        control = control[:-1]  # the last row is only the end
    t = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    lengths = np.linalg.norm(cubic_slopes(control, t), axis=-1)
    return form_of(kind).fit(cubic_points(control, t).reshape(-1, 2), lengths.reshape(-1), is_level=is_level)


def _with_form(scene: Scene, kind: int, fit: Fitted) -> Scene:
    form, parameters = form_of(kind), torch.from_numpy(fit.parameters)[None]
    structure = Structure.of_loops([[form.row_count]], torch.tensor(form.is_line) if any(form.is_line) else None)
    drawn = replace(scene.outlined(), segments=form.segments(parameters)[0].to(scene.segments), structure=structure)
    return drawn.with_forms(Forms(torch.tensor([kind], dtype=torch.int32), parameters.to(scene.segments)))


WAYS: Mapping[str, Callable[[str, Scene], Reshaped | str]] = {
    "outline": to_outline, "stroke": to_stroke,
    "circle": to_form("a circle", CIRCLE), "ellipse": to_form("an ellipse", ELLIPSE),
    "rect": to_form("a rectangle", RECT, ROUND_RECT),
}  # fmt: skip
"""What the page can ask for -> the function that takes a text and its scene, and returns the answer or why not."""

"""Find the straight thin lines and the dots of a drawing, and the picture without them.

A staff, a table, graph paper or a hatch is a set of equal lines that go straight through all that they cross. Traced by
regions, each would be cut into the sides of its meshes, and one thinner than a pixel would have no region. So the lines
are found first, on the paper, and the picture without them is drawn as if they were not there.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import torch
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Integers, Mask
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.flat.lines.line import DrawnLine, scene_of
from warpvec.flat.simplification.outline_samples import top_paths
from warpvec.flat.strokes.line_fitting import Rows
from warpvec.flat.thin_lines.dashes import without_dashes
from warpvec.flat.thin_lines.dots import without_dots
from warpvec.flat.thin_lines.following import ThinLine, follow_lines
from warpvec.flat.thin_lines.grounds import Grounds, grounds_of, without_lines
from warpvec.flat.thin_lines.looks import EqualLines, equal_lines
from warpvec.flat.thin_lines.standing import Standing, places_of, standing
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import BUTT
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg

_END_REACH = 1.5
"""Largest distance in pixels of an end from a line on which it lies."""


class PlacedLines(NamedTuple):
    """Lines, a path for equal ones of one direction, and x and y [n, 2] where they are seen."""

    scene: Scene
    places: Floats

    def scaled(self, x_factor: float, y_factor: float) -> PlacedLines:
        """Return the lines in another copy of the picture."""
        return PlacedLines(self.scene.scaled(x_factor, y_factor), self.places * [x_factor, y_factor])

    def within(self, scene: Scene, height: int, width: int) -> Scene:
        """Return ``scene``, of a picture of this size, with the lines right above the paths that show them.

        A path shows the lines if they are seen in most of the pixels where they cross it.
        """
        if not len(self.scene) or not len(scene):
            return scene.joined(self.scene)
        is_seen, (x, y) = np.zeros((height, width), bool), np.floor(self.places).astype(np.int64).T
        is_seen[y, x] = True
        is_line = _layer(self.scene, height, width)[..., 3] > 0.0
        plain = replace(scene, opacity=torch.ones(len(scene)), softness=None)
        path = top_paths(plain, height, width, None) + 1
        seen, whole = (
            np.bincount(path[mask], minlength=len(scene) + 1)
            for mask in (is_line & ndimage.binary_dilation(is_seen, np.ones((3, 3))), is_line)
        )
        top = int(np.flatnonzero((2 * seen > whole) | (np.arange(len(whole)) == 0)).max())
        rows = torch.arange(len(scene))
        return scene.select(rows[:top]).joined(self.scene).joined(scene.select(rows[top:]))


class ThinLines(NamedTuple):
    """The straight thin lines and the dots of a picture.

    Attributes:
        lines: the lines on the paper. Equal lines of one direction are one path, and so is each dashed line.
        above: the lines that lie on shapes, too.
        dots: circles.
        dashed: the dashes of each dashed line.
        ground: the picture without them [h, w, 3].
    """

    lines: PlacedLines
    above: PlacedLines
    dots: Scene
    dashed: list[list[DrawnLine]]
    ground: Floats32

    def scaled(self, x_factor: float, y_factor: float, ground: Floats32) -> ThinLines:
        """Return the lines and dots in another copy of the picture, which without them is ``ground`` [h, w, 3].

        The lines of `dashed` stay as they are.
        """
        lines, above = (each.scaled(x_factor, y_factor) for each in (self.lines, self.above))
        return self._replace(lines=lines, above=above, dots=self.dots.scaled(x_factor, y_factor), ground=ground)

    def with_scene(self, scene: Scene) -> Scene:
        """Return ``scene``, a drawing of the ground, with the lines right above what they lie on, and dots on top."""
        height, width = self.ground.shape[:2]
        for each in (self.lines, self.above):
            scene = each.within(scene, height, width)
        return scene.joined(self.dots)


def find_thin_lines(image: Floats32, dot_count_max: int, *, has_lines: bool = True) -> ThinLines | None:
    """Return the straight thin lines and dots of an opaque ``image`` [h, w, 3], sRGB-encoded in [0, 1]; None for none.

    Args:
        image: the picture.
        dot_count_max: as the ``count_max`` of `without_dots`.
        has_lines: whether to look for lines, too.
    """
    levels = np.rint(255.0 * image.astype(np.float64))
    colors, counts = _frequent_colors(levels)
    inks = colors[counts >= THIN_LINES.ink_pixels_min]
    papers = colors[counts >= THIN_LINES.paper_share_min * levels[..., 0].size]
    if not len(papers):
        return None
    paper = colors[counts.argmax()]
    levels, dashed = without_dashes(levels, paper, inks)
    levels, dots = without_dots(levels, papers, inks, dot_count_max)
    grounds = grounds_of(levels) if has_lines else None
    found, above = list[EqualLines](), PlacedLines(scene_of([]), np.zeros((0, 2)))
    if grounds is not None:
        found, above = _lines(levels, papers, paper, inks, grounds)
    if not (found or len(above.scene) or len(dots) or dashed):
        return None
    if grounds is not None and len(above.scene):
        levels = without_lines(levels, _layer(above.scene, *levels.shape[:2]), grounds)
    lines = _drawn_lines(found)
    in_ink = [[dash for dash, is_in in zip(*each, strict=True) if is_in] for each in dashed]
    removed = lines + [each for each in in_ink if each]
    ground = _without(levels, paper, scene_of(removed)) if removed else (levels / 255.0).astype(np.float32)
    dashes = [each.dashes for each in dashed]
    strokes = scene_of(lines + dashes)
    return ThinLines(PlacedLines(strokes, _seen(strokes, image, ground)), above, dots, dashes, ground)


def _lines(
    levels: Floats, papers: Floats, paper: Floats, inks: Floats, grounds: Grounds
) -> tuple[list[EqualLines], PlacedLines]:
    """Return the equal lines that lie on ``paper`` [3] alone, or below shapes, and those that lie on shapes."""
    below, free = list[EqualLines](), list[EqualLines]()
    above, known = list[Standing](), list[ThinLine]()
    for each in sorted(papers, key=lambda color: float(np.abs(color - paper).max())):
        is_paper = bool((each == paper).all())
        lines = [line for line in follow_lines(levels, each, grounds) if not _is_on(line, known)]
        for equal in equal_lines(lines, each, inks):
            seen = standing(equal, levels, each, grounds)
            if len(seen.places) or not (is_paper or seen.is_hidden):
                above.append(seen if is_paper else seen._replace(places=places_of(equal, levels, paper, grounds)))
            elif is_paper:
                (below if seen.is_hidden else free).append(equal)
            known += seen.equal.lines
    if not above:
        return _joined(below + free), PlacedLines(scene_of([]), np.zeros((0, 2)))
    joined = _joined(below + free + [seen.equal for seen in above])
    places = np.concatenate([seen.places for seen in above])
    return joined[: len(below)], PlacedLines(scene_of(_drawn_lines(joined[len(below) :])), places)


def _is_on(line: ThinLine, others: list[ThinLine]) -> bool:
    """Return whether ``line`` lies on one of the ``others`` of its direction."""
    middle = (line.top + line.bottom) / 2.0
    x = line.start + line.slope * middle
    return any(other.is_level == line.is_level and other.has(x, middle) for other in others)


def _drawn_lines(found: list[EqualLines]) -> list[list[DrawnLine]]:
    return [[_drawn(line, each) for line in each.lines] for each in found]


def _frequent_colors(levels: Floats) -> tuple[Floats, Integers]:
    """Return the colours [n, 3] of ``levels`` [h, w, 3], and how many pixels have each [n]."""
    codes, counts = np.unique((levels @ [65536.0, 256.0, 1.0]).astype(np.int64), return_counts=True)
    return np.stack([codes >> 16, codes >> 8 & 255, codes & 255], 1).astype(np.float64), counts


def _drawn(line: ThinLine, equal: EqualLines) -> DrawnLine:
    start, end = line.ends
    control = np.array([[start, start + (end - start) / 3.0, start + (end - start) * 2.0 / 3.0], [end, end, end]])
    red, green, blue = (equal.color / 255.0).tolist()
    return DrawnLine(Rows(control, np.array([True, True]), True), equal.width, BUTT, color=(red, green, blue))


def _joined(found: list[EqualLines]) -> list[EqualLines]:
    """Return lines whose ends within a pixel and a half of another line lie on it: corners of frames and tables."""
    every = [line for each in found for line in each.lines]
    return [EqualLines([_on_others(line, every) for line in each.lines], each.color, each.width) for each in found]


def _on_others(line: ThinLine, others: list[ThinLine]) -> ThinLine:
    """Return ``line`` with each end on the nearest of the ``others`` that cross it there."""
    places = []
    for other in others:
        # x = a + b y and y = c + d x
        y = (other.start + other.slope * line.start) / max(1.0 - other.slope * line.slope, 1e-9)
        x = line.start + line.slope * y
        if other.is_level != line.is_level and other.top - _END_REACH <= x <= other.bottom + _END_REACH:
            places.append(y)
    if not places:
        return line
    near = np.array(places)
    nearest = (float(near[np.abs(near - end).argmin()]) for end in (line.top, line.bottom))
    ends = zip(nearest, (line.top, line.bottom), strict=True)
    top, bottom = (place if abs(place - end) <= _END_REACH else end for place, end in ends)
    return line._replace(top=top, bottom=bottom) if bottom > top else line


def _without(levels: Floats, paper: Floats, strokes: Scene) -> Floats32:
    """Return the picture ``levels`` [h, w, 3] without ``strokes`` on ``paper`` [3].

    Where it is paper with lines, the paper stays. Where a shape covers some of that, its share is what the picture
    differs from the paper with lines, over what the shape does. Where a line covers a pixel, its neighbours tell.
    """
    layer = _layer(strokes, *levels.shape[:2])
    alpha = layer[..., 3:] / 255.0
    shown = paper + alpha * (layer[..., :3] - paper)
    is_line = alpha[..., 0] > 0.0
    # In the picture, what differs from paper with lines is a shape.
    off = np.abs(levels - shown).max(2)
    contrast = np.abs(levels - paper).max()
    is_plain = off <= THIN_LINES.explained * contrast + 2.0
    shape = _strongest(levels - paper, ~is_line | ~is_plain) + paper
    step = shape - shown
    size = np.square(step).sum(2)
    share = ((levels - shown) * step).sum(2) / np.maximum(size, 1.0)
    found = np.where(is_plain[..., None], paper, paper + share.clip(0.0, 1.0)[..., None] * (shape - paper))
    result = np.where(is_line[..., None], found, levels)
    is_open = is_line & (alpha[..., 0] > 0.7) & ndimage.maximum_filter(~is_plain | (~is_line & (off > 2.0)), 3)
    is_shape = _filled(np.abs(result - paper).max(2) > 0.5 * np.abs(shape - paper).max(2), is_open)
    result[is_open] = np.where(is_shape[..., None], shape, paper)[is_open]
    result[_left_over(np.abs(result - paper).max(2) > 2.0, is_line)] = paper
    return (result / 255.0).astype(np.float32)


def _layer(strokes: Scene, height: int, width: int) -> Floats:
    """Return ``strokes`` as drawn on nothing [h, w, 4]."""
    return draw(write_svg(strokes, width, height), width, height, transparent=True).astype(np.float64)


def _seen(strokes: Scene, image: Floats32, ground: Floats32) -> Floats:
    """Return x and y [n, 2] of pixels of ``strokes`` in which an ``image`` [h, w, 3] is not its ``ground``."""
    if not len(strokes):
        return np.zeros((0, 2))
    difference = 255.0 * np.abs(image.astype(np.float64) - ground).sum(2)
    is_seen = (_layer(strokes, *image.shape[:2])[..., 3] > 0.0) & (difference >= THIN_LINES.contrast_min)
    places: Floats = np.argwhere(is_seen)[:, ::-1].astype(np.float64) + 0.5
    return places


def _left_over(is_shape: Mask, is_line: Mask) -> Mask:
    """Return the pixels [h, w] of specks that touch a line: what is left of its end."""
    labels, count = ndimage.label(is_shape, np.ones((3, 3)))
    areas = np.bincount(labels.ravel(), minlength=count + 1)
    touches = np.zeros(count + 1, bool)
    touches[np.unique(labels[ndimage.binary_dilation(is_line, np.ones((3, 3)))])] = True
    is_speck = touches & (areas <= THIN_LINES.speck_area)
    is_speck[0] = False
    return np.asarray(is_speck[labels])


def _strongest(residual: Floats, is_known: Mask) -> Floats:
    """Return the residual [h, w, 3] that is strongest of those known [h, w] within two pixels of each pixel."""
    size = np.where(is_known, np.square(residual).sum(2), 0.0)
    best, result = size.copy(), np.where(is_known[..., None], residual, 0.0)
    padded, sizes = np.pad(residual, ((2, 2), (2, 2), (0, 0))), np.pad(size, 2)
    height, width = size.shape
    for down in range(5):
        for right in range(5):
            window = slice(down, down + height), slice(right, right + width)
            is_better = sizes[window] > best
            best = np.where(is_better, sizes[window], best)
            result = np.where(is_better[..., None], padded[window], result)
    return result


def _filled(mask: Mask, is_open: Mask) -> Mask:
    """Return ``mask`` [h, w] with what most known neighbours say in pixels that are open [h, w]."""
    value, known = np.where(is_open, 0.0, mask), (~is_open).astype(np.float64)
    for _ in range(4):
        if known.all():
            break
        weight = ndimage.uniform_filter(known, 3, mode="nearest")
        mean = ndimage.uniform_filter(value * known, 3, mode="nearest")
        is_new = (known == 0.0) & (weight > 1e-6)
        value[is_new] = np.rint(mean / np.maximum(weight, 1e-6))[is_new]
        known[is_new] = 1.0
    return np.asarray(value > 0.5)

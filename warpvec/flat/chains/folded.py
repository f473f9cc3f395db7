"""Hold a sketch of halves at their axes, and unfold what was solved."""

from __future__ import annotations

import math

import numpy as np

from warpvec.arrays import Floats
from warpvec.flat.chains.parts import ARC, CUBIC, LINE
from warpvec.flat.chains.solve import Sketch
from warpvec.flat.chains.symmetry import Fold, mirrored

SQUARE_DEGREES = 8.0
"""Angle from a right one up to which a part that reaches the axis goes on smoothly in its mirror image. Points of
hearts and drops are sharper."""

TURN_MAX = math.radians(330.0)
"""Most that two halves of an arc may turn together to be one."""

Words = list[tuple[int, Floats]]
"""Parts of a loop: kinds and numbers."""


def hold_folds(sketch: Sketch, folds: dict[int, Fold], detail: float, middle: tuple[float, float]) -> None:
    """Hold the halves of ``sketch`` at their axes.

    Args:
        sketch: the sketch, in which nothing is held yet.
        folds: the folds by the numbers of their chains.
        detail: as in `find_relations`.
        middle: of the canvas. The axis of a drawing that is so near is there.
    """
    known: dict[int, int] = {}
    for number, fold in folds.items():
        if fold.shared and fold.axis in known:
            column = known[fold.axis]
        else:
            column = len(sketch.numbers)
            is_centred = fold.shared and abs(middle[fold.axis] - fold.place) <= detail
            place = middle[fold.axis] if is_centred else fold.place
            sketch.numbers = np.append(sketch.numbers, place)
            sketch.fixed.append(column)  # lines across an axis would let it slide
            if fold.shared:
                known[fold.axis] = column
        sketch.axes[number], sketch.folded[number] = column, fold.axis
        if fold.twin is None:
            _hold_half(sketch, number, fold, column)


def _hold_half(sketch: Sketch, number: int, fold: Fold, column: int) -> None:
    begin, end = sketch.ranges[number]
    for part, side in ((begin, 0), (end - 1, 1)):
        if abs(sketch.of(part)[2 * side + fold.axis] - fold.place) > 1e-6:
            continue  # the end of an open line
        columns = sketch.columns[part]
        sketch.at_axis.append((number, side))
        sketch.equal.append([int(columns[2 * side + fold.axis]), column])
        way = sketch.chains[number].after[0] if side == 0 else sketch.chains[number].before[-1]
        if abs(way[1 - fold.axis]) <= math.sin(math.radians(SQUARE_DEGREES)):
            sketch.square.append((part, side, fold.axis))
            if sketch.kind[part] == LINE:
                sketch.equal.append([int(columns[1 - fold.axis]), int(columns[3 - fold.axis])])


def words_of(sketch: Sketch, number: int) -> Words:
    """Return the parts of a chain as they were solved."""
    begin, end = sketch.ranges[number]
    return [(int(sketch.kind[part]), sketch.of(part).copy()) for part in range(begin, end)]


def image_of(words: Words, axis: int, place: float) -> Words:
    """Return the mirror image of parts, from its end to its start, which keeps the sense of rotation of a loop."""
    found: Words = []
    for kind, numbers in reversed(words):
        pairs = mirrored(numbers[: 8 if kind == CUBIC else 4].reshape(-1, 2), axis, place)
        order = [1, 0, 3, 2] if kind == CUBIC else [1, 0]
        found.append((kind, np.concatenate([pairs[order].ravel(), numbers[4:5] if kind == ARC else []])))
    return found


def unfolded(sketch: Sketch, number: int, fold: Fold) -> Words:
    """Return the parts of a loop of which one half was solved. What goes on over the axis is one part."""
    place = float(sketch.numbers[sketch.axes[number]])
    half = words_of(sketch, number)
    begin, end = sketch.ranges[number]
    image = image_of(half, fold.axis, place)
    is_square = {(part, side) for part, side, _ in sketch.square}
    ends_at_axis = (number, 1) in sketch.at_axis
    begins_at_axis = (number, 0) in sketch.at_axis
    if not ends_at_axis:  # from the axis to an open end
        return _chained(image, half, (begin, 0) in is_square)
    found = _chained(half, image, (end - 1, 1) in is_square)
    if begins_at_axis and (begin, 0) in is_square and len(found) > 1:
        last = _one(found[-1], found[0])
        found = found if last is None else [*found[1:-1], last]
    return found


def _chained(first: Words, second: Words, is_smooth: bool) -> Words:
    one = _one(first[-1], second[0]) if is_smooth else None
    return [*first, *second] if one is None else [*first[:-1], one, *second[1:]]


def _one(first: tuple[int, Floats], second: tuple[int, Floats]) -> tuple[int, Floats] | None:
    """Return one line for two, or one arc for two of a circle; None for other parts. The second follows the first."""
    (kind, a), (other, b) = first, second
    if kind != other or kind == CUBIC:
        return None
    if kind == LINE:
        return LINE, np.concatenate([a[:2], b[2:]])
    turn = 4.0 * (math.atan(a[4]) + math.atan(b[4]))
    if abs(turn) > TURN_MAX:
        return None
    return ARC, np.concatenate([a[:2], b[2:4], [math.tan(turn / 4.0)]])

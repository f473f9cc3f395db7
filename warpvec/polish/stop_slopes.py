"""The derivatives of the colours of a gradient of several stops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.gradients import Gradients
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import GAP_MIN, STOPS_MAX

Values = NDArray[np.float64]


class StopRow(NamedTuple):
    """The stops of one path: how many there are, their offsets [S] in order and their colours [S, 3]."""

    size: int
    offset: Values
    color: Values


def stop_rows(scene: Scene, gradients: Gradients) -> list[StopRow]:
    """Return the stops of each path of ``scene``, whose ``gradients`` have `Stops`."""
    stops = gradients.all_stops()
    colors = stops.colors(scene.color, gradients.end_color).double().cpu().numpy()
    offsets = stops.shown_offsets().double().cpu().numpy()
    rows = zip(stops.count.tolist(), offsets, colors, strict=True)
    return [StopRow(count, offset[:count], color[:count]) for count, offset, color in rows]


class StopSlopes(NamedTuple):
    """How the colour in M places depends on the stops of a path.

    Attributes:
        weight: share of each stop in the colour [S, M].
        by_place: change of the colour with the place along the gradient [M, 3].
        by_offset: change of the colour with each offset [S, M, 3].
    """

    weight: Values
    by_place: Values
    by_offset: Values


def slopes_of(row: StopRow, place: Values) -> StopSlopes:
    """Return the derivatives at the places [M] along the gradient of ``row``."""
    gap = np.diff(row.offset)
    steep = np.where(gap > GAP_MIN, 1.0 / np.maximum(gap, GAP_MIN), 0.0)
    rise = (place - row.offset[:-1, None]) * steep[:, None]
    share = np.where(place >= row.offset[1:, None], 1.0, rise.clip(0.0, 1.0))
    is_between = (place > row.offset[:-1, None]) & (place < row.offset[1:, None])
    slope = np.where(is_between, steep[:, None], 0.0)[..., None] * np.diff(row.color, axis=0)[:, None]
    ones, zeros = np.ones((1, len(place))), np.zeros((1, len(place), 3))
    weight = np.concatenate([ones, share]) - np.concatenate([share, 0.0 * ones])
    before, after = (share - 1.0)[..., None] * slope, -share[..., None] * slope
    by_offset = np.concatenate([before, zeros]) + np.concatenate([zeros, after])
    return StopSlopes(weight, slope.sum(0), by_offset)


def inner_color_index(path: int, stop: int, channel: int) -> int:
    """Return the index of a colour among the inner colours [N, STOPS_MAX - 2, 3]."""
    return ((STOPS_MAX - 2) * path + stop - 1) * 3 + channel

"""Tell which chains of a drawing the picture accepts: the exact error near them may hardly rise."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import torch

from warpvec.arrays import Floats, Floats32, Integers, Mask, counted
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.local_error import boxes_of, summed, sums_in_boxes
from warpvec.flat.simplification.outline_samples import control_points, cubic_points, cubic_slopes, segment_loops
from warpvec.geometry.meetings import meeting_rows
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.image.alpha import over_mattes
from warpvec.rendering.draw import draw_exactly

ALLOWED = 0.3
"""Move of an outline that is allowed, in the deviations of outlines that are there. More finds more arcs, and costs
PSNR where the artist drew none: with 0.3, 0.5 and 1, 25 icons of 512 px have 0.50, 0.68 and 0.71 of their arcs again,
and the 16 pictures of `bench/flat.py` 49.47, 49.27 and 48.99 dB; without chains 0.24 and 49.50 dB."""

FITTED = 1.0
"""The same move for parts of a drawing that has a grid, fitted without it: free curves follow errors of the picture's
renderer that arcs and lines cannot."""

FITTED_MIN = 0.07
"""Least such move in pixels: resvg draws half of 200 icons at least so far off exact coverage."""

ON_GRID = 0.13
"""Distance in pixels from the picture, as a root mean square, that an outline on the grid of its drawing may have, if
its parts fit. The grid is no free choice: by chance hardly any number lies on it. Renderers of pictures move outlines,
and free fits follow them: resvg draws 200 icons of lucide and material, at 512 px, up to 0.126 px off exact coverage,
half of them 0.07 px."""

SHIFT = 0.25
"""Move in pixels of the whole drawing that tells what a move of an outline costs, for strokes too."""

SPREAD_MIN = 0.02
"""Least deviation in pixels of outlines from a picture: rounding to 8 bits leaves some thousandths, and the corners of
outlines that are fitted to it a few hundredths."""

NOISE = 2e-3
"""Squared error, summed over channels, that never counts: that of some hundred pixels rounded to 8 bits."""

PIECES = 3
"""Pieces of a curve in drawings that are compared. Chords of whole curves lie up to a tenth of a pixel off them, which
is more than outlines that are right may be off; those of a third lie nine times closer."""

LEVEL = 1e-3
"""Rise in pixels of a level line: what relations leave."""

PEAK = 2.0
"""The same move of a part alone, in those of whole chains, as `STROKES.close_peak`."""


@dataclass(eq=False)
class Verdict:
    """What is known of a drawing before its chains change.

    Attributes:
        scene: the drawing.
        critic: judges it against the picture.
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
    """

    scene: Scene
    critic: Critic
    detail: float

    @cached_property
    def _before(self) -> Floats32:
        return self.critic.error(finely(self.scene))

    @cached_property
    def _worth(self) -> Floats32:
        """Rise of the squared error in each pixel [h, w] by a move of the outlines there by a pixel."""
        shown = self._shown(self.scene)
        moved = [self._shown(self.scene.moved(*way)) - shown for way in ((SHIFT, 0.0), (0.0, SHIFT))]
        mattes = 2.0 if self.scene.transparent else 1.0
        total: Floats32 = np.add(*(np.square(each).sum(-1) for each in moved)) / (SHIFT**2 * mattes)
        return total

    def _shown(self, scene: Scene) -> Floats32:
        """Return the image of ``scene`` [h, w, 3], or that over black and over white [h, w, 6] if it is transparent."""
        height, width = self.critic.image.shape[:2]
        return over_mattes(draw_exactly(scene, height, width, self.critic.config.threads))

    @cached_property
    def _summed_worth(self) -> Floats:
        return summed(self._worth)

    @cached_property
    def spread(self) -> float:
        """Deviation in pixels of the outlines from the picture, by the error that is left; at most the detail."""
        left = math.sqrt(float(self._before.sum()) / max(float(self._worth.sum()), 1e-9))
        return min(max(left, SPREAD_MIN), self.detail)

    @property
    def fitted(self) -> float:
        """Move of an outline that is allowed for fitted parts, in its `spread`."""
        return max(FITTED, FITTED_MIN / self.spread)

    def refused(
        self, new: Scene, changed: Mask, shares: Floats, is_on_grid: Mask | None = None, allowed: float = ALLOWED
    ) -> tuple[Mask, Floats]:
        """Return which of the ``changed`` loops [L] of ``new`` the picture refuses [L]; its loops are those of old.

        ``shares`` [L] tells how much of the error of a move that is ``allowed`` each loop may cause. Loops
        ``is_on_grid`` [L] may cause all that is allowed there.

        Also return the boxes [B, 2, 2], least and greatest coordinates, of segments near which the error rises most.
        """
        rise, count = summed(self.critic.error(finely(new)) - self._before), new.structure.loop_count
        on_grid = ON_GRID * (np.zeros(count) if is_on_grid is None else is_on_grid.astype(np.float64))
        detail, squares = allowed * self.spread, (allowed * self.spread) ** 2 * shares
        wrong, boxes = np.zeros(count, bool), list[Floats]()
        for scene in (self.scene, new):
            control, loop = control_points(scene), segment_loops(scene)
            reach = np.zeros(len(scene)) if scene.strokes is None else scene.strokes.width.double().numpy() / 2.0
            own = reach[scene.structure.segment_path.numpy()][:, None]
            number = np.arange(len(control))
            over = self._is_over(rise, control, loop, count, own, squares, on_grid)
            # A level edge is as far off everywhere as anywhere.
            peak = np.where(_are_level(control), 1.0, PEAK)
            peaks = self._is_over(rise, control, number, len(control), own, (PEAK * detail) ** 2, peak * on_grid[loop])
            wrong |= over
            wrong[loop[peaks]] = True
            worst = peaks | self._is_over(rise, control, number, len(control), own, squares[loop], on_grid[loop])
            boxes.append(np.stack([control.min(1), control.max(1)], 1)[worst])
        meets = segment_loops(new)[meeting_rows(new)]
        wrong[meets] |= ~self._met[meets]
        return wrong & changed, np.concatenate(boxes)

    @cached_property
    def _met(self) -> Mask:
        """Which loops [L] cross themselves or others of their path before."""
        found = np.zeros(self.scene.structure.loop_count, bool)
        found[segment_loops(self.scene)[meeting_rows(self.scene)]] = True
        return found

    @cached_property
    def _summed_before(self) -> Floats:
        return summed(self._before)

    def _is_over(
        self, rise: Floats, control: Floats, owner: Integers, count: int, reach: Floats, squares: Floats | float,
        on_grid: Floats,
    ) -> Mask:  # fmt: skip
        """Return which owners [count] of segments ``control`` [R, 4, 2] have more `summed` ``rise`` in their box.

        Allowed are ``squares`` px^2 of a move. If ``on_grid`` [count] is above 0, allowed is what the drawing has left
        of so many pixels, and a move by its `spread` at least.
        """
        low, high = boxes_of(np.stack([control.min(1) - reach, control.max(1) + reach], 1), owner, count)
        worth = sums_in_boxes(self._summed_worth, low, high)
        room = np.maximum(on_grid**2 * worth - sums_in_boxes(self._summed_before, low, high), self.spread**2 * worth)
        return sums_in_boxes(rise, low, high) > np.where(on_grid > 0.0, room, squares * worth) + NOISE


def _are_level(control: Floats) -> Mask:
    """Return which segments [R] with these points [R, 4, 2] are level or upright lines."""
    return np.ptp(control, axis=1).min(1) <= LEVEL


def finely(scene: Scene) -> Scene:
    """Return ``scene`` with each curve in ``PIECES``, so that the chords by which it is drawn lie closer to it."""
    scene = scene.outlined()
    t = np.linspace(0.0, 1.0, PIECES + 1)
    curves, structure = control_points(scene), scene.structure
    ends, slopes = cubic_points(curves, t), cubic_slopes(curves, t) / (3.0 * PIECES)
    pieces = np.stack([ends[:, :-1], ends[:, :-1] + slopes[:, :-1], ends[:, 1:] - slopes[:, 1:]], 2)
    is_whole = (structure.lines | structure.end_rows).numpy()
    counts = np.where(is_whole, 1, PIECES)
    number = counted(counts)
    row = np.repeat(np.arange(len(curves)), counts)
    stays = torch.from_numpy(is_whole[row])[:, None, None]
    rows = torch.where(stays, scene.segments.double()[row], torch.from_numpy(pieces[row, number]))
    of_loops = np.add.reduceat(counts, structure.loop_first_segment[:-1].long().numpy()).tolist()
    of_paths = [of_loops[a:b] for a, b in pairwise(structure.path_first_loop.tolist())]
    parted = Structure.of_loops(of_paths, structure.lines[row], structure.is_open)
    return replace(scene, segments=rows.to(scene.segments), structure=parted)

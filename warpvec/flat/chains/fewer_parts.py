"""Say outlines with fewer numbers where the exact error stays within a tolerance."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.config.fit_config import FitConfig
from warpvec.flat.chains.chain import Chain, Shown
from warpvec.flat.chains.saying import LoopRows, are_curves, are_ellipse, has_size, said_rows, with_rows
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.price import CUBIC, LINE, number_nats
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.local_error import errors_near
from warpvec.flat.simplification.outline_samples import control_points, segment_loops
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish
from warpvec.watch.decisions import are_wanted, box_of
from warpvec.watch.watch import Watch

SHARE = 0.4
"""Deviation of places, in moves that are allowed. A search by price sees the mean of a part; a fit afterwards takes
some of its error away. 16 pictures at 512 px with alpha have 49.7 dB, 43.2 at 4x and 1.05 times the designer's segments
with 0.4; 49.4, 42.9 and 1.02 with 0.5."""

ROUNDS = 6
"""Most times that parts are chosen. Later ones find nothing in most drawings."""


def with_fewer_parts(scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail) -> Scene:
    """Return ``scene`` with fewer lines and cubics, fitted to the image again.

    Each round chooses the parts of all outlines, fits the scene and takes the outlines back in which the exact squared
    error near a part rises by more than a move of the outline by ``detail`` would cost. These must be nearer there.
    Outlines that the picture does not show cost hardly anything.

    Args:
        scene: a scene of cubics, fitted to the image.
        critic: judges the changes against the image.
        watch: the watch over the run.
        detail: root mean square in pixels by which an outline may move.
    """
    if not len(scene):
        return scene
    work = _Work(critic, watch, detail, critic.error(scene), scene, set(range(scene.structure.loop_count)))
    for _ in range(ROUNDS):
        if not work.left | work.waiting or watch.is_over():
            break
        work.make_round()
    return work.scene


@dataclass(eq=False)
class _Work:
    """The work on one drawing.

    Attributes:
        critic, watch, detail: as in `with_fewer_parts`.
        before: squared error of the first scene [h, w].
        scene: the drawing so far.
        left: the loops that may be said with fewer numbers.
        firm: boxes [B, 2, 2] of loops in which they must be kept better.
        waiting: loops that the picture refused in a round that was no good. The next round is made without them.
    """

    critic: Critic
    watch: Watch
    detail: float
    before: Floats32
    scene: Scene
    left: set[int]
    firm: dict[int, Floats] = field(default_factory=dict)
    waiting: set[int] = field(default_factory=set)

    def make_round(self) -> None:
        """Choose the parts of the loops that are left, and take those that the picture accepts."""
        if not self.left:
            self.left, self.waiting = self.waiting, set()
        old = self.scene
        said = said_rows(self._chains(), SHARE * self.detail, number_nats(max(self.critic.image.shape[:2])))
        tried = {loop: rows for loop, rows in said.items() if has_size(rows[0], True) and _is_shorter(old, loop, rows)}
        self.left = set(tried)
        if not tried:
            return
        new = self._fitted(with_rows(old, tried))
        samples = self.critic.samples(new)
        allowed = self.critic.allowed(samples.worth, samples.moves(self.detail), SIMPLIFICATION.noise)
        rise = errors_near(samples.control, self.critic.error(new) - self.before)
        if are_wanted():
            self._note(new, tried, rise, allowed)
        loop = segment_loops(new)
        is_tried = np.isin(loop, list(tried))
        wrong = is_tried & (rise > allowed)
        self.scene = self._put_back(old, new, wrong, float(self.before.sum() + allowed.sum()))
        refused = set(np.unique(loop[wrong]).tolist())
        if self.scene is not old:
            self.left, self.waiting = self.left | self.waiting, set()
        elif refused:
            self.left, self.waiting = self.left - refused, self.waiting | refused
        else:
            self._hold(new, is_tried)

    def _put_back(self, old: Scene, new: Scene, wrong: Mask, error_max: float) -> Scene:
        """Return ``new`` with the outlines of ``old`` that have a segment that is ``wrong`` [R], which are held firmer.

        If that is worse than ``new``, which is good enough, nothing is put back: what is may no longer fit what has
        moved. If it is no good, all is.
        """
        self._hold(new, wrong)
        back = {loop: _rows_of(old, loop) for loop in np.unique(segment_loops(new)[wrong]).tolist()}
        mixed = with_rows(new, back) if back else new  # the critic knows the error of a scene that it has seen
        error, error_without = (float(self.critic.error(each).sum()) for each in (mixed, new))
        if error_without <= min(error, error_max):
            return new
        return mixed if error <= error_max else old

    def _chains(self) -> dict[int, Chain]:
        """Return the chain of each loop that is left, which is kept as well as the picture shows it."""
        samples, first = self.critic.samples(self.scene), self.scene.structure.loop_first_segment.tolist()
        is_hidden, moves = samples.visibility < SIMPLIFICATION.hidden_visibility, samples.moves(self.detail)[:, None]
        share, found = samples.visibility * (self.detail / moves) ** 2, dict[int, Chain]()
        for loop in sorted(self.left):
            start, stop = first[loop], first[loop + 1]
            rows = start + np.flatnonzero(are_curves(samples.control[start:stop]))
            if len(rows) and not are_ellipse(samples.control[rows]):
                tree, hidden = cKDTree(samples.points[rows].reshape(-1, 2)), is_hidden[rows].ravel()
                shown = Shown(tree, share[rows].ravel(), hidden)
                found[loop] = Chain.of(samples.control[rows], True, firm=self.firm.get(loop), shown=shown)
        return found

    def _fitted(self, scene: Scene) -> Scene:
        return polish(
            self.critic.target, scene, self.critic.config, self.watch.side_part(),
            iterations=SIMPLIFICATION.choice_iterations, values_exact_max=SIMPLIFICATION.values_exact_max,
            unseen=SIMPLIFICATION.unseen, tension=self.critic.tension(scene),
        ).scene  # fmt: skip

    def _hold(self, new: Scene, wrong: Mask) -> None:
        """Keep outlines better where segments [R] of ``new`` are ``wrong``."""
        control, loop = control_points(new)[wrong], segment_loops(new)[wrong]
        boxes = np.stack([control.min(1), control.max(1)], 1)
        for own in np.unique(loop).tolist():
            self.firm[own] = np.concatenate([self.firm.get(own, boxes[:0]), boxes[loop == own]])

    def _note(self, new: Scene, tried: dict[int, LoopRows], rise: Floats, allowed: Floats) -> None:
        """Note each loop that was said with fewer numbers, with the rise of its error and the one that is allowed."""
        loop, control = segment_loops(new), control_points(new)
        for own, (rows, is_line) in tried.items():
            segments = loop == own
            old, old_lines = _rows_of(self.scene, own)
            saved = _numbers(old_lines) - _numbers(is_line)
            cost = float(rise[segments].sum()), float(allowed[segments].sum())
            box = box_of(control[segments])
            self.critic.note("parts", box, f"{len(old)} segments", f"{len(rows)} segments", saved, cost)


def _rows_of(scene: Scene, loop: int) -> LoopRows:
    """Return the rows [S, 3, 2] of a loop, and which are lines [S]."""
    start, stop = scene.structure.loop_first_segment[loop : loop + 2].tolist()
    return scene.segments[start:stop].double().numpy(), scene.structure.lines[start:stop].numpy()


def _numbers(is_line: Mask) -> float:
    """Return the numbers of segments, of which some are lines [S]."""
    return float(np.where(is_line, LINE, CUBIC).sum())


def _is_shorter(scene: Scene, loop: int, rows: LoopRows) -> bool:
    """Return whether ``rows`` say fewer numbers than a ``loop`` does."""
    return _numbers(rows[1]) < _numbers(_rows_of(scene, loop)[1])

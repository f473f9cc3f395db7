"""Drop the nodes that a picture does not need, while the exact error stays within a tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.config.fit_config import FitConfig
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.price import CUBIC, LINE
from warpvec.flat.simplification.chosen_nodes import (
    chosen_scene,
    members,
    nearly_smooth,
    smoothed,
    with_spans_back,
    wrong_segments,
)
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.fewest_spans import ChosenSpans, fewest_spans
from warpvec.flat.simplification.local_error import errors_near
from warpvec.flat.simplification.outline_samples import OutlineSamples, control_points
from warpvec.flat.simplification.span_candidates import Outlines
from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish
from warpvec.watch.decisions import are_wanted, box_of
from warpvec.watch.watch import Watch


def simplify(
    scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail,
    iterations: int = SIMPLIFICATION.choice_iterations,
) -> Scene:  # fmt: skip
    """Return ``scene`` with fewer nodes and more lines, fitted to the image again.

    Nodes are dropped in rounds. Each round chooses the nodes of all outlines, fits the scene for ``iterations`` and
    puts nodes back where the exact squared error near a segment has risen by more than an outline that is moved by
    ``detail`` would cost. Parts of outlines that the picture does not show cost nothing.

    Args:
        scene: a scene of cubics, fitted to the image.
        critic: judges the changes against the image.
        watch: the watch over the run.
        detail: root mean square in pixels by which an outline may move.
        iterations: of the fit of each round; 0 chooses nodes by their distances alone.
    """
    if not len(scene):
        return scene
    work, before = _Work(critic, watch, detail, iterations), critic.error(scene)
    state = _State(scene, np.ones(len(scene.segments)), np.ones(len(scene.segments), np.bool_))
    for _ in range(SIMPLIFICATION.choice_rounds):
        changed = work.changed(state, before)
        if changed is None:
            break
        state = changed
        if watch.is_over():
            break
    return state.scene


@dataclass(frozen=True, eq=False)
class _State:
    """A scene of R segments, and what its changes have shown.

    Attributes:
        share: share of the distance that a segment that replaces each may have [R].
        may_smooth: which nodes have not yet turned out to be corners [R].
    """

    scene: Scene
    share: Floats
    may_smooth: Mask


@dataclass(frozen=True, eq=False)
class _Work:
    critic: Critic
    watch: Watch
    detail: float
    iterations: int

    def changed(self, state: _State, before: Floats32) -> _State | None:
        """Return the scene after a round; None if there is nothing to drop."""
        scene = state.scene
        outlines = outlines_of(scene, self.critic.samples(scene))
        moves = SIMPLIFICATION.refit * outlines.samples.moves(self.detail)
        price = SIMPLIFICATION.price_length * float(np.average(np.square(moves), weights=outlines.samples.seen + 1e-9))
        choice = fewest_spans(outlines, moves * state.share, price)
        is_new = (choice.size > 1) | (choice.is_line != outlines.is_line[choice.first])
        if not is_new.any():
            return None
        is_smooth = outlines.is_smooth[choice.first]
        simple = chosen_scene(scene, choice, is_smooth)
        rounded = nearly_smooth(simple) & state.may_smooth[choice.first]
        simple = smoothed(simple, torch.from_numpy(is_smooth | rounded))
        if self.iterations:
            simple = polish(
                self.critic.target, simple, self.critic.config, self.watch.side_part(), iterations=self.iterations,
                values_exact_max=SIMPLIFICATION.values_exact_max, unseen=SIMPLIFICATION.unseen,
                tension=self.critic.tension(simple),
            ).scene  # fmt: skip
        allowed = self._allowed(outlines, choice, scene)
        rise = errors_near(control_points(simple), self.critic.error(simple) - before)
        if are_wanted():
            self._note(scene, simple, choice, is_new, rise, allowed)
        wrong, corner = wrong_segments(simple, choice, outlines, rise > allowed, is_new, rounded)
        return self._put_back(state, simple, choice, wrong, corner, float(before.sum() + allowed.sum()))

    def _allowed(self, outlines: Outlines, choice: ChosenSpans, scene: Scene) -> Floats:
        """Return the rise of the squared error near each segment [S] of ``choice`` that is allowed."""
        source, _, row = members(choice, choice.size, scene)
        samples = outlines.samples
        own = self.critic.allowed(samples.worth, samples.moves(self.detail), 0.0)
        return np.bincount(source, own[row], len(choice.first)).astype(np.float64) + SIMPLIFICATION.noise

    def _note(
        self, scene: Scene, simple: Scene, choice: ChosenSpans, is_new: Mask, rise: Floats, allowed: Floats
    ) -> None:
        """Note each segment of ``simple`` that replaces others of ``scene``, before any is put back."""
        control, source = control_points(simple), members(choice, choice.size, scene)[0]
        row = members(choice, choice.size, scene)[2]
        old = np.bincount(source, np.where(scene.structure.lines.numpy()[row], LINE, CUBIC), len(control))
        for k in np.flatnonzero(is_new).tolist():
            word, numbers = ("line", LINE) if choice.is_line[k] else ("curve", CUBIC)
            before, cost = f"{choice.size[k]} segments", (float(rise[k]), float(allowed[k]))
            self.critic.note("nodes", box_of(control[k]), before, word, float(old[k] - numbers), cost)

    def _put_back(
        self, state: _State, simple: Scene, choice: ChosenSpans, wrong: Mask, corner: Mask, error_max: float
    ) -> _State:
        """Return the scene ``simple`` with what was ``wrong`` [S] as before.

        If that is worse than ``simple``, which is good enough, nothing is put back. If it is no good, all is.
        """
        sizes = np.where(wrong, choice.size, 1)
        scene, row = with_spans_back(simple, state.scene, choice, wrong, corner)
        error, error_without = (float(self.critic.error(each).sum()) for each in (scene, simple))
        if error_without <= min(error, error_max):  # what is put back may no longer fit what has moved
            return _State(simple, state.share[choice.first], state.may_smooth[choice.first])
        if error > error_max:
            return _State(state.scene, state.share * SIMPLIFICATION.share_again, np.zeros_like(state.may_smooth))
        share = state.share[row] * np.where(np.repeat(wrong, sizes), SIMPLIFICATION.share_again, 1.0)
        may_smooth = state.may_smooth[row]
        may_smooth[np.cumsum(sizes) - sizes] &= ~corner
        return _State(scene, share, may_smooth)


def outlines_of(scene: Scene, samples: OutlineSamples) -> Outlines:
    """Return the outlines of ``scene`` as arrays, with their ``samples``."""
    joints = Joints.of(scene)
    return Outlines(
        samples,
        joints.is_line.numpy(),
        joints.is_smooth.numpy(),
        np.where(joints.is_smooth.numpy()[:, None], _tangents(scene, joints), 0.0),
        joints.preceding.numpy(),
        scene.structure.loop_first_segment.long().numpy(),
    )


def _tangents(scene: Scene, joints: Joints) -> Floats:
    """Return the unit direction of the outline at each node [R, 2]."""
    ahead, behind = joints.ahead_and_behind(*joints.values(scene))
    mean = torch.where(joints.is_line[:, None], ahead, ahead + behind)
    mean = torch.where(joints.is_line[joints.preceding][:, None], behind, mean)
    return torch.nn.functional.normalize(mean.double(), dim=1, eps=1e-12).numpy()

"""Drop the nodes that a picture does not need, while the exact error stays within a tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.polish import polish
from warpvec.fit.target import Target
from warpvec.flat.simplification.chosen_nodes import (
    Mask,
    chosen_scene,
    members,
    nearly_smooth,
    smoothed,
    with_spans_back,
    wrong_segments,
)
from warpvec.flat.simplification.fewest_spans import Choice, fewest_spans
from warpvec.flat.simplification.local_error import errors_near
from warpvec.flat.simplification.outline_samples import Floats, control_points, sample_outlines
from warpvec.flat.simplification.span_candidates import Outlines
from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene

DETAIL = 0.1
"""Root mean square in pixels by which an outline may move, as the picture shows it."""

REFIT = 2.0
"""A fit afterwards at least halves the distance by which a dropped node moves the outline, so a choice may move it by
this many times the detail."""

PRICE_LENGTH = 12.5
"""A curve less is worth an outline of so many pixels at the largest distance that a choice allows: longer segments
must be closer, because each says more about the picture."""

ROUNDS, ITERATIONS = 2, 6
"""Times that nodes are chosen, and the iterations of the fit after each."""

VALUES_EXACT_MAX = 4_800
"""Most values of a drawing of flat art that is fitted by damped Gauss-Newton steps. Each takes a second of a posterised
photo of 1,200 segments, which gradients alone fit in a sixth of the time, 0.2 dB worse."""

SHARE_AGAIN = 0.5
"""Share of the distance that nodes which were put back may cost the next time."""

NOISE = 0.02
"""Squared error, summed over channels, that never counts: that of a few pixels rounded to 8 bits."""


@dataclass(frozen=True)
class Simplified:
    """A scene with fewer nodes.

    Attributes:
        scene: the result.
        dropped: the number of segments that are gone.
        put_back: the number of segments that were replaced and are back, because the error had risen too much.
    """

    scene: Scene
    dropped: int
    put_back: int


def simplify(
    scene: Scene,
    image: Tensor,
    config: FitConfig,
    detail: float = DETAIL,
    iterations: int = ITERATIONS,
    is_over: Callable[[], bool] = bool,
) -> Simplified:
    """Return ``scene`` with fewer nodes and more lines, fitted to ``image`` [h, w, 3 or 4] again.

    Nodes are dropped in rounds. Each round chooses the nodes of all outlines, fits the scene for ``iterations`` and
    puts nodes back where the exact squared error near a segment has risen by more than an outline that is moved by
    ``detail`` would cost. Parts of outlines that the picture does not show cost nothing.

    Args:
        scene: a scene of cubics, fitted to the image.
        image: the target, sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        config: settings of the fit.
        detail: root mean square in pixels by which an outline may move.
        iterations: of the fit of each round; 0 chooses nodes by their distances alone.
        is_over: says whether the nodes that are dropped so far must do.
    """
    if not len(scene):
        return Simplified(scene, 0, 0)
    work = _Work(image, config, detail, iterations, Target(image, config, "cpu"))
    count, put_back, state = len(scene.segments), 0, _State.of(scene)
    before = work.error(scene)
    for _ in range(ROUNDS):
        changed = work.changed(state, before)
        if changed is None:
            break
        state, back_count = changed
        put_back += back_count
        if is_over():
            break
    return Simplified(state.scene, count - len(state.scene.segments), put_back)


@dataclass(frozen=True, eq=False)
class _State:
    """A scene of R segments, and what its changes have shown.

    Attributes:
        share: share of the distance that a segment that replaces each may have [R].
        may_smooth: which nodes have not yet turned out to be corners [R].
    """

    scene: Scene
    share: NDArray[np.float64]
    may_smooth: Mask

    @staticmethod
    def of(scene: Scene) -> _State:
        count = len(scene.segments)
        return _State(scene, np.ones(count), np.ones(count, np.bool_))


@dataclass(frozen=True, eq=False)
class _Work:
    image: Tensor
    config: FitConfig
    detail: float
    iterations: int
    target: Target

    def error(self, scene: Scene) -> NDArray[np.float32]:
        """Return the squared error in each pixel [h, w], summed over the channels."""
        found: NDArray[np.float32] = self.target.squared_error(scene).numpy()
        return found

    def changed(self, state: _State, before: NDArray[np.float32]) -> tuple[_State, int] | None:
        """Return the scene after a round, and how many segments were put back; None if there is nothing to drop."""
        scene = state.scene
        outlines = outlines_of(scene, self.image.shape[0], self.image.shape[1], self.config.threads)
        price = PRICE_LENGTH * (REFIT * self.detail) ** 2
        choice = fewest_spans(outlines, REFIT * self.detail * state.share, price)
        is_new = (choice.size > 1) | (choice.is_line != outlines.is_line[choice.first])
        if not is_new.any():
            return None
        is_smooth = outlines.is_smooth[choice.first]
        simple = chosen_scene(scene, choice, is_smooth)
        rounded = nearly_smooth(simple) & state.may_smooth[choice.first]
        simple = smoothed(simple, torch.from_numpy(is_smooth | rounded))
        if self.iterations:
            simple = polish(
                self.image, simple, self.config, iterations=self.iterations, values_exact_max=VALUES_EXACT_MAX
            ).scene
        allowed = self._allowed(outlines, choice, scene)
        excess = errors_near(control_points(simple), self.error(simple) - before) > allowed
        wrong, corner = wrong_segments(simple, choice, outlines, excess, is_new, rounded)
        return self._put_back(state, simple, choice, wrong, corner, float(before.sum() + allowed.sum()))

    def _allowed(self, outlines: Outlines, choice: Choice, scene: Scene) -> Floats:
        """Return the rise of the squared error near each segment [S] of ``choice`` that is allowed."""
        samples = outlines.samples
        worth = (samples.contrast * samples.lengths).sum(1)
        source, _, row = members(choice, choice.size, scene)
        allowed: Floats = self.detail**2 * np.bincount(source, worth[row], len(choice.first)).astype(np.float64) + NOISE
        return allowed

    def _put_back(
        self, state: _State, simple: Scene, choice: Choice, wrong: Mask, corner: Mask, error_max: float
    ) -> tuple[_State, int]:
        """Return the scene ``simple`` with what was ``wrong`` [S] as before.

        If that is worse than ``simple``, which is good enough, nothing is put back. If it is no good, all is.
        """
        sizes = np.where(wrong, choice.size, 1)
        scene, row = with_spans_back(simple, state.scene, choice, wrong, corner)
        error, error_without = (float(self.error(each).sum()) for each in (scene, simple))
        if error_without <= min(error, error_max):  # what is put back may no longer fit what has moved
            return _State(simple, state.share[choice.first], state.may_smooth[choice.first]), 0
        if error > error_max:
            return _State(state.scene, state.share * SHARE_AGAIN, np.zeros_like(state.may_smooth)), len(wrong)
        share = state.share[row] * np.where(np.repeat(wrong, sizes), SHARE_AGAIN, 1.0)
        may_smooth = state.may_smooth[row]
        may_smooth[np.cumsum(sizes) - sizes] &= ~corner
        return _State(scene, share, may_smooth), int(choice.size[wrong].sum())


def outlines_of(scene: Scene, height: int, width: int, threads: int | None = None) -> Outlines:
    """Return the outlines of ``scene`` as arrays, as a canvas of ``height`` x ``width`` pixels shows them."""
    joints = Joints.of(scene)
    return Outlines(
        sample_outlines(scene, height, width, threads),
        joints.is_line.numpy(),
        joints.is_smooth.numpy(),
        np.where(joints.is_smooth.numpy()[:, None], _tangents(scene, joints), 0.0),
        scene.structure.loop_first_segment.long().numpy(),
    )


def _tangents(scene: Scene, joints: Joints) -> NDArray[np.float64]:
    """Return the unit direction of the outline at each node [R, 2]."""
    ahead, behind = joints.ahead_and_behind(*joints.values(scene))
    mean = torch.where(joints.is_line[:, None], ahead, ahead + behind)
    mean = torch.where(joints.is_line[joints.preceding][:, None], behind, mean)
    found: NDArray[np.float64] = torch.nn.functional.normalize(mean.double(), dim=1, eps=1e-12).numpy()
    return found

"""Minimize the loss of a drawing by damped Gauss-Newton steps, which know how all values act together.

Values that move one edge together are solved for together, so a drawing of some hundred values needs some thirty steps,
each of which takes as long as ten to twenty of `warpvec.polish.descent`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.arrays import Floats
from warpvec.generators import generator_of
from warpvec.polish.damped_steps import DAMPING_MIN, FEW_MAX, Equations, FewEquations, SparseEquations, order_by_nodes
from warpvec.polish.gauss_newton import normal_entries
from warpvec.polish.variables import Evaluation, Variables

DAMPING_FIRST, DAMPING_MAX = 1e-3, 1e4
"""Damping of the first step, as a share of the matrix's diagonal, and the most. With more nothing moves any more."""

DAMPING_UP, DAMPING_DOWN = 4.0, 6.0
"""Factor of the damping after a failed step, and after a step with the expected decrease."""

RATIO_GOOD, RATIO_POOR = 0.7, 0.25
"""A step comes out as expected from this share of its expected decrease on, and poorly below the second share."""

MOVE_MAX, MOVE_SHARE = 1.5, 0.25
"""Largest move of a point in a step: so many pixels, or this share of the shorter line to a neighbouring node. Farther
from an edge its pixels do not tell where it should be."""

FOLD_DAMPING = 3.0
"""Factor of the damping of folding segments, at each fold. With 16 here and 4 below, a thin part that closes stops its
neighbours for good, and the mean PSNR of four tracings is 1.9 dB lower."""

FOLD_RELEASE = 27.0
"""Factor of the return of this damping to normal, with each step."""

FOLD_ROUNDS = 8
"""Times that folding segments are damped before they are held; from then on more and more of their neighbours are."""

HOLD_ROUNDS = 4
"""Times that held parts grow before whole paths are held."""

WHOLE_ROUNDS = 8
"""Times that whole paths are held: a path may fold only once its neighbours stay."""

GAIN_MIN = 0.01
"""The fit ends once the last steps have gained less than this share of the loss, which is 0.04 dB."""

GAIN_STEPS = 5
"""Number of these last steps."""

STILL_STEPS, STILL_SHARE = 2, 0.03
"""The fit also ends once so many last steps have gained less than this share of ``GAIN_MIN``, or a step fails that was
expected to: at the end of a careful fit such steps come in rows, and gain 0.001 dB. With 0.1, one of five icons loses
0.09 dB."""

EXPECTED_MIN = 0.2
"""A rough fit, which is asked for a larger gain than ``GAIN_MIN``, ends once a step is expected to gain less than this
share of that gain. On 23 icons of `bench/gate.py` it saves a tenth of the time, and all figures stay. A careful fit
goes on, because some steps gain more than expected."""

STEPS_MAX = 60
"""Most matrices that are made, each of which takes as long as some fifteen evaluations."""

PROBES = 8
"""Random images from which the strengths of opacities are estimated."""


class LevenbergMarquardt:
    """Steps from ``x`` on that never fold the drawing over.

    Args:
        variables: the drawing that is fitted.
        here: its values at the beginning, evaluated.
        folds: returns which segments [R] (bool) are folded at some values.
        seed: of the random images for opacities.
        scale: factor of ``MOVE_MAX``.
    """

    def __init__(
        self, variables: Variables, here: Evaluation, folds: Callable[[Tensor], Tensor], seed: int, scale: float = 1.0
    ) -> None:
        self._variables, self._folds, self._scale = variables, folds, scale
        self._here, x = here, here.x
        self._damping = DAMPING_FIRST
        self._fold_damping = torch.ones(variables.point_count // 3, dtype=torch.float64, device=x.device)
        self._free = variables.is_free.nonzero().flatten().cpu().numpy()
        self._strength = self._opacity_strength(x, seed)
        self._order: NDArray[np.int64] | None = None
        is_few = len(self._free) <= FEW_MAX
        self._few = order_by_nodes(self._free, variables.point_count) if is_few else None

    def steps(self, count: int, gain_min: float = GAIN_MIN, unseen: float = 0.0) -> Iterator[Evaluation]:
        """Yield each evaluation of the loss, at most ``count``, until the last steps gain less than ``gain_min``.

        ``gain_min`` is a share of the sum of the loss and ``unseen``, the error that viewers of the file add anyway.
        """
        yield self._here
        left, losses = count - 1, [self._here.loss]
        while left > 0 and len(losses) <= STEPS_MAX and not _is_idle(losses, gain_min, unseen):
            system = self._system()
            while left > 0 and self._damping < DAMPING_MAX:
                x, expected = self._allowed_step(system)
                if gain_min > GAIN_MIN and expected < EXPECTED_MIN * gain_min * self._here.loss:
                    return
                tried = self._variables.evaluate(x)
                left -= 1
                yield tried
                if self._accepts(tried, expected):
                    break
                if expected < STILL_SHARE * GAIN_MIN * self._here.loss:
                    return
            if self._here.loss >= losses[-1]:
                return
            losses.append(self._here.loss)
            self._fold_damping = (self._fold_damping / FOLD_RELEASE).clamp_min(1.0)

    def _accepts(self, tried: Evaluation, expected: float) -> bool:
        """Move to ``tried`` if its loss is lower, and adapt the damping to the ratio of real and expected decrease."""
        ratio = (self._here.loss - tried.loss) / max(expected, 1e-30)
        is_better = tried.loss < self._here.loss
        if ratio > RATIO_GOOD:
            self._damping = max(self._damping / DAMPING_DOWN, DAMPING_MIN)
        elif ratio < RATIO_POOR:
            self._damping *= DAMPING_UP if not is_better else DAMPING_UP**0.5
        if is_better:
            self._here = tried
        return is_better

    def _allowed_step(self, system: Equations) -> tuple[Tensor, float]:
        """Return the values [K] after a step that folds nothing, and the expected decrease of the loss."""
        joints, before = self._variables.joints, None
        held = torch.zeros_like(self._fold_damping, dtype=torch.bool)
        for attempt in range(FOLD_ROUNDS + HOLD_ROUNDS + WHOLE_ROUNDS):
            step = self._limited_step(system)
            step[self._variables.points_of(held)] = 0.0
            x = self._variables.limited(self._here.x + step)
            folds = self._folds(x)
            if before is None and folds.any():
                before = self._folds(self._here.x)  # no step can help these, and they stay
                held |= before | before[joints.following] | before[joints.preceding]
                if before.any():
                    continue
            if before is not None:
                folds &= ~before
            if not folds.any():
                break
            self._fold_damping[folds | folds[joints.preceding]] *= FOLD_DAMPING
            if attempt >= FOLD_ROUNDS:
                held |= folds
                held |= held[joints.following] | held[joints.preceding]
            if attempt >= FOLD_ROUNDS + HOLD_ROUNDS - 1:
                held = self._variables.whole_paths(held)
        return x, system.decrease(step)

    def _limited_step(self, system: Equations) -> Tensor:
        """Return the step [K] with more damping of the points that would move too far."""
        extra = self._fold_damping.repeat(3).cpu().numpy()
        step = system.limited_step(self._damping, extra, self._limits).to(self._here.x.device)
        step = self._variables.with_bounded_forms(step, MOVE_MAX * self._scale)
        step = self._variables.with_bounded_stops(self._here.x, step)
        return step.to(self._here.x.dtype)

    def _limits_here(self) -> Floats:
        """Return how far each point may move [3 R]."""
        joints, count = self._variables.joints, self._variables.point_count // 3
        anchor = self._here.x[: 2 * count].view(-1, 2).double()
        chord = (anchor[joints.following] - anchor).norm(dim=1)
        near = MOVE_SHARE * torch.minimum(chord, chord[joints.preceding])
        found: Floats = near.clamp_min(MOVE_MAX * self._scale).repeat(3).cpu().numpy()
        return found

    def _system(self) -> Equations:
        """Return the equations of the next steps, from the present values."""
        variables, self._limits = self._variables, self._limits_here()
        held, gradient = variables.held(self._here)
        entries = normal_entries(variables, self._here.x, held)
        known = entries, self._strength, gradient.double().cpu().numpy()
        if self._few is not None:
            return FewEquations(*known, self._few, variables.point_count, self._floor)
        system = SparseEquations(*known, self._free, variables.point_count, self._floor, self._order)
        self._order = system.order
        return system

    def _floor(self, diagonal: Floats) -> Floats:
        """Return what must be added to a ``diagonal`` [K] so that no number takes endless steps."""
        found: Floats = self._variables.form_floor(torch.from_numpy(diagonal).to(self._here.x.device)).cpu().numpy()
        return found

    def _opacity_strength(self, x: Tensor, seed: int) -> NDArray[np.float64]:
        """Return the diagonal [K] that the matrix leaves out: of opacities and what acts through them, elsewhere 0."""
        strength = np.zeros(len(x))
        estimated = self._variables.estimated_values
        if bool(self._variables.is_free[estimated].any()):
            found = self._variables.strength(x, PROBES, generator_of(seed))
            strength[estimated.cpu().numpy()] = found[estimated].double().cpu().numpy()
        return strength


def _is_idle(losses: list[float], gain_min: float, unseen: float) -> bool:
    """Return whether the last steps have gained a smaller share of the loss and ``unseen`` than ``gain_min``.

    ``losses`` has the loss before each step, and the last one.
    """
    return any(
        len(losses) > count and losses[-1] + unseen > (1.0 - least) * (losses[-1 - count] + unseen)
        for count, least in ((GAIN_STEPS, gain_min), (STILL_STEPS, STILL_SHARE * GAIN_MIN))
    )

"""Judge the changes of a drawing: the exact error against the picture, and how much of it nobody sees."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np
import torch
from torch import Tensor

from warpvec.arrays import Floats, Floats32
from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.price import CUBIC, number_nats
from warpvec.flat.simplification.outline_samples import OutlineSamples, sample_outlines
from warpvec.geometry.scene import Scene
from warpvec.watch.decisions import Box, Decision, note

T = TypeVar("T")

CONTRAST_MAX = 3.0
"""Squared contrast of black and white, summed over the channels."""


@dataclass(frozen=True, eq=False)
class Critic:
    """The one judge of all changes of a drawing of flat art; made once for a picture.

    Attributes:
        image: the picture [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        config: settings of the fit.
        blur: standard deviation in pixels of the blur of the picture; 0 for none.
        tension_price: squared error that a pixel of outline between black and white is worth in fits; 0 for nothing.
        variance: squared deviation of a channel of each pixel from its drawing [h, w], in [0, 1] squared, beyond that
            of rounding; None for none. See `warpvec.flat.evidence`.
    """

    image: Tensor
    config: FitConfig
    blur: float = 0.0
    tension_price: float = 0.0
    variance: Floats | None = None

    @cached_property
    def target(self) -> Target:
        """The picture with its exact renderer."""
        return Target(self.image, self.config, "cpu", self.blur)

    def error(self, scene: Scene) -> Floats32:
        """Return the squared error of ``scene`` in each pixel [h, w], summed over the channels.

        That of a blurred picture is raised to what the same moves of outlines would cause in a sharp one.
        """
        return self._errors.of(scene, self._error_of)

    def removal_costs(self, scene: Scene) -> Floats:
        """Return the rise of the squared error, summed over pixels and channels, without each path [N]."""
        with torch.no_grad():
            cost: Floats = self.target.removal_costs(scene).double().numpy()
        return cost / self.target.error_scale

    def samples(self, scene: Scene) -> OutlineSamples:
        """Return points along the outlines of ``scene``, with how well the picture shows them."""
        return self._samples.of(scene, self._samples_of)

    def tension(self, scene: Scene) -> Tensor | None:
        """Return the tension of the segments of ``scene`` [R] for a fit; see `warpvec.polish.tension`. None for none.

        It is in proportion to the contrast across each segment, so that an edge that the picture shows hardly moves.
        """
        if self.tension_price == 0.0:
            return None
        contrast = self.samples(scene).contrast.mean(1) / CONTRAST_MAX + SIMPLIFICATION.hidden_tension
        return torch.from_numpy(self.target.error_scale * self.tension_price * contrast)

    @cached_property
    def _errors(self) -> _Latest[Floats32]:
        return _Latest()

    def _error_of(self, scene: Scene) -> Floats32:
        share = 1.0 if self.target.blur is None else self.target.blur.edge_share
        found: Floats32 = (self.target.squared_error(scene) / share).numpy()
        return found

    @cached_property
    def _samples(self) -> _Latest[OutlineSamples]:
        return _Latest()

    def _samples_of(self, scene: Scene) -> OutlineSamples:
        height, width = self.image.shape[:2]
        return self._with_doubt(sample_outlines(scene, height, width, self.config.threads))

    def _with_doubt(self, samples: OutlineSamples) -> OutlineSamples:
        """Return ``samples`` with the moves that the picture does not tell from its noise.

        A curve less may raise the error by as many nats as its words have, over the length at which it pays.
        """
        if self.variance is None:
            return samples
        height, width = self.variance.shape
        column, row = np.moveaxis(np.floor(samples.points).astype(np.int64), -1, 0)
        here = self.variance[row.clip(0, height - 1), column.clip(0, width - 1)]
        nats = CUBIC * number_nats(max(height, width))
        slope = SIMPLIFICATION.price_length * (samples.contrast + SIMPLIFICATION.contrast_half)
        return replace(samples, doubt=(2.0 * nats * here / slope).mean(1))

    @staticmethod
    def allowed(worth: Floats, detail: float | Floats, noise: float) -> Floats:
        """Return the rise of the error [K] that outlines of ``worth`` [K] may cause: that of a move by ``detail``.

        Args:
            worth: sums of `OutlineSamples.worth`.
            detail: root mean square in pixels by which an outline may move, or each of them [K].
            noise: squared error that never counts.
        """
        return np.square(detail) * worth + noise

    def note(self, stage: str, place: Box, before: str, after: str, numbers: float, cost: tuple[float, float]) -> None:
        """Tell those who listen of a change of words, whether or not it was taken.

        Args:
            stage: what proposed it.
            place: what it changes.
            before, after: what the drawing says.
            numbers: how many it says less.
            cost: rise of the squared error, and the one that is allowed.
        """
        words, (rise, allowed) = numbers * number_nats(max(self.image.shape[:2])), cost
        picture = words * rise / max(allowed, 1e-12)
        note(Decision(stage, place, before, after, words, picture, rise <= allowed))

    @staticmethod
    def detail_of(worth: float, rise: float, noise: float) -> float:
        """Return the move of outlines of ``worth``, a root mean square in pixels, that lets the error rise by ``rise``.

        It is the inverse of `allowed`.
        """
        return math.sqrt(max(rise - noise, 0.0) / worth) if worth > 0.0 else 0.0 if rise <= noise else math.inf


class _Latest(Generic[T]):
    """What was found of the last scenes: a stage often begins with the scene of the one before.

    Nobody may change a scene, or an answer. The function that finds it is given each time: one that is kept would hold
    its owner, which holds this, and all the memory of the drawing until Python looks for such circles.
    """

    def __init__(self) -> None:
        self._known: deque[tuple[Scene, T]] = deque(maxlen=2)

    def of(self, scene: Scene, find: Callable[[Scene], T]) -> T:
        for known, found in self._known:
            if known is scene:
                return found
        found = find(scene)
        self._known.append((scene, found))
        return found

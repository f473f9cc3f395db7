"""Drop the nodes that a picture does not need, while the exact error stays within a tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.polish import polish
from warpvec.fit.target import Target
from warpvec.flat.chosen_nodes import chosen_scene, members, with_spans_back
from warpvec.flat.fewest_spans import Choice, Outlines, fewest_spans
from warpvec.flat.local_error import errors_near
from warpvec.flat.outline_samples import control_points, sample_outlines
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

ROUNDS, ITERATIONS = 2, 25
"""Times that nodes are chosen, and the iterations of the fit after each."""

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
    scene: Scene, image: Tensor, config: FitConfig, detail: float = DETAIL, iterations: int = ITERATIONS
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
    """
    target = Target(image, config, "cpu")
    before = target.squared_error(scene).numpy()
    count, put_back, share = len(scene.segments), 0, np.ones(len(scene.segments))
    for _ in range(ROUNDS):
        outlines = outlines_of(scene, image.shape[0], image.shape[1], config.threads)
        choice = fewest_spans(outlines, REFIT * detail * share, _price(detail))
        if len(choice.first) == len(scene.segments) and (choice.is_line == outlines.is_line).all():
            break
        simple = chosen_scene(scene, choice)
        if iterations:
            simple = polish(image, simple, config, iterations=iterations).scene
        rise = target.squared_error(simple).numpy() - before
        wrong = _wrong(simple, scene, choice, outlines, rise, detail)
        scene, row = with_spans_back(simple, scene, choice, wrong)
        share = share[row] * np.where(np.repeat(wrong, np.where(wrong, choice.size, 1)), SHARE_AGAIN, 1.0)
        put_back += int(choice.size[wrong].sum())
    return Simplified(scene, count - len(scene.segments), put_back)


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


def _price(detail: float) -> float:
    return PRICE_LENGTH * (REFIT * detail) ** 2


def _tangents(scene: Scene, joints: Joints) -> NDArray[np.float64]:
    """Return the unit direction of the outline at each node [R, 2]."""
    ahead, behind = joints._directions(*joints.values(scene))
    mean = torch.where(joints.is_line[:, None], ahead, ahead + behind)
    mean = torch.where(joints.is_line[joints.preceding][:, None], behind, mean)
    found: NDArray[np.float64] = torch.nn.functional.normalize(mean.double(), dim=1, eps=1e-12).numpy()
    return found


def _wrong(
    simple: Scene, old: Scene, choice: Choice, outlines: Outlines, rise: NDArray[np.float32], detail: float
) -> NDArray[np.bool_]:
    """Return which segments [S] of ``choice`` are new and bring too much ``rise`` [h, w] of the squared error."""
    samples = outlines.samples
    worth = (samples.contrast * samples.lengths).sum(1)
    source, _, row = members(choice, choice.size, old)
    allowed = detail**2 * np.bincount(source, worth[row], len(choice.first)) + NOISE
    is_new = (choice.size > 1) | (choice.is_line != outlines.is_line[choice.first])
    found: NDArray[np.bool_] = is_new & (errors_near(control_points(simple), rise) > allowed)
    return found

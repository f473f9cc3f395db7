"""Make a drawing regular where the picture cannot tell the difference."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import torch

from warpvec.config.fit_config import FitConfig
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.accepted_changes import accepted_loops, accepted_nodes
from warpvec.flat.simplification.circles import ellipse_of
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.outline_samples import OutlineSamples, segment_loops
from warpvec.flat.simplification.path_removal import loop_areas
from warpvec.flat.simplification.spikes import without_spikes
from warpvec.flat.simplification.straight_lines import Lines, regular_anchors
from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene
from warpvec.watch.watch import Watch


def regularize(scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail) -> Scene:
    """Return ``scene`` with regular forms where the exact error hardly rises.

    Circles and ellipses become four arcs. Spikes that show nothing go. Lines become level, upright, parallel and
    aligned, and their corners right. Each change is taken back where the squared error near it rises by more than an
    outline costs that moves by half of ``detail``. What is left is the work of `warpvec.flat.chains`.

    Args:
        scene: a scene of cubics, fitted to the image.
        critic: judges the changes against the image.
        watch: the watch over the run. When it is over, the forms that are regular so far must do.
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
    """
    if watch.is_over():
        return scene
    allowed = SIMPLIFICATION.regular_share * detail
    samples = critic.samples(scene)
    scene = accepted_loops(scene, _ellipses(scene, samples), critic, samples, allowed)
    for change in (without_spikes, _with_regular_lines):
        if watch.is_over():
            break
        samples = critic.samples(scene)
        scene = accepted_nodes(scene, change(scene, samples), critic, samples, allowed)
    return scene


def _ellipses(scene: Scene, samples: OutlineSamples) -> dict[int, np.ndarray]:
    """Return the four curves [4, 3, 2] of each loop that is an ellipse."""
    first = scene.structure.loop_first_segment.tolist()
    areas = loop_areas(samples.control, segment_loops(scene), len(first) - 1)
    seen, found = samples.visibility, {}
    weights = np.where(seen < SIMPLIFICATION.hidden_visibility, 0.0, seen * samples.lengths)
    for loop, (area, (start, stop)) in enumerate(zip(areas.tolist(), pairwise(first), strict=True)):
        ellipse = ellipse_of(samples.points[start:stop].reshape(-1, 2), weights[start:stop].reshape(-1))
        if ellipse is not None:
            found[loop] = ellipse.segments(area > 0.0)
    return found


def _with_regular_lines(scene: Scene, samples: OutlineSamples) -> Scene:
    joints = Joints.of(scene)
    rows = joints.is_line.nonzero().flatten().numpy()
    weight = (samples.visibility * samples.lengths).sum(1)
    control = samples.control[rows]
    lines = Lines(rows, samples.path[rows], control[:, 0], control[:, 3], weight[rows])
    anchor = regular_anchors(lines, samples.control[:, 0], joints.preceding.numpy())
    _, leaving, arriving = joints.values(scene)
    moved = torch.from_numpy(anchor).to(scene.segments.dtype)
    return replace(scene, segments=joints.segments(moved, leaving, arriving))

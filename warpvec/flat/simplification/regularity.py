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
from warpvec.flat.simplification.rounded_corners import rounded_corners
from warpvec.flat.simplification.spikes import without_spikes
from warpvec.flat.simplification.straight_lines import Lines, regular_anchors
from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene
from warpvec.watch.watch import Watch


def regularize(scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail) -> Scene:
    """Return ``scene`` with regular forms where the exact error hardly rises.

    Circles and ellipses become four arcs. Spikes that show nothing go. Lines become level, upright, parallel and
    aligned, and their corners right. Rounded corners become arcs, with equal radii in a loop. The tangents of smooth
    nodes become level or upright. Each change is taken back where the squared error near it rises by more than an
    outline costs that moves by half of ``detail``.

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
    for change in (without_spikes, _with_regular_lines, _with_rounded_corners, _with_level_tangents):
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


def _with_rounded_corners(scene: Scene, samples: OutlineSamples) -> Scene:
    joints, loop = Joints.of(scene), segment_loops(scene)
    following, preceding = joints.following.numpy(), joints.preceding.numpy()
    *values, arcs = rounded_corners(samples.control, joints.is_line.numpy(), following, preceding, loop)
    mask = torch.from_numpy(arcs | arcs[preceding])[:, None]
    old = joints.values(scene)
    new = (torch.where(mask, torch.from_numpy(b).to(a), a) for a, b in zip(old, values, strict=True))
    return replace(scene, segments=joints.segments(*new))


def _with_level_tangents(scene: Scene, samples: OutlineSamples) -> Scene:
    joints = Joints.of(scene)
    anchor, leaving, arriving = joints.values(scene)
    beside_line = joints.is_line | joints.is_line[joints.preceding]
    for axis in (0, 1):
        across = torch.stack([leaving[:, axis].abs(), arriving[:, axis].abs()])
        along = torch.stack([leaving[:, 1 - axis].abs(), arriving[:, 1 - axis].abs()])
        is_near = (across <= SIMPLIFICATION.axis_move) & (
            across <= np.tan(np.radians(SIMPLIFICATION.axis_degrees)) * along
        )
        chosen = joints.is_smooth & ~beside_line & is_near.all(0)
        for handle in (leaving, arriving):
            handle[chosen, axis] = 0.0
    return replace(scene, segments=joints.segments(anchor, leaving, arriving))

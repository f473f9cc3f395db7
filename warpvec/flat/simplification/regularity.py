"""Make outlines that are ellipses exactly so where the picture cannot tell the difference."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from warpvec.config.fit_config import FitConfig
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.accepted_changes import accepted_loops
from warpvec.flat.simplification.circles import ellipse_of
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.outline_samples import OutlineSamples, segment_loops
from warpvec.flat.simplification.path_removal import loop_areas
from warpvec.geometry.scene import Scene
from warpvec.watch.watch import Watch


def regularize(scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail) -> Scene:
    """Return ``scene`` whose circles and ellipses are four arcs where the exact error hardly rises.

    A change is taken back where the squared error near it rises by more than an outline costs that moves by half of
    ``detail``. Lines and other parts are the work of `warpvec.flat.chains`.

    Args:
        scene: a scene of cubics, fitted to the image.
        critic: judges the changes against the image.
        watch: the watch over the run. When it is over, the scene stays as it is.
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
    """
    if watch.is_over():
        return scene
    samples = critic.samples(scene)
    return accepted_loops(scene, _ellipses(scene, samples), critic, samples, SIMPLIFICATION.regular_share * detail)


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

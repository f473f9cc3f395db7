"""Shorten spikes: corners so thin that they show nothing, such as hairs at the ends of letters' stems."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from warpvec.arrays import Floats
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.outline_samples import OutlineSamples, cubic_points
from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene


def without_spikes(scene: Scene, samples: OutlineSamples) -> Scene:
    """Return ``scene`` with each spike cut off where it is as wide as the widest hair.

    A spike keeps its node, which moves to the middle of the cut, and the curves beside it keep what is left of them. Of
    spikes beside each other, only the first one is cut. ``samples`` are those of ``scene``. Whether the picture has the
    spike is not asked.
    """
    joints = Joints.of(scene)
    preceding, following = joints.preceding.numpy(), joints.following.numpy()
    behind, ahead = samples.control[preceding][:, ::-1], samples.control
    share = _cut_shares(behind, ahead)
    row = np.flatnonzero((share > 0.0).all(1) & ~joints.is_smooth.numpy())
    row = row[~np.isin(preceding[row], row)]  # of two neighbours, the curve between them is cut once
    anchor, leaving, arriving = (values.double().numpy().copy() for values in joints.values(scene))
    behind, ahead = (_rest(control[row], share[row, side]) for side, control in enumerate((behind, ahead)))
    anchor[row] = (behind[:, 0] + ahead[:, 0]) / 2.0
    leaving[row], arriving[row] = ahead[:, 1] - ahead[:, 0], behind[:, 1] - behind[:, 0]
    arriving[following[row]] = ahead[:, 2] - ahead[:, 3]
    leaving[preceding[row]] = behind[:, 2] - behind[:, 3]
    values = (torch.from_numpy(each).to(scene.segments.dtype) for each in (anchor, leaving, arriving))
    return replace(scene, segments=joints.segments(*values))


def _cut_shares(behind: Floats, ahead: Floats) -> Floats:
    """Return the shares [R, 2] of the curves behind and ahead of each node that are a hair; 0 where there is none.

    The curves [R, 4, 2] begin at the node.
    """
    reach = np.arange(1, SIMPLIFICATION.spike_samples + 1) * SIMPLIFICATION.spike_step
    lengths = [np.linalg.norm(np.diff(control, axis=1), axis=-1).sum(1)[:, None] for control in (behind, ahead)]
    shares = [np.minimum(reach / np.maximum(length, 1e-9), SIMPLIFICATION.spike_share_max) for length in lengths]
    first, second = (cubic_points(control, share) for control, share in zip((behind, ahead), shares, strict=True))
    width = np.linalg.norm(first - second, axis=-1)
    length = np.linalg.norm((first + second) / 2.0 - ahead[:, :1], axis=-1)
    is_thin = (width < SIMPLIFICATION.spike_width) & (length > SIMPLIFICATION.spike_slimness * width)
    count = np.cumprod(is_thin, axis=1).sum(1)
    rows, last = np.arange(len(count)), np.maximum(count - 1, 0)
    is_spike = (count > 0) & (length[rows, last] > SIMPLIFICATION.spike_length)
    return np.where(is_spike[:, None], np.stack([share[rows, last] for share in shares], 1), 0.0)


def _rest(control: Floats, share: Floats) -> Floats:
    """Return the control points [K, 4, 2] of what is left of cubics [K, 4, 2] beyond ``share`` [K] of each."""
    points, t = control.copy(), share[:, None, None]
    for count in (3, 2, 1):  # de Casteljau's construction, whose last points are the rest
        points[:, :count] += t * (points[:, 1 : count + 1] - points[:, :count])
    return points

"""Points along every segment of a scene, with how well the picture shows the outline there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch

from warpvec.arrays import Floats, Integers
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.nodes import split
from warpvec.geometry.scene import Scene, of_one_color
from warpvec.rendering.draw import draw_exactly
from warpvec.rendering.operator import outline_slopes


@dataclass(frozen=True, eq=False)
class OutlineSamples:
    """``segment_samples`` points in the middle of equal parts of the parameter of each of R segments.

    Attributes:
        control: control points [R, 4, 2] of the segments in pixels.
        path: path of each segment [R].
        points: the points [R, S, 2].
        lengths: length of the outline that each stands for [R, S], in pixels.
        contrast: squared change of the colours across the outline there [R, S], summed over the channels. It is 0
            where the outline is hidden.
        doubt: squared distance in pixels by which each segment may lie off without the picture telling [R].
    """

    control: Floats
    path: Integers
    points: Floats
    lengths: Floats
    contrast: Floats
    doubt: Floats

    @property
    def worth(self) -> Floats:
        """Rise of the squared error for each segment [R] if its outline moves by one pixel."""
        return (self.contrast * self.lengths).sum(1)

    def moves(self, detail: float) -> Floats:
        """Return by how many pixels each segment may move [R]: by ``detail``, and by what the picture does not tell."""
        return np.sqrt(detail**2 + self.doubt)

    @property
    def visibility(self) -> Floats:
        """How well the picture shows the outline at each point [R, S], from 0 (hidden) to 1."""
        return self.contrast / (self.contrast + SIMPLIFICATION.contrast_half)


def sample_outlines(scene: Scene, height: int, width: int, threads: int | None = None) -> OutlineSamples:
    """Return the samples of the cubic ``scene``, seen on a canvas of ``height`` x ``width`` pixels."""
    control = control_points(scene)
    t = (np.arange(SIMPLIFICATION.segment_samples) + 0.5) / SIMPLIFICATION.segment_samples
    points, slopes = cubic_points(control, t), cubic_slopes(control, t)
    return OutlineSamples(
        control,
        scene.structure.segment_path.long().numpy(),
        points,
        np.linalg.norm(slopes, axis=-1) / SIMPLIFICATION.segment_samples,
        _contrast(scene, height, width, threads),
        np.zeros(len(control)),
    )


def control_points(scene: Scene) -> Floats:
    """Return the four control points [R, 4, 2] of each segment."""
    return whole_curves(scene).double().numpy()


def segment_loops(scene: Scene) -> Integers:
    """Return the loop of each segment [R]."""
    sizes = scene.structure.loop_first_segment.diff().long().numpy()
    return np.repeat(np.arange(len(sizes)), sizes)


def cubic_points(control: Floats, t: Floats) -> Floats:
    """Return the points [..., S, 2] of cubics [..., 4, 2] at the parameters ``t`` [S] or [..., S]."""
    return cubic_weights(t) @ control


def cubic_slopes(control: Floats, t: Floats) -> Floats:
    """Return the derivatives [..., S, 2] of cubics [..., 4, 2] at the parameters ``t`` [S] or [..., S]."""
    s = 1.0 - t
    return np.stack([s * s, 2.0 * s * t, t * t], -1) @ (3.0 * np.diff(control, axis=-2))


def cubic_weights(t: Floats) -> Floats:
    """Return the weights [..., 4] of a cubic's control points at ``t`` [...]."""
    s = 1.0 - t
    return np.stack([s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t], -1)


def _contrast(scene: Scene, height: int, width: int, threads: int | None) -> Floats:
    """Return the squared change of colour across the outline [R, S], summed over channels, a mean over the mattes.

    The outline is divided at the points. The derivative of the sum of all reds with respect to a move of one of these
    nodes across the outline, with its handles, is the change of red there times half the length of both pieces beside
    it. It has the transmittance of what lies above.
    """
    count = len(scene.segments)
    t = (torch.arange(SIMPLIFICATION.segment_samples, dtype=torch.float64) + 0.5) / SIMPLIFICATION.segment_samples
    rows = torch.arange(count).repeat_interleave(SIMPLIFICATION.segment_samples)
    pieces = split(scene, rows, t.repeat(count)).scene.moved(*SIMPLIFICATION.off_grid)
    control = control_points(pieces).reshape(count, SIMPLIFICATION.segment_samples + 1, 4, 2)
    reach = np.linalg.norm(control[:, :, 3] - control[:, :, 0], axis=-1)
    along = control[:, 1:, 3] - control[:, :-1, 0]
    normal = np.stack([-along[..., 1], along[..., 0]], -1)
    normal /= np.maximum(np.linalg.norm(along, axis=-1), 1e-9)[..., None]
    length = (reach[:, 1:] + reach[:, :-1]) / 2.0
    background = torch.zeros(3) if scene.transparent else scene.background
    slopes = outline_slopes(replace(pieces, background=background), height, width, threads).double().numpy()
    moves = slopes.reshape(len(slopes), count, SIMPLIFICATION.segment_samples + 1, 3, 2)
    changes = ((moves[:, :, 1:, :2].sum(3) + moves[:, :, :-1, 2]) * normal).sum(-1) / np.maximum(length, 1e-9)
    *colors, matte = changes
    total = sum(np.square(color) for color in colors)
    if scene.transparent:
        total = (total + sum(np.square(color + matte) for color in colors)) / 2.0
    return np.where(length > 1e-6, total, 0.0)


def top_paths(scene: Scene, height: int, width: int, threads: int | None) -> Integers:
    """Return the topmost path in each pixel [h, w], where that is all that the pixel shows; else -1.

    Each path is painted in its number and in two colours that are far from those of its neighbours, so that a mix of
    paths is told from a path between them.
    """
    number = torch.arange(1, len(scene) + 1, dtype=torch.float64)
    color = torch.stack([number / max(len(scene), 1), (number * 0.6180340) % 1.0, (number * 0.4142136) % 1.0], 1)
    numbered = replace(of_one_color(scene, color.to(scene.color)), transparent=False, background=torch.zeros(3))
    drawn = draw_exactly(numbered, height, width, threads)
    planes = [np.ascontiguousarray(drawn[..., channel]) for channel in range(3)]
    top = np.rint(planes[0] * np.float32(len(scene))).clip(0, len(scene)).astype(np.int64)
    known = np.concatenate([np.zeros((1, 3), np.float32), color.float().numpy()])
    error = SIMPLIFICATION.pure_color_error / max(len(scene), 1)
    is_pure = np.ones_like(top, np.bool_)
    for plane, colors in zip(planes, known.T, strict=True):
        is_pure &= np.abs(plane - colors[top]) < error
    return np.where(is_pure, top - 1, -1)

"""How the curves of a drawing follow the values that a fit moves: anchors, and handles that smooth nodes align."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import torch
from scipy import sparse
from torch import Tensor

from warpvec.geometry.joints import Joints, unit_vectors


def curve_derivative(joints: Joints, points: list[Tensor], held: Tensor | None = None) -> sparse.csr_matrix:
    """Return the derivative of the curves of ``joints`` by ``points``, which are `Joints.values`: [8 R, 6 R], float64.

    Its rows are the coordinates of four points of each curve, its end included; its columns those of all anchors,
    then all leaving and all arriving handles. Handles of smooth nodes that are ``held`` [R, 2] keep their length.
    """
    anchor, leaving, arriving = (part.double() for part in points)
    blocks = _Blocks(len(anchor))
    own = torch.arange(len(anchor), device=anchor.device)
    blocks.add(0, own, 0, own, 1.0)
    blocks.add(3, own, 0, joints.following, 1.0)
    line, curve = own[joints.is_line], own[~joints.is_line]
    for point, share in ((1, 1 / 3), (2, 2 / 3)):
        blocks.add(point, line, 0, line, 1.0 - share)
        blocks.add(point, line, 0, joints.following[line], share)
    blocks.add(1, curve, 0, curve, 1.0)
    blocks.add(2, curve, 0, joints.following[curve], 1.0)
    held = torch.zeros_like(joints.least, dtype=torch.bool) if held is None else held
    for kind, node, found in _turning(joints, anchor, leaving, arriving, held):
        blocks.add(1, curve, kind, node[curve], found[0][curve])
        blocks.add(2, curve, kind, node[joints.following[curve]], found[1][joints.following[curve]])
    return blocks.matrix()


def _turning(
    joints: Joints, anchor: Tensor, leaving: Tensor, arriving: Tensor, held: Tensor
) -> Iterator[tuple[int, Tensor, tuple[Tensor, Tensor]]]:
    """Yield the derivatives of the aligned handles of each node: by a kind of value, of which node, and both."""
    ahead, behind = joints.ahead_and_behind(anchor, leaving, arriving)
    is_line, after_line = joints.is_line, joints.is_line[joints.preceding]
    by_ahead, by_behind = (~after_line).double(), (~is_line).double()
    mean = by_ahead[:, None] * ahead + by_behind[:, None] * behind
    length, unit = mean.norm(dim=1).clamp_min(1e-6), unit_vectors(mean)
    along = unit[:, :, None] * unit[:, None, :]
    whole = torch.eye(2, dtype=along.dtype, device=along.device).expand_as(along)
    across = (whole - along) / length[:, None, None]
    least = joints.least.double()
    reach = [
        torch.maximum((leaving * unit).sum(1), least[:, 0]),
        torch.minimum((arriving * unit).sum(1), -least[:, 1]),
    ]
    sides = [unit[:, :, None] * (handle[:, None] @ across) for handle in (leaving, arriving)]
    is_long = [~side[:, None, None] for side in held.unbind(1)]
    turns = [
        length[:, None, None] * across + torch.where(some, side, 0.0)
        for some, length, side in zip(is_long, reach, sides, strict=True)
    ]
    smooth, zero = joints.is_smooth[:, None, None], torch.zeros_like(along)
    chord_after, chord_before = by_ahead * is_line, by_behind * after_line
    own = torch.arange(len(anchor), device=anchor.device)
    parts = [
        (1, own, by_ahead * ~is_line, (1.0, 0.0)),
        (2, own, -by_behind * ~after_line, (0.0, 1.0)),
        (0, joints.following, chord_after, (0.0, 0.0)),
        (0, own, chord_before - chord_after, (0.0, 0.0)),
        (0, joints.preceding, -chord_before, (0.0, 0.0)),
    ]
    for kind, node, share, direct in parts:
        found = [
            torch.where(smooth, share[:, None, None] * turn + part * some * along, part * whole + zero)
            for turn, some, part in zip(turns, is_long, direct, strict=True)
        ]
        yield kind, node, (found[0], found[1])


class _Blocks:
    """Gathers blocks of 2 x 2 of a sparse matrix."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._parts: list[tuple[Tensor, Tensor, Tensor]] = []

    def add(self, point: int, curve: Tensor, kind: int, node: Tensor, value: Tensor | float) -> None:
        """Add a block each, or a factor: of a ``point`` of each ``curve`` by a ``kind`` of value of each ``node``."""
        if isinstance(value, float):
            value = value * torch.eye(2, dtype=torch.float64, device=curve.device).expand(len(curve), 2, 2)
        self._parts.append((4 * curve + point, kind * self._count + node, value))

    def matrix(self) -> sparse.csr_matrix:
        row, column, value = (torch.cat(part).cpu().numpy() for part in zip(*self._parts, strict=True))
        pair = np.arange(2)
        rows = np.broadcast_to(2 * row[:, None, None] + pair[:, None], value.shape)
        columns = np.broadcast_to(2 * column[:, None, None] + pair[None], value.shape)
        shape = (8 * self._count, 6 * self._count)
        return sparse.csr_matrix((value.ravel(), (rows.ravel(), columns.ravel())), shape=shape)

"""Add and remove the anchors of a scene of cubics.

Every operation changes many rows at once and leaves all others as they are, to the bit. An `Edit` also tells an
optimizer how the gradients of the new points follow from those of the old ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.lines import thirds
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure


@dataclass(frozen=True)
class Edit:
    """A scene with other segments: R' rows instead of R.

    Attributes:
        scene: the new scene, outside autograd.
        source: the two old rows that each new row comes from [R', 2] (int64). All rows but merged ones come from one,
            which is then stated twice.
        is_fresh: the new rows that differ from their first source [R'] (bool).
        weights: share of each old point's gradient in that of each new point [R', 2, 3, 3], none negative: the entry
            [r, k, j, i] is for point j of row r and point i of row source[r, k].
    """

    scene: Scene
    source: Tensor
    is_fresh: Tensor
    weights: Tensor


@torch.no_grad()
def split(scene: Scene, rows: Tensor, t: Tensor | float = 0.5) -> Edit:
    """Divide segments by new anchors, by de Casteljau's construction. The outline stays the same.

    Args:
        scene: a scene of cubics.
        rows: rows to divide [K]; a row that occurs several times gets as many anchors.
        t: parameters of the anchors [K] inside (0, 1), or one for all.

    Raises:
        InputError: a row does not exist, a parameter is outside (0, 1), or two of a row are equal.
    """
    rows, count = _checked_rows(scene, rows), scene.structure.segment_count
    t = torch.as_tensor(t, dtype=torch.float64, device=rows.device).expand(len(rows))
    if not bool(((t > 0.0) & (t < 1.0)).all()):
        raise InputError("t", "must be between 0 and 1, both excluded", str(t.tolist()), "leave the ends out")
    order = t.argsort(stable=True)
    order = order[rows[order].argsort(stable=True)]
    cut, t = rows[order], t[order]
    if bool(((cut[1:] == cut[:-1]) & (t[1:] == t[:-1])).any()):
        raise InputError("t", "must differ where a row is divided several times", str(t.tolist()), "give each once")
    piece_counts = 1 + cut.bincount(minlength=count)
    source = torch.arange(count, device=rows.device).repeat_interleave(piece_counts)
    added = cut + torch.arange(1, len(cut) + 1, device=rows.device)
    start, stop = torch.zeros_like(source, dtype=torch.float64), torch.ones_like(source, dtype=torch.float64)
    start[added], stop[added - 1] = t, t
    structure = _restructured(scene.structure, piece_counts, source)
    is_fresh = (piece_counts > 1)[source]
    segments = _pieces(whole_curves(scene)[source].double(), start, stop).to(scene.segments.dtype)
    new = _changed(scene, source, is_fresh, segments, structure)
    weights = torch.where(is_fresh[:, None, None], _split_weights(start, stop, structure.lines), _identity(source))
    return Edit(new, torch.stack([source, source], 1), is_fresh, _first_of_two(weights))


@torch.no_grad()
def merge(scene: Scene, rows: Tensor, handles: Tensor, share: Tensor) -> Edit:
    """Drop the anchors at the start of ``rows`` [K]: each becomes one segment with the row before it in its loop.

    Two lines become a line, unless it would be alone in its loop.

    Args:
        scene: a scene of cubics.
        rows: rows of the anchors to drop [K].
        handles: the handles of the new segments [K, 2, 2] in pixels.
        share: parameters at which these pass the dropped anchors [K], inside (0, 1), in float64.

    Raises:
        InputError: a row does not exist, occurs twice, is alone in its loop, or follows another one of ``rows``.
    """
    rows, structure = _checked_rows(scene, rows), scene.structure
    kept = torch.ones(structure.segment_count, dtype=torch.bool, device=rows.device)
    kept[rows] = False
    before = structure.segment_previous.long()[rows]
    if len(set(rows.tolist())) != len(rows):
        raise InputError("rows", "must occur once", _listed(rows), "leave the others out")
    if not bool(kept[before].all()):
        problem = "must not follow each other, nor be alone in their loop"
        raise InputError("rows", problem, _listed(rows[~kept[before]]), "merge every other row, then the rest")
    source = kept.nonzero().flatten()
    place = kept.cumsum(0)[before] - 1
    others = source.clone()
    others[place] = rows
    new_structure = _restructured(structure, kept.long(), source)
    is_fresh, segments = torch.zeros_like(source, dtype=torch.bool), scene.segments[source].detach()
    is_fresh[place] = True
    segments[place, 1:] = handles.to(segments.dtype)
    if structure.is_line is not None and new_structure.is_line is not None:
        is_alone = new_structure.segment_next.long()[place] == place
        new_structure.is_line[place] = structure.is_line[before] & structure.is_line[rows] & ~is_alone
    new = _changed(scene, source, is_fresh, segments, new_structure)
    weights = _first_of_two(_identity(source))
    weights[place] = _merge_weights(share)
    return Edit(new, torch.stack([source, others], 1), is_fresh, weights)


def _checked_rows(scene: Scene, rows: Tensor) -> Tensor:
    """Return ``rows`` in int64, if all exist in the scene of cubics."""
    if scene.degree != 3:
        raise InputError("scene", "must be of cubics", f"degree {scene.degree}", "convert it by to_cubics")
    rows, count = rows.to(scene.segments.device, torch.int64), scene.structure.segment_count
    if rows.dim() != 1 or not bool(((rows >= 0) & (rows < count)).all()):
        raise InputError("rows", f"must be a list of numbers from 0 to {count - 1}", str(rows.tolist()), "leave it out")
    return rows


def _listed(rows: Tensor) -> str:
    return ", ".join(map(str, rows[:5].tolist())) + (", ..." if len(rows) > 5 else "")


def _restructured(structure: Structure, counts: Tensor, source: Tensor) -> Structure:
    """Return the structure in which old row r has become ``counts[r]`` rows, all of them like their ``source``."""
    ends = torch.nn.functional.pad(counts.cumsum(0), (1, 0)).int()
    is_line = None if structure.is_line is None else structure.is_line[source]
    loops = ends[structure.loop_first_segment.long()]
    return Structure(loops, structure.path_first_loop, is_line, check=False)


def _changed(scene: Scene, source: Tensor, is_fresh: Tensor, segments: Tensor, structure: Structure) -> Scene:
    """Return the scene with ``segments`` in the fresh rows, and lines that are straight to the last bit."""
    start, end = segments[:, 0], segments[structure.segment_next.long(), 0]
    lines = torch.stack([start, *thirds(start, end)], 1)
    segments = torch.where((is_fresh & structure.lines)[:, None, None], lines, segments)
    kept = torch.where(is_fresh[:, None, None], segments, scene.segments[source].detach())
    return replace(scene.detach(), segments=kept, structure=structure)


def _pieces(control: Tensor, start: Tensor, stop: Tensor) -> Tensor:
    """Return anchor and handles [K, 3, 2] of the piece of each cubic [K, 4, 2] from ``start`` to ``stop`` [K]."""
    u, v = start[:, None, None], stop[:, None, None]
    at_start, both = _reduced(_reduced(control, u), u), _reduced(_reduced(control, u), v)
    anchor, leaving = _reduced(at_start, u), _reduced(at_start, v)
    return torch.cat([anchor, leaving, _reduced(both, v)], 1)


def _reduced(points: Tensor, t: Tensor) -> Tensor:
    """Take a step of de Casteljau's construction; it is exact at 0 and 1."""
    return (1.0 - t) * points[:, :-1] + t * points[:, 1:]


def _split_weights(start: Tensor, stop: Tensor, is_line: Tensor) -> Tensor:
    """Return the weights [R', 3, 3] of the row's own points in the gradients of its piece.

    The gradient of a point sums that of the outline near it, so a piece gets its share of it. Along a curve the two
    handles tell the gradient of the outline, along a line the anchor does. Half of an anchor's gradient is from the
    segment before, which stays.
    """
    share = stop - start
    before = torch.nn.functional.pad(share[:-1], (1, 0))
    weights = torch.zeros(len(share), 3, 3, dtype=torch.float64, device=share.device)
    is_first, near = start == 0.0, share + before
    weights[:, 0, 0] = torch.where(is_first, 0.5 + 0.5 * share, torch.where(is_line, 0.5 * near, 0.0))
    weights[:, 0, 1] = torch.where(is_first | is_line, 0.0, near * (1.0 - start))
    weights[:, 0, 2] = torch.where(is_first | is_line, 0.0, near * start)
    for j, place in enumerate((start, stop), 1):
        weights[:, j, 1], weights[:, j, 2] = share * (1.0 - place), share * place
    return weights


def _merge_weights(t: Tensor) -> Tensor:
    """Return the weights [K, 2, 3, 3] of two segments' points in the gradients of the one that replaces them.

    It passes the anchor between them at ``t`` [K]. The weights are the derivatives of the points that de Casteljau's
    construction makes of the one segment.
    """
    s, zero, one = 1.0 - t, torch.zeros_like(t), torch.ones_like(t)
    first = [[one, s, s * s], [zero, t, 2 * s * t], [zero, zero, t * t]]
    second = [[s**3, zero, zero], [3 * s * s * t, s * s, zero], [3 * s * t * t, 2 * s * t, s]]
    return torch.stack([torch.stack([torch.stack(row, -1) for row in part], -2) for part in (first, second)], 1)


def _identity(source: Tensor) -> Tensor:
    return torch.eye(3, dtype=torch.float64, device=source.device).expand(len(source), 3, 3)


def _first_of_two(weights: Tensor) -> Tensor:
    """Return weights [R', 2, 3, 3] that take all from the first source."""
    return torch.stack([weights, torch.zeros_like(weights)], 1)

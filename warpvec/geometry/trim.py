"""Cut closed cubic paths off at the edges of the canvas."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.geometry.lines import thirds
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

Curves = NDArray[np.float64]
"""Control points [K, 4, 2] of the K cubics of one closed path, ends included."""

HANDLE_EXCESS = 0.002
"""Pixels by which a handle may lie outside before its curve is halved. It is then moved onto the edge, which moves the
curve by three quarters of that at most: less than half of one level of 255."""

_HALVINGS = 12
"""Largest number of halvings. Each divides the distance of the handles from the curve by about four."""

_STRAIGHT = 1e-6
"""Pixels by which the handles of a line may miss its thirds, from rounding."""

_TOUCH = 1e-9
"""Parameters this close to an end of a curve, or to each other, are not cut apart."""


def trim(scene: Scene, height: int, width: int) -> Scene:
    """Return a scene of cubics whose points all lie on the canvas, and which looks the same there.

    Each loop is cut along the four edges in turn. Each part outside an edge is replaced by a straight line along the
    edge, which keeps the winding numbers inside, and with them the filled area. Paths that lie wholly outside are
    gone. Paths that lie wholly inside stay as they are, and so do soft ones: what lies outside is blurred into the
    picture. Torch does not differentiate through it.
    """
    scene = scene.detach()
    size = np.array([width, height], np.float64)
    segments = scene.segments.double().cpu().numpy()
    outside: NDArray[np.bool_] = np.any((segments < 0.0) | (segments > size), (1, 2))
    if scene.softness is not None:
        outside &= ~scene.softness.is_soft.cpu().numpy()[scene.structure.segment_path.cpu().numpy()]
    if not outside.any():
        return scene
    is_line, loops = scene.structure.lines.cpu().numpy(), []
    for start, stop in pairwise(scene.structure.loop_first_segment.tolist()):
        loop = segments[start:stop], is_line[start:stop]
        loops.append(_trimmed_loop(*loop, size) if outside[start:stop].any() else loop)
    first = scene.structure.path_first_loop.tolist()
    paths = [[loop for loop in loops[start:stop] if len(loop[0])] for start, stop in pairwise(first)]
    rows = [row for row, path in enumerate(paths) if path]
    kept = [loop for row in rows for loop in paths[row]]
    is_line = np.concatenate([np.zeros(0, np.bool_), *(mask for _, mask in kept)])
    structure = Structure.of_loops(
        [[len(points) for points, _ in paths[row]] for row in rows],
        torch.from_numpy(is_line) if is_line.any() else None,
    ).to(scene.segments.device)
    points = np.concatenate([np.zeros((0, 3, 2)), *(points for points, _ in kept)])
    chosen = torch.tensor(rows, dtype=torch.int64, device=scene.segments.device)
    if scene.forms is not None:
        cut = np.unique(scene.structure.segment_path.cpu().numpy()[outside])
        scene = replace(scene, forms=scene.forms.without(torch.from_numpy(cut).long()))
    return replace(scene.select(chosen), segments=torch.from_numpy(points).to(scene.segments), structure=structure)


def _trimmed_loop(
    points: NDArray[np.float64], is_line: NDArray[np.bool_], size: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the control points [K, 3, 2] of a loop within the canvas, and which of its rows are lines [K].

    New lines run along an edge of the canvas.
    """
    cut = _trimmed(points.reshape(-1, 2), size).reshape(-1, 3, 2)
    start, end = cut[:, 0], np.roll(cut[:, 0], -1, 0)
    off = cut[:, 1:] - np.stack(thirds(start, end), 1)
    straight: NDArray[np.bool_] = np.all(np.abs(off) < _STRAIGHT, (1, 2))
    on_edge: NDArray[np.bool_] = np.any((start == end) & ((start == 0.0) | (start == size)), 1)
    return cut, straight & (is_line.any() | on_edge)


def _trimmed(path: NDArray[np.float64], size: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points [3 K, 2] of a loop [3 S, 2] within the canvas; none if it is outside."""
    closed = np.concatenate([path, path[:1]])
    curves = np.stack([closed[start : start + 4] for start in range(0, len(path), 3)])
    for axis in (0, 1):
        curves = cut_at(curves, axis, 0.0, -1.0)
        curves = cut_at(curves, axis, size[axis], 1.0)
    return np.clip(_with_near_handles(curves, size), 0.0, size)[:, :3].reshape(-1, 2)


def cut_at(curves: Curves, axis: int, bound: float, side: float) -> Curves:
    """Replace each part beyond the line at ``bound`` of ``axis`` by a part of that line.

    ``side`` is 1 where greater coordinates are outside, -1 where smaller ones are.
    """
    excess = side * (curves[:, :, axis] - bound)
    if (excess <= 0.0).all():
        return curves
    cut = [piece for curve, height in zip(curves, excess, strict=True) for piece in _split(curve, _roots(height))]
    pieces = np.stack([piece for piece in cut if (piece != piece[0]).any()] or [curves[0]])
    middle = pieces[:, :, axis] @ np.array([1.0, 3.0, 3.0, 1.0]) / 8.0
    inside = side * (middle - bound) < 0.0
    if inside.all() or not inside.any():
        return pieces[inside]
    first = int(np.flatnonzero(inside & ~np.roll(inside, 1))[0])
    return _bridged(np.roll(pieces, -first, 0), np.roll(inside, -first), axis, bound)


def _bridged(pieces: Curves, inside: NDArray[np.bool_], axis: int, bound: float) -> Curves:
    """Replace each run of outside pieces by a straight line. The first piece is inside, the last one outside."""
    result: list[NDArray[np.float64]] = []
    lines = []
    for is_inside, run in groupby(range(len(pieces)), key=lambda index: bool(inside[index])):
        indices = list(run)
        if is_inside:
            result += [pieces[index] for index in indices]
            continue
        ends = np.stack([pieces[indices[0], 0], pieces[indices[-1], 3]])
        ends[:, axis] = bound
        lines.append(len(result))
        result.append(np.linspace(ends[0], ends[1], 4))
    bridged = np.stack(result)
    for index in lines:  # the ends of their neighbours, exactly on the line too
        bridged[index - 1, 3] = bridged[index, 0]
        bridged[(index + 1) % len(bridged), 0] = bridged[index, 3]
    return bridged[(bridged != bridged[:, :1]).any((1, 2))]


def _roots(heights: NDArray[np.float64]) -> list[float]:
    """Return the parameters inside (0, 1), sorted, at which a cubic with the Bezier ordinates ``heights`` [4] is 0."""
    if (heights <= 0.0).all() or (heights >= 0.0).all():
        return []
    a, b, c, d = heights
    power = np.array([d - 3 * c + 3 * b - a, 3 * (c - 2 * b + a), 3 * (b - a), a])
    scale = np.abs(heights).max()
    power[np.abs(power) < 1e-14 * scale] = 0.0
    found = np.roots(power)
    real = np.sort(found.real[np.abs(found.imag) < 1e-7])
    slopes = np.polyder(power)
    for _ in range(2):  # Newton's steps, for the last digits
        slope = np.polyval(slopes, real)
        real = real - np.polyval(power, real) / np.where(np.abs(slope) > 1e-6 * scale, slope, np.inf)
    roots: list[float] = []
    for root in sorted(real.tolist()):
        if (roots[-1] if roots else 0.0) + _TOUCH < root < 1.0 - _TOUCH:
            roots.append(root)
    return roots


def _split(curve: NDArray[np.float64], parameters: list[float]) -> Iterator[NDArray[np.float64]]:
    """Yield the pieces [4, 2] of a cubic between the sorted ``parameters``."""
    start = 0.0
    for parameter in parameters:
        head, curve = _halves(curve, (parameter - start) / (1.0 - start))
        yield head
        start = parameter
    yield curve


def _halves(curve: NDArray[np.float64], share: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cut a cubic, or each of several [..., 4, 2], at the parameter ``share``, by de Casteljau's construction."""
    a, b, c, d = np.moveaxis(curve, -2, 0)
    ab, bc, cd = a + share * (b - a), b + share * (c - b), c + share * (d - c)
    abc, bcd = ab + share * (bc - ab), bc + share * (cd - bc)
    middle = abc + share * (bcd - abc)
    return np.stack([a, ab, abc, middle], -2), np.stack([middle, bcd, cd, d], -2)


def _with_near_handles(curves: Curves, size: NDArray[np.float64]) -> Curves:
    """Halve the curves whose handles lie outside although they themselves do not, until the handles are near them."""
    for _ in range(_HALVINGS):
        far: NDArray[np.bool_] = np.any(np.maximum(-curves, curves - size) > HANDLE_EXCESS, (1, 2))
        if not far.any():
            break
        pieces = [_halves(curve, 0.5) if each else (curve,) for curve, each in zip(curves, far.tolist(), strict=True)]
        curves = np.stack([piece for group in pieces for piece in group])
    return curves

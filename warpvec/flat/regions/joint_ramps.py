"""Ramps that several regions show together.

A noisy picture has areas of pure pixels that are too small to show a ramp, and steep ramps of a clean picture have no
such areas. Both are broken into flat regions at first.
"""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Floats32, Integers, Integers32
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.color_moments import moments_of
from warpvec.flat.regions.inside_pixels import InsidePixels, seen
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paint_fitting import ramp_of_pixels
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.ramp_fitting import Ramp
from warpvec.flat.regions.ramp_joining import join_regions
from warpvec.geometry.paints.registry import FLAT
from warpvec.watch.watch import UNWATCHED, Watch


def with_joint_ramps(
    image: Floats32, assignment: Assignment, paints: Paints, tolerances: Tolerances, canvas: int | None,
    watch: Watch = UNWATCHED,
) -> Paints:  # fmt: skip
    """Join the regions of a picture that one ramp shows, and return the paints of those that are left.

    Args:
        image: the picture [h, w, 4], sRGB with straight alpha.
        assignment: the shares of the regions, which it changes.
        paints: paints of the regions [K].
        tolerances: those of the picture.
        canvas: the region behind all others, which stays; or None.
        watch: the watch over the run. When it is over, the regions that are left stay.
    """
    inside = InsidePixels.of(image, assignment, paints)
    is_chosen = inside.are_typical(paints) & (paints.opacity == 1)
    if canvas is not None:
        is_chosen[canvas] = False
    areas = inside.areas(len(paints))
    is_chosen[np.argsort(-areas, kind="stable")[REGIONS.joined_max :]] = False
    inside = inside.of_regions(is_chosen)
    union = join_regions(*inside.shown(paints), len(paints), watch)
    is_joined = np.bincount(union, minlength=len(paints)) > 1
    if is_joined.any():
        _rename(assignment, union)
        inside = InsidePixels.of(image, assignment, paints).of_regions(is_chosen)
    pixels = inside.of_each_region()
    for name, (points, colors) in pixels.items():
        if watch.is_over():
            break
        if paints.kind[name] == FLAT or is_joined[name]:
            ramp = _ramp_of(points, colors, tolerances, must_have_one=bool(is_joined[name]))
            paints = paints if ramp is None else paints.replaced(name, ramp.paint(1.0))
    paints = _with_shared_ramps(paints, pixels, tolerances, watch)
    _rename(assignment, _alike_neighbors(assignment.label, paints))
    return _without_unused(assignment, paints)


def _ramp_of(points: Floats, colors: Floats, tolerances: Tolerances, *, must_have_one: bool) -> Ramp | None:
    """Return the ramp that the ``colors`` [N, 3] of ``points`` [N, 2] show, or None if they are too much alike.

    A large region has as many stops as pay, a small one two.
    """
    if len(points) < REGIONS.joint_area_min and not must_have_one:
        return None
    ramp = ramp_of_pixels(points, colors, tolerances) if len(points) >= REGIONS.noisy_ramp_area_min else None
    if ramp is not None:
        return ramp
    moments = moments_of(np.zeros(len(points), np.int64), colors, points, 1)[0]
    linear = moments.ramp()
    ramp = linear.between(points)
    is_seen = ramp.contrast(tolerances.metric) >= REGIONS.ramp_contrast + tolerances.noise
    pays = linear.rest < REGIONS.plain_ramp_gain**2 * moments.flat_rest()
    return ramp if must_have_one or (is_seen and pays) else None


def _with_shared_ramps(
    paints: Paints, pixels: dict[int, tuple[Floats, Floats]], tolerances: Tolerances, watch: Watch
) -> Paints:
    """Return ``paints`` with the ramp of a large region in place of those of small ones that it shows about as well.

    ``pixels`` are the centres [M, 2] and colours [M, 3] of the pixels inside each region.
    """
    limit = REGIONS.flat_deviation + REGIONS.noise_deviation * tolerances.noise
    order = sorted(pixels, key=lambda name: (-len(pixels[name][0]), name))
    large = [name for name in order if len(pixels[name][0]) >= REGIONS.noisy_ramp_area_min]
    givers = [name for name in large if paints.kind[name] != FLAT]
    for name in order[len(large) :]:
        if watch.is_over():
            break
        points, colors = pixels[name]
        most = max(limit, REGIONS.joint_shared * _error(paints, name, points, colors))
        giver = next((each for each in givers if _error(paints, each, points, colors) <= most), None)
        if giver is not None:
            paints = paints.replaced(name, paints.select(np.array([giver])))
    return paints


def _error(paints: Paints, name: int, points: Floats, colors: Floats) -> float:
    """Return the root mean square that a paint leaves of the ``colors`` [N, 3] of ``points`` [N, 2]."""
    return float(np.sqrt(((colors - seen(paints, np.full(len(points), name, np.int32), points)) ** 2).mean()))


def _alike_neighbors(label: Integers32, paints: Paints) -> Integers:
    """Return for each of K regions the first of those that it borders on in ``label`` [h, w] with the same ramp."""
    alike = paints.first_equal_ramp()
    sides = ((label[:, 1:], label[:, :-1]), (label[1:], label[:-1]))
    first, second = (np.concatenate([side[number].ravel() for side in sides]) for number in (0, 1))
    is_link = (first != second) & (alike[first] == alike[second])
    parts = connected_parts(first[is_link], second[is_link], len(paints))
    return np.unique(parts, return_index=True)[1][parts]


def _rename(assignment: Assignment, names: Integers) -> None:
    """Give the regions of ``assignment`` the ``names`` [K]. Mixes of two regions of one name are pure."""
    for part in (assignment.label, assignment.other):
        part[...] = names[part]
    is_known = assignment.anchors >= 0
    assignment.anchors[is_known] = names[assignment.anchors[is_known]]
    assignment.share[assignment.label == assignment.other] = 1.0


def _without_unused(assignment: Assignment, paints: Paints) -> Paints:
    """Return the ``paints`` that pixels of ``assignment`` have, and number its regions anew."""
    used = np.unique(np.concatenate([assignment.label.ravel(), assignment.other.ravel()]))
    number = np.zeros(len(paints), np.int64)
    number[used] = np.arange(len(used))
    _rename(assignment, number)
    return paints.select(used)

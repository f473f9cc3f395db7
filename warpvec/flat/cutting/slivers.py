"""Slivers between outlines that nearly coincide: they go to their neighbours."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.planar_map import PlanarMap


def without_slivers(mapped: PlanarMap, owners: Integers, path_of_edge: Integers) -> tuple[Integers, int]:
    """Return the owner of each face [F] with no slivers left, and how many there were.

    A sliver goes to the neighbour behind the lowest of its outlines, so that the uppermost outline stays whole.

    Args:
        owners: owner of each face [F].
        path_of_edge: path of each edge [E]; the last one is the canvas, over which nothing goes, and -1 is the mouth
            of a spur, which parts two regions of one owner.
    """
    owners, count, length = owners.copy(), 0, mapped.lengths()
    areas = mapped.areas()
    is_border = np.repeat((path_of_edge == mapped.winding.shape[1] - 1) | (path_of_edge < 0), 2)
    for _ in range(CUTTING.sliver_rounds_max):
        region = _regions(mapped, owners, path_of_edge >= 0)
        across = region[mapped.face.reshape(-1, 2)[:, ::-1].reshape(-1)]
        is_outline = region[mapped.face] != across
        region_area = np.bincount(region, areas)
        outline = np.bincount(region[mapped.face][is_outline], length[is_outline], len(region_area))
        is_sliver = region_area < CUTTING.sliver_width * outline / 2
        is_sliver[region[0]] = False
        changed: set[int] = set()
        for number in sorted(np.flatnonzero(is_sliver).tolist(), key=lambda each: float(region_area[each])):
            half_edges = np.flatnonzero(is_outline & (region[mapped.face] == number) & ~is_border)
            neighbour = _neighbour(across[half_edges], np.repeat(path_of_edge, 2)[half_edges], length[half_edges])
            if neighbour is not None and neighbour not in changed:
                owners[region == number] = owners[np.flatnonzero(region == neighbour)[0]]
                changed.add(number)
        count += len(changed)
        if not changed:
            break
    return owners, count


def _neighbour(across: Integers, path: Integers, length: Floats) -> int | None:
    """Return the neighbour of a sliver that gets it; None if it has none."""
    whole = length.sum()
    for lowest in np.unique(path):
        chosen = path == lowest
        if length[chosen].sum() >= CUTTING.sliver_share_min * whole:
            shared = np.bincount(across[chosen], length[chosen])
            return int(shared.argmax())
    return int(np.bincount(across, length).argmax()) if len(across) else None


def _regions(mapped: PlanarMap, owners: Integers, joins: Mask) -> Integers:
    """Return the number of the connected part of one owner that each face is in [F]; edges that ``joins`` connect."""
    sides = mapped.face.reshape(-1, 2)[joins]
    same = sides[owners[sides[:, 0]] == owners[sides[:, 1]]]
    return connected_parts(same[:, 0], same[:, 1], len(owners))

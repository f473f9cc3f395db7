"""Lines along which a drawing is cut, each edge once: a laser that goes along an edge twice burns it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats
from warpvec.flat.cutting.arrangement import arranged
from warpvec.flat.cutting.cut_edges import Chain, CutEdges
from warpvec.flat.cutting.fewest_parts import CurvePart, fewest_parts
from warpvec.geometry.scene import Scene


class CutLine(NamedTuple):
    """Consecutive parts of curves, and whether the last one ends where the first one starts."""

    parts: list[CurvePart]
    is_closed: bool


def cut_lines(scene: Scene, width: float, height: float) -> list[CutLine]:
    """Return the lines between what shows of ``scene``, whose canvas is ``width`` x ``height`` pixels, each once.

    Where edges meet, the two go on as one line that turn least. The edge between the background and what lies beyond
    the canvas is none.
    """
    laid = arranged(scene, width, height)
    page = () if scene.transparent else (0,)
    is_page = np.array([key == page for key in laid.keys])
    chains = list(
        CutEdges(laid.mapped, np.where(is_page[laid.owners], 0, laid.owners), laid.cubics, laid.is_line).chains()
    )
    lines = list(_joined(chains))
    fewer = fewest_parts([line.parts for line in lines])
    return [CutLine(parts, line.is_closed) for line, parts in zip(lines, fewer, strict=True)]


_End = tuple[int, bool]
"""A chain, and whether it is its end or its start."""


def _joined(chains: list[Chain]) -> Iterator[CutLine]:
    """Yield all ``chains``, joined where they meet."""
    mates = _mates(chains)
    waiting = dict.fromkeys(range(len(chains)))
    # Open lines first: what is left then are rings.
    starts = [end for end in ((k, side) for k in waiting for side in (False, True)) if end not in mates]
    for end in [*starts, *((k, False) for k in range(len(chains)))]:
        if end[0] not in waiting:
            continue
        parts, here = [], end
        while True:
            chain, is_back = here
            del waiting[chain]
            own = chains[chain].parts
            parts += [part.reversed() for part in own[::-1]] if is_back else own
            following = mates.get((chain, not is_back))
            if following is None or following[0] not in waiting:
                break
            here = following
        yield CutLine(parts, following == end or chains[chain].is_closed)


def _mates(chains: list[Chain]) -> dict[_End, _End]:
    """Return the end of a chain with which each end goes on, if there is one."""
    meeting = defaultdict(list)
    for k, chain in enumerate(chains):
        if not chain.is_closed:
            meeting[chain.start].append((k, False))
            meeting[chain.end].append((k, True))
    mates: dict[_End, _End] = {}
    for ends in meeting.values():
        away = {end: _direction(chains[end[0]], end[1]) for end in ends}
        for one, two in sorted(combinations(ends, 2), key=lambda pair: float(away[pair[0]] @ away[pair[1]])):
            if one not in mates and two not in mates:
                mates[one], mates[two] = two, one
    return mates


def _direction(chain: Chain, is_end: bool) -> Floats:
    """Return the unit vector [2] along which ``chain`` leaves one of its ends."""
    part = chain.parts[-1].reversed() if is_end else chain.parts[0]
    along = part.cubic[1:] - part.cubic[0]
    length = np.hypot(*along.T)
    first = int((length > 1e-3 * length.max()).argmax())
    return along[first] / max(length[first], 1e-12)

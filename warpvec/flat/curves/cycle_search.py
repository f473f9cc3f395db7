"""The cheapest cycle of pieces around a loop."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats


def cheapest_cycle(cost: Floats) -> list[int]:
    """Return the nodes of the cheapest cycle, in order, at least two.

    Args:
        cost: costs [n, K] of the piece from each node to that k + 1 nodes further around the loop of n nodes. Those of
            k = 0 are finite.

    Two rounds from an arbitrary node end up on the best cycle, or close to it; a node of the second half of the first
    round is then where the cycle begins.
    """
    count, longest = cost.shape
    longest = min(longest, count - 1)
    node = np.arange(count)[:, None]
    length = np.arange(longest, 0, -1)
    incoming = cost[(node - length) % count, length - 1]  # column j: from the node that is longest - j behind
    path = _cheapest_path(incoming, 0, 2 * count)
    begin = min(path, key=lambda place: abs(place - count)) % count
    return [(begin + place) % count for place in _cheapest_path(incoming, begin, count)[:-1]]


def _cheapest_path(incoming: Floats, begin: int, steps: int) -> list[int]:
    """Return the places of the cheapest path from node ``begin``, 0, to ``steps`` nodes further."""
    count, longest = incoming.shape
    best = np.full(longest + steps + 1, np.inf)
    best[longest] = 0.0
    came = np.zeros(steps + 1, np.int64)
    for place in range(1, steps + 1):
        total = best[place : place + longest] + incoming[(begin + place) % count]
        lowest = int(total.argmin())
        best[longest + place], came[place] = total[lowest], longest - lowest
    path = [steps]
    while path[-1] > 0:
        path.append(path[-1] - int(came[path[-1]]))
    return path[::-1]

"""Divide closed walks where they pass a place twice."""

from __future__ import annotations

from collections.abc import Hashable, Sequence


def simple_walks(places: Sequence[Hashable]) -> list[list[int]]:
    """Return the closed walks that a closed walk along ``places`` [n] consists of, none of which passes a place twice.

    Each walk is a list of numbers of places, in order; together they are 0 to n - 1.
    """
    found: list[list[int]] = []
    way: list[int] = []
    first: dict[Hashable, int] = {}
    for number, place in enumerate(places):
        if place in first:
            start = first[place]
            found.append(way[start:])
            for gone in way[start:]:
                del first[places[gone]]
            del way[start:]
        first[place] = len(way)
        way.append(number)
    return [*found, way] if way else found

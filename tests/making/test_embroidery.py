"""What will go wrong in embroidery is listed with its place, and nothing else."""

from __future__ import annotations

import pytest

pytest.importorskip("shapely")
pytest.importorskip("ezdxf")

from warpvec.making.embroidery import embroidery_warnings
from warpvec.making.parts import read_parts

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40">'


def warnings_of(elements: str) -> list[str]:
    return embroidery_warnings(read_parts(f"{HEAD}{elements}</svg>"))


def test_a_narrow_bar_a_narrow_gap_and_a_crossing_are_listed_with_their_places() -> None:
    bar = '<path fill="#c00" d="M5 5h20v.6h-20z"/>'
    pair = '<path fill="#00c" d="M5 15h10v10h-10zM15.3 15h10v10h-10z"/>'
    bow = '<path fill="#0a0" d="M40 10l12 12v-12l-12 12z"/>'
    found = warnings_of(bar + pair + bow)
    assert any(each.startswith("#cc0000: narrower than 1 mm at 15.0, 5.") for each in found)
    assert any(each.startswith("a gap below 0.4 mm at 15.") for each in found)
    assert any(each.startswith("#00aa00: an outline crosses itself at ") for each in found)


def test_wide_shapes_that_touch_or_lie_apart_are_fine() -> None:
    assert (
        warnings_of('<path fill="#c00" d="M5 5h10v10h-10z"/><path fill="#00c" d="M15 5h10v10h-10zM30 5h9v9h-9z"/>')
        == []
    )

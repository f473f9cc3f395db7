"""What the page hands to machines that cut."""

from __future__ import annotations

from io import StringIO

import numpy as np
import pytest

from warpvec.app.export import encode
from warpvec.app.making import SHEETS_MAX, WARNINGS_MAX, cut_facts
from warpvec.errors import InputError
from warpvec.making import packages

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60">'
SQUARE = f'{HEAD}<rect fill="#00f" x="10" y="10" width="40" height="40"/></svg>'


def test_without_the_extra_sheets_and_warnings_are_refused_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packages, "find_spec", lambda name: None)
    for ask in (lambda: encode(SQUARE, "zip"), lambda: encode(SQUARE, "cut.dxf"), lambda: cut_facts(SQUARE, "vinyl")):
        with pytest.raises(InputError, match=r"need the packages of the extra cut.*pip install 'warpvec\[cut\]'"):
            ask()


def test_a_thin_line_tears_when_it_is_cut_but_a_pen_draws_it() -> None:
    pytest.importorskip("shapely")
    line = f'{HEAD}<path fill="none" stroke="#f00" stroke-width="0.26" d="M10 30H90"/></svg>'
    assert ["may tear" in each for each in cut_facts(line, "vinyl")["warnings"]] == [True]
    assert cut_facts(line, "pen")["warnings"] == []
    with pytest.raises(InputError, match="machine must be one of vinyl, laser, pen, stencil"):
        cut_facts(line, "plough")


def test_a_laser_cuts_an_edge_of_two_parts_once() -> None:
    ezdxf = pytest.importorskip("ezdxf")
    pytest.importorskip("shapely")
    from ezdxf import path

    two = f'{HEAD}<path fill="#f00" d="M10 10h20v30h-20z"/><path fill="#00f" d="M30 10h20v30h-20z"/></svg>'
    lengths = {}
    for kind in ("dxf", "cut.dxf"):
        lines = ezdxf.read(StringIO(encode(two, kind).data.decode())).modelspace().query("LWPOLYLINE LINE")
        points = (np.array([place.vec2 for place in path.make_path(each).flattening(0.1)]) for each in lines)
        lengths[kind] = sum(float(np.hypot(*np.diff(each, axis=0).T).sum()) for each in points)
    assert lengths == pytest.approx({"dxf": 200.0, "cut.dxf": 170.0}, abs=0.01)


def squares(count: int) -> str:
    """Return a drawing of squares of 1 mm, each of a colour of its own."""
    rects = (
        f'<rect fill="#{2 * i:06x}" x="{i % 40 * 2}" y="{i // 40 * 2}" width="1" height="1"/>' for i in range(count)
    )
    return f"{HEAD}{''.join(rects)}</svg>"


def test_only_a_drawing_of_few_colours_gets_sheets_and_only_the_first_warnings_are_listed() -> None:
    pytest.importorskip("shapely")
    for ask in (lambda text: encode(text, "zip"), lambda text: cut_facts(text, "vinyl")):
        with pytest.raises(InputError, match=f"at most {SHEETS_MAX} colours, a sheet each, got {SHEETS_MAX + 1};"):
            ask(squares(SHEETS_MAX + 1))
    found = cut_facts(squares(SHEETS_MAX), "vinyl")["warnings"]
    assert len(found) == WARNINGS_MAX + 1 and found[-1] == f"and {SHEETS_MAX - WARNINGS_MAX} more"

"""What a file says it consists of: kinds of shapes, looks of strokes in pixels, and parameters."""

from __future__ import annotations

import pytest

from warpvec.svg.measure import file_facts

SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 240 240" width="24" height="24">{}</svg>'
LINE = '<path fill="none" stroke="#000" {} d="M0 0h9"/>'


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('<circle r="2"/><circle r="3"/><path d="M0 0h9v9z"/>', "2 circles, 1 path; 10 parameters"),
        (LINE.format('stroke-width="20" stroke-linecap="round"') * 3, "3 strokes (2.0 px, round); 6 parameters"),
        (LINE.format('stroke-width="20"') + LINE.format('style="stroke-width:50"'), "2 strokes (2.0 to 5.0 px); 4"),
        ('<g fill="none" stroke="red" stroke-width="15"><circle r="2"/><line/></g>',
         "1 circle (stroked, 1.5 px), 1 stroke (1.5 px); 7 parameters"),
        ('<rect width="9" stroke="#000"/><rect width="3"/>', "2 rectangles (1 stroked, 0.1 px); 12 parameters"),
        ('<path d="M0 0h9v9z" stroke="#000"/><defs><circle r="2"/></defs>', "1 path (stroked, 0.1 px); 4 parameters"),
        ('<g stroke="#000"><path stroke="none" d="M0 0h9v9z"/></g>', "1 path; 4 parameters"),
    ],
)  # fmt: skip
def test_a_file_says_what_it_has(body: str, words: str) -> None:
    found = file_facts(SVG.format(body))["found"]
    assert found == words if words.endswith("parameters") else found.startswith(words)


def test_looks_of_strokes_are_counted_in_pixels() -> None:
    thin, thick = LINE.format('stroke-width="5" stroke-linejoin="bevel"'), LINE.format('stroke-width="20"')
    looks = file_facts(SVG.format(thin + thick * 2))["stroke_looks"]
    assert looks == [
        {"width": 2.0, "cap": "butt", "join": "miter", "count": 2},
        {"width": 0.5, "cap": "butt", "join": "bevel", "count": 1},
    ]

"""The page of a small icon keeps its colour, though fits move it a little."""

from __future__ import annotations

import pytest
import torch

from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.drawing import snapped_canvas

WHITE, BEIGE = (255.0, 255.0, 255.0), (245.0, 245.0, 220.0)


@pytest.mark.parametrize(
    ("fitted", "traced", "expected"),
    [
        ((251.2, 253.7, 252.6), WHITE, WHITE),
        ((241.0, 246.0, 217.0), BEIGE, BEIGE),
        ((253.9, 253.4, 252.2), (254.0, 244.0, 240.0), WHITE),
        ((230.0, 240.0, 220.0), BEIGE, (230.0, 240.0, 220.0)),
    ],
)
def test_a_canvas_is_as_it_was_traced_or_white_if_the_fit_moved_it_little(
    fitted: tuple[float, ...], traced: tuple[float, ...], expected: tuple[float, ...]
) -> None:
    found = snapped_canvas(torch.tensor(fitted) / 255.0, torch.tensor(traced) / 255.0, DRAWING.snap_canvas)
    assert torch.equal(found, torch.tensor(expected) / 255.0)

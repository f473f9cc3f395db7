"""Rounds of a polish that go on with the edges that resvg draws."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import warpvec
from warpvec.polish import drawn_rounds
from warpvec.svg.measure import draw

OPENING = '<svg xmlns="http://www.w3.org/2000/svg" width="96" height="96">'


def _stars(shift: float) -> str:
    """Return a drawing of two thin shapes with slanted and curved edges, moved by ``shift`` px."""
    a, b = 8.3 + shift, 51.7 - 0.7 * shift
    blade = f'<path fill="#136" d="M{a} 9.1L{a + 37.3} {14.6 - shift}L{a + 30.2} 84.4C{a + 9} 70 {a - 3} 40 {a} 9.1z"/>'
    drop = f'<path fill="#c40" d="M{b} 12.2C{b + 46} 22.3 {b + 42} {70 + shift} {b + 6.5} 86.9L{b + 11.3} 47.4z"/>'
    return OPENING + blade + drop + "</svg>"


def _photo() -> NDArray[np.uint8]:
    """Return a picture with a texture that no path has, so that the fit ends at a residual of its own."""
    picture = draw(_stars(0.0), 96, 96).astype(np.int16)
    noise = np.random.default_rng(0).normal(0.0, 1.0, picture.shape)
    return np.clip(picture + np.round(noise), 0, 255).astype(np.uint8)


def test_rounds_make_the_file_better_and_share_the_iterations(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []
    result = warpvec.refine(
        _photo(), _stars(1.2), iterations=120, threads=1, on_progress=lambda step: seen.append(step.iteration)
    )
    monkeypatch.setattr(drawn_rounds, "ROUNDS", 0)
    without = warpvec.refine(_photo(), _stars(1.2), iterations=120, threads=1)
    assert result.metrics["psnr"] > without.metrics["psnr"] + 0.02
    assert without.run.iterations < result.run.iterations == len(seen) <= 120
    assert seen == list(range(1, len(seen) + 1))
    few = without.run.iterations + 3
    monkeypatch.setattr(drawn_rounds, "ROUNDS", 3)
    assert warpvec.refine(_photo(), _stars(1.2), iterations=few, threads=1).run.iterations <= few

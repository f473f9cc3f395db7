"""What a drawing could not keep of its picture, from what its run has found out."""

from __future__ import annotations

import numpy as np
from damage import drawn, levels_of, noisy
from numpy.typing import NDArray

import warpvec


def not_kept(picture: NDArray[np.uint8], **settings: object) -> dict[str, str]:
    result = warpvec.vectorize(picture, threads=1, iterations=6, **settings)
    found = result.metrics["not_kept"]
    assert isinstance(found, dict)
    return found


def test_a_clean_drawing_keeps_all() -> None:
    assert not_kept(np.asarray(drawn(96))) == {}


def test_what_settings_and_noise_cost_is_said() -> None:
    ramp = np.full((56, 56, 3), 255, np.uint8)
    ramp[8:44, 8:44] = np.linspace((0, 0, 160), (0, 0, 96), 36)[:, None]
    assert not_kept(ramp, gradients=0) == {"shades": "1 gradient, one colour each"}
    assert not_kept(ramp) == {}
    assert set(not_kept(ramp, mode="mono")) == {"colors"}
    assert "2" in not_kept(ramp, colors=2)["colors"]
    grain = levels_of(noisy(drawn(160), 9.0)).astype(np.uint8)
    assert set(not_kept(grain)) == {"noise"}
    assert set(not_kept(grain, mode="photo", curves=4)) == {"shades", "texture"}


def test_a_refined_drawing_has_lost_what_it_had_lost() -> None:
    ramp = np.full((40, 40, 3), 255, np.uint8)
    ramp[8:32, 8:32] = 128
    first = warpvec.vectorize(ramp, threads=1)
    assert warpvec.refine(ramp, first.svg(), iterations=1).metrics["not_kept"] == {}

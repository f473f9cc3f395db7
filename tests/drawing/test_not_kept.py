"""A drawing says what of its picture is lost: words too small, colours, shades, noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

import warpvec
from warpvec.condition.condition import Condition
from warpvec.drawing.not_kept import LEGIBLE_HEIGHT, not_kept
from warpvec.flat.constants.lettering import LETTERING
from warpvec.geometry.softness import Softness

RAMP = np.full((32, 32, 3), 255, np.uint8)
QUICK = {"threads": 1, "iterations": 2}
RAMP[6:26, 6:26] = np.linspace((0, 0, 160), (0, 0, 96), 20)[:, None]


def test_what_settings_cost_is_said() -> None:
    plain, flat = (warpvec.vectorize(RAMP, mode="flat", **QUICK, **more) for more in ({}, {"gradients": 0}))
    assert plain.metrics["not_kept"] == {}
    assert flat.metrics["not_kept"] == {"shades": "1 gradient (drawn in one colour each)"}
    photo = warpvec.vectorize(RAMP, mode="photo", curves=2, **QUICK)
    assert set(photo.metrics["not_kept"]) == {"shades", "texture"}
    scene = photo.drawing.scene
    soft = replace(photo.drawing, scene=replace(scene, softness=Softness(torch.ones(len(scene)))))
    assert not_kept(soft)["shades"].endswith("but for 2 soft paths)")
    assert not_kept(replace(photo.drawing, start_psnr=20.0)) == {}  # it was refined


def test_a_grid_that_is_not_kept_is_said() -> None:
    kept, lost = (warpvec.vectorize(RAMP, mode="flat", grid=16, purpose=use, **QUICK) for use in ("web", "plain"))
    assert (kept.metrics["grid"], kept.metrics["not_kept"]) == (16, {})
    assert lost.metrics["not_kept"] == {"grid": "the grid of 16 units (the file is in pixels)"}


def test_what_was_removed_is_said() -> None:
    drawing = warpvec.vectorize(RAMP, mode="flat", **QUICK).drawing
    encoding = replace(drawing.encoding, picture=replace(drawing.encoding.picture, is_restored=True))
    noisy = replace(drawing, condition=Condition(noise=(9.0, 9.0, 9.0)))
    assert not_kept(noisy) == {}  # measured, but left alone
    found = not_kept(replace(noisy, encoding=encoding, left_out={"speck": 3, "node": 9}, roughly={"small word": 1}))
    assert found["specks"].startswith("3 specks") and found["text"].endswith("below 7 px, not legible in 1 place")
    assert set(found) == {"text", "noise", "specks"}
    assert LETTERING.legible_height == LEGIBLE_HEIGHT

"""What a picture says of its drawing: misfits in nats."""

from __future__ import annotations

import math

import numpy as np
from damage import as_jpeg, drawn, levels_of
from PIL import Image

from warpvec.condition.jpeg import Jpeg
from warpvec.flat.evidence.evidence import Evidence


def test_the_misfit_is_half_the_squared_distance_over_the_variance_up_to_a_literal_pixel() -> None:
    evidence = Evidence(np.full((2, 3, 3), 100.0), np.array([2.0, 2.0, 2.0]))
    shown = evidence.levels.copy()
    shown[0, 0] += (2.0, 0.0, 4.0)
    shown[1, 2] += 200.0
    nats = evidence.misfit(shown)
    assert math.isclose(nats[0, 0], (1.0 + 4.0) / 2.0)
    assert math.isclose(nats[1, 2], evidence.literal_nats)
    assert nats.sum() == nats[0, 0] + nats[1, 2]


def test_a_clean_drawing_fits_its_jpeg_by_the_steps_and_another_one_does_not() -> None:
    clean, quality = levels_of(drawn(96)).astype(np.float64), 50
    saved = (levels_of(as_jpeg(drawn(96), quality)) / 255.0).astype(np.float32)
    evidence = Evidence.of(saved, Jpeg(quality, is_subsampled=True))
    moved = np.roll(clean, 3, axis=1)
    own, other = (float(evidence.misfit(shown).mean()) for shown in (clean, moved))
    assert own < 0.5  # a third of half for each channel, for the values that are stored are uniform within a step
    assert other > 5.0 * own


def test_a_transparent_picture_is_seen_over_white() -> None:
    image = np.zeros((4, 4, 4), np.float32)
    image[:2, :, 3] = 0.5
    assert set(Evidence.of(image).levels.ravel().tolist()) == {127.5, 255.0}


def test_the_deviation_of_a_jpeg_is_high_at_edges_as_far_as_it_is_off_there_and_low_in_even_areas() -> None:
    clean = np.full((64, 64, 3), 230.0)
    clean[:, 36:] = (40.0, 90.0, 160.0)
    saved = levels_of(as_jpeg(Image.fromarray(clean.astype(np.uint8)), 70)).astype(np.float64)
    said = Evidence.of((saved / 255.0).astype(np.float32), Jpeg(70, is_subsampled=True)).variance
    off = np.square(saved - clean).mean(2)
    edge, even = np.s_[:, 32:40], np.s_[:, :16]
    assert 0.5 < math.sqrt(said[edge].mean() / off[edge].mean()) < 2.0
    assert said[even].max() < 0.05 * said[edge].mean()

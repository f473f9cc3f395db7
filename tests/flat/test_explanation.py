"""Drawings against photos by what is shorter to say, on pictures made here."""

from __future__ import annotations

import numpy as np
import pytest
from damage import as_jpeg, drawn, levels_of
from numpy.typing import NDArray
from sweep import sweep

from warpvec.condition.jpeg import Jpeg
from warpvec.flat.evidence.coded import coded_nats
from warpvec.flat.evidence.evidence import Evidence
from warpvec.flat.explanation import is_shorter_as_photo, require_shorter, require_shorter_parts
from warpvec.flat.regions.regions import NotFlatArtError, find_regions

Image32 = NDArray[np.float32]


def texture(side: int) -> Image32:
    """Return waves that no few paints explain."""
    waves = np.sin(np.indices((side, side)).sum(0) / 3.0) * np.sin(np.indices((side, side))[0] / 5.0)
    return np.repeat(0.5 + 0.25 * waves[..., None], 3, 2).astype(np.float32)


def test_a_drawing_is_shorter_to_say_as_regions_and_texture_as_a_photo() -> None:
    flat = (levels_of(drawn(128)) / 255.0).astype(np.float32)
    assert not is_shorter_as_photo(flat, None)
    assert is_shorter_as_photo(texture(120), None)
    with pytest.raises(NotFlatArtError, match="times the words of a photo"):
        require_shorter(find_regions(texture(120)), Evidence.of(texture(120)))


@sweep("quality", (40, 60, 80))
def test_a_drawing_stays_one_as_jpeg_if_its_steps_are_known(quality: int) -> None:
    flat = (levels_of(as_jpeg(drawn(96), quality)) / 255.0).astype(np.float32)
    jpeg = Jpeg(quality, is_subsampled=True)
    assert not is_shorter_as_photo(flat, jpeg)
    regions = find_regions(flat, is_jpeg=True)
    known, unknown = (Evidence.of(flat, each) for each in (jpeg, None))
    assert regions.nats(known) / coded_nats(known) < 0.5 * regions.nats(unknown) / coded_nats(unknown)


def test_parts_of_a_large_picture_tell_texture() -> None:
    flat = (levels_of(drawn(400)) / 255.0).astype(np.float32)
    require_shorter_parts(flat, None)
    with pytest.raises(NotFlatArtError, match="times the words of a photo"):
        require_shorter_parts(np.tile(texture(120), (3, 4, 1)), None)


def test_noise_that_is_known_is_no_reason_for_a_photo() -> None:
    flat = levels_of(drawn(400)).astype(np.float64)
    noisy = np.rint(flat + np.random.default_rng(0).normal(0.0, 6.0, flat.shape)).clip(0.0, 255.0) / 255.0
    evidence = Evidence.of(noisy.astype(np.float32))
    assert 4.0 < evidence.sigma.max() < 8.0
    assert not is_shorter_as_photo(noisy.astype(np.float32), None)

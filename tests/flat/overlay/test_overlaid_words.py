"""Tests of warpvec.flat.overlay.overlaid_words: words over several grounds, and what lies below them."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from flat_regions import box, coverage

from warpvec.config.presets import make_config
from warpvec.flat import drawing
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.overlay.overlaid_words import Overlay, find_overlay
from warpvec.flat.regions.regions import find_regions
from warpvec.watch.watch import Watch

HEIGHT, WIDTH = 56, 120
PAGE, WOOD, INK = (np.array(color, np.float32) for color in ((0.95, 0.94, 0.9), (0.68, 0.82, 0.62), (0.0, 0.0, 0.0)))


def word(x: float = 30.0) -> np.ndarray:
    """Return the coverage [h, w] of five letters like an E of thin strokes, of which two touch."""
    parts = []
    for left in x + np.array([0.0, 9.3, 17.1, 27.2, 36.4]):
        parts.append(coverage(box(left, 22.0, left + 1.3, 32.0), WIDTH, HEIGHT))
        parts += [coverage(box(left + 1.3, top, left + 6.6, top + 1.1), WIDTH, HEIGHT) for top in (22.0, 26.4, 30.9)]
    return np.clip(np.sum(parts, axis=0), 0.0, 1.0).astype(np.float32)


def ground(edge: float) -> np.ndarray:
    """Return a page [h, w, 3] with a wood to the right of a slanting ``edge``."""
    share = coverage(lambda x, y: x > edge + 0.4 * y, WIDTH, HEIGHT)[..., None]
    return (PAGE + share * (WOOD - PAGE)).astype(np.float32)


def labelled(below: np.ndarray) -> np.ndarray:
    """Return the ground ``below`` [h, w, 3] with the word on it, in whole levels."""
    image = below + word()[..., None] * (INK - below)
    return (np.rint(255.0 * image) / 255.0).astype(np.float32)


def overlay(below: np.ndarray) -> Overlay | None:
    image = labelled(below)
    return find_overlay(image, find_regions(image))


def test_a_word_over_two_grounds_has_the_ink_that_was_drawn_and_leaves_the_ground() -> None:
    below = ground(40.0)
    found = overlay(below)
    assert found is not None
    assert len(found.words) == 2
    np.testing.assert_array_equal(found.words.paints.color[1], INK)
    ink = np.where(found.words.label == 1, found.words.share, 1.0 - found.words.share)
    assert np.abs(ink - word()).max() < 0.06
    assert np.abs(found.ground - below).max() < 0.06


def test_a_word_over_one_ground_is_left_to_the_regions() -> None:
    assert overlay(ground(500.0)) is None


def test_an_edge_in_the_paint_of_a_ground_is_no_word() -> None:
    image = ground(40.0)
    image[22:32, 30:70:3] = WOOD
    assert find_overlay(image, find_regions(image)) is None


def test_no_word_is_found_once_the_time_is_over() -> None:
    image = labelled(ground(40.0))
    assert find_overlay(image, find_regions(image), Watch(time_budget=1e-9)) is None


def test_words_that_explain_less_than_the_regions_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    image = labelled(ground(40.0))
    found = overlay(ground(40.0))
    assert found is not None

    def paths(words: Overlay | None) -> int:
        monkeypatch.setattr(drawing, "find_overlay", lambda *_: words)
        work = FlatDrawing(torch.from_numpy(image), make_config("draft"), Watch())
        return len(work.outlines.traced)

    without = paths(None)
    assert paths(found) != without
    assert paths(found._replace(ground=np.ones_like(found.ground))) == without

"""Tests of warpvec.flat.regions.lettering: small marks whose strokes are narrower than two pixels."""

from __future__ import annotations

import numpy as np
import pytest
from flat_regions import Shape, box, coverage

from warpvec.flat.regions.regions import Regions, find_regions

SIDE = 64
STEM, BAR = box(20.5, 12.0, 21.5, 24.0), box(20.5, 17.6, 28.0, 18.4)


def letters(*shapes: Shape, x: float = 0.0) -> np.ndarray:
    """Return the coverage [h, w] of ``shapes``, moved to the right by ``x`` pixels."""
    parts = [coverage(lambda u, v, shape=shape: shape(u - x, v), SIDE, SIDE) for shape in shapes]
    return np.clip(np.sum(parts, axis=0), 0.0, 1.0)


def regions_on_white(covered: np.ndarray, ink: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Regions:
    """Return the regions of a picture with ``covered`` [h, w] of ``ink``, rounded to 8 bits."""
    image = 1.0 - covered[..., None] * (1.0 - np.array(ink))
    return find_regions((np.rint(255.0 * image) / 255.0).astype(np.float32))


def ink_in(regions: Regions) -> np.ndarray:
    """Return how much of each pixel [h, w] shows anything but the canvas."""
    share = regions.share.astype(np.float64)
    return share * (regions.label != regions.canvas) + (1.0 - share) * (regions.other != regions.canvas)


def test_stroke_without_a_pixel_of_pure_ink_keeps_its_coverage_and_the_ink_of_its_word() -> None:
    # The stem covers two columns by half; only the heavy letter beside it shows how black the ink is.
    covered = letters(STEM, BAR) + letters(box(31.0, 12.0, 33.0, 24.0))
    regions = regions_on_white(covered)
    assert np.abs(ink_in(regions) - covered).max() < 0.02
    assert len(regions) == 2
    assert sorted(regions.paints.color[:, 0]) == [0.0, 1.0]


def test_inks_of_two_words_on_one_ground_stay_apart() -> None:
    black, gray = letters(STEM, BAR), letters(STEM, BAR, x=24.0)
    regions = regions_on_white(black + 0.5 * gray + letters(box(31.0, 12.0, 32.0, 24.0)))
    colors = np.unique(regions.paints.color[np.unique(regions.label[12:24])].round(2))
    assert len(colors) == 3


def test_words_in_one_line_keep_like_inks_that_their_pixels_tell_apart() -> None:
    """Yellow beside gray, as in an editor: both lie in nearly the same direction from the dark ground."""
    gray, yellow = (np.array(levels) / 255.0 for levels in ((212, 212, 212), (220, 220, 170)))
    stem = box(20.6, 12.0, 22.3, 24.0)
    first, second = letters(stem) + letters(stem, x=5.0), letters(stem, x=10.0) + letters(stem, x=15.0)
    ground = np.full(3, 30.0 / 255.0)
    image = ground + first[..., None] * (gray - ground) + second[..., None] * (yellow - ground)
    regions = find_regions((np.rint(255.0 * image) / 255.0).astype(np.float32))
    blue = regions.paints.color[:, 2]
    assert blue[regions.label[14, 21]] - blue[regions.label[14, 31]] > 0.1


def test_letter_that_shows_its_ink_keeps_it_beside_a_darker_word() -> None:
    """Its stem reaches into the columns on both sides of the middle one, which is of pure ink."""
    dark, pale = letters(box(20.0, 12.0, 22.2, 24.0)), letters(box(25.6, 12.0, 27.3, 24.0), box(28.6, 12.0, 30.3, 24.0))
    regions = regions_on_white(dark + 0.75 * pale)
    assert regions.paints.color[regions.label[18, 26], 0] == pytest.approx(0.25, abs=0.01)


def test_mark_of_two_colors_stays_as_it_was() -> None:
    covered, dot = letters(box(20.0, 20.0, 32.0, 32.0)), letters(box(24.0, 24.0, 28.0, 28.0))
    image = 1.0 - covered[..., None] * np.array([0.2, 0.5, 0.9]) - dot[..., None] * np.array([0.6, 0.0, 0.0])
    regions = find_regions(image.astype(np.float32))
    assert len(regions) == 3


def test_marks_below_the_area_asked_for_are_left_out() -> None:
    covered = letters(STEM, BAR) + letters(box(31.0, 12.0, 33.0, 24.0)) + letters(box(35.0, 22.0, 36.5, 23.5))
    image = np.repeat(1.0 - covered[..., None], 3, 2).astype(np.float32)
    drawn, without = (np.count_nonzero(find_regions(image, area).label[20:, 35:38]) for area in (0.0, 4.0))
    assert drawn > without == 0


def test_dot_of_an_i_stays_though_it_has_hardly_a_pixel_of_ink() -> None:
    covered = letters(STEM, BAR) + letters(box(31.0, 12.0, 33.0, 24.0)) + letters(box(35.2, 16.0, 36.0, 24.0))
    dot = letters(box(35.2, 13.0, 36.0, 14.0))
    regions = regions_on_white(covered + dot)
    assert np.abs(ink_in(regions) - covered - dot).max() < 0.02


def test_dot_between_two_words_is_a_mark_of_their_line() -> None:
    """It is a space away from both, and has no pixel of their ink."""
    dot = letters(box(37.5, 18.0, 38.6, 19.1))
    covered = letters(STEM, BAR) + letters(box(47.5, 12.0, 49.5, 24.0)) + dot
    assert np.abs(ink_in(regions_on_white(covered)) - covered).max() < 0.02


def test_color_that_only_mixed_pixels_show_is_no_ink_of_a_word() -> None:
    """The ring beside the word is darker than its ink, but has no pixel of its own colour."""
    words = letters(box(20.0, 12.0, 21.0, 24.0), BAR) + letters(box(31.0, 12.0, 32.0, 24.0))
    far = coverage(lambda u, v: np.abs(np.hypot(u - 46.3, v - 46.4) - 6.0) < 0.4, SIDE, SIDE)
    regions = regions_on_white(0.6 * words + 0.8 * far)
    assert regions.paints.color[regions.label[14, 20], 0] == pytest.approx(0.4, abs=0.01)


def test_two_shapes_of_two_inks_that_touch_keep_their_inks() -> None:
    """An eye and its brow: the paler one is no thin part of the darker one, as it has pixels of equal neighbours."""
    brow, eye = letters(box(20.0, 20.0, 30.0, 23.4)), letters(box(22.6, 23.4, 28.3, 28.7))
    regions = regions_on_white(0.9 * brow + eye)
    shown = regions.paints.color[np.unique(regions.label[20:29, 20:30])][:, 0]
    np.testing.assert_allclose(np.sort(shown), [0.0, 0.1, 1.0], atol=0.01)


def test_letter_across_the_edge_of_two_grounds_has_the_ink_of_its_word() -> None:
    covered = letters(STEM, BAR) + letters(STEM, BAR, x=9.5) + letters(STEM, BAR, x=19.0)
    tint = np.where(np.arange(SIDE)[:, None] < 35, [1.0, 1.0, 1.0], [0.6, 0.9, 0.7])
    image = (1.0 - covered[..., None]) * tint
    regions = find_regions((np.rint(255.0 * image) / 255.0).astype(np.float32))
    assert regions.is_lettering is not None
    is_word = regions.is_lettering & (regions.paints.color.max(1) < 0.02)
    ink = regions.share * is_word[regions.label] + (1.0 - regions.share) * is_word[regions.other]
    assert np.abs(ink - covered).max() < 0.12
    assert np.abs(regions.mixed()[..., :3] - image).max() < 0.05


def test_halo_that_letters_part_is_one_region() -> None:
    inner = letters(box(14.5, 11.0, 15.5, 25.0))
    covered = inner + letters(box(20.5, 8.0, 21.5, 28.0)) + letters(box(26.2, 8.0, 27.4, 28.0))
    halo = letters(box(8.0, 8.0, 40.0, 28.0))
    paper = letters(box(0.0, 44.0, 64.0, 64.0))
    ground = 0.8 + 0.2 * (halo + paper)
    image = np.repeat(((1.0 - covered) * ground)[..., None], 3, 2)
    regions = find_regions((np.rint(255.0 * image) / 255.0).astype(np.float32))
    assert len(np.unique(regions.label[8:28, 8:40][covered[8:28, 8:40] == 0.0])) == 1


def test_bold_letters_of_a_word_are_lettering_and_a_bold_mark_alone_is_none() -> None:
    bold = box(10.5, 12.0, 13.5, 24.0)  # two thirds of its ink are pure
    word = regions_on_white(letters(bold) + letters(bold, x=6.0) + letters(bold, x=12.0))
    assert word.is_lettering is not None
    assert word.is_lettering.sum() == 1
    assert regions_on_white(letters(bold)).is_lettering is None

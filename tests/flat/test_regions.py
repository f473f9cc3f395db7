"""Test the regions of clean pictures: their number, paints, shares and transparency."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from flat_regions import box, coverage, disc
from numpy.typing import NDArray

from warpvec.flat.regions.regions import Regions, find_regions, premultiplied
from warpvec.flat.scene_building import scene_of
from warpvec.geometry.paints.registry import ELLIPTIC, FLAT, LINEAR, RADIAL
from warpvec.svg.resvg import rasterize

Floats = NDArray[np.float32]


def drawn(elements: str, width: int = 128, height: int = 128, transparent: bool = False) -> Floats:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">'
    pixels = rasterize(f"{head}{elements}</svg>", transparent=transparent, sandboxed=False)
    return pixels.astype(np.float32) / 255


def linear_gradient(ends: str, *colors: str) -> str:
    """Return the gradient "a" from x1, y1 to x2, y2, with stops at equal distances."""
    places = " ".join(f'{name}="{value}"' for name, value in zip(("x1", "y1", "x2", "y2"), ends.split(), strict=True))
    last = len(colors) - 1
    stops = "".join(f'<stop offset="{at / last}" stop-color="{color}"/>' for at, color in enumerate(colors))
    return f'<linearGradient id="a" gradientUnits="userSpaceOnUse" {places}>{stops}</linearGradient>'


def membership(regions: Regions, region: int) -> Floats:
    """Return the share of ``region`` in each pixel."""
    in_label, in_other = regions.label == region, (regions.other == region) & (regions.label != region)
    return in_label * regions.share + in_other * (1 - regions.share)


def error(image: Floats, regions: Regions) -> float:
    """Return the root mean square difference, in levels of 8 bits, of the picture that the regions state."""
    return float(np.sqrt(((regions.mixed() - premultiplied(image)) ** 2).mean()) * 255)


def colors(regions: Regions) -> set[str]:
    """Return the colours of flat regions that are seen, as "rrggbb"."""
    chosen = (regions.paints.kind == FLAT) & (regions.paints.opacity > 0)
    return {bytes(np.round(color * 255).astype(np.uint8)).hex() for color in regions.paints.color[chosen]}


def test_shares_are_the_coverage_of_a_disc() -> None:
    covered = coverage(disc(30.3, 31.8, 17.6), 64, 64)
    image = np.repeat(1 - covered[..., None], 3, 2).astype(np.float32)
    regions = find_regions(image)
    assert len(regions) == 2
    difference = membership(regions, int(regions.label[32, 30])) - covered
    # Pixels within two levels of a paint count as pure.
    assert np.abs(difference).max() <= 2.5 / 255


def test_shapes_of_one_color_are_regions_of_one_color() -> None:
    image = drawn(
        '<rect width="128" height="128" fill="#fff"/><circle cx="40" cy="40" r="25" fill="#c2185b"/>'
        '<circle cx="40" cy="40" r="11" fill="#fff"/><rect x="75" y="70" width="30.5" height="41.3" fill="#c2185b"/>'
    )
    regions = find_regions(image)
    assert len(regions) == 4
    assert colors(regions) == {"ffffff", "c2185b"}
    assert regions.canvas == regions.label[0, 0] != regions.label[40, 40]
    assert error(image, regions) < 0.5


def test_shares_of_touching_shapes_leave_no_region_between_them() -> None:
    image = drawn(
        '<path d="M8,8L70.3,8L52.7,120L8,120Z" fill="#e07f14"/>'
        '<path d="M70.3,8L120,8L120,120L52.7,120Z" fill="#563428"/>',
        transparent=True,
    )
    assert len(find_regions(image)) == 3


def test_what_shines_through_a_seam_is_no_region() -> None:
    image = drawn(
        '<rect width="128" height="128" fill="#c00"/><path d="M8,8L70.3,8L60.7,120L8,120Z" fill="#06c"/>'
        '<path d="M70.3,8L120,8L120,120L60.7,120Z" fill="#fc0"/>'
    )
    assert len(find_regions(image)) == 3


def test_a_ramp_that_shines_through_a_seam_is_no_region() -> None:
    image = drawn(
        '<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="0" x2="0" y2="50"><stop stop-color="#60c"/>'
        '<stop offset="1" stop-color="#f60"/></linearGradient><rect width="128" height="128" fill="#fff"/>'
        '<rect x="12" y="12" width="104" height="104.5" fill="url(#a)"/>'
        '<rect x="12" y="60" width="104" height="56.5" fill="#216"/>'
    )
    assert len(find_regions(image)) == 3


@pytest.mark.parametrize("width", [0.8, 1.3, 2.4])
def test_thin_lines_are_regions_of_their_color(width: float) -> None:
    image = drawn(
        f'<rect width="128" height="128" fill="#ffe"/><path d="M10,20L118,57" stroke="#036" stroke-width="{width}"/>'
        '<circle cx="40" cy="95" r="14" fill="#036"/>'
    )
    regions = find_regions(image)
    assert len(regions) == 3
    assert colors(regions) == {"ffffee", "003366"}
    assert regions.label[95, 40] != regions.label[38, 64] != regions.label[0, 0]
    # Shares of lines that are thinner than a pixel are moved between pixels to keep them in one piece.
    assert error(image, regions) < (0.5 if width > 1 else 1.3)


def test_specks_are_left_out() -> None:
    image = drawn('<rect x="20" y="20" width="2" height="3"/><rect x="60" y="60" width="5" height="5"/>', 256, 256)
    assert len(find_regions(image)) == 3
    assert len(find_regions(image, min_area=10)) == 2
    assert len(find_regions(image, min_area=50)) == 1


def test_dots_of_letters_stay_and_faint_specks_go() -> None:
    letter = '<rect x="60" y="60" width="8" height="40"/>'
    dotted = drawn(letter + '<rect x="63" y="50.2" width="1.2" height="1.6"/>', 256, 256)
    assert len(find_regions(dotted)) == 3
    assert len(find_regions(dotted, min_area=5)) == 2
    assert len(scene_of(find_regions(dotted))) == 2
    faint = drawn(letter + '<rect x="63" y="50" width="2" height="1" fill="#ddd"/>', 256, 256)
    assert len(find_regions(faint)) == 2


def test_holes_and_surroundings_are_clear_regions() -> None:
    image = drawn('<path d="M20,20H100V100H20Z M40,40V70H70V40Z" fill="#090" fill-rule="evenodd"/>', transparent=True)
    image[..., :3] = np.where(image[..., 3:] == 0, 0.7, image[..., :3])  # The colour of clear pixels says nothing.
    regions = find_regions(image)
    assert len(regions) == 3
    surroundings, hole, shape = (int(regions.label[place]) for place in ((0, 0), (55, 55), (90, 90)))
    assert len({surroundings, hole, shape}) == 3
    np.testing.assert_array_equal(regions.paints.opacity[[surroundings, hole, shape]], [0, 0, 1])
    assert regions.canvas == surroundings


def test_translucent_areas_keep_color_and_opacity() -> None:
    image = drawn('<circle cx="60" cy="60" r="40" fill="#3e717a" fill-opacity="0.6"/>', transparent=True)
    regions = find_regions(image)
    shape = int(regions.label[60, 60])
    assert len(regions) == 2
    np.testing.assert_allclose(regions.paints.opacity[shape], 0.6, atol=1 / 255)
    np.testing.assert_allclose(regions.paints.color[shape] * 255, [0x3E, 0x71, 0x7A], atol=1.5)


def test_a_shape_cut_by_the_end_of_the_picture_has_no_region_along_it() -> None:
    image = drawn('<rect x="-10" y="0.4" width="90.5" height="200" fill="#0681b6"/>', transparent=True)
    assert len(find_regions(image)) == 2


def test_a_ring_along_the_end_of_the_picture_is_one_region() -> None:
    # The page beyond it lies in several parts, each of which has less of the border than the ring.
    rim = "M3,1.3Q16,-0.4 29,1.3Q31.9,1.7 31.3,6L28.2,28Q27.6,31.1 24.6,31.1H7.4Q4.4,31.1 3.8,28L0.7,6Q0.1,1.7 3,1.3Z"
    image = drawn(f'<path d="{rim}" fill="#fef9ec" stroke="#e5d1bf" stroke-width="1.6"/>', 32, 32)
    regions = find_regions(image)
    assert regions.canvas is not None and (regions.paints.color[regions.canvas] == 1.0).all()
    is_ring = np.abs(255 * regions.paints.color - [0xE5, 0xD1, 0xBF]).max(1) < 2
    assert is_ring.sum() == 1


def test_a_linear_gradient_is_one_region_with_its_stops() -> None:
    image = drawn(
        linear_gradient("20 30 110 90", "#fc0", "#a0326e") + '<circle cx="64" cy="64" r="55" fill="url(#a)"/>'
        '<circle cx="50" cy="60" r="12" fill="#fff"/>'
    )
    regions = find_regions(image)
    shape = int(regions.label[100, 64])
    assert len(regions) == 3
    assert regions.paints.kind[shape] == LINEAR
    stops = np.array([regions.paints.color[shape], regions.paints.end_color[shape]]) * 255
    np.testing.assert_allclose(sorted(stops.tolist()), [[160, 50, 110], [255, 204, 0]], atol=3)
    assert error(image, regions) < 0.7


def test_a_radial_gradient_is_one_region_with_its_center() -> None:
    image = drawn(
        '<radialGradient id="a" gradientUnits="userSpaceOnUse" cx="50" cy="60" r="62"><stop stop-color="#eef"/>'
        '<stop offset="1" stop-color="#28c"/></radialGradient><path d="M8,8H120V118H8Z" fill="url(#a)"/>'
    )
    regions = find_regions(image)
    shape = int(regions.label[60, 60])
    assert len(regions) == 2
    assert regions.paints.kind[shape] == RADIAL
    np.testing.assert_allclose(regions.paints.geometry[shape, :3], [50, 60, 62], atol=0.7)
    assert error(image, regions) < 0.7


def test_a_gradient_of_three_stops_is_one_region() -> None:
    image = drawn(
        linear_gradient("10 0 118 30", "#f00", "#ff0", "#08f") + '<rect width="128" height="128" fill="url(#a)"/>'
    )
    regions = find_regions(image)
    assert len(regions) == 1 and regions.paints.count.tolist() == [3]
    assert error(image, regions) < 0.8


def test_an_ellipse_of_four_stops_is_one_region() -> None:
    stops = [("0", "#fde"), (".3", "#db9"), (".6", "#97b"), ("1", "#357")]
    gradient = "".join(f'<stop offset="{place}" stop-color="{color}"/>' for place, color in stops)
    image = drawn(
        f'<radialGradient id="a" gradientUnits="userSpaceOnUse" cx="0" cy="0" r="1" '
        f'gradientTransform="matrix(70 42 -27 45 60 66)">{gradient}</radialGradient>'
        '<rect width="128" height="128" fill="url(#a)"/>'
    )
    regions = find_regions(image)
    assert len(regions) == 1 and regions.paints.kind.tolist() == [ELLIPTIC] and regions.paints.count.tolist() == [4]
    np.testing.assert_allclose(regions.paints.geometry[0, :2], [60, 66], atol=0.5)
    assert error(image, regions) < 1.0


def test_a_shape_that_fades_into_a_gradient_is_told_from_it() -> None:
    shade = '<linearGradient id="b" x1="0" x2="1"><stop stop-color="#036"/><stop offset="1" stop-color="#69c"/>'
    image = drawn(
        linear_gradient("0 0 128 0", "#036", "#9cf") + '<rect width="128" height="128" fill="url(#a)"/>'
        f'{shade}</linearGradient><path d="M0 40H128L60 100H0z" fill="url(#b)"/>'
    )
    regions = find_regions(image)
    assert len(regions) <= 4 and not (regions.paints.kind == FLAT).any()
    assert error(image, regions) < 1.0


def test_a_ramp_of_opacity_and_colour_is_one_region() -> None:
    part = np.broadcast_to(np.abs(np.linspace(-1, 1, 96, dtype=np.float32)), (64, 96))
    image = np.stack([0.2 + 0.5 * part, 0.6 - 0.1 * part, 0.3 + 0 * part, 0.9 - 0.4 * part], -1)
    regions = find_regions(np.round(255 * image).astype(np.float32) / 255)
    assert len(regions) == 1 and regions.paints.count.tolist() == [3]
    assert error(image, regions) < 1.0
    np.testing.assert_allclose(regions.paints.shown[0, :3] * regions.paints.opacity[0], [0.5, 0.9, 0.5], atol=0.01)


def test_parts_of_one_gradient_share_it() -> None:
    image = drawn(
        linear_gradient("0 0 0 128", "#036", "#9cf") + '<rect width="128" height="128" fill="url(#a)"/>'
        '<rect x="75" y="-5" width="12" height="140" fill="#fff"/>'
    )
    regions = find_regions(image)
    left, right = int(regions.label[60, 10]), int(regions.label[60, 110])
    assert left != right
    np.testing.assert_array_equal(regions.paints.geometry[left], regions.paints.geometry[right])


def test_ramps_of_opacity_become_bands() -> None:
    alpha = np.broadcast_to(np.linspace(0, 1, 96, dtype=np.float32), (64, 96))
    image = np.stack([0.2 * np.ones_like(alpha), 0 * alpha, 0 * alpha, alpha], -1)
    regions = find_regions(image)
    assert 4 <= len(regions) <= 9
    assert error(image, regions) < 12


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (2, 2), (5, 3)])
@pytest.mark.parametrize("channels", [3, 4])
def test_tiny_pictures_of_any_content_have_regions(shape: tuple[int, int], channels: int) -> None:
    image = np.random.default_rng(3).random((*shape, channels)).astype(np.float32)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        regions = find_regions(image)
    assert regions.label.shape == shape
    assert len(regions) >= 1


@pytest.mark.parametrize("channels", [3, 4])
def test_fields_are_consistent(channels: int) -> None:
    image = drawn(
        '<rect width="70" height="128" fill="#fae501"/><ellipse cx="60" cy="50" rx="41" ry="30" fill="#f05751"/>'
        '<path d="M0,100Q60,60 128,120" stroke="#063" fill="none"/>',
        transparent=channels == 4,
    )
    regions = find_regions(image)
    count = len(regions)
    assert set(np.unique(regions.label)) == set(range(count))
    assert set(np.unique(regions.other)) <= set(range(count))
    assert regions.share.min() >= 0.5
    np.testing.assert_array_equal(regions.share == 1, regions.label == regions.other)


def test_boxes_on_pixel_borders_are_exact() -> None:
    covered = coverage(box(10, 12, 31, 40), 64, 64)
    image = np.repeat(0.25 + 0.5 * covered[..., None], 3, 2).astype(np.float32)
    regions = find_regions(image)
    assert len(regions) == 2
    np.testing.assert_array_equal(membership(regions, int(regions.label[20, 20])), covered)

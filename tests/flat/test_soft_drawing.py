"""Shadows and glows of flat art: found in the picture, and drawn as one soft path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

import warpvec
from warpvec.config.fit_config import FitConfig
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.regions.regions import find_regions
from warpvec.flat.soft_drawing import SoftDrawing
from warpvec.flat.softness import copies
from warpvec.flat.softness.drawn_casters import DrawnCasters
from warpvec.flat.softness.shadows import Shadow, channels_of
from warpvec.flat.softness.shapes import paths_below
from warpvec.image.colors import parse_color
from warpvec.rendering.draw import draw_8_bits
from warpvec.svg.read import read_svg

SIDE = 80

SHAPE = "M24 24h28v16h-12v14h-16z"

SHADOWED = """<svg xmlns="http://www.w3.org/2000/svg" width="80" height="80"><defs>
<filter id="b" x="-100%" y="-100%" width="300%" height="300%" color-interpolation-filters="sRGB">
<feGaussianBlur stdDeviation="{sigma}"/></filter></defs><rect width="80" height="80" fill="{ground}"/>
<g transform="translate({x} {y})"><path filter="url(#b)" fill="{color}" fill-opacity=".6" d="M24 24h28v16h-12v14h-16z"/>
</g><path fill="#2f7de0" d="M24 24h28v16h-12v14h-16z"/>{top}</svg>"""


def find_shadows(image: np.ndarray) -> list[Shadow]:
    return copies.find_shadows(image, find_regions(image), lambda: False)


def find_shadow(image: np.ndarray) -> Shadow | None:
    found = find_shadows(image)
    return found[0] if found else None


def picture(**values: object) -> np.ndarray:
    text = SHADOWED.format(**{"sigma": 3, "ground": "#fff", "color": "#000", "x": 4, "y": 6, "top": "", **values})
    return draw_8_bits(read_svg(text).scene, SIDE, SIDE, 1).astype(np.float32) / 255.0


@pytest.mark.parametrize(
    ("sigma", "ground", "color", "offset"),
    [
        (1.5, "#fff", "#000", (4.0, 5.0)),
        (6.0, "#2a3550", "#ffd75e", (0.0, 0.0)),
        (3.0, "#fff", "#204080", (-5.0, 3.0)),
    ],
)
def test_a_shadow_is_measured(sigma: float, ground: str, color: str, offset: tuple[float, float]) -> None:
    pytest.importorskip("svgelements")
    found = find_shadow(picture(sigma=sigma, ground=ground, color=color, x=offset[0], y=offset[1]))
    assert found is not None
    assert found.look.sigma == pytest.approx(sigma, rel=0.1)
    assert found.look.offset == pytest.approx(offset, abs=0.3)
    change = np.array(parse_color(color)) - np.array(parse_color(ground))
    assert np.abs(found.look.amplitude / 255.0 - 0.6 * change).max() <= 4.0 / 255.0


RAMP_INK = """<linearGradient id="i" x2="0" y2="1"><stop stop-color="#06c"/><stop offset="1" stop-color="#60f"/>
</linearGradient><path fill="url(#i)" d="{}"/>"""

RAMP = """<linearGradient id="r" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="20" y2="80">
<stop stop-color="#e8d8c0"/><stop offset="1" stop-color="#f8f0ff"/></linearGradient>
<rect width="80" height="80" fill="url(#r)"/>"""

CARD = '<rect width="80" height="80" fill="#456"/><rect x="2" y="2" width="76" height="76" rx="8" fill="#f4e0c8"/>'


@pytest.mark.parametrize(("ground", "is_flat"), [(RAMP, False), (CARD, True)])
def test_a_shadow_on_a_gradient_or_on_a_card_is_measured(ground: str, is_flat: bool) -> None:
    pytest.importorskip("svgelements")
    text = SHADOWED.format(sigma=3, ground="#fff", color="#203060", x=4, y=6, top="")
    flat = '<rect width="80" height="80" fill="#fff"/>'
    image = draw_8_bits(read_svg(text.replace(flat, ground)).scene, SIDE, SIDE, 1)[..., :3]
    found = find_shadow(image.astype(np.float32) / 255.0)
    assert found is not None and found.ground.is_flat == is_flat
    assert found.look.sigma == pytest.approx(3.0, rel=0.05) and found.look.offset == pytest.approx((4.0, 6.0), abs=0.1)
    if not is_flat:  # the ground behind it tells how opaque it is
        assert found.paint[1] == pytest.approx(0.6, abs=0.15)
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="80" height="80">'
    scene = read_svg(f'{head}{ground}<path fill="#2f7de0" d="{SHAPE}"/></svg>').scene
    expected = draw_8_bits(scene, SIDE, SIDE, 1)[..., :3] / 255.0
    assert np.abs(found.clean - expected).mean() < 0.002


def test_the_colour_of_a_shadow_on_a_transparent_ground_is_known() -> None:
    pytest.importorskip("svgelements")
    color, alpha = np.array(parse_color("#402060")), np.zeros((SIDE, SIDE, 1))
    alpha[...] = 1.0 - picture()[..., :1]  # a black shadow on white: how much it covers
    shape = np.ptp(picture(), axis=2, keepdims=True) > 0.1
    image = np.where(
        shape, [0.18, 0.49, 0.88, 1.0], np.concatenate([np.broadcast_to(color, (SIDE, SIDE, 3)), alpha], 2)
    )
    found = find_shadow(np.round(255.0 * image).astype(np.float32) / 255.0)
    assert found is not None and found.clean.shape == (SIDE, SIDE, 4)
    assert found.look.sigma == pytest.approx(3.0, rel=0.03) and found.look.offset == pytest.approx((4.0, 6.0), abs=0.1)
    paint, opacity = found.paint
    assert opacity == pytest.approx(0.6, abs=0.02) and np.abs(paint - color).max() < 0.02
    assert found.clean[60, 30, 3] < 0.02 and found.clean[30, 30, 3] > 0.98
    assert find_shadow(np.where(shape, image, 0.0).astype(np.float32)) is None


def test_a_shape_without_a_shadow_beside_one_with_it_changes_nothing() -> None:
    pytest.importorskip("svgelements")
    found = find_shadow(picture(x=-6, y=-8, top='<path fill="#123" d="M50 62h22v8h-22z"/>'))
    assert found is not None
    assert found.look.offset == pytest.approx((-6, -8), abs=0.1) and found.look.sigma == pytest.approx(3.0, rel=0.03)
    assert found.casters[66, 60] == 0.0 and found.casters[30, 30] == 1.0


def test_a_shape_with_a_gradient_casts_a_shadow() -> None:
    pytest.importorskip("svgelements")
    ramp = RAMP_INK.format("M24 24h28v16h-12v14h-16z")
    found = find_shadow(picture(top=ramp))
    assert found is not None and found.spot is None
    assert found.look.offset == pytest.approx((4.0, 6.0), abs=0.2) and found.look.sigma == pytest.approx(3.0, rel=0.05)
    np.testing.assert_allclose(found.casters[26:38, 26:50], 1.0)


def test_a_thin_line_in_a_shadow_belongs_to_what_lies_above_it() -> None:
    pytest.importorskip("svgelements")
    line = '<path fill="none" stroke="#123" stroke-width="1.4" d="M18 66l8-6 6 8 8-8 6 8 8-6"/>'
    found = find_shadow(picture(sigma=4, top=line))
    assert found is not None and found.spot is None
    assert found.look.offset == pytest.approx((4.0, 6.0), abs=0.1) and found.look.sigma == pytest.approx(4.0, rel=0.03)
    assert found.clean[60:69, 30:50].min() < 0.5 and found.clean[50:56, 45:50].min() > 0.98


def test_what_lies_on_the_shape_stays_as_it_is_without_the_shadow() -> None:
    """The anti-aliased edge of a disk on a shape mixes two colours of the drawing, and none with the ground."""
    pytest.importorskip("svgelements")
    image = picture(top='<circle cx="37.4" cy="32.3" r="6" fill="#fc3"/>')
    found = find_shadow(image)
    assert found is not None
    np.testing.assert_allclose(found.clean[25:40, 25:51], image[25:40, 25:51], atol=1e-6)


def test_a_picture_without_a_shadow_has_none() -> None:
    image = picture(sigma=0.001, x=0, y=0)
    assert find_shadow(image) is None
    ramp = image.copy()  # a gradient on the shape is no shadow
    ramp[24:40, 24:52] *= np.linspace(0.3, 1.0, 28, dtype=np.float32)[None, :, None]
    assert find_shadow(ramp) is None


@pytest.mark.parametrize(
    "top",
    [
        "",
        '<path fill="none" stroke="#a33" stroke-width="1.2" d="M10 10l12 9"/>',
        '<path fill="#fc3" stroke="#2f7de0" stroke-width="4" d="M26 10h24v50h-24z"/>',
    ],
)
def test_a_soft_spot_is_an_ellipse_also_behind_a_figure_or_beside_a_thin_line(top: str) -> None:
    pytest.importorskip("svgelements")
    spot = '<ellipse filter="url(#b)" cx="38" cy="58" rx="26" ry="9" fill="#000" fill-opacity=".5"/>'
    text = SHADOWED.format(sigma=2.5, ground="#fff", color="#000", x=0, y=0, top=top)
    text = text[: text.index("<g ")] + spot + text[text.index("</g>") + len("</g>") :]
    text = text.replace(f'<path fill="#2f7de0" d="{SHAPE}"/>', "")
    found = find_shadow(draw_8_bits(read_svg(text).scene, SIDE, SIDE, 1).astype(np.float32) / 255.0)
    assert found is not None and found.look.sigma == pytest.approx(2.5, rel=0.05)
    y, x = np.indices((SIDE, SIDE)) + 0.5
    ellipse = ((x - 38) / 26) ** 2 + ((y - 58) / 9) ** 2 <= 1.0
    assert np.abs(found.casters - ellipse).sum() < 0.06 * ellipse.sum()
    np.testing.assert_allclose(found.look.amplitude / 255.0, -0.5, atol=0.02)
    np.testing.assert_allclose(found.clean[68:], 1.0, atol=0.01)


BLUR = (
    '<filter id="b{0}" filterUnits="userSpaceOnUse" x="-60" y="-60" width="240" height="200" '
    'color-interpolation-filters="sRGB"><feGaussianBlur stdDeviation="{0}"/></filter>'
)

BESIDE = f"""<svg xmlns="http://www.w3.org/2000/svg" width="120" height="80">
<defs>{BLUR.format(2)}{BLUR.format(4)}</defs><rect width="120" height="80" fill="#fff"/>{{things}}</svg>"""

TWO_CARDS = """<path fill-opacity=".5" filter="url(#b2)" d="M15 18h30v24h-30z"/>
<path fill="#fc6" d="M12 14h30v24h-30z"/>
<path fill-opacity=".5" filter="url(#b4)" d="M76 38h30v24h-30z"/>
<path fill="#2f7de0" d="M76 31h30v24h-30z"/>"""

TWO_LIGHTS = """<circle cx="32" cy="30" r="10" fill="#fb4" filter="url(#b2)"/>
<circle cx="86" cy="46" r="14" fill="#48f" filter="url(#b4)"/>"""


@pytest.mark.parametrize(("things", "is_cast"), [(TWO_CARDS, True), (TWO_LIGHTS, False)])
def test_things_side_by_side_have_shadows_of_their_own(things: str, is_cast: bool) -> None:
    pytest.importorskip("svgelements")
    image = draw_8_bits(read_svg(BESIDE.format(things=things)).scene, 80, 120, 1)[..., :3]
    found = find_shadows(image.astype(np.float32) / 255.0)
    assert sorted(shadow.look.sigma for shadow in found) == pytest.approx([2.0, 4.0], rel=0.05)
    assert all((shadow.spot is None) == is_cast for shadow in found)
    if is_cast:
        assert sorted(shadow.look.offset[1] for shadow in found) == pytest.approx([4.0, 7.0], abs=0.2)


ICON = """<svg xmlns="http://www.w3.org/2000/svg" width="80" height="80"><defs>{blur}</defs>
<rect x="4" y="4" width="72" height="72" rx="16" fill="#3a7bf0"/>{other}
<path d="M26 30h26v22h-26z" fill-opacity=".6" filter="url(#b2)"/><path fill="#fff" d="M25 26h26v22h-26z"/></svg>"""


@pytest.mark.parametrize(
    "other", ["", '<path fill="#bcd" d="M0 0h80v80h-80z"/><path fill="#e95" d="M6 20h68v40h-68z"/>']
)
def test_a_shadow_is_found_on_the_card_of_an_icon_or_on_the_smaller_of_two(other: str) -> None:
    pytest.importorskip("svgelements")
    text = ICON.format(blur=BLUR.format(2), other=other)
    image = draw_8_bits(replace(read_svg(text).scene, transparent=True), SIDE, SIDE, 1).astype(np.float32) / 255.0
    found = find_shadows(image if not other else image[..., :3])
    assert len(found) == 1 and found[0].spot is None
    assert found[0].look.sigma == pytest.approx(2.0, rel=0.05)
    assert found[0].look.offset == pytest.approx((1.0, 4.0), abs=0.1)
    assert found[0].clean.shape[2] == (3 if other else 4)
    if not other:
        assert (
            np.array_equal(found[0].clean[..., 3], image[..., 3])
            and np.abs(found[0].clean[45, 60] - image[8, 40]).max() < 0.01
        )


@pytest.mark.slow
def test_lights_alone_are_no_blurred_drawing() -> None:
    pytest.importorskip("svgelements")
    wide = TWO_LIGHTS.replace("#b2", "#b4")
    image = draw_8_bits(read_svg(BESIDE.format(things=wide)).scene, 80, 120, 1)[..., :3]
    result = warpvec.vectorize(image, threads=1, device="cpu")
    assert result.scene.soft_count == len(result.scene) == 2 and result.file_psnr > 42.0


@pytest.mark.slow
def test_each_of_two_cards_casts_a_soft_path_with_its_outline() -> None:
    pytest.importorskip("svgelements")
    image = draw_8_bits(read_svg(BESIDE.format(things=TWO_CARDS)).scene, 80, 120, 1)[..., :3]
    result = warpvec.vectorize(image, mode="flat", threads=1, device="cpu")
    scene = result.scene
    assert len(scene) == 4 and scene.softness is not None and result.file_psnr > 45.0
    soft = scene.softness.is_soft.nonzero().flatten().tolist()
    assert sorted(scene.softness.sigma[soft].tolist()) == pytest.approx([2.0, 4.0], rel=0.05)
    assert scene.structure.segment_count == 16  # four corners each


def test_a_ball_with_a_gradient_is_no_soft_spot() -> None:
    y, x = np.indices((SIDE, SIDE)) + 0.5
    away = np.hypot(x - 40, y - 40)[..., None]
    shade = 1.0 - np.array([0.2, 0.6, 0.8]) * (1.0 - 0.8 * away / 26.0)
    image = np.where(away <= 26.0, shade, 1.0)
    assert find_shadow(np.round(255.0 * image).astype(np.float32) / 255.0) is None


def test_a_shadow_becomes_one_soft_path() -> None:
    pytest.importorskip("svgelements")
    image = picture()
    config = FitConfig(mode="flat", opacity="free", threads=1, device="cpu")
    with torch.no_grad():
        scene, _ = SoftDrawing(FlatDrawing(torch.from_numpy(image), config)).draw(0.1)
    assert len(scene) == 2 and scene.softness is not None
    assert [each for each in scene.softness.sigma.tolist() if each] == [pytest.approx(3.0, rel=0.02)]
    assert np.abs(draw_8_bits(scene, SIDE, SIDE, 1) / 255.0 - image).mean() < 0.003
    shade, shape = (scene.select(torch.tensor([k])) for k in range(2))  # the shadow has the outline of its shape
    moves = shade.segments[:, 0] - shape.segments[:, 0]
    torch.testing.assert_close(moves, torch.tensor([[4.0, 6.0]]).expand(len(moves), 2), atol=0.05, rtol=0)
    np.testing.assert_allclose(1.0 - shade.color[0].numpy(), 0.6 / float(shade.opacity), atol=0.01)


def test_what_casts_a_shadow_is_found_among_the_paths() -> None:
    pytest.importorskip("svgelements")
    top = '<circle cx="36" cy="32" r="5" fill="#fc3"/>'
    image = picture(top=top)
    shadow = find_shadow(image)
    assert shadow is not None
    size = 'width="80" height="80"'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><path d="M24 24h28v16h-12v14h-16z"/>{top}</svg>'
    shapes = read_svg(text).scene
    assert DrawnCasters(255.0 * channels_of(image), shapes, shadow, 1).find() == [0]  # the disc lies in the same shadow
    assert DrawnCasters(255.0 * channels_of(image), shapes.moved(60.0, 0.0), shadow, 1).find() is None


def test_the_shadow_on_a_card_lies_above_it_though_other_cards_have_its_colour() -> None:
    pytest.importorskip("svgelements")
    cards = (
        '<rect x="2" y="2" width="76" height="62" rx="4" fill="#fff"/><rect y="66" width="80" height="13" fill="#fff"/>'
    )
    text = SHADOWED.format(sigma=3, ground="#456", color="#000", x=4, y=-4, top="")
    text = text.replace('<g transform="translate(4 -4)">', f'{cards}<g transform="translate(4 -4)">')
    scene = read_svg(text).scene
    shadow = find_shadow(draw_8_bits(scene, SIDE, SIDE, 1)[..., :3].astype(np.float32) / 255.0)
    assert shadow is not None and not shadow.ground.region.all()
    assert scene.softness is not None
    assert not shadow.ground.is_seen[70:].any()
    assert paths_below(scene.select(~scene.softness.is_soft), shadow, 1) == 1  # the page is none


def test_a_line_beside_a_shape_hides_its_part_of_the_shadow() -> None:
    pytest.importorskip("svgelements")
    line = '<path fill="none" stroke="#a33" stroke-width="4" d="M20 66L48 70L70 30"/>'
    image = picture(top=line)
    shadow = find_shadow(picture())
    assert shadow is not None
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="80" height="80"><path d="{SHAPE}"/>{line}</svg>'
    rough = replace(shadow, look=replace(shadow.look, sigma=2.5, offset=(3.0, 5.0)))
    again = DrawnCasters(255.0 * channels_of(image), read_svg(text).scene, rough, 1).measured([0])
    assert again.look.sigma == pytest.approx(3.0, rel=0.02) and again.look.offset == pytest.approx((4.0, 6.0), abs=0.05)
    np.testing.assert_allclose(again.look.amplitude / 255.0, -0.6, atol=0.01)

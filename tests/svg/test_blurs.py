"""Soft paths in files: written, read back, drawn by resvg, and read from the files of other programs."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import torch
from scenes import seeded

from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.image.metrics import psnr
from warpvec.rendering.draw import draw_8_bits
from warpvec.svg.measure import draw
from warpvec.svg.minify import write_minified
from warpvec.svg.quantize import SIGMAS_MAX, quantize
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

SIDE = 96


def soft_shapes(sigmas: list[float], seed: int = 5) -> Scene:
    """Return a random round shape for each standard deviation, 0 for a sharp one."""
    generator, count = seeded(seed), len(sigmas)
    turn = torch.arange(12) / 12 * 2 * torch.pi
    rim = torch.stack([turn.cos(), turn.sin()], -1) * (0.7 + 0.6 * torch.rand(count, 12, 1, generator=generator))
    center, size = (torch.rand(count, 1, n, generator=generator) for n in (2, 1))
    points = 10.0 + 0.8 * SIDE * center + (8.0 + 25.0 * size) * rim
    color, opacity = torch.rand(count, 3, generator=generator), 0.5 + 0.5 * torch.rand(count, generator=generator)
    scene = Scene.uniform(points.float(), color.float(), opacity.float(), torch.ones(3), torch.zeros(count).long())
    return replace(scene, softness=Softness(torch.tensor(sigmas)))


def test_a_file_is_read_as_it_was_written() -> None:
    scene = soft_shapes([0.0, 2.5, 12.34, 2.5])
    text = write_svg(scene, SIDE, SIDE)
    assert text.count("<filter") == 2 and text.count("filter=") == 3
    loaded = read_svg(text)
    assert loaded.precision == 2 and loaded.scene.softness is not None
    torch.testing.assert_close(loaded.scene.softness.sigma, scene.softness.sigma)
    assert write_svg(loaded.scene, SIDE, SIDE) == text
    short = write_minified(scene.scaled(10.0), 10 * SIDE, 10 * SIDE, (str(SIDE), str(SIDE)))
    loaded = read_svg(short)
    assert loaded.minified and write_minified(loaded.scene, 10 * SIDE, 10 * SIDE, (str(SIDE), str(SIDE))) == short


def test_a_drawing_of_many_blurs_states_a_few() -> None:
    sigmas = torch.exp(torch.linspace(-1.0, 3.0, 40)).tolist()
    quantized = quantize(soft_shapes(sigmas), 2)
    found = quantized.softness.sigma
    assert len(found.unique()) == SIGMAS_MAX
    assert (found / torch.tensor(sigmas)).log().abs().max() < 0.5
    assert torch.equal(quantize(quantized, 2).softness.sigma, found)


def test_resvg_draws_what_the_renderer_does() -> None:
    errors = []
    for seed, sigma in enumerate(np.exp(np.linspace(-1.1, 3.0, 20)).tolist()):
        scene = quantize(soft_shapes([sigma], seed), 2)
        errors.append(10 ** (-psnr(draw(write_svg(scene, SIDE, SIDE)), draw_8_bits(scene, SIDE, SIDE, 1)) / 10))
    # resvg blurs recursively below a deviation of 2, and by boxes above, whose deviation is up to 12 % off.
    assert -10 * np.log10(np.mean(errors)) > 48.0 and -10 * np.log10(np.max(errors)) > 40.0


BLURRED = """<svg xmlns="http://www.w3.org/2000/svg" width="90" height="60"><defs>
<filter id="soft" x="-1" width="3"><feGaussianBlur in="SourceGraphic" stdDeviation="{deviation}"/>{more}</filter></defs>
<g transform="scale(3)" filter="{on_group}"><path {attributes} d="M5 5h10v10z"/></g></svg>"""


@pytest.mark.parametrize(
    ("deviation", "more", "attributes", "on_group", "sigma", "remark"),
    [
        ("2", "", 'filter="url(#soft)"', "none", 6.0, None),
        ("2 2", "", 'style="filter:url(#soft)"', "none", 6.0, None),
        ("2", "", 'fill="red"', "url(#soft)", 6.0, None),
        ("1 4", "", 'filter="url(#soft)"', "none", 6.0, "1 uneven blur: made as wide both ways"),
        ("2", "<feOffset dx='1'/>", 'filter="url(#soft)"', "none", None, "1 filter: left out"),
        ("2", "", 'filter="url(#none)"', "none", None, "1 filter: left out"),
    ],
)
def test_blurs_of_other_programs_are_read(
    deviation: str, more: str, attributes: str, on_group: str, sigma: float | None, remark: str | None
) -> None:
    pytest.importorskip("svgelements")
    text = BLURRED.format(deviation=deviation, more=more, attributes=attributes, on_group=on_group)
    loaded = read_svg(text)
    found = None if loaded.scene.softness is None else loaded.scene.softness.sigma.tolist()
    assert found == (None if sigma is None else [pytest.approx(sigma)])
    assert loaded.omitted == ([] if remark is None else [remark])


def test_a_straight_line_that_is_soft_is_drawn() -> None:
    text = BLURRED.format(deviation="1", more="", attributes="", on_group="none")
    line = re.sub(
        "<path.*/>", '<path stroke="#000" stroke-width="2" fill="none" filter="url(#soft)" d="M5 9h10"/>', text
    )
    loaded = read_svg(line)
    written = write_svg(loaded.scene, 90, 60)
    assert 'filterUnits="userSpaceOnUse"' in written
    assert draw(written).min() < 150

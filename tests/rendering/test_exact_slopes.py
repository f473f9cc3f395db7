"""How the exact renderer tells what a winding and a path's share change in a picture."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.rendering.exact import ExactRenderer
from warpvec.svg.read import read_svg

TEXT = """<svg xmlns="http://www.w3.org/2000/svg" width="40" height="36"><path fill="#c62" d="M5.3 6.2 H30.6 V25.1z"/>
<path fill="#26c" fill-opacity=".6" d="M12.4 3.1 L35.2 20.3 L9.1 30.7z"/></svg>"""


def crossed_pixels(scene: Scene, renderer: ExactRenderer) -> Tensor:
    """Return where [h, w] the first path covers a pixel in part. Elsewhere the rounding of a winding may be a slope."""
    alone = scene.prefix(1)
    black = replace(alone, color=torch.zeros(1, 3), opacity=torch.ones(1), background=torch.ones(3))
    light = renderer.render(black)[..., 0]
    return (light > 1e-4) & (light < 1 - 1e-4)


def test_slopes_of_windings_say_how_a_moved_edge_changes_its_pixels() -> None:
    scene = replace(read_svg(TEXT).scene, background=torch.tensor([1.0, 0.9, 0.8]), transparent=False)
    y, x = (part.flatten() for part in torch.meshgrid(torch.arange(36), torch.arange(40), indexing="ij"))
    found = []
    for lanes in (1, 16):
        renderer = ExactRenderer(36, 40, threads=1, lane_width=lanes)
        found.append(renderer.winding_slopes(scene, torch.zeros_like(x), x, y).reshape(36, 40, 3))
    crossed = crossed_pixels(scene, renderer)
    assert 30 < int(crossed.sum()) < 120
    torch.testing.assert_close(found[0][crossed], found[1][crossed])
    # The upper side of the triangle moves down by 0.1 px: the winding changes by as much along it.
    images = []
    for move in (0.0, 0.1):
        segments = scene.segments.clone()
        segments[[0, 1], 0, 1] += move
        segments[0, 1:, 1] += move
        segments[1, 1:, 1] += move * torch.tensor([2 / 3, 1 / 3])
        segments[2, 1:, 1] += move * torch.tensor([1 / 3, 2 / 3])
        images.append(renderer.render(replace(scene, segments=segments)))
    change = (images[1] - images[0])[6, 8:28]  # without the corners
    torch.testing.assert_close(change.abs(), 0.1 * found[1][6, 8:28].abs(), atol=1e-4, rtol=1e-3)
    assert float(found[1].abs().max()) > 0.1
    assert not found[1][30].any()  # no edge of the triangle lies there


def test_shares_add_up_to_the_picture() -> None:
    scene = replace(read_svg(TEXT).scene, background=torch.zeros(3), transparent=False)
    renderer = ExactRenderer(36, 40, threads=1)
    (shares,) = renderer.shares(scene)
    picture = shares[:2].permute(1, 2, 0) @ scene.color
    torch.testing.assert_close(picture, renderer.render(scene), atol=1e-5, rtol=0)
    assert not shares[2].any()

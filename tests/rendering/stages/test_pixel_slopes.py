"""How the exact renderer tells what a winding and a path's share change in a picture."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from warpvec.geometry.scene import Scene, of_one_color
from warpvec.kernels.constants import TILE
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.stages import pixel_slopes
from warpvec.svg.read import read_svg

TEXT = """<svg xmlns="http://www.w3.org/2000/svg" width="40" height="36"><path fill="#c62" d="M5.3 6.2 H30.6 V25.1z"/>
<path fill="#26c" fill-opacity=".6" d="M12.4 3.1 L35.2 20.3 L9.1 30.7z"/></svg>"""


def crossed_pixels(scene: Scene, renderer: ExactRenderer) -> Tensor:
    """Return where [h, w] the first path covers a pixel in part. Elsewhere the rounding of a winding may be a slope."""
    alone = scene.prefix(1)
    black = replace(alone, color=torch.zeros(1, 3), opacity=torch.ones(1), background=torch.ones(3))
    light = renderer.render(black)[..., 0]
    return (light > 1e-4) & (light < 1 - 1e-4)


def slopes_of(scene: Scene, renderer: ExactRenderer) -> tuple[Tensor, Tensor]:
    """Return the visible share of each path [N, 36, 40], and the slopes by the first path's winding [4, 36, 40]."""
    share, slopes = torch.zeros(len(scene), 48, 48), torch.zeros(4, 48, 48)
    for part in renderer.pixel_slopes(scene):
        for tile, path, _, is_partial, *found in zip(*part[1:], strict=True):
            rows, columns = (slice(TILE * k, TILE * (k + 1)) for k in divmod(int(tile), 3))
            own, by_winding = (torch.from_numpy(each.copy()).unflatten(-1, (TILE, TILE)).mT for each in found)
            share[path, rows, columns] = own
            if path == 0 and is_partial:
                slopes[:, rows, columns] = by_winding
    assert not share[:, 36:].any() and not share[:, :, 40:].any()
    return share[:, :36, :40], slopes[:, :36, :40]


def test_slopes_of_windings_say_how_a_moved_edge_changes_its_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pixel_slopes, "HITS_AT_ONCE", 5)
    scene = replace(read_svg(TEXT).scene, background=torch.tensor([1.0, 0.9, 0.8]), transparent=False)
    found = []
    for lanes in (1, 16):
        renderer = ExactRenderer(36, 40, threads=1, lane_width=lanes)
        found.append(slopes_of(scene, renderer)[1])
    crossed = crossed_pixels(scene, renderer)
    assert 30 < int(crossed.sum()) < 120
    torch.testing.assert_close(found[0][:, crossed], found[1][:, crossed])
    # The upper side of the triangle moves down by 0.1 px: the winding changes by as much along it.
    images, clear = [], replace(of_one_color(scene, torch.zeros(2, 3)), background=torch.ones(3))
    for move in (0.0, 0.1):
        segments = scene.segments.clone()
        segments[[0, 1], 0, 1] += move
        segments[0, 1:, 1] += move
        segments[1, 1:, 1] += move * torch.tensor([2 / 3, 1 / 3])
        segments[2, 1:, 1] += move * torch.tensor([1 / 3, 2 / 3])
        both = (renderer.render(replace(each, segments=segments)) for each in (scene, clear))
        images.append(torch.cat([next(both), next(both)[..., :1]], 2).movedim(2, 0))
    change = (images[1] - images[0])[:, 6, 8:28]  # without the corners
    torch.testing.assert_close(change.abs(), 0.1 * found[1][:, 6, 8:28].abs(), atol=1e-4, rtol=1e-3)
    assert float(found[1].abs().max()) > 0.1


def test_shares_add_up_to_the_picture() -> None:
    scene = replace(read_svg(TEXT).scene, background=torch.zeros(3), transparent=False)
    renderer = ExactRenderer(36, 40, threads=1)
    picture = slopes_of(scene, renderer)[0].permute(1, 2, 0) @ scene.color
    torch.testing.assert_close(picture, renderer.render(scene), atol=1e-5, rtol=0)

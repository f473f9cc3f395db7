"""Rounding nodes to the ticks of a file."""

from __future__ import annotations

import math
from dataclasses import replace

import torch

from warpvec.geometry.joints import Joints
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.svg.quantize import quantize
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg


def _wheel(handle: float, count: int = 40) -> Scene:
    """Return a closed curve of smooth nodes whose handles are ``handle`` px long, beside a triangle."""
    angle = torch.arange(count, dtype=torch.float32) * (2 * math.pi / count) + 0.1
    out = torch.stack([angle.cos(), angle.sin()], 1)
    along = handle * torch.stack([-angle.sin(), angle.cos()], 1)
    anchor = 50 + 40 * out
    following = anchor.roll(-1, 0) - 0.7 * along.roll(-1, 0)
    corners = torch.tensor([[3.123, 4.321], [9.1, 5.777], [6.6, 11.1]])
    thirds = [corners + (corners.roll(-1, 0) - corners) * share for share in (0.0, 1 / 3, 2 / 3)]
    segments = torch.cat([torch.stack([anchor, anchor + along, following], 1), torch.stack(thirds, 1)])
    is_line = torch.arange(count + 3) >= count
    paint = torch.tensor([[0.2, 0.4, 0.6]]).repeat(2, 1)
    structure = Structure.of_loops([[count], [3]], is_line)
    return Scene(segments, structure, paint, torch.ones(2), torch.ones(3), torch.zeros(2, dtype=torch.int64))


def _turns(scene: Scene, rows: int) -> torch.Tensor:
    ahead, behind = Joints.of(scene).ahead_and_behind(*Joints.of(scene).values(scene))
    cosine = torch.nn.functional.cosine_similarity(ahead[:rows].double(), behind[:rows].double(), dim=1)
    return torch.rad2deg(cosine.clamp(-1, 1).acos())


def test_smooth_nodes_stay_smooth_within_a_degree_in_the_file() -> None:
    for handle in (0.4, 1.0, 6.0):
        scene = _wheel(handle)
        rounded = round_nodes(scene, 2)
        read = read_svg(write_svg(rounded, 100, 100)).scene
        assert float(_turns(read, 40).max()) <= 1.0
        assert float((read.segments - scene.segments).norm(dim=2).max()) < 0.12
    coarse = read_svg(write_svg(_wheel(1.0), 100, 100)).scene
    assert float(_turns(coarse, 40).max()) > 2.0


def test_rounded_nodes_are_at_ticks_and_stay_there() -> None:
    rounded = round_nodes(_wheel(3.0), 2)
    again = quantize(rounded, 2)
    torch.testing.assert_close(again.segments[:40], rounded.segments[:40], atol=1e-5, rtol=0)
    assert torch.equal(quantize(again, 2).segments, again.segments)
    moved = replace(rounded, segments=rounded.segments + 0.004)
    off = (quantize(moved, 2).segments[:40, 1] - quantize(moved, 2).segments[:40, 0]) * 10
    torch.testing.assert_close(off, off.round(), atol=1e-3, rtol=0)  # handles with one decimal, as before

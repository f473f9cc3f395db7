"""Nodes and segments of a drawing keep their kinds."""

import torch

from warpvec.geometry.joints import Joints, with_lines
from warpvec.svg.read import read_svg

TEXT = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64"><path d="'
    'M12 12 C21.33 12 30.67 12 40 12 C46 12 52 18 52 24 V50 C44 44 40 56 30 50 C20 44 14 30 12 12z"/></svg>'
)


def test_a_straight_curve_is_a_line_and_smooth_nodes_are_found() -> None:
    scene = with_lines(read_svg(TEXT).scene)
    joints = Joints.of(scene)
    assert joints.is_line.tolist() == [True, False, True, False, False]
    assert joints.is_smooth.tolist() == [False, True, True, False, True]


def test_moved_nodes_keep_their_kinds() -> None:
    scene = with_lines(read_svg(TEXT).scene)
    joints = Joints.of(scene)
    generator = torch.Generator().manual_seed(1)
    parts = [part + torch.randn(part.shape, generator=generator) for part in joints.values(scene)]
    segments = joints.segments(*parts)
    assert torch.equal(segments[:, 0], parts[0])
    moved = Joints.of(scene.__class__(**{**vars(scene), "segments": segments}))
    assert moved.is_smooth.tolist() == joints.is_smooth.tolist()
    torch.testing.assert_close(joints.segments(*joints.values(scene)), scene.segments, atol=0.01, rtol=0)

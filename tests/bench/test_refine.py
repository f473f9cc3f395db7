"""The bench of `warpvec refine`: its rows, and drawings that it disturbs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import refine
import torch
from click.testing import CliRunner
from PIL import Image

from warpvec.geometry.joints import Joints
from warpvec.svg.measure import draw

TEXT = """<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64"><rect width="64" height="64" fill="#fff"/>
<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="12" y1="32" x2="52" y2="32"><stop stop-color="#d84"/>
<stop offset="1" stop-color="#26c"/></linearGradient><circle cx="32" cy="32" r="20.3" fill="url(#a)"/>
<path d="M24.4 24.7 H39.6 V38.2z" fill="#175"/></svg>"""


def test_a_row_for_each_kind_and_drawing(tmp_path: Path) -> None:
    (tmp_path / "one.svg").write_text(TEXT)
    Image.fromarray(draw(TEXT, 64, 64)).save(tmp_path / "one.png")
    kinds = "tracing,original,noise-gradients"
    options = [str(tmp_path), "--tracings", str(tmp_path), "--kinds", kinds, "--iterations", "30"]
    result = CliRunner().invoke(refine.main, options)
    assert result.exit_code == 0, result.output
    rows = [line.strip("| ").split(" | ") for line in result.output.splitlines()]
    assert [row[:2] for row in rows] == [[kind, name] for kind in kinds.split(",") for name in ("one", "mean")]
    noise = rows[4]
    assert float(noise[3]) > float(noise[2]) + 10.0
    assert noise[-2:] == ["0", "0"]


def test_flat_paths_get_gradients_if_asked(tmp_path: Path) -> None:
    drawn = draw(TEXT, 64, 64)
    flat = TEXT.replace("url(#a)", "#888")
    plain, painted = (
        refine.refined("one", drawn, flat, {"iterations": 20, "gradients": count}) for count in (0.0, "auto")
    )
    assert painted.after > plain.after + 5.0


def test_disturbed_drawings_keep_their_kinds_and_flat_paints() -> None:
    scene = refine.drawing_from(TEXT, draw(TEXT, 64, 64))
    for with_gradients in (False, True):
        moved = refine.disturbed(scene, 1.0, with_gradients)
        assert refine.lost_kinds(scene, moved) == 0
        assert float((moved.segments - scene.segments).norm(dim=2).mean()) > 0.5
        assert torch.equal(moved.color[-1], scene.color[-1])
        assert torch.equal(moved.color[0], scene.color[0]) is not with_gradients


def test_a_corner_made_of_a_smooth_node_is_lost() -> None:
    scene = refine.drawing_from(TEXT, draw(TEXT, 64, 64))
    row = int(Joints.of(scene).is_smooth.nonzero()[0])
    segments = scene.segments.clone()
    segments[row, 1] += torch.tensor([3.0, 3.0])
    assert refine.lost_kinds(scene, replace(scene, segments=segments)) == 1

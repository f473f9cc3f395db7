"""What the page shows while a drawing is made: soon something like the picture, and never a step back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import torch

from warpvec.app.fitting import run_job
from warpvec.app.frames import Best, FrameWriter
from warpvec.app.messages import FitJob
from warpvec.app.settings import FitSettings
from warpvec.app.sketch import sketch
from warpvec.app.stage_times import StageTimes
from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr
from warpvec.image.write import png_bytes, to_8_bits
from warpvec.rendering.draw import draw_exactly
from warpvec.svg.measure import draw
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Watch


def disc(radius: float, side: int = 48) -> Scene:
    points = circle_points(torch.tensor([[side / 2, side / 2]]), torch.tensor([radius]), segment_count=4)
    color = torch.tensor([[0.8, 0.1, 0.2]])
    return Scene.uniform(points, color, torch.ones(1), torch.ones(3), generation=torch.zeros(1, dtype=torch.long))


def picture(side: int = 48) -> Any:
    return draw_exactly(disc(side / 3, side), side, side, 1)


@pytest.mark.parametrize("side", [16, 48, 700])
def test_a_sketch_is_like_its_picture(side: int) -> None:
    pixels = picture(side)
    drawn = draw(sketch(pixels))
    assert drawn.shape == pixels.shape
    assert psnr(drawn, pixels) > 20.0


def test_a_sketch_leaves_holes_open_and_draws_all_else() -> None:
    pixels = np.ones((40, 60, 4), np.float32)
    pixels[10:30, 20:40] = 0.0  # transparent
    pixels[:10, :, :3] = (0.1, 0.2, 0.9)
    drawn = draw(sketch(pixels), transparent=True)
    assert psnr(drawn, pixels) > 20.0
    assert drawn[20, 30, 3] == 0
    assert drawn[2:8, 2:58, 3].min() == drawn[35:, :, 3].min() == 255
    sketch(np.zeros((1, 1, 4), np.float32))


def test_frames_of_flat_art_never_become_worse_and_count_no_paths() -> None:
    frames: list[dict[str, Any]] = []
    pixels = picture()
    writer = FrameWriter(48, 48, frames.append, Best(pixels, "<svg/>", 12.0, 1))
    for number, radius in enumerate((15.0, 4.0, 16.0), 1):
        writer._due = 0.0
        writer(Progress(number, 3, 1, 0.1, torch.tensor(0.01), lambda radius=radius: disc(radius)))
    closeness = [frame["psnr"] for frame in frames]
    assert closeness[0] == closeness[1] > 12.0
    assert closeness[2] is None or closeness[2] > closeness[1]
    assert frames[0]["svg"] == frames[1]["svg"] != frames[2]["svg"]
    assert [frame["paths"] for frame in frames] == [None] * 3


@pytest.mark.parametrize("start", [False, True])
def test_the_first_frame_comes_before_the_first_fit_unless_there_is_a_drawing(start: bool) -> None:
    seen: list[tuple[str, Any]] = []
    pixels = picture()
    job = FitJob(1, png_bytes(to_8_bits(pixels)), "disc", FitSettings({}), start=sketch(pixels) if start else None)
    watch = Watch(lambda progress: seen.append(("iteration", None)))
    run_job(job, lambda kind, facts: seen.append((kind, facts)), watch, 1)
    kinds = [kind for kind, _ in seen]
    assert kinds.index("mode") == 0
    assert (kinds.index("frame") > kinds.index("iteration")) == start


def test_a_picture_of_two_colours_is_shown_before_its_kind_is_chosen() -> None:
    kinds = list[str]()
    job = FitJob(1, png_bytes(to_8_bits((picture() < 0.5).astype(np.float32))), "disc", FitSettings({}))
    run_job(job, lambda kind, facts: kinds.append(kind), Watch(lambda progress: None), 1)
    assert kinds[:2] == ["frame", "mode"]


def test_a_stage_takes_as_long_as_it_did() -> None:
    seconds = iter([0.0, 7.0, 7.0, 8.0, 8.0])
    times = StageTimes(lambda: next(seconds))
    assert times.begin("digging") == {"words": "digging", "seconds": None}
    assert times.begin("filling") == {"words": "filling", "seconds": None}
    assert times.begin("digging")["seconds"] == 7.0

"""A fit on a GPU keeps the order of its caller's streams."""

from __future__ import annotations

import pytest
import torch
import warp as wp
from short_fits import small_photo

from warpvec.config.presets import make_config
from warpvec.fit.loop import fit


@pytest.mark.parametrize("colors", [0, 3])
def test_a_fit_on_a_stream_of_the_caller_ends_the_same(colors: int, device: str) -> None:
    if device == "cpu":
        pytest.skip("the CPU has no streams")
    config = make_config(curves=24, iterations=60, device=device, colors=colors)
    want = fit(small_photo(), config).scene
    before = wp.get_stream(device)
    with torch.cuda.stream(torch.cuda.Stream()):
        torch.cuda._sleep(100_000_000)  # what follows on this stream comes late, the photo too
        got = fit(small_photo().to(device), config).scene
    assert wp.get_stream(device) is before
    assert torch.equal(got.segments, want.segments) and torch.equal(got.color, want.color)

"""Torch and Warp work in one order on a GPU, and the host runs ahead of it by few steps."""

from __future__ import annotations

import pytest
import torch
import warp as wp

from warpvec.rendering import streams
from warpvec.rendering.launch import start_warp
from warpvec.rendering.streams import StepQueue, on_warps_stream


class FakeEvent:
    """Stands for the end of a step; keeps the order in which steps end and are waited for."""

    log: list[tuple[str, int]] = []
    made = 0

    def __init__(self) -> None:
        self.number = FakeEvent.made
        FakeEvent.made += 1

    def record(self) -> None:
        self.log.append(("launched", self.number))

    def synchronize(self) -> None:
        self.log.append(("done", self.number))


def test_the_host_waits_once_more_than_two_steps_are_not_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeEvent, "log", [])
    monkeypatch.setattr(FakeEvent, "made", 0)
    monkeypatch.setattr(streams.torch.cuda, "Event", FakeEvent)
    queue = StepQueue("cuda:0")
    for _ in range(4):
        queue.add()
    names = [("launched", 0), ("launched", 1), ("launched", 2), ("done", 0), ("launched", 3), ("done", 1)]
    assert FakeEvent.log == names
    queue.wait()
    queue.wait()
    assert FakeEvent.log[len(names) :] == [("done", 2), ("done", 3)]


def test_on_the_cpu_no_step_waits_and_no_stream_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> None:
        raise AssertionError("there is no GPU")

    monkeypatch.setattr(streams.torch.cuda, "Event", refuse)
    monkeypatch.setattr(streams.torch.cuda, "current_stream", refuse)
    queue = StepQueue("cpu")
    with on_warps_stream("cpu"):
        queue.add()
        queue.wait()


def test_torch_joins_warp_between_the_callers_work(device: str) -> None:
    if device == "cpu":
        pytest.skip("the CPU has no streams")
    start_warp()
    own = torch.cuda.Stream()
    with torch.cuda.stream(own):
        torch.cuda._sleep(50_000_000)  # what follows on this stream comes late
        values = torch.ones(1000, device=device)
        with on_warps_stream(device):
            assert torch.cuda.current_stream().cuda_stream == wp.get_stream(device).cuda_stream
            torch.cuda._sleep(50_000_000)
            doubled = values * 2.0
        assert torch.cuda.current_stream() == own
        assert float(doubled.sum() + values.sum()) == 3000.0

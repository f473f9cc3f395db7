"""Fixtures of every test: devices, seeds, a quiet Warp."""

from __future__ import annotations

import numpy as np
import pytest
import torch
import warp as wp

wp.config.log_level = wp.LOG_WARNING

# Sums in torch then have one order, so that a seeded test gives the same digits on every machine.
torch.set_num_threads(1)


@pytest.fixture(params=["cpu", "cuda"])
def device(request: pytest.FixtureRequest) -> str:
    """Every device in turn; "cuda" is skipped, with the reason, where there is none."""
    name: str = request.param
    if name == "cuda" and (reason := _why_no_cuda()):
        pytest.skip(reason)
    return name


@pytest.fixture(autouse=True)
def seed() -> int:
    """Seeds the global generators before each test, and gives the seed for a test's own."""
    value = 0
    torch.manual_seed(value)
    np.random.seed(value)
    return value


@pytest.fixture
def quick_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Circles in place of the paths of a fit."""
    from stubs import stub_fit

    from warpvec.vectorization import api

    monkeypatch.setattr(api, "fit", stub_fit)


def _why_no_cuda() -> str | None:
    if not torch.cuda.is_available():
        return "torch sees no CUDA device"
    if wp.get_cuda_device_count() == 0:
        return "warp sees no CUDA device"
    return None

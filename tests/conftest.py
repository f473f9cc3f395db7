"""Fixtures for all tests: devices, kernel backends and seeds; also keeps Warp quiet."""

from __future__ import annotations

import numpy as np
import pytest
import torch
import warp as wp
from backends import BACKENDS, Backend, why_no_cuda

wp.config.log_level = wp.LOG_WARNING

# With one thread torch adds in a fixed order, so a seeded test gives the same digits on every machine.
torch.set_num_threads(1)


@pytest.fixture(params=["cpu", "cuda"])
def device(request: pytest.FixtureRequest) -> str:
    """Each device in turn; "cuda" is skipped on a machine without a GPU."""
    name: str = request.param
    if name == "cuda" and (reason := why_no_cuda()):
        pytest.skip(reason)
    return name


@pytest.fixture(params=BACKENDS)
def backend(request: pytest.FixtureRequest) -> Backend:
    """Each way to run the kernels in turn; "cuda" is skipped on a machine without a GPU."""
    if request.param == "cuda" and (reason := why_no_cuda()):
        pytest.skip(reason)
    return BACKENDS[request.param]


@pytest.fixture(autouse=True)
def seed() -> int:
    """Seed the global generators before each test; return the seed."""
    value = 0
    torch.manual_seed(value)
    np.random.seed(value)
    return value


@pytest.fixture
def quick_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the fit by a stub that returns circles."""
    from stubs import stub_fit

    from warpvec.vectorization import photo_fit

    monkeypatch.setattr(photo_fit, "fit", stub_fit)

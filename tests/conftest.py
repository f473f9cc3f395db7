"""Fixtures for all tests: devices, kernel backends and seeds; also keeps Warp quiet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import torch
import warp as wp
from backends import BACKENDS, Backend, why_no_cuda
from children import kill_all, take_default_signals
from hangs import no_hang
from short_fits import Photo

wp.config.log_level = wp.LOG_WARNING

# With one thread torch adds in a fixed order, so a seeded test gives the same digits on every machine.
torch.set_num_threads(1)


take_default_signals()  # here and not in each test: what tests start inherits it

NO_CUDA = why_no_cuda()

TESTS = Path(__file__).parent

SCALAR_IS_SLOW = [TESTS / name for name in ("paper", "paper/stages", "rendering")]
"""Folders in which tests of the form of kernels for GPUs are slow. It has the same source as the CPU's form, which the
fast tests of these folders run; in `rendering/stages` both forms of each kernel are tested fast."""


@pytest.hookimpl(tryfirst=True)  # before -m selects
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests of the form of kernels for GPUs as slow in some folders: a tenth of the time of the fast tests."""
    for item in items:
        call = getattr(item, "callspec", None)
        if call is not None and call.params.get("backend") == "scalar" and item.path.parent in SCALAR_IS_SLOW:
            item.add_marker(pytest.mark.slow)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Iterator[None]:
    """Let a fixture fail that hangs."""
    with no_hang():
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Let a test fail that hangs: one that waits for a minute, or for as long as its mark ``longest_wait`` allows."""
    mark = item.get_closest_marker("longest_wait")
    with no_hang(*mark.args if mark else ()):
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Iterator[None]:
    """Let the end of a fixture fail that hangs. After the last test of a file, kill what failed tests have left."""
    try:
        with no_hang():
            yield
    finally:
        if nextitem is None or nextitem.path != item.path:
            kill_all()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say why nothing was tested on CUDA, rather than skip a test in seven."""
    if NO_CUDA:
        terminalreporter.write_line(f"not tested on CUDA: {NO_CUDA}")


@pytest.fixture(params=["cpu"] if NO_CUDA else ["cpu", "cuda"])
def device(request: pytest.FixtureRequest) -> str:
    """Each device in turn; "cuda" only on a machine with a GPU."""
    name: str = request.param
    return name


@pytest.fixture(params=[name for name, where in BACKENDS.items() if where.device == "cpu" or not NO_CUDA])
def backend(request: pytest.FixtureRequest) -> Backend:
    """Each way to run the kernels in turn; "cuda" only on a machine with a GPU."""
    if request.param == "cuda" and NO_CUDA:  # a test may ask for it by name
        pytest.skip(NO_CUDA)
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

    from warpvec.modes import photo

    monkeypatch.setattr(photo, "fit", stub_fit)


@pytest.fixture
def photo() -> Photo:
    """Noise, 48 x 32."""
    return np.random.default_rng(1).integers(0, 256, (32, 48, 3), dtype=np.uint8)

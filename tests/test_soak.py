"""Many runs in one process do not take more and more memory."""

from __future__ import annotations

import gc
from pathlib import Path

import numpy as np
import pytest

import warpvec

RUNS = 50
SETTINGS = (
    {}, {"colors": 4}, {"opacity": "opaque"}, {"renderer": "splat", "samples": 8, "lines": 4}, {"max_bytes": 6_000}
)  # fmt: skip


def _resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads memory from Linux's /proc")
def test_memory_is_flat_over_many_runs() -> None:
    """Compare from the tenth run on: by then every kernel is loaded and each cached renderer has its buffers."""
    resident = []
    for run in range(RUNS):
        photo = np.random.default_rng(run).integers(0, 256, (48, 64 + run % 3, 3), dtype=np.uint8)
        settings = SETTINGS[run % len(SETTINGS)]
        curves = None if "max_bytes" in settings else 16
        result = warpvec.vectorize(photo, curves, iterations=12, initial_curves=8, threads=2, device="cpu", **settings)
        assert result.metrics["curves"] > 0
        if run % 10 == 9:
            gc.collect()
            resident.append(_resident_bytes())
    # A photo, its scene and its file take 0.2 MB, so runs that kept them would add 8 MB. Measured: 0.5 to 2.5 MB.
    assert resident[-1] - resident[0] < 6e6, resident

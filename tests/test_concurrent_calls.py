"""Calls of `warpvec.vectorize` in several threads at once."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import pytest

CALLS = """
import json, sys
from concurrent.futures import ThreadPoolExecutor
import numpy as np
import warpvec

sys.setswitchinterval(1e-6)  # so that threads meet often
rng = np.random.default_rng(0)
photos = [np.kron(rng.integers(0, 255, (6, 6, 3)), np.ones((6, 6, 1))).astype(np.uint8) for _ in range(4)]
settings = [
    {"mode": "photo", "gradients": 4}, {"mode": "photo", "renderer": "splat"}, {"mode": "photo"}, {"mode": "flat"},
]
settings = [{**given, "curves": 16, "iterations": 20} if given["mode"] == "photo" else given for given in settings]
draw = lambda photo, given: warpvec.vectorize(photo, **given).svg()
with ThreadPoolExecutor(int(sys.argv[1])) as pool:
    print(json.dumps(list(pool.map(draw, photos, settings))))
"""


@pytest.mark.slow
def test_first_calls_in_several_threads_draw_what_one_thread_draws() -> None:
    # In processes of their own: what Warp keeps in globals is at risk while kernels are made, which happens once.
    def drawings(threads: int) -> Any:
        command = [sys.executable, "-c", CALLS, str(threads)]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    assert drawings(4) == drawings(1)

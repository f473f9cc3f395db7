"""Whatever order a user does things in: no edit is lost, no figure is stale, and the page reports no error.

`bench/sequences.py` tries very many more, with the real worker.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_sequences import STEPS, Sequences
from quick_desk import QuickServer, quick_server_fixture  # noqa: F401  (fixture)

pytestmark = NEEDS_BROWSER


@pytest.fixture
def sequences(browser: Any, quick_server: QuickServer, tmp_path: Path) -> Iterator[Sequences]:
    made = Sequences(browser, quick_server, tmp_path)
    yield made
    made.close()


@pytest.mark.parametrize("first", STEPS)
def test_no_two_steps_lose_an_edit(sequences: Sequences, first: str) -> None:
    for second in STEPS[STEPS.index(first) % 8 :: 8]:  # bench/sequences.py has all, with the real worker
        sequences.check(("edit", first, second))


@pytest.mark.parametrize("number", range(2))
def test_no_eight_steps_lose_an_edit(sequences: Sequences, number: int) -> None:
    rng = np.random.default_rng(number)
    for _ in range(3):
        sequences.check(tuple(rng.choice(STEPS, 8).tolist()))


def test_no_three_steps_on_one_drawing_lose_an_edit(sequences: Sequences) -> None:
    for steps in list(itertools.product(STEPS[:6], repeat=3))[::24]:
        sequences.check(steps)

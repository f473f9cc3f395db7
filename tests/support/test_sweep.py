"""A swept test runs every case, and a failure in one of them is a failure that states it."""

from __future__ import annotations

import pytest
from sweep import sweep


def test_every_combination_runs() -> None:
    seen = []

    @sweep("z", [5, 6])
    @sweep(("x", "y"), [(1, 2), (3, 4)])
    def test(x: int, y: int, z: int, device: str) -> None:
        seen.append((x, y, z, device))

    test(device="cpu")
    assert seen == [(1, 2, 5, "cpu"), (3, 4, 5, "cpu"), (1, 2, 6, "cpu"), (3, 4, 6, "cpu")]


def test_a_failure_states_its_case() -> None:
    @sweep("x", [1, 2, 3])
    def test(x: int) -> None:
        with pytest.raises(ZeroDivisionError):
            1 / (x - 1)

    with pytest.raises(pytest.fail.Exception) as caught:
        test()
    assert caught.value.__notes__ == ["with x = 2"]


@sweep("x", [1, 2])
@pytest.mark.parametrize("y", [3])
def test_fixtures_and_parameters_are_given(x: int, y: int, seed: int) -> None:
    assert (x in (1, 2), y, seed) == (True, 3, 0)

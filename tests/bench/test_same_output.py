"""Test the comparison of outputs: what counts as a difference, and that a command that fails is not compared."""

from __future__ import annotations

from pathlib import Path

import pytest
import same_output
from commands import write_photo

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("after", "places"),
    [
        ({"report": {"psnr": 30.0, "paths": {"0": 7}}}, []),
        ({"report": {"psnr": 31.0, "paths": {"0": 7}}}, ["/report/psnr: 30.0 -> 31.0"]),
        ({"report": {"psnr": 30.0, "paths": {"0": 7, "1": 8}}}, ["/report/paths/1: None -> 8"]),
        ({"report": {"psnr": 30.0, "paths": {"0": 7}, "bytes": 5}}, []),
        (None, ["None"]),
    ],
)
def test_places_that_differ_are_listed(after: object, places: list[str]) -> None:
    before = {"report": {"psnr": 30.0, "paths": {"0": 7}, "bytes": 4}}
    found = same_output.differing(before, after, ["bytes"])
    assert len(found) == len(places) and all(place in line for place, line in zip(places, found, strict=True))


def test_a_command_is_recorded_with_its_files(tmp_path: Path) -> None:
    write_photo(tmp_path, "photo.png", 24, 40, seed=0)
    words = ["run", "photo.png", "photo.svg", "--curves", "4", "--iterations", "2", "--json"]
    first, second = (same_output.run_command(words, tmp_path) for _ in range(2))
    assert first["report"]["curves"] == 4 and first["files"].keys() == {"photo.svg"}
    assert same_output.differing(first, second, []) == []


def test_a_command_that_fails_stops_the_comparison(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="exit code must be 0, got 2; it printed:\\n.*missing.png"):
        same_output.run_command(["run", "missing.png"], tmp_path)

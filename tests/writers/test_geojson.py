"""GeoJSON lies on the map that a world file places the picture on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.commands import invoke

import warpvec
from warpvec.errors import InputError
from warpvec.image.write import write_png

WORLD = "0.5\n0\n0\n-0.25\n100.25\n49.875\n"
"""A pixel is 0.5 wide and 0.25 high; the corner of the picture is at (100, 50)."""


def square() -> np.ndarray:
    image = np.full((40, 60, 3), 255, np.uint8)
    image[10:30, 20:50] = (200, 30, 30)
    return image


@pytest.mark.parametrize("size", [None, "90mm"])
def test_a_world_file_places_the_areas(tmp_path: Path, size: str | None) -> None:
    pytest.importorskip("shapely")
    result = warpvec.vectorize(square(), threads=1, mode="flat", size=size, world_file=[*map(float, WORLD.split())])
    result.save(tmp_path / "map.geojson")
    features = json.loads((tmp_path / "map.geojson").read_text())["features"]
    ring = next(each["geometry"] for each in features if each["properties"]["fill"] == "#c81e1e")["coordinates"][0]
    ring = np.array(ring[0] if isinstance(ring[0][0], list) else ring)
    np.testing.assert_allclose([ring.min(0), ring.max(0)], [[110.0, 42.5], [125.0, 47.5]], atol=0.01)
    x, y = ring.T
    assert (x[:-1] * y[1:] - x[1:] * y[:-1]).sum() > 0.0  # counterclockwise


def test_a_command_reads_the_world_file(tmp_path: Path) -> None:
    pytest.importorskip("shapely")
    write_png(tmp_path / "map.png", square() / np.float32(255.0))
    (tmp_path / "map.pgw").write_text(WORLD)
    out = tmp_path / "map.geojson"
    found = invoke("run", tmp_path / "map.png", out, "--mode", "flat", "--world-file", tmp_path / "map.pgw")
    assert found.exit_code == 0, found.output
    assert "110" in out.read_text()


@pytest.mark.parametrize("wrong", ["1 0 0 -1 0", "1 2 2 4 0 0", "1 0 0 nan 0 0", "1 0 0 x 0 0", [1, 0, 0, 0, 0, 0]])
def test_numbers_that_place_nothing_are_refused(wrong: Any) -> None:
    with pytest.raises(InputError, match="six numbers"):
        warpvec.vectorize(square(), mode="flat", world_file=wrong)

"""Writing PNG files."""

from __future__ import annotations

import numpy as np
from image_files import RGB, assert_pixels, complaint

from warpvec.image.read import read_image
from warpvec.image.write import write_png


def test_write_png_rounds_and_replaces(tmp_path):
    path = tmp_path / "frame.png"
    path.write_bytes(b"old")
    levels = np.array([[(0.49, 0.51, 254.51), (254.49, 300, -4), (1, 2, 3)]]) / 255
    write_png(path, levels)
    assert_pixels(read_image(path), np.array([[(0, 1, 255), (254, 255, 0), (1, 2, 3)]]) / 255)
    write_png(path, (RGB / 255).astype(np.float32))
    assert_pixels(read_image(path), RGB / 255)
    assert [p.name for p in tmp_path.iterdir()] == ["frame.png"]
    assert complaint(write_png, tmp_path / "no" / "frame.png", levels, name="--save-frames").startswith(
        "--save-frames "
    )

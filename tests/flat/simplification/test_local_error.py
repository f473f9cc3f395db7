"""Tests of warpvec.flat.simplification.local_error: the error in the pixels that curves pass."""

from __future__ import annotations

import numpy as np

from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.local_error import errors_near


def test_each_curve_has_the_error_of_the_pixels_it_passes_and_of_those_beside_them() -> None:
    rng = np.random.default_rng(0)
    height, width = 23, 31
    control = rng.uniform(-6.0, 36.0, (40, 4, 2))  # many leave the picture
    control[0] = control[0, 0]  # a point
    error = rng.normal(size=(height, width)).astype(np.float32)
    np.testing.assert_allclose(errors_near(control, error), [_error_near(each, error) for each in control], rtol=1e-9)


def _error_near(control: np.ndarray, error: np.ndarray) -> float:
    reach = np.linalg.norm(np.diff(control, axis=0), axis=1).sum()
    count = int(np.clip(np.ceil(reach / SIMPLIFICATION.error_spacing), 1, SIMPLIFICATION.error_points_max))
    seen = set()
    for t in np.arange(count + 1) / count:
        s = 1.0 - t
        x, y = np.floor(np.array([s**3, 3 * s * s * t, 3 * s * t * t, t**3]) @ control).astype(int)
        seen |= {(x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1)}
    height, width = error.shape
    return float(sum(float(error[y, x]) for x, y in seen if 0 <= x < width and 0 <= y < height))

"""Fixtures for the tests of vectorization."""

from __future__ import annotations

import numpy as np
import pytest
from short_fits import Photo


@pytest.fixture
def photo() -> Photo:
    """Noise, 48 x 32."""
    return np.random.default_rng(1).integers(0, 256, (32, 48, 3), dtype=np.uint8)

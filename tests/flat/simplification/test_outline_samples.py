"""Points along outlines know how well a picture shows them there."""

from __future__ import annotations

import numpy as np
import torch
from flat_drawings import BLUE, RED, SIZE, drawing
from scenes import rectangle

from warpvec.flat.simplification.outline_samples import sample_outlines


def test_contrast_is_that_of_the_colours_at_both_sides_and_none_where_hidden():
    scene = drawing((RED, [rectangle(8, 8, 40, 56)]), (BLUE, [rectangle(30, 4, 60, 60)]))

    samples = sample_outlines(scene, SIZE, SIZE)

    top, right, _, left = samples.contrast[:4]
    over_white = float((torch.ones(3) - torch.tensor(RED)).square().sum())
    np.testing.assert_allclose(left, over_white, rtol=1e-2)
    np.testing.assert_allclose(right, 0.0, atol=1e-4)
    np.testing.assert_allclose(top[:5], over_white, rtol=1e-2)
    np.testing.assert_allclose(top[-2:], 0.0, atol=1e-4)

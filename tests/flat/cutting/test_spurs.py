"""Spurs between outlines that nearly coincide go to the neighbours."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.flat.cutting.cutout import cut_out
from warpvec.geometry.bezier import whole_curves
from warpvec.svg.read import read_svg

SIDE = 64


def _cut(elements: str):  # type: ignore[no-untyped-def]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}">'
    return cut_out(read_svg(f"{head}{elements}</svg>").scene, SIDE, SIDE)


@pytest.mark.parametrize(("gap", "is_kept"), [(0.1, False), (0.5, True)])
def test_a_part_that_runs_out_between_two_outlines_loses_its_spur(gap: float, is_kept: bool) -> None:
    # The square below shows as a block on the left, and as a strip of the width ``gap`` along the upper path.
    below = '<path d="M8,8H56V40H8Z" fill="#00f"/>'
    above = f'<path d="M20,8H56V{40 - gap}H20Z" fill="#f00"/>'
    cut = _cut(below + above)
    blue = cut.scene.color[:, 2].argmax()
    right = float(whole_curves(cut.scene.select(blue[None]))[..., 0].max())
    assert right == pytest.approx(56.0 if is_kept else 20.0, abs=0.2)
    assert cut.sliver_count == (0 if is_kept else 1)


def test_what_a_spur_loses_its_neighbour_gets() -> None:
    wedge = '<path d="M4,4H60V60H4Z" fill="#00f"/><path d="M4,4H60V30L20,30.12V60H4Z" fill="#f00"/>'
    cut = _cut(wedge)
    points = whole_curves(cut.scene).double().numpy()
    x, y = np.moveaxis(points, 2, 0)
    weights = np.array([[-10, 6, 3, 1], [-6, 0, 3, 3], [-3, -3, 0, 6], [-1, -3, -6, 10]]) / 20
    areas = np.einsum("ni,ij,nj->n", x, weights, y)
    assert abs(np.bincount(cut.scene.structure.segment_path.numpy(), areas)).sum() == pytest.approx(56 * 56, rel=1e-5)

"""The optimizer state of segments that come from others."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.geometry.nodes import Edit
from warpvec.kernels.adan import BETAS


def carried_averages(averages: Tensor, age: Tensor, edit: Edit) -> tuple[Tensor, Tensor]:
    """Return the averages of the gradients and the ages of the segments that ``edit`` makes.

    Averages follow the gradients, of which they are sums: the weights of the edit apply to them, and to the root of
    that of squares, so that a point that has long moved one way goes on at its speed. A merged segment has the age of
    the older one, to which the averages of the younger one are scaled. Segments that stay keep their bits.

    Args:
        averages: m, v, n and the previous gradient of the old segments [4, R, 6], as in
            ``warpvec/fit/adan.py``.
        age: their steps taken [R] (int64).

    Returns:
        averages [4, R', 6] and ages [R'].
    """
    new, new_age = averages[:, edit.source[:, 0]], age[edit.source].amax(1)
    fresh = edit.is_fresh.nonzero().flatten()
    source = edit.source[fresh]
    linear = averages[:, source].double().reshape(len(averages), len(fresh), 2, 3, 2)
    linear[2] = linear[2].sqrt()
    gathered = linear * _age_factors(age[source], new_age[fresh])[..., None, None]
    carried = torch.einsum("rkji,arkic->arjc", edit.weights[fresh], gathered)
    carried[2] = carried[2].square()
    new[:, fresh] = carried.flatten(-2).to(averages.dtype)
    return new, new_age


def _age_factors(age: Tensor, new_age: Tensor) -> Tensor:
    """Return what scales averages of ``age`` [R', 2] to those of ``new_age`` [R'], for each of the four [4, R', 2].

    An average is too small at first by the factor 1 - b^age, and the root of that of squares by its root.
    """
    betas = torch.tensor(BETAS, dtype=torch.float64, device=age.device)[:, None, None]
    own, new = (1.0 - betas**values for values in (age.clamp(min=1), new_age.clamp(min=1)[:, None]))
    factors = new / own
    factors[2] = factors[2].sqrt()
    return torch.cat([factors, torch.ones_like(factors[:1])])

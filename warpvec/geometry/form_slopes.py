"""How the curves of a drawing follow the parameters of its forms."""

from __future__ import annotations

import numpy as np
import torch
from scipy import sparse

from warpvec.geometry.forms.form import PARAMETERS
from warpvec.geometry.path_forms import Forms, form_rows
from warpvec.geometry.structure import Structure

_POINTS = 4
"""Points of a curve, its end included."""


def form_derivative(forms: Forms, structure: Structure) -> sparse.csr_matrix:
    """Return the derivative of the curves by the parameters of ``forms``: [8 R, 6 N], float64.

    Its rows are the coordinates of four points of each curve, its end included.
    """
    parts = []
    for _, form, paths in forms.groups():
        slopes = form.derivative(forms.parameters[paths].double())
        slopes = torch.cat([slopes, slopes.roll(-1, 1)[:, :, :1]], 2)  # [K, S, 4, 2, 6]
        rows = 2 * (_POINTS * form_rows(structure, paths, form)[..., None] + torch.arange(_POINTS, device=paths.device))
        row = rows[..., None, None] + torch.arange(2, device=paths.device)[:, None]
        column = PARAMETERS * paths[:, None, None, None, None] + torch.arange(PARAMETERS, device=paths.device)
        parts.append([each.expand_as(slopes).flatten().cpu().numpy() for each in (slopes, row, column)])
    values, *places = (np.concatenate(part) for part in zip(*parts, strict=True))
    shape = (2 * _POINTS * structure.segment_count, PARAMETERS * len(forms))
    return sparse.csr_matrix((values, tuple(places)), shape=shape)

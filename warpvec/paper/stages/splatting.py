"""Host side of stage 1 of the splat renderer: control points -> Gaussians, and the adjoint."""

from __future__ import annotations

import math
from functools import cache

import torch
import warp as wp
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.bezier import bernstein
from warpvec.kernels import splatting as kernels
from warpvec.kernels import splatting_adjoint as adjoint_kernels
from warpvec.kernels.constants import END_FACTORS, LINE_REACH, LINE_SPREAD, SIGMA_PER_SPACING, SPLAT_END
from warpvec.kernels.lanes import Lanes
from warpvec.kernels.splatting import PLANES
from warpvec.kernels.splatting_adjoint import CENTER_TERMS, COVARIANCE_TERMS, SIDE_TERMS
from warpvec.rendering.launch import Launcher, as_warp


class Splatting:
    """The Gaussians along the two sides of each path and on ``lines`` lines between them, ``samples`` on each.

    Attributes:
        row_count, sample_count: rows of a path, and Gaussians of a row.
        sample_stride: Gaussians of a row in memory, padded to whole lane values.
        splats: [N, rows, PLANES, sample_stride], see ``kernels/splatting.py``.
        term_count: number of sums per Gaussian that :meth:`adjoint` takes.
    """

    splats: wp.array

    def __init__(
        self, launch: Launcher, lanes: Lanes, samples: int, lines: int, degree: int, interior: bool, covariance: bool
    ) -> None:
        self._launch, self._lanes, self._degree = launch, lanes, degree
        self._interior, self._covariance = int(interior), covariance
        self.row_count, self.sample_count = lines + 2, samples
        self._block_count = -(-samples // lanes.width)
        self.sample_stride = self._block_count * lanes.width
        self.term_count = COVARIANCE_TERMS if covariance else CENTER_TERMS
        self._buffers = launch.make_buffers()
        weight = row_weights(lines)
        self._rows = [self._upload(weight), self._upload(row_steps(weight))]
        self._spacing_factor = self._upload_lanes(spacing_factors(samples))
        self._basis: dict[int, wp.array] = {}

    def run(self, points: Tensor, row_opacity: wp.array) -> None:
        """Place the Gaussians of ``points`` [N, P, 2] px with ``row_opacity`` [N rows].

        Raises:
            InputError: a path has fewer than two pieces, or an incomplete one.
        """
        path_count, point_count = points.shape[:2]
        size = path_count * self.row_count * PLANES * self.sample_stride
        self.splats = self._buffers.get("splats", size, self._lanes.dtype)
        counts = [self.row_count, self.sample_count, self._block_count]
        inputs = [self._flat(points), point_count, row_opacity, self._basis_of(point_count)]
        arguments = [*inputs, self._spacing_factor, *self._rows, *counts, lane_view(self.splats, self._lanes)]
        place = kernels.make_kernels(self._lanes).place_splats
        self._launch.shared(place, path_count * self._block_count, arguments)

    def adjoint(
        self, points: Tensor, opacity: Tensor, splat_sums: wp.array, adj_points: Tensor, adj_opacity: Tensor
    ) -> None:
        """Fill ``adj_points`` [N, P, 2] and ``adj_opacity`` [N] from the sums [N, rows, terms, sample_stride]."""
        lanes, (path_count, point_count) = self._lanes, points.shape[:2]
        stage = adjoint_kernels.make_kernels(lanes, self._covariance)
        size = path_count * SIDE_TERMS * self.sample_stride
        side_sums = lane_view(self._buffers.get("side_sums", size, lanes.dtype), lanes)
        sums = lane_view(splat_sums, lanes)
        basis, counts = self._basis_of(point_count), [self.row_count, self._block_count, self._interior]
        arguments = [self._rows[0], *counts, lane_view(self.splats, lanes), sums, side_sums]
        self._launch.shared(stage.center_adjoint, path_count * self._block_count, arguments)
        if self._covariance:
            shape = [self._flat(points), point_count, basis, self._spacing_factor, *self._rows, *counts]
            self._launch.shared(stage.covariance_adjoint, path_count * self._block_count, [*shape, sums, side_sums])
        arguments = [basis, point_count, self._block_count, side_sums, self._flat(adj_points)]
        self._launch.shared(stage.gather_points_adjoint, path_count * point_count, arguments)
        arguments = [as_warp(opacity, lanes.dtype), self._block_count, side_sums, as_warp(adj_opacity, lanes.dtype)]
        self._launch(stage.gather_opacity_adjoint, path_count, arguments)

    def _flat(self, points: Tensor) -> wp.array:
        return as_warp(points.reshape(-1, 2), self._lanes.dtype)

    def _basis_of(self, point_count: int) -> wp.array:
        if point_count not in self._basis:
            if point_count < 2 * self._degree or point_count % self._degree:
                rule = f"must make at least 2 curves of degree {self._degree} a path"
                remedy = f"give a multiple of {self._degree}, at least {2 * self._degree}"
                raise InputError("points", rule, f"{point_count} points", remedy)
            basis = side_basis(point_count, self._degree, self.sample_count)
            self._basis[point_count] = self._upload_lanes(basis)
        return self._basis[point_count]

    def _upload(self, values: Tensor) -> wp.array:
        return wp.array(values.numpy(), dtype=self._lanes.dtype, device=self._launch.device)

    def _upload_lanes(self, values: Tensor) -> wp.array:
        """Upload ``values`` [..., samples] as lane values, with the last sample repeated as padding."""
        missing = self.sample_stride - values.shape[-1]
        padded = torch.cat([values, values[..., -1:].expand(*values.shape[:-1], missing)], -1)
        rows = padded.reshape(-1) if self._lanes.width == 1 else padded.reshape(-1, self._lanes.width)
        return wp.array(rows.numpy(), dtype=self._lanes.vector, device=self._launch.device)


def lane_view(values: wp.array, lanes: Lanes) -> wp.array:
    """Return a flat array of numbers viewed as lane values; the array must outlive the view."""
    return wp.array(
        ptr=values.ptr, dtype=lanes.vector, shape=(values.size // lanes.width,), device=values.device, copy=False
    )


@cache
def row_weights(lines: int) -> Tensor:
    """Return w_r [lines + 2], float64: 0 for side A, Phi of equal steps for the lines between, 1 for side B."""
    steps = (
        torch.linspace(-LINE_REACH, LINE_REACH, lines, dtype=torch.float64) if lines > 1 else torch.zeros(1).double()
    )
    between = 0.5 * (1.0 + torch.erf(steps / (LINE_SPREAD * math.sqrt(2.0))))
    return torch.cat([between.new_zeros(1), between, between.new_ones(1)])


def row_steps(weight: Tensor) -> Tensor:
    """Return the difference of w [rows] from each row to the next; side B takes that of side A."""
    steps = weight.diff()
    return torch.cat([steps, steps[:1]])


def spacing_factors(samples: int) -> Tensor:
    """Return sx divided by the distance to the next sample [samples], float64."""
    factors = torch.full((samples,), SIGMA_PER_SPACING, dtype=torch.float64)
    for index, factor in reversed(list(enumerate(END_FACTORS))):
        for sample in (index, samples - 1 - index):
            if 0 <= sample < samples:
                factors[sample] = SIGMA_PER_SPACING * factor
    return factors


def side_basis(point_count: int, degree: int, samples: int) -> Tensor:
    """Return the weights [KINDS, 2, P, samples], float64, of the control points in each kind of basis of both sides."""
    parameter = torch.linspace(SPLAT_END, 1.0 - SPLAT_END, samples, dtype=torch.float64)
    piece_count = point_count // degree
    first = piece_count // 2
    forward = _outline_basis(parameter * first, point_count, degree)
    backward = _outline_basis(piece_count - parameter * (piece_count - first), point_count, degree)
    position = torch.stack([forward, backward])
    step = torch.cat([position.diff(dim=-1), position[..., -1:] - position[..., -2:-1]], -1)
    inner = position[..., 2:] - position[..., :-2] if samples > 2 else step[..., :1]
    ends = 0 if samples == 2 else 1
    tangent = torch.cat([inner[..., :1].expand(-1, -1, 1), inner, inner[..., -1:].expand(-1, -1, ends)], -1)
    return torch.stack([position, step, tangent])


def _outline_basis(parameter: Tensor, point_count: int, degree: int) -> Tensor:
    """Return the Bernstein weights [P, samples] of the control points at outline parameters (integers at anchors)."""
    piece = parameter.floor().clamp(0, point_count // degree - 1)
    t = parameter - piece
    basis = torch.zeros(point_count, len(parameter), dtype=torch.float64)
    sample = torch.arange(len(parameter))
    for k, weight in enumerate(bernstein(degree, t).unbind(-1)):
        basis.index_put_(((piece.long() * degree + k) % point_count, sample), weight, accumulate=True)
    return basis

"""The adjoint of the flattened outlines, before it is summed into the control points."""

from __future__ import annotations

from dataclasses import dataclass, replace

from torch import Tensor


@dataclass(frozen=True)
class OutlineAdjoint:
    """The vertices of a scene, and dL/d(start) and dL/d(end) of the edge that begins at each of them.

    All are in host memory, in float64 and int64.

    Attributes:
        segment_first_vertex: first vertex of each segment [R + 1]; the last entry is V.
        vertices: px [V, 2].
        adj_edges: dL/d(start) and dL/d(end) of each edge [V, 4].
    """

    segment_first_vertex: Tensor
    vertices: Tensor
    adj_edges: Tensor

    def averaged(self, other: OutlineAdjoint) -> OutlineAdjoint:
        """Return the mean of two adjoints of the same outlines."""
        return replace(self, adj_edges=(self.adj_edges + other.adj_edges) / 2.0)

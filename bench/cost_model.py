"""Ideal times of the stages of a step, if they only did their arithmetic and touched their memory once.

Each ideal is a time on one thread, from the amount of work in a scene; the table of ``bench_step`` divides by it. The
rates are those of loops that do a single thing. They were measured with NVIDIA Warp's CPU kernels on an AMD EPYC with
AVX-512, unless another source is given. They show how far a stage is from its limit, not how fast another machine is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import warp as wp
from harness import Statistics, markdown_table
from numpy.typing import NDArray

from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.kernels.constants import COLUMNS, EMPTY, TILE
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.stages.binning import Binning
from warpvec.rendering.stages.flattening import Flattening

FORWARD_NS, ADJOINT_NS = 0.14, 0.4
"""Per pixel and path, in 16 lanes: coverage from two half planes and compositing (21 flops); its adjoint (56 flops)."""

EDGE_PIXEL_NS = 0.7
"""Per pixel that an edge crosses, forward or adjoint, 16 edges at a time: a step is 35 vector operations and 16 to 32
scattered loads and stores, 40 cycles at 4 GHz. (Counted, not measured.)"""

BYTE_NS = 0.1
"""Per byte that is read or written once: 10 GB/s, the rate at which one thread streams from memory beyond the cache."""

VERTEX_NS = 5.0
"""Per vertex, forward or adjoint: four weights, a point of two coordinates, and a store."""

EDGE_NS = 2.0
"""Per edge that binning examines, 16 at a time: 60 vector operations and 32 scattered stores, 120 cycles at 4 GHz.
(Counted, not measured.)"""

PAIR_NS = 5.0
"""Per (path, tile) pair that is numbered, classified and sorted: eight integers read and written."""

PARAMETER_NS = 2.0
"""Per number that Adan updates: a root, a division and five state values."""


class Work(NamedTuple):
    """Amount of work in one step of the exact renderer."""

    paths: int
    points: int
    vertices: int
    edge_pixels: int
    pairs: int
    partial_pairs: int
    visible_pairs: int


def work_of(flattening: Flattening, binning: Binning, first_visible: NDArray[np.int32], scene: Scene) -> Work:
    """Return the work of a rendered ``scene``; ``first_visible`` [tiles] is the lowest visible hit of each tile."""
    hits = binning.tile_first_hit.numpy()[: len(first_visible) + 1]
    return Work(
        paths=len(scene),
        points=scene.segments.shape[0] * scene.degree,
        vertices=flattening.vertex_count,
        edge_pixels=edge_pixels(flattening, scene.structure),
        pairs=int((binning.pair_class.numpy()[: binning.pair_count] != EMPTY).sum()),
        partial_pairs=binning.slot_count,
        visible_pairs=int((hits[1:] - first_visible).sum()),
    )


def edge_pixels(flattening: Flattening, structure: Structure) -> int:
    """Count the pixels that the edges of all loops cross: one for each new column or row, and the one they start in."""
    vertices = flattening.vertices.numpy()[: flattening.vertex_count]
    first = flattening.segment_first_vertex.numpy()[structure.loop_first_segment.cpu().numpy()]
    ahead = np.roll(vertices, -1, axis=0)
    ahead[first[1:] - 1] = vertices[first[:-1]]
    return int(np.abs(np.floor(ahead) - np.floor(vertices)).sum() + len(vertices))


def ideal_seconds(work: Work) -> dict[str, float]:
    """Return the ideal seconds of each stage of a step on one thread."""
    pixels = TILE * TILE
    slot_bytes = work.partial_pairs * COLUMNS * TILE * 4
    nanoseconds = {
        "flattening": VERTEX_NS * work.vertices,
        "binning": EDGE_NS * work.vertices + PAIR_NS * work.pairs,
        "coverage": EDGE_PIXEL_NS * work.edge_pixels + BYTE_NS * slot_bytes,
        "compositing": FORWARD_NS * pixels * work.visible_pairs,
        "compositing_adjoint": (FORWARD_NS + ADJOINT_NS) * pixels * work.visible_pairs,
        "coverage_adjoint": EDGE_PIXEL_NS * work.edge_pixels + BYTE_NS * slot_bytes,
        "flattening, adjoint": VERTEX_NS * work.vertices,
        "regularization": 10 * VERTEX_NS * work.points / 3,
        "population": PARAMETER_NS * (2 * work.points + 4 * work.paths),
    }
    return {name: 1e-9 * value for name, value in nanoseconds.items()}


def work_of_step(renderer: ExactRenderer, scene: Scene) -> Work:
    """Return the work of the step that ``renderer`` has just taken with ``scene``."""
    first_visible = renderer._compositing._buffers.get("tile_first_visible", renderer.grid.count, wp.int32).numpy()
    return work_of(renderer._flattening, renderer._binning, first_visible, scene)


def report_ideal(work: Work, rows: dict[str, Statistics]) -> str:
    """Return a table of the stages of a step: ideal time, min of the measured times, and their ratio."""
    found = {name: (seconds, rows[name].minimum) for name, seconds in ideal_seconds(work).items() if name in rows}
    found["sum of these"] = tuple(map(sum, zip(*found.values(), strict=True)))
    body = [[name, f"{1e3 * a:.2f}", f"{1e3 * b:.2f}", f"{b / a:.1f}"] for name, (a, b) in found.items()]
    return markdown_table(["one thread, ms", "ideal", "measured min", "ratio"], body)

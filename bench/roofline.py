"""Compare each stage of a step with the machine's roof: its peak memory bandwidth and its peak arithmetic.

The roof is measured in the same run: bytes a second of c = a + b on arrays beyond the cache (two reads and a write
for each entry, as STREAM counts), and operations a second of a matrix product, which is fused multiply-adds from
registers. The counts of a stage are what it must do, not what it does: every array is read or written once, and an
operation is an addition, multiplication, comparison or root of float32. A stage far below both roofs waits for
something else: latency, branches, the sorting of integers, launches. A stage whose arrays stay in the cache can
exceed the roof of memory.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import torch
from cost_model import Work
from harness import Statistics, markdown_table

from warpvec.kernels.constants import COLUMNS, TILE

# Floats of each of the three arrays: 64 MB, more than the cache of most machines.
_STREAM_FLOATS = 2**24
_MATRIX_SIDE = 768
# Many short runs: even on a busy machine, the best of them was undisturbed.
_ROOF_REPEAT = 30

_PIXELS = TILE * TILE
# Two coordinates of a vertex or a control point, or two int32.
_PAIR_BYTES = 8
_FLOAT_BYTES = 4

# Operations: Bernstein weights and two coordinates of a vertex; clip, area and two sums of an edge in a pixel.
_VERTEX_FLOPS, _EDGE_PIXEL_FLOPS = 26, 25
# |winding|, minimum, opacity, and three channels of c a + (1 - a) b; then the same with its adjoint.
_PIXEL_FLOPS, _PIXEL_ADJOINT_FLOPS = 13, 13 + 43
# Three regularization terms of a cubic, each with a root or a division, and its adjoint; Adan's averages and root.
_CUBIC_FLOPS, _PARAMETER_FLOPS = 250, 22
# For each parameter, its gradient, itself and four averages are read; all but the gradient are also written.
_PARAMETER_FLOATS = 11
# For each (path, tile) pair, path, class, winding and slot are written and read once, sort key and value twice.
_PAIR_INTEGERS = 16


class Roof(NamedTuple):
    """Rates that the machine reaches in loops that do a single thing."""

    bytes_per_second: float
    flops_per_second: float


class Load(NamedTuple):
    """Bytes that a stage must move, and operations that it must compute."""

    bytes: float
    flops: float

    def seconds(self, roof: Roof) -> float:
        """Return the min time under ``roof``, with memory and arithmetic overlapping."""
        return max(self.bytes / roof.bytes_per_second, self.flops / roof.flops_per_second)


def measure_roof(device: str = "cpu", threads: int = 1) -> Roof:
    """Measure the best rates on one CPU thread and on ``threads``, as more threads can be slower on a busy machine."""
    roofs = [_measure_roof(device, count) for count in {1, threads}]
    return Roof(*map(max, zip(*roofs, strict=True)))


def _measure_roof(device: str, threads: int) -> Roof:
    before = torch.get_num_threads()
    torch.set_num_threads(threads)
    try:
        a, b, c = (torch.rand(_STREAM_FLOATS, device=device) for _ in range(3))
        stream = _best_seconds(lambda: torch.add(a, b, out=c), device)
        x, y = (torch.rand(_MATRIX_SIDE, _MATRIX_SIDE, device=device) for _ in range(2))
        z = torch.empty_like(x)
        product = _best_seconds(lambda: torch.mm(x, y, out=z), device)
    finally:
        torch.set_num_threads(before)
    return Roof(3 * _FLOAT_BYTES * _STREAM_FLOATS / stream, 2 * _MATRIX_SIDE**3 / product)


def _best_seconds(action: Callable[[], object], device: str) -> float:
    wait = torch.cuda.synchronize if device.startswith("cuda") else lambda: None
    seconds = []
    for _ in range(_ROOF_REPEAT):
        wait()
        start = time.perf_counter()
        action()
        wait()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def stage_loads(work: Work, pixel_count: int) -> dict[str, Load]:
    """Return the load of each stage of a step of the exact renderer, by the name of its row."""
    points, vertices = _PAIR_BYTES * work.points, _PAIR_BYTES * work.vertices
    slots = _FLOAT_BYTES * COLUMNS * TILE * work.partial_pairs
    pairs = _FLOAT_BYTES * _PAIR_INTEGERS * work.pairs
    image = 3 * _FLOAT_BYTES * pixel_count
    edges = _EDGE_PIXEL_FLOPS * work.edge_pixels
    visible = _PIXELS * work.visible_pairs
    parameters = 2 * work.points + 4 * work.paths
    return {
        "flattening": Load(points + vertices, _VERTEX_FLOPS * work.vertices),
        "binning": Load(vertices + pairs, 4 * work.vertices),
        "coverage": Load(vertices + slots, edges + COLUMNS * TILE * work.partial_pairs),
        "compositing": Load(slots + image, _PIXEL_FLOPS * visible),
        "compositing_adjoint": Load(2 * slots + image, _PIXEL_ADJOINT_FLOPS * visible),
        "coverage_adjoint": Load(3 * vertices + slots, edges),
        "flattening, adjoint": Load(2 * vertices + points, _VERTEX_FLOPS * work.vertices),
        "regularization": Load(3 * points, _CUBIC_FLOPS * work.points / 3),
        "population": Load(_FLOAT_BYTES * _PARAMETER_FLOATS * parameters, _PARAMETER_FLOPS * parameters),
    }


def report_roofline(work: Work, pixel_count: int, rows: dict[str, Statistics], roof: Roof, label: str) -> str:
    """Return a table of the stages: their load, the rates they reach, and the roof's time beside the measured min."""
    loads = {name: load for name, load in stage_loads(work, pixel_count).items() if name in rows}
    took = {name: rows[name].minimum for name in loads}
    body = [_row(name, load, took[name], roof) for name, load in loads.items()]
    whole = Load(*map(sum, zip(*loads.values(), strict=True)))
    limit = sum(load.seconds(roof) for load in loads.values())
    body.append(_row("sum of these", whole, sum(took.values()), roof, limit))
    rates = f"{roof.bytes_per_second / 1e9:.1f}", f"{roof.flops_per_second / 1e9:.0f}"
    body.append(["roof: stream, multiply-add", "", "", *rates, "", "", "", ""])
    header = ["MB", "Mflop", "GB/s", "Gflop/s", "bound by", "roof, ms", "min, ms", "roof / min"]
    return markdown_table([label, *header], body)


def _row(name: str, load: Load, seconds: float, roof: Roof, limit: float | None = None) -> list[str]:
    ideal = load.seconds(roof) if limit is None else limit
    bound = "memory" if load.bytes / roof.bytes_per_second > load.flops / roof.flops_per_second else "arithmetic"
    moved = [f"{load.bytes / 1e6:.2f}", f"{load.flops / 1e6:.1f}"]
    rates = [f"{load.bytes / seconds / 1e9:.1f}", f"{load.flops / seconds / 1e9:.1f}"]
    return [name, *moved, *rates, bound, f"{1e3 * ideal:.3f}", f"{1e3 * seconds:.3f}", f"{ideal / seconds:.0%}"]

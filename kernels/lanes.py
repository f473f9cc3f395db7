"""Lane arithmetic: one kernel body serves CPU and CUDA. A CPU thread owns 16 pixels at a time, a CUDA thread one pixel.

On the CPU a lane value is a ``vector(16)`` with native 16-wide vector instructions. (Warp's own vector operators are
unrolled to scalars and 3 to 15 times slower.) On CUDA a lane value is a scalar. A factory builds the kernels
once per :class:`Lanes`. The gradient checks use float64 lanes.

``functions`` is the table of all functions of lanes. A factory of kernels begins with ``v = lanes.functions``, and its
kernels call ``v.mul(a, b)``: Warp looks the names up while it compiles.
"""

import platform
from types import SimpleNamespace
from typing import Any

import warp as wp

from warpvec.kernels import index_lanes, real_lanes
from warpvec.kernels.constants import CANVAS_THREADS, CPU_FLAGS, CPU_FLAGS_X86, REDUCED_LANES, TILE
from warpvec.kernels.making import made_once


class Lanes(SimpleNamespace):
    """A lane type and its operations, hashed by identity: there is one object per width and precision."""

    __hash__ = object.__hash__

    def __eq__(self, other: object) -> bool:
        return self is other


@made_once
def make_lanes(width: int, dtype: Any) -> Lanes:
    """Return lanes of ``width`` 16 (CPU) or 1 (CUDA, and the CPU to check it), ``dtype`` wp.float32 or wp.float64.

    Fields:
        functions: the functions of `real_lanes` and `index_lanes`, by name.
        vector, whole: types of a lane value and of a value of integer lanes.
        blocks: lane values per pixel column of a tile.
        tile_threads, tile_vectors: threads per tile, and lane values per thread.
        reducers: slots of a sum over a tile.
        canvas_threads, canvas_reducers: threads and slots of a sum over all tiles.
    """
    lanes = Lanes(
        width=width,
        dtype=dtype,
        vector=dtype if width == 1 else wp.types.vector(width, dtype=dtype),
        whole=wp.int32 if width == 1 else wp.types.vector(width, dtype=wp.int32),
        vec2=wp.types.vector(2, dtype=dtype),
        vec3=wp.types.vector(3, dtype=dtype),
        vec4=wp.types.vector(4, dtype=dtype),
        name=f"{width}x{real_lanes.C_NAME[dtype]}",
        blocks=TILE // width,
        tile_vectors=TILE if width > 1 else 1,
        tile_threads=1 if width > 1 else TILE * TILE,
        reducers=1 if width > 1 else TILE * TILE // REDUCED_LANES,
        canvas_threads=1 if width > 1 else CANVAS_THREADS,
        canvas_reducers=1 if width > 1 else CANVAS_THREADS // REDUCED_LANES,
    )
    lanes.functions = SimpleNamespace(**real_lanes.functions(lanes), **index_lanes.functions(lanes))
    return lanes


def bundle(*functions: Any) -> SimpleNamespace:
    """Return Warp functions or kernels by name."""
    return SimpleNamespace(**real_lanes.named(*functions))


def stage_module(stage: str, lanes: Lanes) -> wp.Module:
    """Return the Warp module (one compile unit) of a stage's kernels for these lanes."""
    return unit(f"{stage}.{lanes.name}")


def unit(name: str) -> wp.Module:
    """Return the Warp module of a name. All are compiled alike: Warp reads its headers once for each set of flags."""
    module = wp.get_module(f"warpvec.kernels.{name}")
    # max_unroll=1 keeps the 16 columns of a tile in one small loop. The adjoints are written by hand.
    flags = CPU_FLAGS + CPU_FLAGS_X86 * (platform.machine() in ("x86_64", "AMD64"))
    module.options.update(enable_backward=False, max_unroll=1, cpu_compiler_flags=flags, optimization_level=3)
    return module

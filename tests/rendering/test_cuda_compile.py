"""Every kernel compiles for sm_90 without a GPU, does not spill, and lets enough blocks run at a time."""

from __future__ import annotations

import cubins
import pytest
import warp as wp

from warpvec.kernels.constants import TILE
from warpvec.rendering.launch import start_warp

REGISTERS_MAX = 64
"""64 registers let four blocks of 256 threads share a multiprocessor's 65,536."""

REGISTERS_ALLOWED = {"covariance_adjoint": 80, "gather_rows_adjoint": 80}
"""Kernels that may take more registers. With 80, three blocks of 256 threads share a multiprocessor. That is enough for
a kernel that only an ablation runs, once per step, with one thread per sample, and for one with a thread per row of a
stroke."""

TRIGONOMETRY_FRAME = 32
"""Bytes of local memory that a sine or cosine takes to reduce huge angles. Strokes turn normals by angles."""

GRADIENT_REGISTERS = 80
"""Registers that the compositing adjoint may take in scenes with gradients, whose terms it keeps too (72 are taken)."""

STOP_REGISTERS = 128
"""The same with gradients of several stops: two blocks share a multiprocessor."""

BY_AXIS_REGISTERS = 80
"""The same for the step of a population whose units differ by axis (71 are taken): the presets of the papers."""

SHARED_MAX = 2048
"""Bytes of shared memory per block that Warp and the driver reserve; kernels use none."""


def test_the_stages_are_found() -> None:
    known = {"flattening", "binning", "capacity", "coverage", "coverage_adjoint", "compositing", "compositing_adjoint"}
    assert known <= set(cubins.STAGES)


@pytest.mark.slow
@pytest.mark.parametrize(("stage", "variant"), cubins.VARIANTS)
def test_kernels_compile_ahead_of_time(stage: str, variant: tuple[bool, ...]) -> None:
    is_adjoint = stage == "compositing_adjoint"
    most = (
        STOP_REGISTERS
        if is_adjoint and variant[3]
        else GRADIENT_REGISTERS
        if is_adjoint and variant[2]
        else BY_AXIS_REGISTERS
        if stage == "population" and variant[-1]
        else REGISTERS_MAX
    )
    for name, resources in cubins.stage_resources(stage, variant).items():
        print(f"{name}: {resources}, {resources.blocks} blocks")
        assert 0 < resources.registers <= REGISTERS_ALLOWED.get(name, most), name
        frame = TRIGONOMETRY_FRAME if stage.startswith("stroking") else 0
        assert max(resources.local, resources.stack) <= frame, f"{name} spills, or has local arrays"
        assert resources.shared <= SHARED_MAX, name


@pytest.mark.slow
def test_kernels_of_exact_fits_compile_for_a_gpu() -> None:
    modules = cubins.fit_modules()
    assert {"near_errors", "folds", "normal_matrix"} <= {module.name.split(".")[2] for module in modules}
    for module in modules:
        assert cubins.module_resources(module), module.name


def test_a_kernel_with_local_and_shared_memory_is_seen() -> None:
    # Local arrays need a stack frame on CUDA. Only vector lanes use them, in the compositing adjoint.
    module = wp.get_module("test_cuda_compile")
    module.options.update(enable_backward=False)

    @wp.func_native("__shared__ float staged[4096]; staged[i] = value; __syncthreads(); return staged[i ^ 1];")
    def stage(i: int, value: float) -> float: ...

    @wp.kernel(module=module)
    def with_frame(count: int, out: wp.array(dtype=float)):
        values = wp.zeros(shape=(TILE,), dtype=float)
        for i in range(count):
            values[i % TILE] = values[(i * i) % TILE] + out[i]
        out[0] = values[count % TILE]

    @wp.kernel(module=module)
    def with_shared(out: wp.array(dtype=float)):
        out[wp.tid()] = stage(wp.tid(), out[wp.tid()])

    start_warp()
    found = {
        symbol.split("__")[-1].rsplit("_", 4)[0]: value for symbol, value in cubins.module_resources(module).items()
    }
    assert found["with_frame"].local >= 4 * TILE and found["with_frame"].stack >= found["with_frame"].local
    assert found["with_shared"].shared >= 4 * 4096 > SHARED_MAX and found["with_shared"].local == 0


@pytest.mark.parametrize(
    ("registers", "shared", "blocks"), [(32, 0, 8), (33, 0, 6), (64, 2048, 4), (76, 0, 3), (32, 100 * 1024, 2)]
)
def test_blocks_at_a_time(registers: int, shared: int, blocks: int) -> None:
    assert cubins.Resources(registers, 0, 0, shared).blocks == blocks

"""Every kernel compiles for sm_90 without a GPU, and the ones with a thread per pixel need no local memory."""

import re
import struct
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest
import warp as wp

import warpvec.kernels
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.launch import start_warp

ARCHITECTURE = 90

REGISTERS_MAX = 64
"""64 registers let four blocks of 256 threads share a multiprocessor's 65,536; the most in use is 52."""

REGISTERS_ALLOWED = {"covariance_adjoint": 80}
"""Kernels that may take more, and why: with 76 three blocks of 256 threads share a multiprocessor, enough for a kernel
that an ablation alone runs, once a step, with a thread a sample."""

_BOTH = (False, True)
_FOLDER = Path(warpvec.kernels.__file__).parent

STAGES = sorted(path.stem for path in _FOLDER.glob("*.py") if "\ndef make_kernels(" in path.read_text())

FACTORY_ARGUMENTS = {
    "compositing_adjoint": [(fused, importance) for fused in _BOTH for importance in _BOTH],
    "splat_coverage_adjoint": [(covariance,) for covariance in _BOTH],
    "splatting_adjoint": [(covariance,) for covariance in _BOTH],
}
"""The variants of a stage, as what its factory takes beside the lanes; a stage that is not named has one."""

VARIANTS = [(stage, variant) for stage in STAGES for variant in FACTORY_ARGUMENTS.get(stage, [()])]

# Attributes of a kernel in a cubin's .nv.info section, and the format of those that hold a value.
_REGISTER_COUNT, _FRAME_SIZE, _SIZED = 0x2F, 0x11, 4


def make_stage(stage: str, variant: tuple[bool, ...]) -> SimpleNamespace:
    start_warp()
    return import_module(f"warpvec.kernels.{stage}").make_kernels(make_lanes(1, wp.float32), *variant)


def test_the_stages_are_found() -> None:
    assert {"flattening", "binning", "coverage", "coverage_adjoint", "compositing", "compositing_adjoint"} <= set(
        STAGES
    )


@pytest.mark.parametrize(("stage", "variant"), VARIANTS)
def test_kernels_compile_ahead_of_time(stage: str, variant: tuple[bool, ...], tmp_path: Path) -> None:
    kernels = vars(make_stage(stage, variant))
    (module,) = {kernel.module for kernel in kernels.values()}
    wp.compile_aot_module(module, arch=ARCHITECTURE, module_dir=tmp_path, use_ptx=False)
    (cubin,) = tmp_path.rglob("*.cubin")
    resources = read_cubin(cubin.read_bytes())
    for name in kernels:
        (entry,) = [entry for symbol, entry in resources.items() if re.search(rf"__{name}_[0-9a-f]+_cuda", symbol)]
        limit = REGISTERS_ALLOWED.get(name, REGISTERS_MAX)
        assert entry[_REGISTER_COUNT] <= limit, f"{name} takes {entry[_REGISTER_COUNT]} registers"
        assert entry[_FRAME_SIZE] == 0, f"{name} keeps {entry[_FRAME_SIZE]} bytes a thread in local memory"


def test_a_kernel_with_local_memory_is_seen(tmp_path: Path) -> None:
    # Local arrays cost a frame on CUDA: the compositing adjoint of the vector form has four.
    module = wp.get_module("test_cuda_compile")
    module.options.update(enable_backward=False)

    @wp.kernel(module=module)
    def with_frame(count: int, out: wp.array(dtype=float)):
        values = wp.zeros(shape=(TILE,), dtype=float)
        for i in range(count):
            values[i % TILE] = values[(i * i) % TILE] + out[i]
        out[0] = values[count % TILE]

    start_warp()
    wp.compile_aot_module(module, arch=ARCHITECTURE, module_dir=tmp_path, use_ptx=False)
    (cubin,) = tmp_path.rglob("*.cubin")
    (entry,) = [entry for symbol, entry in read_cubin(cubin.read_bytes()).items() if "with_frame" in symbol]
    assert entry[_FRAME_SIZE] >= 4 * TILE


def read_cubin(data: bytes) -> dict[str, dict[int, int]]:
    """Attributes of each function of a cubin, an ELF file with NVIDIA's section .nv.info: a list of tagged values."""
    (table,) = struct.unpack_from("<Q", data, 0x28)
    size, count, name_index = struct.unpack_from("<HHH", data, 0x3A)
    headers = [struct.unpack_from("<IIQQQQIIQQ", data, table + i * size) for i in range(count)]
    sections = {text(data, headers[name_index][4] + header[0]): header for header in headers}
    symbols = sections[".symtab"]
    found: dict[str, dict[int, int]] = {}
    for attribute, symbol, value in function_attributes(data, *sections[".nv.info"][4:6]):
        (name,) = struct.unpack_from("<I", data, symbols[4] + 24 * symbol)
        found.setdefault(text(data, headers[symbols[6]][4] + name), {})[attribute] = value
    return found


def function_attributes(data: bytes, start: int, size: int) -> list[tuple[int, int, int]]:
    """Attribute, symbol and value of the entries that have these."""
    entries, position = [], start
    while position < start + size:
        form, attribute, length = struct.unpack_from("<BBH", data, position)
        position += 4
        if form == _SIZED:
            if attribute in (_REGISTER_COUNT, _FRAME_SIZE):
                entries.append((attribute, *struct.unpack_from("<II", data, position)))
            position += length
    return entries


def text(data: bytes, start: int) -> str:
    return data[start : data.index(b"\0", start)].decode()

"""List the registers, local memory and shared memory of every kernel on a GPU.

The numbers are read from compiled kernels (cubins), which can be made without a GPU.
"""

from __future__ import annotations

import re
import struct
import tempfile
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import click
import warp as wp
from harness import markdown_table

import warpvec.kernels
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.polish.fold_look import fold_numbers
from warpvec.rendering.launch import start_warp

ARCHITECTURE = 90
"""Compute capability 9.0, that of H100 and H200."""

_BOTH = (False, True)
_PAINTS = ((False, False), (True, False), (False, True))  # flat, gradients of two stops, gradients of several
_SHARES = (False, False, True)  # flat, with shares of colours
_FOLDER = Path(warpvec.kernels.__file__).parent

_FACTORIES = {path.stem: path.read_text() for path in sorted(_FOLDER.glob("*.py"))}

STAGES = [
    stem for stem, text in _FACTORIES.items() if "\ndef make_kernels(lanes: Lanes" in text.replace("(\n    ", "(")
]

FIT_STEPS = [stem for stem, text in _FACTORIES.items() if "\ndef make_kernels(" in text and stem not in STAGES]
"""Files of the kernels of exact fits (``warpvec/polish``), which run as few work items, most of them on the CPU."""

FACTORY_ARGUMENTS = {
    "compositing": list(_PAINTS),
    "compositing_adjoint": [
        (fused, curvature, *paints) for fused in _BOTH for curvature in _BOTH for paints in (*_PAINTS, _SHARES)
    ],
    "coverage": [(linked,) for linked in _BOTH],
    "pixel_slopes": list(_PAINTS),
    "population": [(by_axis,) for by_axis in _BOTH],
    "row_opacity": [(sides,) for sides in _BOTH],
    "splat_coverage": [(shares,) for shares in _BOTH],
    "splat_coverage_adjoint": [(covariance,) for covariance in _BOTH],
    "splatting_adjoint": [(covariance,) for covariance in _BOTH],
}
"""Stage -> its variants, each the arguments of its factory after the lanes; a stage not listed has one variant."""

VARIANTS = [(stage, variant) for stage in STAGES for variant in FACTORY_ARGUMENTS.get(stage, [()])]

# Limits of a multiprocessor: registers, the unit in which a thread gets them, threads, and bytes of shared memory.
_REGISTERS, _REGISTER_UNIT, _THREADS, _SHARED = 65_536, 8, 2_048, 228 * 1024
# Threads of a block: one for each pixel of a tile.
_BLOCK = TILE * TILE

# Attributes of a function in the section .nv.info of a cubin, and the format of entries that hold a value.
_REGISTER_COUNT, _FRAME_SIZE, _STACK_SIZE, _SIZED = 0x2F, 0x11, 0x12, 4


class Resources(NamedTuple):
    """Resources of a kernel.

    Attributes:
        registers: registers of a thread.
        local: bytes of a thread's local memory, for local arrays and spilled registers.
        stack: the same, including all functions that the kernel calls.
        shared: bytes of shared memory of a block.
    """

    registers: int
    local: int
    stack: int
    shared: int

    @property
    def blocks(self) -> int:
        """Number of blocks of 256 threads that a multiprocessor holds at a time."""
        rounded = -(-self.registers // _REGISTER_UNIT) * _REGISTER_UNIT
        return min(_THREADS // _BLOCK, _REGISTERS // (rounded * _BLOCK), _SHARED // max(self.shared, 1))


def make_stage(stage: str, variant: tuple[bool, ...]) -> SimpleNamespace:
    """Return the kernels of a stage in the form that a GPU runs."""
    start_warp()
    return import_module(f"warpvec.kernels.{stage}").make_kernels(make_lanes(1, wp.float32), *variant)


def fit_modules() -> list[wp.Module]:
    """Return the modules of the kernels of `FIT_STEPS`."""
    start_warp()
    arguments = {"aligned_nodes": [wp.float32], "folds": [fold_numbers()]}
    modules = []
    for stem in FIT_STEPS:
        made = import_module(f"warpvec.kernels.{stem}").make_kernels(*arguments.get(stem, []))
        modules += [kernel.module for kernel in vars(made).values()]
    return list(dict.fromkeys(modules))


def stage_resources(stage: str, variant: tuple[bool, ...]) -> dict[str, Resources]:
    """Return the resources of each kernel of a stage by its name."""
    kernels = vars(make_stage(stage, variant))
    (module,) = {kernel.module for kernel in kernels.values()}
    found = module_resources(module)
    return {name: _only(found, rf"__{name}_[0-9a-f]+_cuda") for name in kernels}


def module_resources(module: wp.Module) -> dict[str, Resources]:
    """Return the resources of each kernel of a Warp module by its symbol."""
    with tempfile.TemporaryDirectory() as folder:
        wp.compile_aot_module(module, arch=ARCHITECTURE, module_dir=folder, use_ptx=False)
        (cubin,) = Path(folder).rglob("*.cubin")
        return read_cubin(cubin.read_bytes())


def _only(found: dict[str, Resources], pattern: str) -> Resources:
    (resources,) = [resources for symbol, resources in found.items() if re.search(pattern, symbol)]
    return resources


# Cubins


def read_cubin(data: bytes) -> dict[str, Resources]:
    """Read the resources of each kernel from a cubin: an ELF file whose section .nv.info is a list of tagged values."""
    (table,) = struct.unpack_from("<Q", data, 0x28)
    size, count, name_index = struct.unpack_from("<HHH", data, 0x3A)
    headers = [struct.unpack_from("<IIQQQQIIQQ", data, table + i * size) for i in range(count)]
    sections = {_text(data, headers[name_index][4] + header[0]): header for header in headers}
    symbols = sections[".symtab"]
    found: dict[str, dict[int, int]] = {}
    for attribute, symbol, value in _attributes(data, *sections[".nv.info"][4:6]):
        (name,) = struct.unpack_from("<I", data, symbols[4] + 24 * symbol)
        found.setdefault(_text(data, headers[symbols[6]][4] + name), {})[attribute] = value
    return {symbol: _resources(symbol, values, sections) for symbol, values in found.items() if _STACK_SIZE in values}


def _resources(symbol: str, values: dict[int, int], sections: dict[str, tuple[int, ...]]) -> Resources:
    shared = sections.get(f".nv.shared.{symbol}")
    taken = (values[attribute] for attribute in (_REGISTER_COUNT, _FRAME_SIZE, _STACK_SIZE))
    return Resources(*taken, shared=shared[5] if shared else 0)


def _attributes(data: bytes, start: int, size: int) -> Iterator[tuple[int, int, int]]:
    """Yield attribute, symbol and value of the entries that give a resource."""
    position = start
    while position < start + size:
        form, attribute, length = struct.unpack_from("<BBH", data, position)
        position += 4
        if form == _SIZED:
            if attribute in (_REGISTER_COUNT, _FRAME_SIZE, _STACK_SIZE):
                yield (attribute, *struct.unpack_from("<II", data, position))
            position += length


def _text(data: bytes, start: int) -> str:
    return data[start : data.index(b"\0", start)].decode()


# The table


def rows() -> Iterator[list[object]]:
    """Yield a row for each kernel of each variant of each stage."""
    for stage, variant in VARIANTS:
        kind = "".join("+" if flag else "-" for flag in variant)
        for name, resources in stage_resources(stage, variant).items():
            yield [f"{stage} {kind}".strip(), name, *resources, resources.blocks]


@click.command()
def main() -> None:
    """List registers and memory of every kernel, compiled for compute capability 9.0.

    + and - after the name of a stage are the switches of the variant.
    """
    header = ["stage", "kernel", "registers", "local B", "stack B", "shared B", "blocks of 256 at a time"]
    click.echo(markdown_table(header, rows()))


if __name__ == "__main__":
    main()

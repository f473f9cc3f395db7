"""``warpvec info``: show versions, devices and the kernel cache, and compile kernels in advance."""

from __future__ import annotations

import json
import os
import platform
from pathlib import Path
from typing import Any

import click

from warpvec import __version__
from warpvec.cli.arguments import json_option


@click.command()
@click.option("--compile", "compiles", is_flag=True, help="Compile the kernels now; otherwise the first run does.")
@click.option("--device", default="auto", show_default=True, help="Compile for this device, and for the CPU.")
@json_option
def info(compiles: bool, device: str, as_json: bool) -> None:
    """Show versions, devices and the kernel cache."""
    compilation = {"compile_seconds": _compile_kernels(device)} if compiles else {}
    facts = {**_describe_environment(), **compilation}
    lines = (f"{name.replace('_', ' ')}: {value}" for name, value in facts.items())
    click.echo(json.dumps(facts) if as_json else "\n".join(lines))


def _compile_kernels(device: str) -> float:
    from warpvec.modes.precompile import compile_kernels

    return round(compile_kernels(device), 1)


def _describe_environment() -> dict[str, Any]:
    import numpy as np
    import resvg_py
    import torch
    import warp as wp

    from warpvec.rendering.devices import gpu_count, why_no_gpu
    from warpvec.rendering.launch import start_warp

    start_warp()
    reason = why_no_gpu()
    cache = Path(wp.config.kernel_cache_dir or "")
    return {
        "warpvec": __version__,
        "warp": wp.config.version,
        "torch": torch.__version__,
        "numpy": np.__version__,
        "resvg": resvg_py.__resvg_version__,
        "python": platform.python_version(),
        "cpu_count": os.cpu_count(),
        "devices": ["cpu", *(f"cuda:{k} {torch.cuda.get_device_name(k)}" for k in range(gpu_count()))],
        "gpu": "used" if reason is None else f"not used: {reason}",
        "kernel_cache": str(cache),
        "kernel_cache_bytes": sum(file.stat().st_size for file in cache.rglob("*") if file.is_file()),
    }

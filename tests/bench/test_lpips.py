"""Tests of LPIPS as the benchmarks measure it, with random weights: those of the trained networks are a download."""

from __future__ import annotations

import io
import pickle
from typing import Any

import click
import lpips_weights
import numpy as np
import pytest
from lpips_metric import Lpips
from scipy.signal import correlate

# Stride, padding, and the pooling before each convolution, as in the paper's networks; those that end a stage.
ALEX = [(4, 2, None), (1, 2, (3, 2)), (1, 1, (3, 2)), (1, 1, None), (1, 1, None)]
VGG = [(1, 1, (2, 2) if k in (2, 4, 7, 10) else None) for k in range(13)]
SIDES = {"alex": [11, 5, 3, 3, 3], "vgg": [3] * 13}
STAGES = {"alex": [0, 1, 2, 3, 4], "vgg": [1, 3, 6, 9, 12]}
CHANNELS = 2


def _weights(network: str) -> dict[str, np.ndarray]:
    random, found = np.random.default_rng(3), dict[str, np.ndarray]()
    for layer, side in enumerate(SIDES[network]):
        inputs = 3 if layer == 0 else CHANNELS
        found[f"kernel{layer}"] = random.normal(0.0, 0.4, (CHANNELS, inputs, side, side)).astype(np.float32)
        found[f"bias{layer}"] = random.normal(0.3, 0.1, CHANNELS).astype(np.float32)
    return {**found, **{f"channels{stage}": random.random(CHANNELS).astype(np.float32) for stage in range(5)}}


def _pooled(values: np.ndarray, side: int, stride: int) -> np.ndarray:
    windows = np.lib.stride_tricks.sliding_window_view(values, (side, side), (1, 2))
    return windows[:, ::stride, ::stride].max((-1, -2))


def _features(
    image: np.ndarray, network: str, weights: dict[str, np.ndarray], is_centered: bool = True
) -> list[np.ndarray]:
    shift, scale = np.array([-0.030, -0.088, -0.188]), np.array([0.458, 0.448, 0.450])
    values = (((image / 127.5 - 1.0 if is_centered else image / 255.0) - shift) / scale).transpose(2, 0, 1)
    found = []
    for layer, (stride, padding, pooling) in enumerate(ALEX if network == "alex" else VGG):
        values = values if pooling is None else _pooled(values, *pooling)
        padded = np.pad(values, ((0, 0), (padding, padding), (padding, padding)))
        kernels = weights[f"kernel{layer}"].astype(np.float64)
        sums = np.stack([correlate(padded, kernel, "valid")[0] for kernel in kernels])
        values = np.maximum(sums[:, ::stride, ::stride] + weights[f"bias{layer}"][:, None, None], 0.0)
        if layer in STAGES[network]:
            found.append(values / (np.sqrt((values**2).sum(0)) + 1e-10))
    return found


@pytest.mark.parametrize(("network", "is_centered"), [("alex", True), ("vgg", True), ("vgg", False)])
def test_lpips_is_that_of_a_plain_implementation(network: str, is_centered: bool) -> None:
    weights, random = _weights(network), np.random.default_rng(4)
    a, b = random.integers(0, 256, (2, 64, 80, 3), dtype=np.uint8)
    features = (_features(image, network, weights, is_centered) for image in (a, b))
    stages = zip(*features, strict=True)
    expected = sum(
        (weights[f"channels{number}"][:, None, None] * (x - y) ** 2).sum(0).mean()
        for number, (x, y) in enumerate(stages)
    )
    metric = Lpips(network, weights)
    assert metric(a, b, is_centered) == pytest.approx(expected, rel=1e-4)
    assert metric(a, a) == 0.0


class _Command:
    def __reduce__(self) -> tuple[Any, ...]:
        return print, ("run",)


def test_weights_are_arrays_and_nothing_else() -> None:
    array = np.arange(6.0).reshape(2, 3)
    text = pickle.dumps({"a": array}, protocol=3).replace(b"numpy._core.multiarray", b"numpy.core.multiarray")
    np.testing.assert_array_equal(lpips_weights._Unpickler(io.BytesIO(text)).load()["a"], array)
    with pytest.raises(pickle.UnpicklingError, match="no part of an array"):
        lpips_weights._Unpickler(io.BytesIO(pickle.dumps(_Command()))).load()
    with pytest.raises(click.UsageError, match="checksum"):
        lpips_weights.convert(b"another file")

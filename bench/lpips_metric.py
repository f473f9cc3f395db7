"""Measure LPIPS (Zhang et al. 2018, version 0.1) with VGG16 and AlexNet, from the weights of `lpips_weights`.

Features after the five stages of the backbone are divided by their length in each pixel. The squared differences of two
images are summed over the channels with calibrated weights, averaged over the pixels, and summed over the stages.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from lpips_weights import NETWORKS, weights_path
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import conv2d, max_pool2d, relu

_SHIFT, _SCALE = (-0.030, -0.088, -0.188), (0.458, 0.448, 0.450)
"""Mean and deviation of the channels of an image in [-1, 1], as the backbones were trained."""


class _Convolution(NamedTuple):
    """Stride and padding of a convolution, the side and stride of the pooling before it, and whether a stage ends."""

    stride: int = 1
    padding: int = 1
    pooling: tuple[int, int] | None = None
    is_stage: bool = True


_VGG = [_Convolution(pooling=(2, 2) if k == 0 and block else None, is_stage=k == size - 1)
        for block, size in enumerate((2, 2, 3, 3, 3)) for k in range(size)]  # fmt: skip
_ALEX = [_Convolution(4, 2), _Convolution(padding=2, pooling=(3, 2)), _Convolution(pooling=(3, 2)),
         _Convolution(), _Convolution()]  # fmt: skip
_LAYERS = {"vgg": _VGG, "alex": _ALEX}


class Lpips:
    """LPIPS with the backbone ``network``, "vgg" or "alex", and the ``weights`` by name; see `lpips_weights`."""

    def __init__(self, network: str, weights: dict[str, NDArray[np.float32]]) -> None:
        self._layers = _LAYERS[network]
        self._weights = {name: torch.from_numpy(values) for name, values in weights.items()}

    def __call__(self, a: NDArray[np.uint8], b: NDArray[np.uint8], is_centered: bool = True) -> float:
        """Return the LPIPS of two images [h, w, 3], at least 32 pixels high and wide.

        Unless it ``is_centered``, the network gets values in [0, 1] and not, as it was trained, in [-1, 1].
        """
        with torch.no_grad():
            stages = zip(self._features(a, is_centered), self._features(b, is_centered), strict=True)
            return sum(self._distance(number, *pair) for number, pair in enumerate(stages))

    def _distance(self, stage: int, a: Tensor, b: Tensor) -> float:
        channels = self._weights[f"channels{stage}"][:, None, None]
        return float((channels * (a - b).square()).sum(0).double().mean())

    def _features(self, image: NDArray[np.uint8], is_centered: bool) -> list[Tensor]:
        """Return the features of each stage [channels, h, w], of length 1 in each pixel."""
        shown = image / np.float32(127.5) - np.float32(1.0) if is_centered else image / np.float32(255.0)
        values = torch.from_numpy(shown).permute(2, 0, 1)
        values = (values - torch.tensor(_SHIFT)[:, None, None]) / torch.tensor(_SCALE)[:, None, None]
        found = []
        for number, layer in enumerate(self._layers):
            if layer.pooling is not None:
                values = max_pool2d(values[None], *layer.pooling)[0]
            kernel, bias = (self._weights[f"{name}{number}"] for name in ("kernel", "bias"))
            values = relu(conv2d(values[None], kernel, bias, layer.stride, layer.padding))[0]
            if layer.is_stage:
                found.append(values / (values.norm(dim=0) + 1e-10))
        return found


@cache
def _loaded(network: str, path: Path) -> Lpips:
    with np.load(path) as weights:
        return Lpips(network, dict(weights))


def lpips_metrics() -> dict[str, Lpips]:
    """Return LPIPS by network; nothing if their weights are not in the cache."""
    paths = {network: weights_path(network) for network in NETWORKS}
    return {network: _loaded(network, path) for network, path in paths.items() if path.exists()}

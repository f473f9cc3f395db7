"""Measure LPIPS (Zhang et al. 2018) with the package ``lpips`` and backbone weights from a file.

The package contains its own calibrated layers but downloads the backbone. Here the backbone comes from a file that the
user names; without one there is no LPIPS, and no other number takes its place.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

NOT_FOUND = "weights not found: give --lpips-weights PATH"
"""Text of a table cell without a value."""

# The last convolution of torchvision's backbones, which shows the backbone that a file holds.
_LAST_LAYER = {"features.28.weight": "vgg", "features.10.weight": "alex"}


class Lpips:
    """LPIPS with the backbone in the file ``path``: torchvision's state dict of VGG16 or AlexNet.

    Bezier Splatting's evaluation uses VGG16.

    Attributes:
        name: the backbone and a digest of its file.

    Raises:
        click.UsageError: the package is missing, or the file is not such a state dict.
    """

    def __init__(self, path: Path) -> None:
        weights = _read_weights(path)
        net = next((net for layer, net in _LAST_LAYER.items() if layer in weights), None)
        if net is None:
            raise click.UsageError(f"--lpips-weights must be torchvision's VGG16 or AlexNet, but {path} is neither")
        self.name = f"{net} {hashlib.sha256(path.read_bytes()).hexdigest()[:12]}"
        self._model = _make_model(net)
        _load_backbone(self._model.net, weights, path)

    def __call__(self, a: NDArray[np.uint8], b: NDArray[np.uint8]) -> float:
        """Return the LPIPS of two images [h, w, 3]."""
        import torch

        with torch.no_grad():
            return float(self._model(_to_input(a), _to_input(b)))


def _read_weights(path: Path) -> Mapping[str, Any]:
    import torch

    try:
        weights = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises many kinds of errors for a wrong file
        raise click.UsageError(f"--lpips-weights must be a state dict that torch saved, but {path} is not") from error
    if not isinstance(weights, Mapping):
        raise click.UsageError(f"--lpips-weights must be a state dict, but {path} holds a {type(weights).__name__}")
    return weights


def _make_model(net: str) -> Any:
    try:
        import lpips
    except ImportError as error:
        raise click.UsageError(
            f"--lpips-weights needs the package lpips ({error}); pip install lpips and the torchvision of your torch"
        ) from error
    with warnings.catch_warnings():
        # It calls torchvision in a way that torchvision reports as deprecated.
        warnings.simplefilter("ignore")
        return lpips.LPIPS(net=net, pnet_rand=True, verbose=False).eval()


def _load_backbone(backbone: Any, weights: Mapping[str, Any], path: Path) -> None:
    """Fill ``backbone``, whose name for torchvision's layer features.N.x is sliceS.N.x."""
    names = {name: "features." + name.partition(".")[2] for name in backbone.state_dict()}
    try:
        backbone.load_state_dict({name: weights[source] for name, source in names.items()})
    except (KeyError, RuntimeError) as error:
        raise click.UsageError(f"--lpips-weights must hold every layer of its backbone, but {path} does not") from error


def _to_input(image: NDArray[np.uint8]) -> Any:
    """Convert an image to [1, 3, h, w] in [-1, 1], the input of the package."""
    import torch

    return torch.from_numpy(image / np.float32(127.5) - np.float32(1.0)).permute(2, 0, 1)[None]

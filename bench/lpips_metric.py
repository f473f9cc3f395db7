"""LPIPS (Zhang et al. 2018) through the package ``lpips``, with weights of the backbone from a file.

The package carries its own calibrated layers, but downloads the backbone; here that comes from a file that the user
names, and without one there is no LPIPS and no other number in its place.
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
"""What a table says in the place of a value."""

# The last convolution of torchvision's backbones: which of them a file holds.
_LAST_LAYER = {"features.28.weight": "vgg", "features.10.weight": "alex"}


class Lpips:
    """The distance of two images under the backbone in ``path``: torchvision's state dict of VGG16 or AlexNet.

    VGG16 is what Bezier Splatting's evaluation takes.

    Attributes:
        name: the backbone and a digest of its file.

    Raises:
        click.UsageError: the package is missing, or the file is not such a state dict.
    """

    def __init__(self, path: Path) -> None:
        weights = _read_weights(path)
        net = next((net for layer, net in _LAST_LAYER.items() if layer in weights), None)
        if net is None:
            raise click.UsageError(f"--lpips-weights must be torchvision's VGG16 or AlexNet, {path} is neither")
        self.name = f"{net} {hashlib.sha256(path.read_bytes()).hexdigest()[:12]}"
        self._model = _make_model(net)
        _load_backbone(self._model.net, weights, path)

    def __call__(self, a: NDArray[np.uint8], b: NDArray[np.uint8]) -> float:
        """LPIPS of two images [h, w, 3]."""
        import torch

        with torch.no_grad():
            return float(self._model(_to_input(a), _to_input(b)))


def _read_weights(path: Path) -> Mapping[str, Any]:
    import torch

    try:
        weights = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises half a dozen kinds, by what is wrong with the file
        raise click.UsageError(f"--lpips-weights must be a state dict that torch saved, {path} is none") from error
    if not isinstance(weights, Mapping):
        raise click.UsageError(f"--lpips-weights must be a state dict, {path} holds a {type(weights).__name__}")
    return weights


def _make_model(net: str) -> Any:
    try:
        import lpips
    except ImportError as error:
        raise click.UsageError(
            f"--lpips-weights needs the package lpips ({error}); pip install lpips and the torchvision of your torch"
        ) from error
    with warnings.catch_warnings():
        # It asks torchvision for its backbone in a way that torchvision calls deprecated.
        warnings.simplefilter("ignore")
        return lpips.LPIPS(net=net, pnet_rand=True, verbose=False).eval()


def _load_backbone(backbone: Any, weights: Mapping[str, Any], path: Path) -> None:
    """Fill ``backbone``, which names torchvision's layer features.N.x sliceS.N.x."""
    names = {name: "features." + name.partition(".")[2] for name in backbone.state_dict()}
    try:
        backbone.load_state_dict({name: weights[source] for name, source in names.items()})
    except (KeyError, RuntimeError) as error:
        raise click.UsageError(f"--lpips-weights must hold every layer of its backbone, {path} does not") from error


def _to_input(image: NDArray[np.uint8]) -> Any:
    """[1, 3, h, w] in [-1, 1], as the package takes it."""
    import torch

    return torch.from_numpy(image / np.float32(127.5) - np.float32(1.0)).permute(2, 0, 1)[None]

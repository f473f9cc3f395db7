"""warpvec: a photo becomes an editable SVG, measured on the file that is written.

>>> import warpvec
>>> result = warpvec.vectorize("photo.png", curves=512)      # doctest: +SKIP
>>> result.save("photo.svg"); result.metrics["psnr"]         # doctest: +SKIP

Importing this package is quick: torch and warp are loaded at the first use of a name that needs them.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "FitConfig": "config.fit_config",
    "make_config": "config.presets",
    "PRESETS": "config.presets",
    "InputError": "errors",
    "Scene": "geometry.scene",
    "render": "rendering.operator",
    "vectorize": "vectorization.api",
    "Result": "vectorization.result",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'warpvec' has no attribute {name!r}")
    return getattr(import_module(f"warpvec.{_HOMES[name]}"), name)

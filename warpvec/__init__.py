"""warpvec turns images into editable SVGs and measures their quality on the written file.

>>> import warpvec
>>> result = warpvec.vectorize("photo.png", curves=512)      # doctest: +SKIP
>>> result.save("photo.svg"); result.metrics["psnr"]         # doctest: +SKIP

Importing this package is quick. Torch and Warp are loaded when a name that needs them is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_MODULES = {
    "FitConfig": "config.fit_config",
    "make_config": "config.presets",
    "PRESETS": "config.presets",
    "InputError": "errors",
    "Scene": "geometry.scene",
    "render": "rendering.operator",
    "vectorize": "api",
    "refine": "api",
    "placeholder": "placeholders.placeholder",
    "Result": "result",
    "edit": "edit",
}

__all__ = ["__version__", *_MODULES]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'warpvec' has no attribute {name!r}")
    module = import_module(f"warpvec.{_MODULES[name]}")
    return module if name == _MODULES[name] else getattr(module, name)


def __dir__() -> list[str]:
    return sorted(__all__)

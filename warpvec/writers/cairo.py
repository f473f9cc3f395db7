"""Convert an SVG of warpvec by CairoSVG, which keeps paths, gradients and the size in real units.

CairoSVG (LGPL, maintained by CourtBouillon) is the extra "print".
"""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

from warpvec.errors import InputError


def check(path: str, name: str) -> None:
    """Check that the file ``path`` can be made, before work is spent on its contents.

    Raises:
        InputError: CairoSVG or the library cairo is missing; ``name`` is for the message.
    """
    load(path, name)


def load(path: str, name: str) -> ModuleType:
    """Return the module ``cairosvg``.

    Raises:
        InputError: as `check`.
    """
    try:
        import cairosvg  # type: ignore[import-untyped]
    except ImportError:
        rule = f"must end in .svg unless CairoSVG is installed, which writes {Path(path).suffix.lower()}"
        raise InputError(name, rule, repr(path), "pip install 'warpvec[print]'") from None
    except OSError:  # cairocffi finds no library
        rule = "must end in .svg unless the library cairo is installed"
        raise InputError(name, rule, repr(path), "install it, on Debian as libcairo2") from None
    module: ModuleType = cairosvg
    return module

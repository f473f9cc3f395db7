"""Convert an SVG of warpvec by CairoSVG, which keeps paths, gradients and the size in real units.

CairoSVG (LGPL, maintained by CourtBouillon) is the extra "print".
"""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

from warpvec.errors import InputError
from warpvec.writers.writer import Target, Writer


def load(path: str, name: str) -> ModuleType:
    """Return the module ``cairosvg``, which makes the file ``path``.

    Raises:
        InputError: CairoSVG or the library cairo is missing; ``name`` is for the message.
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


def writer(suffix: str, media_type: str, method: str) -> Writer:
    """Return the writer of files with this ``suffix``, which a ``method`` of CairoSVG makes."""

    def encode(svg: str, target: Target) -> bytes:
        from warpvec.writers.round_corners import (
            with_round_paths,
        )  # not above: it takes time that the help does without

        del target
        module = load(f"drawing{suffix}", "path")
        data: bytes = getattr(module, method)(bytestring=with_round_paths(svg).encode())
        return data

    return Writer(suffix, media_type, encode, load)

"""Convert an SVG of warpvec by CairoSVG, which keeps paths, gradients and the size in real units.

CairoSVG (LGPL, maintained by CourtBouillon) is the extra "print". It works in the sandbox: a small SVG can take it
hours, and it raises exceptions of many kinds.
"""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

from warpvec.errors import InputError
from warpvec.purposes.table import PRINT
from warpvec.sandbox.run import SandboxError, run_in_sandbox
from warpvec.writers.writer import Target, Writer

_DECIMALS = 3
"""Decimals of points: cairo's own places are 1/256 of a point apart."""


def load(path: str, name: str) -> ModuleType:
    """Return the module ``cairosvg``, which makes the file ``path``.

    Raises:
        InputError: CairoSVG, the library cairo or a folder for temporary files is missing; ``name`` is for the message.
    """
    try:
        import cairosvg  # type: ignore[import-untyped]
    except ImportError:
        rule = f"must end in .svg unless CairoSVG is installed, which writes {Path(path).suffix.lower()}"
        raise InputError(name, rule, repr(path), "pip install 'warpvec[print]'") from None
    except FileNotFoundError:  # the search for the library writes a temporary file
        rule = "must end in .svg where no folder for temporary files can be written"
        raise InputError(name, rule, repr(path), "set TMPDIR to one that can") from None
    except OSError:  # cairocffi finds no library
        rule = "must end in .svg unless the library cairo is installed"
        raise InputError(name, rule, repr(path), "install it, on Debian as libcairo2") from None
    module: ModuleType = cairosvg
    return module


def _with_rings(svg: str) -> str:
    """Return a drawing of warpvec without blur, which CairoSVG does not know; other texts as they are."""
    if "<feGaussianBlur" not in svg:
        return svg
    from warpvec.purposes.texts import text_for  # not above: they load Torch, which the help does without
    from warpvec.svg.read import read_svg

    return svg if read_svg(svg).precision is None else text_for(svg, PRINT).text


def _in_points(svg: str) -> str:
    """Return a drawing of warpvec with translucent gradients in units of a point; other texts as they are.

    ``pdftocairo -svg`` of poppler 22.12 places such a gradient wrongly if the units of a PDF are others.
    """
    if "stop-opacity" not in svg:
        return svg
    from warpvec.svg.description import description_of  # not above: they load Torch, which the help does without
    from warpvec.svg.document import parse_svg
    from warpvec.svg.read import read_svg
    from warpvec.svg.units import stated_size
    from warpvec.svg.write import write_svg

    loaded = read_svg(svg)
    if loaded.precision is None:
        return svg
    across, down = (0.75 * side for side in stated_size(parse_svg(svg).root))
    scene = loaded.scene.scaled(across / loaded.width, down / loaded.height)
    width, height = round(across, _DECIMALS), round(down, _DECIMALS)
    title, _ = description_of(svg.encode())
    return write_svg(
        scene, width, height, precision=_DECIMALS, title=title, sides=(f"{width}pt", f"{height}pt"),
        layer_names=loaded.layer_names,
    )  # fmt: skip


def writer(suffix: str, media_type: str, method: str, files: int = 0) -> Writer:
    """Return the writer of files with this ``suffix``.

    A ``method`` of CairoSVG makes them, with at most so many temporary ``files``.
    """

    def encode(svg: str, target: Target) -> bytes:
        del target
        load(f"drawing{suffix}", "path")
        svg = _in_points(_with_rings(svg))
        try:
            return run_in_sandbox("warpvec.writers.cairo_work", svg.encode(), files, method=method)
        except SandboxError as error:
            rule = f"must be one that CairoSVG can write as {suffix}"
            raise InputError("SVG", rule, f"an error ({error})", "save it as SVG") from None

    return Writer(suffix, media_type, encode, load, purpose="print")

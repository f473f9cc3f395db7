"""Write DXF files for laser cutters, routers and plotters, in millimetres: see `warpvec.making.dxf`.

The page is not a part.
"""

from __future__ import annotations

from warpvec.errors import InputError
from warpvec.writers.writer import Target, Writer


def _check(path: str, name: str) -> None:
    """Check that ezdxf is there, which makes the file ``path``; ``name`` is for the message."""
    try:
        import ezdxf  # noqa: F401
    except ImportError:
        rule = "must end in .svg unless ezdxf is installed, which writes .dxf"
        raise InputError(name, rule, repr(path), "pip install 'warpvec[cut]'") from None


def _encode(svg: str, target: Target) -> bytes:
    _check("drawing.dxf", "path")
    from warpvec.making.dxf import encode_sheet  # not above: it loads Torch, which the help does without
    from warpvec.making.parts import read_parts

    return encode_sheet(read_parts(svg, target.per_inch), splines=target.splines)


WRITER = Writer(".dxf", "image/vnd.dxf", _encode, _check, draws_blur=False)

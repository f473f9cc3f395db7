"""Write VectorDrawables, the pictures of Android's apps: see `warpvec.purposes.vector_drawable`."""

from __future__ import annotations

from warpvec.purposes.table import ANDROID
from warpvec.writers.writer import Target, Writer


def _check(path: str, name: str) -> None:
    del path
    ANDROID.check_packages(name)


def _encode(svg: str, target: Target) -> bytes:
    del target
    from warpvec.purposes.vector_drawable import vector_drawable  # not above: it loads what the help does without

    return vector_drawable(svg).encode()


WRITER = Writer(".xml", "application/xml", _encode, _check, purpose="android")

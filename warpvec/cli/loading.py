"""Load modules and end the process without Python's searches for cycles of garbage."""

from __future__ import annotations

import atexit
import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from warpvec.cli.postponed import postpone


@contextmanager
def quick_loading() -> Iterator[None]:
    """Import torch, and modules that need torch, in this block. This takes 0.6 of the usual time.

    The modules make half a million objects that stay. Python would search them for cycles again and again during the
    imports. After this block, Python leaves these objects out of its searches. Parts of other packages that no command
    uses are not loaded (`postpone`).
    """
    is_first, was_enabled = "torch" not in sys.modules, gc.isenabled()
    if is_first:
        postpone()
    gc.disable()
    try:
        yield
    finally:
        if is_first:
            gc.freeze()
        if was_enabled:
            gc.enable()


def load_drawing() -> None:
    """Load what draws pictures, in a process that is kept for many."""
    with quick_loading():
        import warpvec.modes.choice
        import warpvec.modes.flat
        import warpvec.result  # noqa: F401


def end_quickly() -> None:
    """Have Python end this process without a last search for cycles, which takes half a second if torch is loaded.

    Python still calls the functions that `atexit` knows of, and flushes files. The system frees the memory.
    """
    atexit.register(gc.freeze)

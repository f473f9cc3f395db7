"""Let one thread at a time make kernels and load their modules: Warp keeps what it is building in globals."""

import os
from collections.abc import Callable
from functools import cache, wraps
from threading import RLock
from typing import ParamSpec, TypeVar

making = RLock()
"""Hold this to make a kernel, or to launch one for the first time, which compiles or loads its module."""

# A fork waits for a module that is being made: the child could not finish it, and would find the lock held for ever.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=making.acquire, after_in_parent=making.release, after_in_child=making.release)

_Arguments = ParamSpec("_Arguments")
_Made = TypeVar("_Made")


def made_once(factory: Callable[_Arguments, _Made]) -> Callable[_Arguments, _Made]:
    """Keep what ``factory`` returns for each set of arguments, and let one thread at a time call it."""
    kept = cache(factory)

    @wraps(factory)
    def made(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Made:
        with making:
            return kept(*args, **kwargs)  # type: ignore[arg-type]

    return made

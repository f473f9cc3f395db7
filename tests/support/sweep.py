"""Many cases as one test."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from inspect import signature
from typing import Any

import numpy as np
import torch


def sweep(names: str | tuple[str, ...], cases: Sequence[Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Run a test with each of ``cases`` as its arguments ``names``, as one test; a failure states the case.

    It is written like `pytest.mark.parametrize`, and can stand above and below it. Each case of that is a test of its
    own, which takes longer to be collected and reported than a few milliseconds of arithmetic.
    """
    fields = (names,) if isinstance(names, str) else names

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @wraps(test)
        def run(**arguments: object) -> None:
            for case in cases:
                values = dict(zip(fields, [case] if isinstance(names, str) else case, strict=True))
                torch.manual_seed(0)  # as before each test
                np.random.seed(0)
                try:
                    test(**values, **arguments)
                except BaseException as error:  # pytest's own failures are no `Exception`
                    error.add_note("with " + ", ".join(f"{name} = {_shown(value)}" for name, value in values.items()))
                    raise

        own = signature(test)
        run.__signature__ = own.replace(  # type: ignore[attr-defined]
            parameters=[parameter for name, parameter in own.parameters.items() if name not in fields]
        )
        del run.__wrapped__  # type: ignore[attr-defined]
        return run

    return decorate


def _shown(value: object) -> str:
    return str(getattr(value, "__name__", value))

"""Signatures with every keyword argument, for help(), notebooks and editors that run the code."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from warpvec.keywords.table import annotation, keywords

_Function = TypeVar("_Function", bound=Callable[..., Any])


def with_keywords(function: _Function) -> _Function:
    """Return ``function``, whose signature lists the keywords in place of the ``**`` that takes them."""
    plain = inspect.signature(function)
    own = [each for each in plain.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
    added = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=each.default, annotation=annotation(each))
        for name, each in keywords().items()
    ]
    function.__signature__ = plain.replace(parameters=[*own, *added])  # type: ignore[attr-defined]
    return function

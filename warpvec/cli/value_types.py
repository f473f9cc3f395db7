"""The type of option values that click does not have."""

from __future__ import annotations

from typing import Any

import click

from warpvec.config.kinds import Kind


class ValueOf(click.ParamType):
    """A value of the option ``option``, of a `Kind`."""

    def __init__(self, option: str, kind: Kind) -> None:
        self.name, self._option, self._kind = kind.metavar, option, kind

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the value that a text stands for."""
        return self._kind.parse(self._option, value) if isinstance(value, str) else value

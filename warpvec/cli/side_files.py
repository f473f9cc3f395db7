"""Files beside OUT, such as a checkpoint or a video: if one cannot be written, the fit goes on without it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, ParamSpec

import click

from warpvec.cli.options import stated
from warpvec.config.fit_config import FitConfig
from warpvec.config.toml_file import write_settings
from warpvec.errors import InputError

_P = ParamSpec("_P")

_REASON_CHARACTERS = 120
"""Longest reason in a warning: an encoder's own message may have many lines."""


class SideFile:
    """A file or a folder that a run writes beside OUT, by the name of its option."""

    def __init__(self, option: str) -> None:
        self._option = option
        self.has_failed = False

    def attempt(self, write: Callable[_P, object], *arguments: _P.args, **named: _P.kwargs) -> None:
        """Call ``write``. If it fails, warn in one line on stderr, but only the first time."""
        try:
            write(*arguments, **named)
        except (OSError, InputError) as error:  # a folder that is gone is wrong input for some writers
            self.fail(error)

    def fail(self, error: Exception) -> None:
        """Note that the file could not be written, and warn if that is new."""
        if not self.has_failed:
            reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
            reason = " ".join(reason.split())[:_REASON_CHARACTERS]
            click.echo(f"warpvec: warning: {self._option} could not be written ({reason}); going on", err=True)
        self.has_failed = True


def write_config(options: Mapping[str, Any], config: FitConfig, undecided: Collection[str] = ()) -> None:
    """Write the settings of a run to the file that --write-config names, if it does, without the ``undecided`` ones."""
    if options["write_config"] is not None:
        kept = {name: value for name, value in stated(options, config).items() if name not in undecided}
        SideFile("--write-config").attempt(write_settings, options["write_config"], kept)

"""The command ``warpvec``; its commands are in ``warpvec/commands``, a file each.

Exit codes: 0 done, 1 unexpected failure, 2 wrong input or usage (nothing is written), 130 interrupted (``run`` has
then saved the best result so far). Messages are one line on stderr. Where OUT is ``-`` stdout carries the SVG alone
and the report goes to stderr. Torch and Warp are imported inside the commands, so that ``--help`` is quick.
"""

from __future__ import annotations

import errno
import sys
from importlib import import_module
from typing import Any

import click

from warpvec import __version__
from warpvec.cli.options import OPTION_NAMES
from warpvec.errors import InputError

_COMMANDS = {
    "run": "run",
    "refine": "refine",
    "batch": "batch",
    "eval": "evaluate",
    "view": "view",
    "lod": "lod",
    "info": "info",
    "sample": "sample",
}
"""Command -> its function, in the module of ``warpvec.cli.commands`` that has the command's name; in the order of the help."""


class _Group(click.Group):
    """Commands by name, and errors in one line, with the exit codes that this module's docstring states."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in _COMMANDS:
            return None
        module = import_module(f"warpvec.cli.commands.{name}")
        command: click.Command = getattr(module, _COMMANDS[name])
        return command

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise click.UsageError(str(error.renamed(OPTION_NAMES))) from error
        except (click.ClickException, click.exceptions.Exit, click.Abort, BrokenPipeError):
            raise
        except Exception as error:
            if ctx.params["debug"]:
                raise
            hint = f"warpvec --debug {ctx.invoked_subcommand} ... shows where"
            told = _told(error) or f"{type(error).__name__}: {error}; {hint}"
            raise click.ClickException(told) from error

    def main(self, *args: Any, **kwargs: Any) -> Any:
        kwargs["standalone_mode"] = False
        try:
            code = super().main(*args, **kwargs)
        except click.Abort:
            code = 130  # 128 + SIGINT, as shells have it
        except click.exceptions.NoArgsIsHelpError as error:
            error.show()
            code = error.exit_code
        except click.ClickException as error:
            click.echo(f"warpvec: error: {' '.join(error.format_message().split())}", err=True)
            code = error.exit_code
        sys.exit(code or 0)


def _told(error: Exception) -> str | None:
    """What has run out on this machine and what to do, if that is the cause of ``error``."""
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"the disk is full ({error.strerror}); free some of it and run again, files are whole or as they were"
    # Torch has an exception of its own; Torch on the CPU and Warp have only a text.
    exhausted = isinstance(error, MemoryError) or type(error).__name__ == "OutOfMemoryError"
    if exhausted or (isinstance(error, RuntimeError) and "allocate" in str(error)):
        return f"memory has run out ({str(error) or 'for Python'}); give a smaller --fit-size or fewer --curves"
    return None


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="warpvec")
@click.option("--debug", is_flag=True, envvar="WARPVEC_DEBUG", help="Show the traceback of an unexpected failure.")
def main(debug: bool) -> None:
    """A photo becomes an editable SVG, measured on the file that is written."""
    del debug

"""The command ``warpvec``. Each of its commands has a file in ``warpvec/cli/commands``.

Exit codes: 0 done, 1 unexpected failure, 2 wrong input or usage (nothing is written), 128 + n ended by the signal n,
such as 130 by Ctrl-C (``run`` and ``refine`` have then saved the best result so far; see ``signals``). Messages are one
line on stderr. With ``-`` for OUT only the SVG goes to stdout, and the report to stderr. The commands import Torch and
Warp when they run, so that ``--help`` is quick.
"""

from __future__ import annotations

import errno
import os
import shlex
import sys
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from warpvec import __version__
from warpvec.checks import in_one_line
from warpvec.cli.options import OPTION_NAMES
from warpvec.cli.streams import prepare_streams, settle_stdout
from warpvec.errors import InputError, shortened
from warpvec.files import is_full
from warpvec.image.formats import SUFFIXES
from warpvec.writers.registry import SVG_SUFFIXES

_COMMANDS = ("run", "refine", "batch", "eval", "app", "mcp", "view", "lod", "info", "inkscape", "sample", "help")
"""The commands in the order of the help. Each is in the module of ``warpvec.cli.commands`` with its name."""

_FUNCTIONS = {"eval": "evaluate", "help": "show_help"}
"""Command -> its function, if that has another name."""


class _Group(click.Group):
    """The commands by name, with one-line errors and the exit codes of this module's docstring."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in _COMMANDS:
            return None
        module = import_module(f"warpvec.cli.commands.{name}")
        command: click.Command = getattr(module, _FUNCTIONS.get(name, name))
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args[0] not in _COMMANDS and not args[0].startswith("-"):
            raise click.UsageError(f"no command is called {args[0]!r}; {_suggestion(args)}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        if not _has_working_folder():  # libraries end the process without one
            raise click.UsageError("the working folder does not exist any more; change to another one")
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise click.UsageError(str(error.renamed(OPTION_NAMES))) from error
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except Exception as error:
            if ctx.params["debug"]:
                raise
            hint = f"run warpvec --debug {ctx.invoked_subcommand} ... for the traceback"
            message = _exhaustion(error) or f"{type(error).__name__}: {error}; {hint}"
            raise click.ClickException(message) from error

    def main(self, *args: Any, **kwargs: Any) -> Any:
        prepare_streams()
        kwargs["standalone_mode"] = False
        try:
            code = super().main(*args, **kwargs)
        except click.Abort:
            code = 130  # 128 + SIGINT, as in shells
        except click.exceptions.NoArgsIsHelpError as error:
            error.show()
            code = error.exit_code
        except click.ClickException as error:
            message = in_one_line(" ".join(map(shortened, error.format_message().split())))
            click.echo(f"warpvec: error: {message}{_hint(error)}", err=True)
            code = error.exit_code
        except OSError as error:  # the help, which no command prints, to a stdout that is full
            click.echo(f"warpvec: error: {_exhaustion(error) or error}", err=True)
            code = 1
        finally:
            settle_stdout()
        sys.exit(code or 0)


def _has_working_folder() -> bool:
    try:
        os.getcwd()
    except OSError:
        return False
    return True


_SURPLUS = "Got unexpected extra argument"
"""Beginning of click's message about arguments that a command does not take."""


def _hint(error: click.ClickException) -> str:
    """Return the hint at the command's help, for a missing or surplus argument and for an option that is like none."""
    is_unlike = isinstance(error, click.NoSuchOption) and not error.possibilities
    is_about_usage = isinstance(error, click.MissingParameter) or error.message.startswith(_SURPLUS) or is_unlike
    if not isinstance(error, click.UsageError) or error.ctx is None or not is_about_usage:
        return ""
    stop = "" if error.format_message().endswith(".") else "."
    return f"{stop} See warpvec {error.ctx.info_name} --help."


_OTHER_NAMES = ("convert", "draw", "trace", "vectorise", "vectorize")
"""Names that other programs and languages have for the command run."""


def _suggestion(args: list[str]) -> str:
    """Return a hint for arguments that do not start with a command."""
    path = Path(args[0])
    is_drawing, is_picture = (path.suffix.lower() in suffixes for suffixes in (SVG_SUFFIXES, SUFFIXES))
    if is_drawing or is_picture or os.path.isfile(path):
        command = "view" if is_drawing else "run"
        return f"did you mean `{shlex.join(['warpvec', command, *args])}`?"
    similar = ["run"] if args[0] in _OTHER_NAMES else get_close_matches(args[0], _COMMANDS, n=1)
    return f"did you mean `warpvec {similar[0]}`?" if similar else "see warpvec --help for the commands"


def _exhaustion(error: Exception) -> str | None:
    """Return a message if the disk or memory is full, the disk is read-only, or the reader has left."""
    if isinstance(error, BrokenPipeError):
        return "the reader of the output left before all was written"
    if isinstance(error, OSError) and (is_full(error) or error.errno == errno.EFBIG):
        lost = f"{error.filename!r} could not be written" if error.filename else "no file was damaged"
        if error.errno == errno.EFBIG:
            return f"a file would be larger than is allowed ({error.strerror}), {lost}; raise the limit (ulimit -f)"
        return f"the disk is full ({error.strerror}), {lost}; free some space and run again"
    if isinstance(error, OSError) and error.errno == errno.EROFS:
        return f"{error.filename!r} could not be written ({error.strerror}); make its folder one that can be written"
    # Torch has an exception of its own on CUDA; Torch on the CPU and Warp raise RuntimeError with a text.
    exhausted = isinstance(error, MemoryError) or type(error).__name__ == "OutOfMemoryError"
    if exhausted or (isinstance(error, RuntimeError) and "allocate" in str(error)):
        return f"memory has run out ({str(error) or 'for Python'}); give a smaller --fit-size or fewer --curves"
    return None


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "-V", "--version", prog_name="warpvec")
@click.option("--debug", is_flag=True, envvar="WARPVEC_DEBUG", help="Show the traceback of an unexpected failure.")
def main(debug: bool) -> None:
    """Turn images into editable SVGs, and measure the quality of the written files.

    To begin: warpvec run photo.png
    """
    del debug

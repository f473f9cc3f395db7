"""``warpvec app``: make, edit and save drawings on one page in the browser."""

from __future__ import annotations

import os
from contextlib import ExitStack, suppress
from importlib.util import find_spec
from pathlib import Path

import click

from warpvec.cli import signals
from warpvec.errors import InputError


@click.command(short_help="Make and edit drawings on a page in the browser.")
@click.argument("folder", metavar="[FOLDER]", required=False)
@click.option("--port", type=click.IntRange(1024, 65_535), metavar="N", help="Port of the page. [8437, or a free one]")
@click.option("--no-browser", is_flag=True, help="Print the address and open no browser.")
@click.option("--threads", type=click.IntRange(min=1), metavar="N", help="CPU threads of fits. [all cores]")
def app(folder: str | None, port: int | None, no_browser: bool, threads: int | None) -> None:
    """Open a page in the browser on which pictures become drawings.

    Drop a picture there, watch it being drawn, edit the drawing, and save it.

    Everything stays on this machine. Only the page that this command opens can use the server. Pictures are kept in
    memory until their page is closed. With FOLDER the page lists the pictures in FOLDER, and saves drawings there
    instead of downloading them. Ctrl-C ends the server.
    """
    if folder is not None and not (folder and os.path.isdir(folder)):
        raise InputError("FOLDER", "must be an existing folder", repr(folder), "create it first, or leave it out")
    if any(find_spec(name) is None for name in ("starlette", "uvicorn")):
        rule = "needs the packages of the extra app"
        raise InputError("app", rule, "starlette or uvicorn is missing", "pip install 'warpvec[app]'")
    from warpvec.app.address import open_socket
    from warpvec.app.identity import Identity, read_key
    from warpvec.app.opening import has_browser, leading_file, open_browser
    from warpvec.app.server import run_server

    listener = open_socket(port)
    identity = Identity(read_key(listener.getsockname()[1]))

    def show(address: str, ticket_address: str) -> None:
        click.echo(f"The page is at {address}\nCtrl-C ends it.", err=True)
        if not no_browser and has_browser():
            with suppress(OSError):  # the address has been printed
                open_browser(kept.enter_context(leading_file(ticket_address)))

    where = None if folder is None else Path(folder)
    with listener, ExitStack() as kept:
        run_server(listener, identity, folder=where, threads=threads, on_start=show, signals=signals.listener())
    signals.end_if_signalled()

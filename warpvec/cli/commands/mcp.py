"""``warpvec mcp``: tools for assistants and other programs that speak the Model Context Protocol."""

from __future__ import annotations

from importlib.util import find_spec

import click

from warpvec.errors import InputError


@click.command(short_help="Give assistants the tools vectorize, refine and evaluate.")
@click.argument("folders", metavar="FOLDER...", nargs=-1, required=True)
@click.option("--threads", type=click.IntRange(min=1), metavar="N", help="CPU threads of fits. [all cores]")
def mcp(folders: tuple[str, ...], threads: int | None) -> None:
    """Serve the tools vectorize, refine and evaluate over stdin and stdout, as MCP clients start it.

    The tools read and write files in FOLDER alone. A client lists the command, such as
    {"command": "warpvec", "args": ["mcp", "pictures"]}. It ends when stdin ends, or
    with its client.
    """
    if find_spec("mcp") is None:
        raise InputError("mcp", "needs the package of the extra mcp", "none", "pip install 'warpvec[mcp]'")
    from warpvec.agents.folders import Folders

    named = Folders(folders)
    from warpvec.agents.client import end_without_reader
    from warpvec.agents.server import make_server

    end_without_reader()
    make_server(named, threads).run("stdio")

"""``warpvec sample``: write a sample photo."""

from __future__ import annotations

import os

import click

from warpvec.checks import in_one_line
from warpvec.errors import InputError
from warpvec.files import check_writable


@click.command(short_help="Write a sample photo.")
@click.argument("name", default="coffee.png")
@click.argument("out", required=False)
@click.option("--force", is_flag=True, help="Replace OUT if it exists.")
def sample(name: str, out: str | None, force: bool) -> None:
    """Write the sample photo NAME to the file OUT, by default NAME in this folder. Nothing is downloaded."""
    from warpvec.image.samples import write_sample

    target = name if out is None else out
    check_writable(target, "OUT")
    if os.path.isfile(target) and not force:
        raise InputError("OUT", "must be a new file", repr(target), "add --force to replace it")
    write_sample(name, target)
    click.echo(in_one_line(target))

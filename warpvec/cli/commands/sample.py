"""``warpvec sample``: write a sample photo."""

from __future__ import annotations

import click

from warpvec.checks import in_one_line
from warpvec.files import check_writable


@click.command(short_help="Write a sample photo.")
@click.argument("name", default="coffee.png")
@click.argument("out", required=False)
def sample(name: str, out: str | None) -> None:
    """Write the sample photo NAME to the file OUT, by default NAME in this folder. Nothing is downloaded."""
    from warpvec.image.samples import write_sample

    target = name if out is None else out
    check_writable(target, "OUT")
    write_sample(name, target)
    click.echo(in_one_line(target))

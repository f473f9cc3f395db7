"""``warpvec sample``: a real photo without a download."""

from __future__ import annotations

import click

from warpvec.files import check_writable


@click.command()
@click.argument("name", default="coffee.png")
@click.argument("out", required=False)
def sample(name: str, out: str | None) -> None:
    """Write the real photo NAME to OUT, without a download. OUT is NAME in this folder unless given."""
    from warpvec.image.samples import write_sample

    target = name if out is None else out
    check_writable(target, "OUT")
    write_sample(name, target)
    click.echo(target)

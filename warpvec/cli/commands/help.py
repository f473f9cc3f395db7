"""``warpvec help``: the help of warpvec or of a command."""

from __future__ import annotations

import click


@click.command("help")
@click.argument("command", required=False)
@click.pass_context
def show_help(ctx: click.Context, command: str | None) -> None:
    """Show the help of a command."""
    group_context = ctx.find_root()
    group = group_context.command
    if command is None or not isinstance(group, click.Group):
        click.echo(group.get_help(group_context))
        return
    _, found, _ = group.resolve_command(group_context, [command])
    if found is not None:
        click.echo(found.get_help(click.Context(found, info_name=command, parent=group_context)))

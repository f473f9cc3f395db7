"""``warpvec inkscape``: put warpvec into the menus of Inkscape."""

from __future__ import annotations

import json
from pathlib import Path

import click

from warpvec.checks import in_one_line

_folder_option = click.option("--folder", metavar="DIR", help="Inkscape's folder of extensions, if not the user's.")


@click.group("inkscape", short_help="Trace and refine inside Inkscape.")
def inkscape() -> None:
    """Trace images and refine paths inside Inkscape.

    After the installation and a restart, Inkscape has the menu Extensions > warpvec. "Trace image" draws the selected
    images in layers above them. "Refine selected paths against the image" moves nodes and colours. Inkscape 1.2 or
    later is needed. An Inkscape from Flatpak or Snap cannot call programs outside of it.
    """


@inkscape.command()
@_folder_option
def install(folder: str | None) -> None:
    """Write the extension into Inkscape's folder. Do it again if warpvec has moved or is new."""
    from warpvec.inkscape.installation import install

    click.echo(in_one_line(f"{install(_chosen(folder))}: restart Inkscape, then see Extensions > warpvec"))


@inkscape.command()
@_folder_option
def uninstall(folder: str | None) -> None:
    """Remove the extension."""
    from warpvec.inkscape.installation import uninstall

    click.echo(in_one_line(f"{uninstall(_chosen(folder))}: removed"))


@inkscape.command(hidden=True)
@click.argument("image", metavar="IMAGE")
def size(image: str) -> None:
    """Print the width and height of IMAGE in pixels as JSON, turned upright, as fits see it."""
    from warpvec.image.read import read_image

    height, width = read_image(image, name="IMAGE").shape[:2]
    click.echo(json.dumps([width, height]))


def _chosen(folder: str | None) -> Path:
    from warpvec.inkscape.installation import user_folder

    return user_folder() if folder is None else Path(folder)

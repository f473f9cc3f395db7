"""The packages of the extra "cut", without which no drawing can be made ready for machines."""

from __future__ import annotations

from importlib.util import find_spec

from warpvec.errors import InputError

PACKAGES = ("ezdxf", "shapely")


def can_make() -> bool:
    """Return whether the packages are installed."""
    return all(map(find_spec, PACKAGES))


def check_packages(name: str) -> None:
    """Check that the packages are installed for ``name``: what the user asked for, in the plural.

    Raises:
        InputError: a package is missing.
    """
    if not can_make():
        rule, found = "need the packages of the extra cut", f"{' or '.join(PACKAGES)} is missing"
        raise InputError(name, rule, found, "pip install 'warpvec[cut]'")

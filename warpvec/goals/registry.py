"""The table of goals. To add a goal, write a file in this folder, and add its name here."""

from __future__ import annotations

from importlib import import_module

from warpvec.goals.quantity import Quantity

_FILES = ("file_bytes", "file_psnr", "file_ssim")
"""Modules of this folder with a `QUANTITY`, in the order of the help."""

_FOUND: list[Quantity] = [import_module(f"warpvec.goals.{name}").QUANTITY for name in _FILES]

QUANTITIES: dict[str, Quantity] = {quantity.name: quantity for quantity in _FOUND}
"""Quantity by the name of its option."""

"""Limit the work that one file may ask for."""

from __future__ import annotations


class WorkBudget:
    """The amount of work that may be spent on one file."""

    def __init__(self, amount: int) -> None:
        self._left = amount

    def takes(self, amount: int) -> bool:
        """Return whether ``amount`` is left, and take it if so."""
        if amount > self._left:
            return False
        self._left -= amount
        return True

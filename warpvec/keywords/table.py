"""The keyword arguments, from the tables of settings, goals and file options.

Write their types anew after a change of a setting:

    python -m warpvec.keywords.table > warpvec/keywords/typed.py
"""

from __future__ import annotations

from typing import NamedTuple

from warpvec.config.fit_config import SETTINGS
from warpvec.config.kinds import Flag, Kind
from warpvec.config.setting import settings_of
from warpvec.drawing.file_options import FileOptions
from warpvec.goals.registry import QUANTITIES

_HEAD = '''"""The types of the keyword arguments of `warpvec.vectorize` and `warpvec.refine`.

Written by ``python -m warpvec.keywords.table > warpvec/keywords/typed.py``; do not edit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict


class Keywords(TypedDict, total=False):
    """Settings, goals and choices about the file; see `warpvec/config/README.md`."""

'''

_NAMED = ("curves", "no_metadata")
"""What the functions have parameters of their own for."""

FILE_OPTIONS = tuple(name for name in settings_of(FileOptions) if name not in _NAMED)
"""Keywords that are choices about the file alone."""


class Keyword(NamedTuple):
    """A keyword argument: its kind of values, its default, and its help in one sentence."""

    kind: Kind
    default: object
    help: str


def keywords() -> dict[str, Keyword]:
    """Return the keyword arguments by name."""
    tables = (SETTINGS, settings_of(FileOptions))
    found = {name: Keyword(each.kind, each.default, each.help) for table in tables for name, each in table.items()}
    goals = {name: Keyword(each.kind, None, each.help) for name, each in QUANTITIES.items()}
    goals["gzip"] = Keyword(Flag(), False, "Count max_bytes after gzip.")
    return {name: each for name, each in (goals | found).items() if name not in _NAMED}


def typed_text() -> str:
    """Return the text of ``warpvec/keywords/typed.py``."""
    return _HEAD + "".join(
        f'    {name}: {annotation(each)}\n    """{each.help}"""\n' for name, each in keywords().items()
    )


def annotation(keyword: Keyword) -> str:
    """Return the type of a keyword's values, as Python text."""
    found = keyword.kind.annotation
    return f"{found} | None" if keyword.default is None and not found.endswith("None") else found


if __name__ == "__main__":
    print(typed_text(), end="")

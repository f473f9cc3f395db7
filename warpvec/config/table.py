"""The table of all settings, as it stands in ``warpvec/config/README.md``.

Write it anew after a change of a setting:

    python -m warpvec.config.table > warpvec/config/README.md
"""

from __future__ import annotations

from warpvec.config.fit_config import SETTINGS
from warpvec.config.setting import ANY_MODE, Setting

_HEAD = """# Settings

Every setting of a run, by its name in Python, in files of settings (`--config`) and in the metadata of files; on the
command line `--inflation-gap` stands for `inflation_gap`. A setting that only one mode has selects that mode.

`python -m warpvec.config.table > warpvec/config/README.md` writes this page from the fields of
`fit_config.CoreSettings` and of the settings of other rooms (`rooms.py`). Add a setting there, and nowhere else.
"""

_COLUMNS = "| setting | default | values | modes | use |\n|---|---|---|---|---|"


def settings_table() -> str:
    """Return the table in Markdown, a section of the help each."""
    sections = dict.fromkeys(setting.section for setting in SETTINGS.values())
    parts = [_HEAD, *(_section(name) for name in sections)]
    return "\n".join(parts)


def _section(name: str) -> str:
    rows = [_row(setting) for setting in SETTINGS.values() if setting.section == name]
    return f"## {name}\n\n{_COLUMNS}\n" + "\n".join(rows) + "\n"


def _row(setting: Setting) -> str:
    modes = "all" if setting.modes == ANY_MODE else ", ".join(setting.modes)
    cells = [f"`{setting.name}`", _shown(setting.default), setting.kind.limits, modes, setting.help]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _shown(default: object) -> str:
    if isinstance(default, bool):
        return "on" if default else "off"
    return "-" if default is None else str(default)


if __name__ == "__main__":
    print(settings_table(), end="")

"""A setting: kind of values, default, help, and who uses it. Each setting is stated once, as a field of a class.

The class of settings, the options of the command line, files of settings, the controls of the page, the help and the
table in `warpvec/config/README.md` come from these fields. To add a setting, add a field to
`warpvec.config.fit_config.CoreSettings`, or to the settings of a room of its own (see `warpvec.config.rooms`).
"""

from __future__ import annotations

from dataclasses import Field, dataclass, field, fields
from typing import Any, Literal

from warpvec.config.control import Control
from warpvec.config.kinds import Kind
from warpvec.config.modes import MODES

PHOTO = ("photo",)
"""Modes of a setting that only the fit of a photo uses."""

ANY_MODE = tuple(MODES)
"""Modes of a setting that every mode uses."""

Stated = Literal["always", "if used", "never"]
"""Whether files of photos state a setting: "if used" leaves out the values 0, off and none."""


@dataclass(frozen=True)
class Setting:
    """A setting.

    Attributes:
        name: its name in Python and in files.
        kind: the kind of its values.
        default: its value unless it is given.
        help: one sentence for the help.
        section: section of the help.
        is_daily: whether --help shows it; --help-all shows every setting.
        metavar: placeholder of the value in the help; None for that of the kind.
        modes: the modes that use the setting. A setting of one mode selects this mode when it is given.
        is_binding: whether other modes refuse the setting even if a preset gives it.
        ignored_by: other modes that ignore the setting instead of refusing it.
        stated: whether files of photos state the setting, if photos use it. Files of flat art state what differs from
            the defaults.
        is_of_machine: whether the setting only says where a run works. Files and records leave such settings out.
        renderer: name of the only renderer that uses the setting; None for any renderer.
        old_name: former name, which still works; None for none.
        page: control on the page of `warpvec app`; None for none.
        bare: value of the option without a value on the command line; None if it needs one.
        flag: its name on the command line, where that is a word that Python keeps to itself; None for ``name``.
    """

    name: str
    kind: Kind
    default: Any
    help: str
    section: str
    is_daily: bool = False
    metavar: str | None = None
    modes: tuple[str, ...] = ANY_MODE
    is_binding: bool = False
    ignored_by: tuple[str, ...] = ()
    stated: Stated = "always"
    is_of_machine: bool = False
    renderer: str | None = None
    old_name: str | None = None
    page: Control | None = None
    bare: str | None = None
    flag: str | None = None


def setting(default: Any, kind: Kind, help: str, section: str, **more: Any) -> Any:
    """Return the field of a class of settings; the arguments are attributes of `Setting`."""
    return field(default=default, metadata={"kind": kind, "help": help, "section": section, **more})


def photo_setting(default: Any, kind: Kind, help: str, section: str, **more: Any) -> Any:
    """Return the field of a setting that only the fit of a photo uses."""
    return setting(default, kind, help, section, modes=PHOTO, **more)


def settings_of(owner: Any) -> dict[str, Setting]:
    """Return the settings of a class by name, in the order of its fields."""
    return {each.name: _setting_of(each) for each in fields(owner)}


def _setting_of(each: Field[Any]) -> Setting:
    return Setting(each.name, default=each.default, **each.metadata)

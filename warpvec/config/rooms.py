"""Rooms that add renderers, path models, policies, presets and settings to warpvec.

A room is a folder with a module ``room`` that holds a `Room` named ``ROOM``. Without the folder and its line in
`ROOMS`, warpvec works without what the room adds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any

from warpvec.config.preset import Preset

ROOMS = ("warpvec.paper",)
"""The rooms, as packages."""


@dataclass(frozen=True)
class Room:
    """The additions of a room. Modules that load Torch are given as "package.module:name", and loaded at first use.

    Attributes:
        settings: class of its settings, a frozen dataclass of `warpvec.config.setting.setting` fields.
        check: raises InputError for values that do not go together, from all settings of a run by name.
        presets: preset by name; see `warpvec.config.presets`.
        renderers: name of a renderer -> its class, a subclass of `warpvec.rendering.tile_renderer.TileRenderer`.
        path_models: name of a path model -> its class, a `warpvec.fit.path_models.PathModel`.
        policies: name of a policy -> its class; see `warpvec.fit.policies.base.Policy`.
        words: one of these names -> what it is, for the help.
        short_fits: settings of fits that use every kernel of the room, for `warpvec.modes.precompile`.
    """

    settings: type
    check: Callable[[Mapping[str, object]], None]
    presets: Mapping[str, Preset] = field(default_factory=dict)
    renderers: Mapping[str, str] = field(default_factory=dict)
    path_models: Mapping[str, str] = field(default_factory=dict)
    policies: Mapping[str, str] = field(default_factory=dict)
    words: Mapping[str, str] = field(default_factory=dict)
    short_fits: tuple[Mapping[str, Any], ...] = ()


@cache
def rooms() -> tuple[Room, ...]:
    """Return the rooms."""
    return tuple(import_module(f"{package}.room").ROOM for package in ROOMS)


def added_settings() -> tuple[type, ...]:
    """Return the classes of settings that the rooms add."""
    return tuple(room.settings for room in rooms())


def added_names(kind: str) -> tuple[str, ...]:
    """Return the names that the rooms add to a registry: "renderers", "path_models" or "policies"."""
    return tuple(name for room in rooms() for name in getattr(room, kind))


def with_added_names(text: str, kind: str) -> str:
    """Return the help ``text`` about the names of a registry, with those that the rooms add, as a sentence."""
    return "".join(
        [text, *(f" or {name} ({room.words[name]})" for room in rooms() for name in getattr(room, kind)), "."]
    )


def load(kind: str, name: str) -> Any:
    """Return the class that a room has added as ``name`` to the registry ``kind``.

    Raises:
        KeyError: no room has.
    """
    module, _, attribute = {n: where for room in rooms() for n, where in getattr(room, kind).items()}[name].partition(
        ":"
    )
    return getattr(import_module(module), attribute)

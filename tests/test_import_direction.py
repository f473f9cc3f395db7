"""Imports point one way, from the command line down to the kernels, and never in a circle."""

import ast
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import warpvec

PACKAGE = Path(warpvec.__file__).parent

ROOMS = [
    "cli",
    "batch viewer",
    "vectorization",
    "fit",
    "rendering svg",
    "kernels config",
    "geometry image",
    "checks files",
    "errors",
]
"""From top to bottom. A room may import those on lower lines, and itself."""

LEVEL = {room: len(ROOMS) - index for index, line in enumerate(ROOMS) for room in line.split()}
LEVEL |= {"__main__": len(ROOMS) + 1, "__init__": 0}


@cache
def imports() -> dict[str, set[str]]:
    """Every module of the package, and those it imports, inside functions too."""
    paths = {*PACKAGE.rglob("*.py"), *(PACKAGE / "kernels").glob("*.py")}  # rglob passes by the symbolic link
    modules = {".".join(path.relative_to(PACKAGE).with_suffix("").parts): path for path in paths}
    return {name: _imported(path, modules) - {name} for name, path in modules.items()}


def _imported(path: Path, modules: dict[str, Path]) -> set[str]:
    nodes = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ImportFrom)]
    froms = [
        (f"{node.module}.".removeprefix("warpvec."), node) for node in nodes if (node.module or "")[:7] == "warpvec"
    ]
    names = {prefix + alias.name for prefix, node in froms for alias in node.names}
    return (names | {prefix.rstrip(".") for prefix, _ in froms}) & modules.keys()


@pytest.mark.parametrize("room", sorted(LEVEL))
def test_a_room_imports_only_what_is_below_it(room: str) -> None:
    modules = {name: found for name, found in imports().items() if name.split(".")[0] == room}
    assert modules
    for name, found in modules.items():
        above = [each for each in found if each.split(".")[0] != room and LEVEL[each.split(".")[0]] >= LEVEL[room]]
        assert not above, f"{name} imports {above}"


def test_no_modules_import_each_other() -> None:
    list(TopologicalSorter(imports()).static_order())  # raises CycleError


def test_there_are_at_most_ten_levels_of_rooms() -> None:
    rooms: dict[str, set[str]] = {}
    for name, found in imports().items():
        room = name.split(".")[0]
        rooms.setdefault(room, set()).update({each.split(".")[0] for each in found} - {room})

    @cache
    def level(room: str) -> int:
        return 1 + max((level(below) for below in rooms[room]), default=0)

    assert 5 < max(map(level, rooms)) <= 10

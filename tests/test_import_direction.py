"""Imports point one way, from the command line down to the kernels, and never in a circle."""

import ast
import re
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import warpvec

PACKAGE = Path(warpvec.__file__).parent


def _lines_of_rooms() -> list[list[str]]:
    """Return the rooms in the table of ``warpvec/README.md``, a list for each line, from top to bottom."""
    table = (PACKAGE / "README.md").read_text().partition("## Rooms\n")[2].partition("\n## ")[0]
    cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    return [re.findall(r"`(\w+)(?:/|\.py)`", cell) for cell in cells]


LINES = _lines_of_rooms()
"""A room may import those on lower lines, and itself."""

LEVEL = {room: len(LINES) - index for index, line in enumerate(LINES) for room in line}
LEVEL |= {"__main__": len(LINES) + 1, "__init__": 0}

PUBLIC = warpvec._MODULES
"""Name in the package -> the module that it is loaded from when it is first used."""

COMPUTED_IMPORTS = {"__init__", "cli.main", "config.rooms", "goals.registry", "sandbox.child", "writers.registry"}
"""The modules that may compute the names of others: the public names, the commands, the rooms that register themselves,
the tables of goals and of kinds of files, which name modules of their own folder, and the work in the sandbox."""


@cache
def sources() -> dict[str, Path]:
    """Every module of the package, without the leading "warpvec.", and its file."""
    paths = {*PACKAGE.rglob("*.py"), *(PACKAGE / "kernels").glob("*.py")}  # rglob passes by the symbolic link
    names = {path: ".".join(path.relative_to(PACKAGE).with_suffix("").parts) for path in paths}
    return {name.removesuffix(".__init__"): path for path, name in names.items()}


@cache
def imports() -> dict[str, set[str]]:
    """Every module of the package, and those it imports, inside functions too."""
    return {name: _imported(path) - {name} for name, path in sources().items()}


def _imported(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
            if "warpvec" in names:  # every public name can be reached from it
                names |= {f"warpvec.{module}" for module in PUBLIC.values()}
        elif isinstance(node, ast.ImportFrom):
            module = _absolute(node, path)
            names |= {module, *(f"{module}.{alias.name}" for alias in node.names)}
    found = {name.removeprefix("warpvec.") for name in names if name.startswith("warpvec.")}
    return {PUBLIC.get(name, name) for name in found} & sources().keys()


def _absolute(node: ast.ImportFrom, path: Path) -> str:
    """Return the module that ``node`` imports from, with leading dots resolved."""
    if not node.level:
        return node.module or ""
    folders = ("warpvec", *path.relative_to(PACKAGE).parent.parts)
    return ".".join([*folders[: len(folders) + 1 - node.level], *([node.module] if node.module else [])])


@pytest.mark.parametrize("room", sorted(LEVEL))
def test_a_room_imports_only_what_is_below_it(room: str) -> None:
    modules = {name: found for name, found in imports().items() if name.split(".")[0] == room}
    assert modules
    for name, found in modules.items():
        above = [each for each in found if each.split(".")[0] != room and LEVEL[each.split(".")[0]] >= LEVEL[room]]
        assert not above, f"{name} imports {above}"


def test_every_module_is_in_a_room() -> None:
    assert {name.split(".")[0] for name in sources()} == LEVEL.keys()


def test_no_modules_import_each_other() -> None:
    list(TopologicalSorter(imports()).static_order())  # raises CycleError


def test_only_few_modules_compute_what_they_import() -> None:
    found = {name for name, path in sources().items() if re.search("import_module|__import__", path.read_text())}
    assert found == COMPUTED_IMPORTS

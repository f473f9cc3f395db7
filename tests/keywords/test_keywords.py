"""The keyword arguments in types and signatures follow the tables of settings, goals and file options."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import warpvec
from warpvec.keywords import typed
from warpvec.keywords.table import keywords, typed_text

ROOT = Path(warpvec.__file__).parents[1]


def test_the_types_are_up_to_date() -> None:
    written = Path(typed.__file__).read_text(encoding="utf-8")
    assert written == typed_text(), "run python -m warpvec.keywords.table > warpvec/keywords/typed.py"


@pytest.mark.parametrize("function", [warpvec.vectorize, warpvec.refine])
def test_help_shows_every_keyword_with_its_default(function: object) -> None:
    parameters = inspect.signature(function).parameters  # type: ignore[arg-type]
    assert {*keywords()} <= {*parameters} and "options" not in parameters
    assert parameters["fit_size"].default == 1024 and parameters["max_bytes"].default is None
    assert parameters["opacity"].annotation == 'Literal["free", "common", "opaque"]'


def test_the_stub_of_the_package_has_the_public_names() -> None:
    lines = (ROOT / "warpvec" / "__init__.pyi").read_text(encoding="utf-8").splitlines()
    names = {line.rpartition(" as ")[2] for line in lines if " as " in line}
    imports = [(line.split()[1], line.split()[-1]) for line in lines if " as " in line]
    assert names == {*warpvec._MODULES}
    assert {(name if module == "warpvec" else module.removeprefix("warpvec."), name) for module, name in imports} == {
        (module, name) for name, module in warpvec._MODULES.items()
    }


PROGRAM = """
import warpvec

result = warpvec.vectorize("a.png", curves="auto", mode="flat", palette=["red", "#123"], size="90mm", max_bytes=9)
text: str = result.svg()
better: warpvec.Result = warpvec.refine("a.png", text, gradients="auto", threads=2)
warpvec.vectorize("a.png", mode="drawing")  # a wrong choice
warpvec.vectorize("a.png", curve=3)  # no such keyword
warpvec.vectorize("a.png", fit_size="large")  # a wrong type
wrong: int = result
"""

SETTINGS = """
[mypy]
strict = True

[mypy-torch.*,scipy.*,warp.*]
follow_imports = skip
"""
"""What these packages declare takes mypy half a minute to read, and is not in question."""


@pytest.mark.slow
def test_mypy_checks_calls_from_another_folder(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    (tmp_path / "program.py").write_text(PROGRAM)
    (tmp_path / "mypy.ini").write_text(SETTINGS)
    command = [sys.executable, "-m", "mypy", "program.py"]
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env={"MYPYPATH": str(ROOT)})
    assert [int(line.split(":")[1]) for line in found.stdout.splitlines() if ": error:" in line] == [7, 8, 9, 10]


def test_a_palette_may_be_a_list() -> None:
    settings = warpvec.make_config(palette=["red", "#123"])
    assert settings == warpvec.make_config(palette="red,#112233")
    with pytest.raises(warpvec.InputError, match="palette must be colours such as"):
        warpvec.make_config(palette=["red", 3])


def test_the_repr_of_a_scene_is_one_line() -> None:
    import torch

    points = torch.rand(2, 6, 2)
    colors = {"color": torch.rand(2, 3), "opacity": torch.ones(2), "background": torch.ones(3)}
    scene = warpvec.Scene.uniform(points, **colors, generation=torch.zeros(2, dtype=torch.int64))
    assert repr(scene) == "<Scene: 2 paths, 4 segments of degree 3, background [1.0, 1.0, 1.0], on cpu>"

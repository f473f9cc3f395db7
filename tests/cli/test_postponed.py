"""Modules that a process loads only when they are used."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from threading import Thread
from types import ModuleType

import pytest

from warpvec.cli import postponed
from warpvec.cli.postponed import postpone

NAME = "warpvec_test_of_postponed"
CODE = """
import time
time.sleep(0.05)
runs = globals().get("runs", 0) + 1
later = 7
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    (tmp_path / f"{NAME}.py").write_text(CODE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    monkeypatch.setattr(postponed, "POSTPONED", frozenset({NAME}))
    monkeypatch.delitem(sys.modules, NAME, raising=False)
    postpone()
    return importlib.import_module(NAME)


def test_a_postponed_module_runs_once_when_threads_use_it(module: ModuleType) -> None:
    assert not hasattr(module, "__all__") and "later" not in vars(module)
    found: list[int] = []
    threads = [Thread(target=lambda: found.append(module.later)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [7] * 4
    assert module.runs == 1
    assert type(module) is ModuleType


def test_a_postponed_module_lacks_the_names_that_its_code_does_not_make(module: ModuleType) -> None:
    with pytest.raises(AttributeError, match=f"module '{NAME}' has no attribute 'other'"):
        _ = module.other


COMPILED = """
from warpvec.cli.postponed import postpone
postpone()
import torch
print(torch.compile(lambda x: x + 1, backend="eager")(torch.ones(1)).item(), torch.export.Dim.__name__)
"""


@pytest.mark.slow
def test_torch_compiles_where_parts_of_it_are_postponed() -> None:
    run = subprocess.run([sys.executable, "-c", COMPILED], capture_output=True, text=True, check=True)
    assert run.stdout == "2.0 Dim\n"


@pytest.mark.parametrize(("last", "module"), [((99, 0), "warpvec.cli.postponed"), ((1, 0), "scipy._lib._docscrape")])
def test_functions_of_scipy_keep_their_text_and_work(last: tuple[int, int], module: str) -> None:
    code = f"""
from warpvec.cli import postponed
postponed._LAST_KNOWN["scipy"] = {last}
postponed.postpone()
import numpy, scipy.ndimage, scipy._lib._array_api
print(scipy._lib._array_api.FunctionDoc.__module__)
print(scipy.ndimage.label.__doc__.split()[0], scipy.ndimage.label(numpy.eye(3))[1])
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines() == [module, "Label 3"]

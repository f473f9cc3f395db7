"""Test bench/gpu.sh: its message without a GPU, and the commands that it gives to a stand-in for Python."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import bench_scenes
import bench_step
import pytest
import torch

pytestmark = pytest.mark.slow

SCRIPT = Path(__file__).parents[2] / "bench" / "gpu.sh"

# Stand-in for Python with a GPU: the check for a GPU succeeds, bench_step prints its line, ``failing`` commands fail.
_ACTOR = """#!/usr/bin/env bash
echo "$*" >>"{log}"
[ "$*" = "-" ] && exit 0
case "$*" in
    *"{failing}"*) exit 3 ;;
    -\\ *) exec "{python}" "$@" ;;
    *bench_step*) echo '{line}' ;;
esac
"""

_ROWS = {"binning": 2.0, "coverage": 3.0, "compositing_adjoint": 1.0, "coverage_adjoint": 4.0, "host": 9.0}
_LINE = json.dumps({"ms": {"cuda:0": {"step": {name: {"min": value} for name, value in _ROWS.items()}}}})


def run(python: str, *arguments: object, path: str = os.environ["PATH"]) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHON": python, "PATH": path}
    command = ["bash", str(SCRIPT), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120)


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    """A folder with a Kodak photo and a stand-in for the program ncu."""
    (tmp_path / "kodak").mkdir()
    (tmp_path / "kodak" / "kodim07.png").touch()
    (tmp_path / "ncu").write_text(f'#!/usr/bin/env bash\necho "ncu $*" >>"{tmp_path / "log"}"\n')
    (tmp_path / "ncu").chmod(0o755)
    return tmp_path


def act(stage: Path, failing: str = "nothing") -> tuple[subprocess.CompletedProcess[str], list[str]]:
    """Run the script with the stand-in for Python; return the result and the commands that the script gave."""
    actor = stage / "actor"
    actor.write_text(_ACTOR.format(log=stage / "log", failing=failing, python=sys.executable, line=_LINE))
    actor.chmod(0o755)
    result = run(str(actor), stage / "kodak", path=f"{stage}:{os.environ['PATH']}")
    return result, (stage / "log").read_text().splitlines()


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a GPU")
def test_without_a_gpu_it_prints_one_line() -> None:
    result = run(sys.executable)
    assert result.returncode == 2 and not result.stdout
    assert result.stderr.startswith("bench/gpu.sh: no GPU to measure: torch") and result.stderr.count("\n") == 1


def test_without_an_interpreter_it_prints_one_line() -> None:
    result = run("/nowhere/python")
    assert result.returncode == 2 and result.stderr.count("\n") == 1 and "/nowhere/python" in result.stderr


def test_all_parts_run_and_the_slowest_kernels_are_counted(stage: Path) -> None:
    result, commands = act(stage)
    assert result.returncode == 0, result.stdout + result.stderr
    kernel_tests, other_tests = [command.split() for command in commands if "-m pytest" in command]
    paths = [word for word in kernel_tests if word.startswith("tests/")]
    assert paths and all((SCRIPT.parents[1] / path).exists() for path in paths)
    assert [word for word in other_tests if word.startswith("--ignore=")] == [f"--ignore={path}" for path in paths]
    assert all("cuda" in command for command in (kernel_tests, other_tests)) and other_tests[-1] == "tests"
    scenes = [command.split("--scene ")[1].split()[0] for command in commands if command.startswith("bench/bench_step")]
    assert scenes == ["kodim07-256", "kodim07-1024", "photo-2040x1344-2048", "wide-4096x4096-4096"]
    assert any("bench_fit.py" in command and "kodim07.png" in command for command in commands)
    (counters,) = [command for command in commands if command.startswith("ncu")]
    assert "regex:.*(integrate_edges|accumulate_winding).*" in counters


@pytest.mark.parametrize(
    ("failing", "name"), [("pytest", "kernel tests on the GPU"), ("wide-4096", "step, wide-4096x4096")]
)
def test_a_failed_part_is_named_and_the_rest_runs(stage: Path, failing: str, name: str) -> None:
    result, commands = act(stage, failing)
    assert result.returncode == 1 and f"failed: {name}" in result.stdout
    assert any("bench_fit" in command for command in commands)


def test_names_in_the_script_exist() -> None:
    text = SCRIPT.read_text()
    assert all(f"step {name} " in text for name in bench_scenes.SCENES)
    for module, name in re.findall(r"from (warpvec[\w.]*) import (\w+)", text):
        assert hasattr(import_module(module), name)
    kernels = "".join(path.read_text() for path in (SCRIPT.parents[1] / "kernels").glob("*.py"))
    stages = {stage.name for stage in bench_step.STAGES["exact"]}
    pairs = re.findall(r'"([\w, ]+)": "(\w+)"', text)
    assert pairs and all(stage in stages and f"def {kernel}(" in kernels for stage, kernel in pairs)


def test_the_help_lists_what_to_run_in_order() -> None:
    result = run("no-python", "--help")
    assert result.returncode == 0 and "#" not in result.stdout
    places = [result.stdout.index(text) for text in ("bench/gpu.sh kodak\n", "bench_fit.py", "interior", "table1")]
    assert places == sorted(places)

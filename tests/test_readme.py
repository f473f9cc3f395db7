"""The examples in the README have the types that they are said to have."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"


@pytest.mark.slow
@pytest.mark.longest_wait(300)
def test_the_examples_in_python_pass_the_strict_checks_of_types(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    examples = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    assert len(examples) >= 2
    names = []
    for number, text in enumerate(examples):
        names.append(f"example_{number}.py")
        (tmp_path / names[-1]).write_text(text)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", f"--cache-dir={tmp_path / 'cache'}"]
    found = subprocess.run(
        [*command, *names],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={"MYPYPATH": str(README.parent)},
        check=False,
    )
    faults = [line for line in found.stdout.splitlines() if line.startswith("example_")]
    assert faults == [] and "example" not in found.stderr, found.stdout[-2000:]

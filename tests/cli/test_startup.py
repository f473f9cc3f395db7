"""A run must not take time for what it does not use: modules, and searches for garbage among modules."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import torch
from commands import QUICK, write_photo
from PIL import Image

from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene
from warpvec.rendering.operator import draw, draw_adjoint, render

FIT = """
import sys
import numpy as np
from warpvec import vectorize
noise = np.random.default_rng(0).random((16, 16, 3), dtype=np.float32)
result = vectorize(noise, curves=4, initial_curves=2, iterations=6, inflation_gap=1, renderer={renderer!r})
assert result.metrics["curves"] == 4
print("torch._dynamo" in sys.modules)
"""


@pytest.mark.slow
@pytest.mark.parametrize("renderer", ["exact", "splat"])
def test_a_run_does_not_import_the_compiler(renderer: str) -> None:
    assert _last_line(FIT.format(renderer=renderer)) == "False"


COMMAND = """
import atexit, gc, sys
is_enabled = []
gc.callbacks.append(lambda phase, info: is_enabled.append("torch" in sys.modules))
atexit.register(lambda: print(gc.get_freeze_count(), "scipy" in sys.modules, any(is_enabled)))
from warpvec.__main__ import main
sys.argv = {arguments!r}
main()
"""


@pytest.mark.slow
def test_a_command_on_a_photo_loads_no_scipy_and_leaves_the_modules_out_of_searches(tmp_path: Path) -> None:
    photo = write_photo(tmp_path)
    # Without the mode, SciPy measures what has happened to the picture.
    arguments = ["warpvec", "run", str(photo), str(tmp_path / "out.svg"), *QUICK, "--mode", "photo"]
    frozen, has_scipy, has_searched = _last_line(COMMAND.format(arguments=arguments)).split()
    assert int(frozen) > 100_000
    assert has_scipy == "False"
    assert has_searched == "True"  # again, once the modules are loaded


POSTPONED = """
import atexit, sys
from warpvec.cli.postponed import POSTPONED
atexit.register(lambda: print([name for name in POSTPONED if type(sys.modules.get(name)) is type(sys)]))
from warpvec.__main__ import main
sys.argv = {arguments!r}
main()
"""


@pytest.mark.slow
def test_a_command_on_a_drawing_leaves_parts_of_torch_unloaded(tmp_path: Path) -> None:
    drawing = Image.new("RGB", (48, 32), "white")
    drawing.paste((200, 20, 20), (8, 8, 30, 20))
    drawing.save(tmp_path / "in.png")
    arguments = ["warpvec", "run", str(tmp_path / "in.png"), str(tmp_path / "out.svg"), "-q", "--mode", "flat"]
    assert _last_line(POSTPONED.format(arguments=arguments)) == "[]"


def _last_line(code: str) -> str:
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return run.stdout.splitlines()[-1]


def test_drawing_without_the_torch_operator_gives_the_same_bits() -> None:
    points = circle_points(torch.tensor([[9.0, 8.0], [14.0, 11.0]]), torch.tensor([6.0, 4.0]), 4).requires_grad_()
    color = torch.tensor([[0.9, 0.2, 0.1], [0.1, 0.3, 0.8]])
    scene = Scene.uniform(points, color, torch.tensor([1.0, 0.6]), torch.ones(3), torch.zeros(2).long())
    adj_image = torch.rand(20, 24, 3)
    image = render(scene, 20, 24)
    image.backward(adj_image)
    assert torch.equal(draw(scene, 20, 24), image)
    assert not draw(scene, 20, 24).requires_grad
    assert torch.equal(draw_adjoint(scene, adj_image).segments.view_as(points), points.grad)

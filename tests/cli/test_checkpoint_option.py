"""``warpvec run --checkpoint`` and ``--resume``: killed processes continue, and contradictions are refused."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from children import limit, start
from commands import assert_refused, invoke
from PIL import Image

from warpvec.fit.checkpoint import read_checkpoint, write_checkpoint

SETTINGS = ["--curves", "40", "--initial-curves", "8", "--inflation-gap", "20", "--device", "cpu"]
LONGER = [*SETTINGS, "--iterations", "600", "--colors", "12", "--recycle-gap", "10"]
QUICK = [*SETTINGS, "--iterations", "12", "--every", "5", "-q"]


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """Write smooth noise, 64 x 48."""
    noise = np.random.default_rng(5).integers(0, 256, (6, 8, 3), dtype=np.uint8)
    Image.fromarray(noise).resize((64, 48)).save(tmp_path / "photo.png")
    return tmp_path / "photo.png"


def _start(*arguments: object) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "warpvec", "run", *(str(argument) for argument in arguments)]
    return start(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def _wait_for(process: subprocess.Popen[bytes], state: Path, iteration: int) -> None:
    while not state.exists() or read_checkpoint(state).state["iteration"] < iteration:
        assert process.poll() is None, process.communicate()
        time.sleep(0.03)


@pytest.mark.slow
def test_a_killed_run_is_resumed_to_the_same_bytes(photo: Path) -> None:
    whole, out, state = (photo.with_name(name) for name in ("whole.svg", "out.svg", "state"))
    assert invoke("run", photo, whole, "-q", *LONGER).exit_code == 0
    generator = random.Random(os.getpid())  # another iteration in each run of the test
    for _ in range(10):  # on a busy machine a run may be over before it is killed
        process = _start(photo, out, "-q", *LONGER, "--checkpoint", state, "--every", "5")
        _wait_for(process, state, generator.randint(1, 300))
        process.kill()
        process.communicate()
        if process.returncode == -signal.SIGKILL and not out.exists():
            break
        out.unlink(missing_ok=True)
        state.unlink()
    assert process.returncode == -signal.SIGKILL
    assert not out.exists()
    reached = read_checkpoint(state).state["iteration"]
    assert 0 < reached < 600 and reached % 5 == 0
    result = invoke("run", photo, out, "-q", "--resume", state, "--checkpoint", state)
    assert result.exit_code == 0, result.output
    assert out.read_bytes() == whole.read_bytes(), f"resumed after iteration {reached}"


@pytest.mark.slow
def test_an_interrupted_run_is_resumed_to_the_same_bytes(photo: Path) -> None:
    whole, out, state = (photo.with_name(name) for name in ("whole.svg", "out.svg", "state"))
    assert invoke("run", photo, whole, "-q", *LONGER).exit_code == 0
    process = _start(photo, out, "-q", *LONGER, "--checkpoint", state, "--every", "7")
    _wait_for(process, state, 1)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=limit())
    assert process.returncode == 130
    assert out.read_bytes() != whole.read_bytes()
    assert invoke("run", photo, out, "-q", "--resume", state).exit_code == 0
    assert out.read_bytes() == whole.read_bytes()


@pytest.fixture
def state(photo: Path) -> Path:
    path = photo.with_name("state")
    assert invoke("run", photo, photo.with_name("whole.svg"), *QUICK, "--checkpoint", path).exit_code == 0
    return path


def test_a_resumed_run_reports_the_whole_fit(photo: Path, state: Path) -> None:
    result = invoke("run", photo, photo.with_name("out.svg"), "--resume", state, "--every", "5")
    assert "12 iterations in" in result.stdout
    assert result.stderr.splitlines()[0].startswith("iteration 11 of 12, ")


@pytest.mark.parametrize(
    "options",
    [
        ["--curves", "40"],
        ["--threads", "1"],
        ["--device", "cpu", "--iterations", "12"],
        ["--preset", "default"],
    ],
)
def test_equal_settings_and_machine_settings_may_be_given(photo: Path, state: Path, options: list[str]) -> None:
    out = photo.with_name("out.svg")
    result = invoke("run", photo, out, "-q", "--resume", state, *options)
    assert result.exit_code == 0, result.output
    assert out.read_bytes() == photo.with_name("whole.svg").read_bytes()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--curves", "41"], ["--curves must be as in the checkpoint, 40, got 41; leave it out"]),
        (["--iterations", "13"], ["--iterations must be as in the checkpoint"]),
        (["--opaque"], ["--opacity must be as in the checkpoint, 'free'"]),
        (["--colors", "4"], ["--colors must be as in the checkpoint, 0, got 4"]),
        (["--one-generation"], ["--one-generation must be as in the checkpoint, False"]),
        (["--preset", "draft"], ["--iterations must be as in the checkpoint, 12, got 400"]),
        (
            ["--max-bytes", "9k"],
            ["--resume cannot be combined with --max-bytes, --target-psnr, --target-ssim or curves auto"],
        ),
        (
            ["--curves", "auto"],
            ["--resume cannot be combined with --max-bytes, --target-psnr, --target-ssim or curves auto"],
        ),
        (["--background", "#fff", "--curves", "0"], ["--curves must be"]),
        (["--checkpoint", "missing/state"], ["--checkpoint must be in an existing folder"]),
    ],
)
def test_settings_that_contradict_the_checkpoint_are_refused(
    photo: Path, state: Path, options: list[str], words: list[str]
) -> None:
    out = photo.with_name("out.svg")
    assert_refused(invoke("run", photo, out, "--resume", state, *options), *words)
    assert not out.exists()


def test_another_photo_and_damaged_files_are_refused(photo: Path, state: Path) -> None:
    out, data = photo.with_name("out.svg"), state.read_bytes()
    with Image.open(photo) as image:
        image.rotate(180).save(photo.with_name("other.png"))
    result = invoke("run", photo.with_name("other.png"), out, "--resume", state, "-q")
    assert_refused(result, "IN must be the photo of the checkpoint")
    for damaged in (data[:-30], b"", b"no zip", data[:50] + bytes(50) + data[100:]):
        state.write_bytes(damaged)
        result = invoke("run", photo, out, "--resume", state)
        assert_refused(result, "--resume must be a checkpoint of warpvec", str(state), "check the path, or start again")
    assert_refused(invoke("run", photo, out, "--resume", photo.with_name("none")), "--resume must be a file", "none")
    assert not out.exists()


def test_a_state_that_would_end_in_foreign_memory_is_refused(photo: Path, state: Path) -> None:
    out, checkpoint = photo.with_name("out.svg"), read_checkpoint(state)
    population = checkpoint.state["population"]
    damaged = {**checkpoint.state, "population": {**population, "age": population["age"][:0]}}
    write_checkpoint(state, replace(checkpoint, state=damaged))
    result = invoke("run", photo, out, "--resume", state)
    assert_refused(
        result, "--resume must hold a whole fit", "population.age", "it is damaged", "start again without it"
    )
    assert not out.exists()


def test_a_goal_with_a_new_checkpoint_is_refused(photo: Path) -> None:
    result = invoke(
        "run", photo, photo.with_name("out.svg"), "--checkpoint", photo.with_name("s"), "--target-psnr", "9"
    )
    assert_refused(result, "--checkpoint cannot be combined with --max-bytes")
    assert not photo.with_name("s").exists()

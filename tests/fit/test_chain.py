"""Chains of a fit: one graph serves whole stretches of it, and gives the same paths as steps by themselves.

A fit on a GPU has chains. Here the CPU has them too, with the kernels of a GPU on one thread.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest
import torch
import warp as wp
from short_fits import small_photo
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode

from warpvec.config.presets import make_config
from warpvec.fit import clock, loop, record, target
from warpvec.fit.arena import Arena
from warpvec.fit.chain import Chain
from warpvec.fit.loop import fit
from warpvec.fit.places import Places
from warpvec.modes.precompile import compile_kernels
from warpvec.rendering import graph, launch
from warpvec.rendering.graph import RecordedStep
from warpvec.rendering.stages import binning, flattening

READS = ("_local_scalar_dense", "nonzero")
"""Operations of torch for which the host waits for a GPU."""


class Counts(Counter[str]):
    """What a fit does: graphs recorded and replayed, launches by the host, and reads.

    Those in chains, and in the changes between them that need no look of the host, are also counted apart.
    """

    chains = longest = 0

    def count(self, name: str, act: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*args: Any, **kwargs: Any) -> Any:
            self[name] += 1
            if self.chains:
                self[f"{name} in chains"] += 1
            return act(*args, **kwargs)

        return counted

    def chained(self, run: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*args: Any) -> Any:
            self.chains += 1
            if isinstance(args[0], Chain):
                self.longest = max(self.longest, args[2])
            try:
                return run(*args)
            finally:
                self.chains -= 1

        return counted


class Reads(TorchDispatchMode):
    """Counts the reads of torch."""

    def __init__(self, counts: Counts) -> None:
        super().__init__()
        self._counts = counts

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        act = self._counts.count("reads", func) if any(name in str(func) for name in READS) else func
        return act(*args, **(kwargs or {}))


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> Counts:
    """Count what fits do, which can have chains."""
    found, make = Counts(), target.make_renderer
    monkeypatch.setattr(target, "make_renderer", lambda **given: make(**{**given, "lane_width": 1, "threads": 1}))
    monkeypatch.setattr(graph, "_can_record", lambda device: True)
    for stage in (binning, flattening):
        monkeypatch.setattr(stage, "read_total", found.count("count reads", stage.read_total))
    monkeypatch.setattr(wp, "capture_launch", found.count("replays", wp.capture_launch))
    for owner, method, name in ((RecordedStep, "_captured", "graphs"), (launch._Command, "run", "launches")):
        monkeypatch.setattr(owner, method, found.count(name, getattr(owner, method)))
    monkeypatch.setattr(record, "_HISTORY_GAP", record._HISTORY_GAP_CUDA)
    monkeypatch.setattr(clock, "LOOK_SECONDS", 1e9)  # a busy machine would shorten chains
    monkeypatch.setattr(Arena, "__init__", found.count("arenas", Arena.__init__))
    # What changes the paths of an arena may not read anything either.
    for owner, method in ((Chain, "run"), (Arena, "drop"), (Arena, "add"), (Places, "_drawn")):
        monkeypatch.setattr(owner, method, found.chained(getattr(owner, method)))
    monkeypatch.setattr(Arena, "drop", found.count("drops", Arena.drop))
    return found


def values_of(result: Any) -> list[Tensor]:
    scene = result.scene
    return [scene.segments, scene.color, scene.opacity, scene.background, scene.generation]


def test_a_chained_fit_ends_with_the_same_bits(counts: Counts, monkeypatch: pytest.MonkeyPatch) -> None:
    config = make_config(curves=40, iterations=150, device="cpu")
    got = fit(small_photo(), config)
    assert counts["replays"] > 100
    monkeypatch.setattr(loop, "can_chain", lambda *args: False)
    counts.clear()
    want = fit(small_photo(), config)
    assert counts["graphs"] > 2
    assert all(map(torch.equal, values_of(got), values_of(want)))
    assert [entry["psnr"] for entry in got.history] == [entry["psnr"] for entry in want.history]


@pytest.mark.parametrize(("curves", "iterations"), [(40, 500), pytest.param(128, 2000, marks=pytest.mark.slow)])
def test_a_fit_records_hardly_any_graph_and_chains_read_nothing(curves: int, iterations: int, counts: Counts) -> None:
    """There are inflations, recyclings and exchanges of nodes."""
    with Reads(counts):
        fit(small_photo(), make_config(curves=curves, iterations=iterations, device="cpu"))
    assert counts["graphs"] <= 5 and counts["arenas"] == 1
    assert counts["replays in chains"] > 0.9 * iterations
    assert counts["drops"] > 0.5 * iterations / 25  # recyclings by kernels
    assert counts["reads in chains"] == 0
    assert counts["count reads in chains"] == 0
    # Recyclings and shifts for SSIM replay graphs of their own: of removal costs, and of a picture.
    assert counts["replays"] >= counts["replays in chains"] + 1.2 * iterations / 25


@pytest.mark.parametrize(
    "settings",
    [
        {"preset": "paper", "samples": 8, "lines": 3},
        {"preset": "paper-released", "samples": 8, "lines": 3},
        {"renderer": "splat", "samples": 8, "lines": 3},
    ],
)
def test_fits_of_gaussians_have_chains_too(
    settings: dict[str, Any], counts: Counts, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The preset looks at the paths before each of its inflations, by which a chain must have ended."""
    config = make_config(**{"curves": 24, "iterations": 80, "inflation_gap": 25, "device": "cpu", **settings})
    with Reads(counts):
        got = fit(small_photo(), config)
    assert counts["graphs"] <= 5 and counts["replays in chains"] > 0.9 * 80 - 20
    assert counts.longest >= (25 if "preset" in settings else 23)  # recycled paths need a step with removal costs
    assert counts["reads in chains"] == counts["count reads in chains"] == 0
    monkeypatch.setattr(loop, "can_chain", lambda *args: False)
    want = fit(small_photo(), config)
    assert all(map(torch.equal, values_of(got), values_of(want)))


def test_more_paths_than_there_is_room_for_get_a_larger_arena(counts: Counts) -> None:
    """A drawing to begin with may have more segments a path than the settings."""
    start = fit(small_photo(), make_config(curves=12, segments=9, iterations=40, device="cpu")).scene
    counts.clear()
    result = fit(small_photo(), make_config(curves=12, iterations=60, device="cpu"), start=start)
    assert result.scene.structure.segment_count > 60
    assert counts["arenas"] >= 1 and result.scene.segments.isfinite().all()


@pytest.mark.slow
def test_what_a_fit_on_a_gpu_runs_is_compiled_before(counts: Counts, monkeypatch: pytest.MonkeyPatch) -> None:
    """`warpvec info --compile` leaves nothing to compile for the kernels of a chain and of what lies between chains."""
    loaded, load = set[str](), wp.Module.load
    monkeypatch.setattr(wp.Module, "load", lambda module, *args: (loaded.add(module.name), load(module, *args))[1])
    compile_kernels("cpu")
    compiled = set(loaded)
    loaded.clear()
    fit(small_photo(), make_config(curves=40, iterations=150, device="cpu"))
    assert any("recycling" in name for name in loaded) and any("places" in name for name in loaded)
    assert loaded <= compiled

"""The fit on small pictures: populations, reproducibility, interrupts, time budgets, and presets."""

import json

import pytest
import torch
from finished_fits import final_psnr, rendered_psnr, run
from pictures import picture

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit import record
from warpvec.fit.checkpoint import MAX_HEADER
from warpvec.fit.loop import fit
from warpvec.fit.population import Population
from warpvec.fit.schedule import population
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene


def test_population_follows_the_schedule():
    counts = []
    config = FitConfig(curves=100, initial_curves=16, growth=2.0, inflation_gap=10, prune_opacity=0.0)
    run(lambda progress: counts.append(progress.curve_count), curves=100, iterations=80, inflation_gap=10)
    for k in range(4):
        assert set(counts[10 * k : 10 * (k + 1)]) == {population(k, config)}, k
    assert counts[-1] == 100
    assert len(counts) == 80


def test_pruned_paths_are_compensated():
    # Every path is below this opacity at each inflation, so all are replaced each time.
    counts = []
    result = run(lambda progress: counts.append(progress.curve_count), prune_opacity=1.0, recycle_gap=0)
    assert counts[-1] == 48
    assert (result.scene.generation == result.scene.generation.max()).all()


def test_without_compensation_pruned_paths_are_gone():
    counts = []
    run(lambda progress: counts.append(progress.curve_count), prune_opacity=1.0, compensate=False, recycle_gap=0)
    # Each inflation prunes all paths, and the last one adds 16.
    assert counts[-1] == 16


def test_new_generations_are_on_top():
    generation = run().scene.generation
    assert (generation.diff() >= 0).all()
    assert generation[0] == 0


def test_one_generation_starts_with_all_paths():
    counts = []
    result = run(lambda progress: counts.append(progress.curve_count), one_generation=True, recycle_gap=0)
    assert set(counts) == {48}
    assert (result.scene.generation == 0).all()


def test_area_order_puts_small_boxes_on_top():
    scene = run(z_order="area", recycle_gap=0).scene
    box = path_boxes(scene)
    size = (box[:, 2:] - box[:, :2]).prod(-1)
    # The last step moves points after the last sort.
    assert (size.diff() <= 0.1 * size[:-1]).all()


def test_area_order_uses_the_curves_not_their_control_points():
    # A handle of the first path lies far outside, but its curve is smaller than the second's.
    points = circle_points(torch.full((2, 2), 20.0), torch.tensor([6.0, 10.0]), 4)
    points[0, 1] += torch.tensor([14.0, 14.0])
    color = torch.full((2, 3), 0.5)
    scene = Scene.uniform(points, color, torch.ones(2), torch.ones(3), torch.arange(2))
    population = Population(scene, FitConfig(), 20.0)
    population.sort_by_area()
    assert population.live.generation.tolist() == [1, 0]
    assert population.serial.tolist() == [1, 0]
    population.append(scene)
    assert population.serial.tolist() == [1, 0, 2, 3]


@pytest.mark.parametrize("color_parameter", ["direct", "logit"])
def test_a_white_backdrop_stays_white(color_parameter):
    seen = []
    scene = run(
        lambda progress: seen.append(progress.scene().background), backdrop="white", color_parameter=color_parameter
    ).scene
    assert all(torch.equal(background, torch.ones(3)) for background in [*seen, scene.background])
    learned = run(color_parameter=color_parameter).scene.background
    assert not torch.equal(learned, picture().mean((0, 1)))


def test_fit_improves_and_recycling_improves_it():
    kept = run(iterations=150, recycle_gap=0)
    recycled = run(iterations=150, recycle_gap=10, recycle_share=0.15)
    assert final_psnr(kept) > 22.0
    assert final_psnr(recycled) > final_psnr(kept) + 0.5


@pytest.mark.parametrize("preset", ["draft", "default", "best"])
def test_every_preset_fits(preset):
    config = make_config(preset, curves=32, iterations=40, threads=1)
    result = fit(picture(), config)
    assert final_psnr(result) > 15.0
    assert result.scene.segments.isfinite().all()


@pytest.mark.parametrize("threads", [2, 3])
def test_result_does_not_depend_on_threads(threads):
    one, many = run(threads=1).scene, run(threads=threads).scene
    for name in ("segments", "color", "opacity", "background", "generation"):
        assert torch.equal(getattr(one, name), getattr(many, name)), name


def test_seed_decides():
    assert torch.equal(run(seed=1).scene.segments, run(seed=1).scene.segments)
    assert not torch.equal(run(seed=1).scene.segments, run(seed=2).scene.segments)


def test_torch_threads_are_given_back():
    before = torch.get_num_threads()
    run(iterations=2)
    assert torch.get_num_threads() == before


def test_last_iteration_adds_no_paths():
    # A recycling is due at the last iteration, but its paths would never be fitted.
    result = run(iterations=60, recycle_gap=4, recycle_until=1.0)
    assert final_psnr(result) == pytest.approx(rendered_psnr(result.scene), abs=0.5)


def test_interruption_gives_the_best_so_far():
    def interrupt(progress):
        if progress.iteration == 31:
            raise KeyboardInterrupt

    result = run(interrupt)
    assert result.interrupted
    assert result.iterations == 31
    assert rendered_psnr(result.scene) > 12.0


def test_interruption_after_a_recycling_gives_the_scene_before_it():
    psnr = {}

    def interrupt(progress):
        psnr[progress.iteration] = progress.psnr
        if progress.iteration == 93:
            raise KeyboardInterrupt

    # All paths are there after iteration 16; 76 iterations later all are replaced, which makes the picture worse.
    result = run(interrupt, iterations=200, recycle_gap=76, recycle_share=1.0)
    assert psnr[93] < psnr[92] - 1.0
    assert rendered_psnr(result.scene) > psnr[92] - 0.1


def test_time_budget_ends_the_fit():
    result = run(iterations=10**6, time_budget=1.0)
    assert 1 <= result.iterations < 10**5  # a million take an hour
    assert len(result.scene) == 48


def test_progress_reports_every_iteration():
    seen = []
    run(lambda progress: seen.append((progress, len(progress.scene()))), iterations=12, inflation_gap=5)
    assert [progress.iteration for progress, _ in seen] == list(range(1, 13))
    assert all(progress.iteration_count == 12 for progress, _ in seen)
    assert all(progress.curve_count == count for progress, count in seen[:5])
    assert seen[-1][0].psnr > seen[0][0].psnr


def test_a_kept_scene_does_not_change():
    kept = []

    def keep(progress):
        if progress.iteration == 5:
            scene = progress.scene()
            kept.extend([scene, scene.segments.clone(), scene.color.clone(), scene.background.clone()])

    run(keep, iterations=20)
    scene, points, color, background = kept
    assert torch.equal(scene.segments, points)
    assert torch.equal(scene.color, color)
    assert torch.equal(scene.background, background)


def test_time_budget_does_not_add_iterations():
    assert run(iterations=15, time_budget=60.0).iterations == 15


def test_fit_on_every_device(device):
    result = run(device=device, iterations=100)
    assert final_psnr(result) > 20.0
    assert result.device.startswith(device)


def test_history_ends_with_the_last_iteration():
    result = run(iterations=33)
    assert [entry["iteration"] for entry in result.history] == [10, 20, 30, 33]


def test_history_of_a_long_fit_keeps_fewer_iterations(monkeypatch):
    monkeypatch.setattr(record, "HISTORY_MAX", 4)
    whole = run(iterations=33, lr_scale=0.5)
    monkeypatch.setattr(record, "HISTORY_MAX", 3)
    thinned = run(iterations=33, lr_scale=0.5)
    assert [entry["iteration"] for entry in whole.history] == [10, 20, 30, 33]
    assert [entry["iteration"] for entry in thinned.history] == [20, 33]
    assert torch.equal(whole.scene.segments, thinned.scene.segments)


def test_a_history_of_the_most_entries_fits_into_a_checkpoint():
    entry = {"iteration": 10**9, "curves": 2**16, "psnr": 30.123456789012345, "seconds": 1000000.1234567891}
    assert len(json.dumps([entry] * record.HISTORY_MAX)) < 0.8 * MAX_HEADER


@pytest.mark.parametrize("size", [(1, 1), (1, 30), (30, 1), (17, 16)])
def test_tiny_pictures(size):
    result = fit(torch.full((*size, 3), 0.25), make_config(curves=20, iterations=20, threads=1))
    assert result.scene.segments.isfinite().all()
    assert final_psnr(result) > 30.0


def test_unknown_device():
    with pytest.raises(InputError, match="device must be auto or one of"):
        run(device="tpu")

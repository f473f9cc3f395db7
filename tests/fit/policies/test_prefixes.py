"""Levels of detail that are each a picture: prefixes, their adjoints, and recyclings within a generation."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from pictures import picture
from skimage import data

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.loop import fit
from warpvec.fit.policies.prefixes import (
    PREFIX_WEIGHT,
    TURN_GROWTH,
    PrefixScaffolding,
    generation_at_turn,
    prefix_length,
    with_prefix,
)
from warpvec.fit.population import Population
from warpvec.fit.schedule import population
from warpvec.fit.target import Target
from warpvec.image.metrics import psnr_from_mse
from warpvec.image.picture import reduce_image

SETTINGS = {"curves": 64, "iterations": 300, "inflation_gap": 20, "threads": 1, "prune_opacity": 0.0}


def prefix_psnrs(result, image):
    """Return the number of paths and the PSNR of each prefix."""
    target = Target(image, FitConfig(threads=1), "cpu")
    found = {}
    for generation in sorted(set(result.scene.generation.tolist())):
        part = result.scene.select(result.scene.generation <= generation)
        found[len(part)] = psnr_from_mse(float(target.squared_error(part).mean() / 3))
    return found


def test_levels_have_the_counts_of_the_schedule_after_many_recyclings():
    config = make_config("default", **SETTINGS, lod=True, recycle_gap=5)
    result = fit(picture(), config)
    assert list(prefix_psnrs(result, picture())) == [population(k, config) for k in range(3)]
    generation = result.scene.generation
    assert (generation[1:] >= generation[:-1]).all()


@pytest.mark.slow
def test_each_prefix_is_nearly_as_good_as_a_fit_of_its_own():
    photo = torch.from_numpy(reduce_image(data.coffee() / np.float32(255), 96))
    leveled = prefix_psnrs(fit(photo, make_config("default", **SETTINGS, lod=True)), photo)
    plain = prefix_psnrs(fit(photo, make_config("default", **SETTINGS)), photo)
    for count in (16, 32):
        own = fit(photo, make_config("default", **{**SETTINGS, "curves": count})).history[-1]["psnr"]
        assert leveled[count] > own - 2.5, count  # two seeds: 0.4 to 2.1 dB below
    # A fit without this option leaves far less below its last generation.
    assert max(psnr for count, psnr in plain.items() if count <= 32) < leveled[32] - 1.0


def test_adjoints_are_those_of_the_sum_of_both_errors():
    scene = fit(picture(), make_config("default", **{**SETTINGS, "iterations": 60})).scene
    target = Target(picture(), FitConfig(threads=1), "cpu")
    generations = sorted(set(scene.generation.tolist()))
    assert len(generations) > 2
    counts = Population(scene, FitConfig(), 28.0).prefix_counts
    for turn in range(2 * len(generations)):
        part = scene.select(scene.generation <= generations[generation_at_turn(turn, len(generations) - 1)])
        own = {name: getattr(target.fit_step(part, False), name).clone() for name in ("segments", "color", "opacity")}
        whole = {name: getattr(target.fit_step(scene, False), name).clone() for name in own}
        count = prefix_length(counts, turn)
        assert count == len(part)
        both = with_prefix(target.fit_step(scene, False), scene, target, count)
        for name, adj in own.items():
            expected = whole[name].clone()
            expected[: len(adj)] += PREFIX_WEIGHT * adj
            torch.testing.assert_close(getattr(both, name), expected, rtol=0, atol=0)
    assert float(both.loss) == float(target.fit_step(scene, False).loss)


def test_higher_generations_have_more_turns():
    counts = torch.tensor([generation_at_turn(turn, 6) for turn in range(2000)]).bincount(minlength=6)
    torch.testing.assert_close(counts[1:] / counts[:-1], torch.full((5,), TURN_GROWTH), rtol=0.05, atol=0)
    assert generation_at_turn(7, 1) == 0


def test_a_single_generation_has_no_prefix():
    target = Target(picture(), FitConfig(threads=1), "cpu")
    scene = fit(picture(), make_config("default", curves=16, iterations=5, threads=1)).scene
    adjoints = target.fit_step(scene, False)
    assert prefix_length(Population(scene, FitConfig(), 28.0).prefix_counts, 3) == 16
    assert with_prefix(adjoints, scene, target, 16) is adjoints


def test_a_recycling_moves_paths_of_one_generation_only():
    config = make_config("default", **{**SETTINGS, "recycle_gap": 0, "recycle_share": 0.25}, lod=True)
    scene = fit(picture(), config).scene
    target = Target(picture(), config, "cpu")
    policy = PrefixScaffolding(picture(), config, 0, target)
    paths = Population(scene, config, 28.0)
    for turn in range(6):
        before = paths.scene
        policy._recycle(paths, torch.zeros(len(paths)), target.squared_error)
        assert paths.scene.generation.tolist() == before.generation.tolist()
        changed = (paths.scene.points != before.points).any(-1).any(-1)
        assert set(before.generation[changed].tolist()) == {generation_at_turn(turn, 3)}


def test_a_recycling_takes_unwanted_paths_first():
    config = make_config("default", **{**SETTINGS, "recycle_gap": 0, "recycle_share": 0.25}, lod=True)
    scene = fit(picture(), config).scene
    target = Target(picture(), config, "cpu")
    for turn in range(3):
        policy = PrefixScaffolding(picture(), config, 0, target)
        policy._turn = turn
        paths = Population(scene, config, 28.0)
        level = generation_at_turn(turn, 3)
        rows = (scene.generation == level).nonzero().flatten()
        count = int(len(rows) * 0.25)
        # Mark those with the highest removal cost as unwanted.
        cost = target.fit_step(scene.select(scene.generation <= level), True).removal_cost[rows]
        unwanted = rows[cost.topk(count).indices]
        removal_cost = torch.zeros(len(scene))
        removal_cost[unwanted] = -torch.inf
        before = paths.serial.clone()
        policy._recycle(paths, removal_cost, target.squared_error)
        assert set(before.tolist()) - set(paths.serial.tolist()) == set(before[unwanted].tolist())


def test_counts_of_prefixes_are_read_once_per_change_of_population(monkeypatch):
    scene = fit(picture(), make_config("default", curves=6, iterations=1, threads=1)).scene
    paths = Population(replace(scene, generation=torch.tensor([0, 0, 1, 1, 1, 4])), FitConfig(), 28.0)
    reads = []
    to_list = torch.Tensor.tolist
    monkeypatch.setattr(torch.Tensor, "tolist", lambda self: reads.append(self) or to_list(self))
    for _ in range(3):
        assert paths.prefix_counts == [2, 5, 6]
    assert len(reads) == 1
    paths.keep(torch.tensor([0, 2, 3, 5]))
    assert paths.prefix_counts == [1, 3, 4]
    assert paths.prefix_counts == [1, 3, 4]
    assert len(reads) == 2


def test_levels_need_an_order_by_creation():
    with pytest.raises(InputError, match="lod needs policy scaffolding and z_order creation"):
        make_config("default", lod=True, z_order="area")

"""Levels of detail that are each fitted as a picture: prefixes, their adjoints, and recyclings within a level."""

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
    _prefix_counts,
    _whose_turn,
    with_prefix,
)
from warpvec.fit.population import Population
from warpvec.fit.schedule import population
from warpvec.fit.target import Target
from warpvec.image.metrics import psnr_from_mse
from warpvec.image.resize import reduce_image

SETTINGS = {"curves": 64, "iterations": 300, "inflation_gap": 20, "threads": 1, "prune_opacity": 0.0}


def prefix_psnrs(result, target):
    """Paths and PSNR of each prefix of the generations."""
    canvas = Target(target, FitConfig(threads=1), "cpu")
    found = {}
    for generation in sorted(set(result.scene.generation.tolist())):
        part = result.scene.select(result.scene.generation <= generation)
        found[len(part)] = psnr_from_mse(float(canvas.squared_error(part).mean() / 3))
    return found


def test_levels_have_the_counts_of_the_schedule_after_many_recyclings():
    config = make_config("default", **SETTINGS, lod=True, recycle_gap=5)
    result = fit(picture(), config)
    assert list(prefix_psnrs(result, picture())) == [population(k, config) for k in range(3)]
    generation = result.scene.generation
    assert (generation[1:] >= generation[:-1]).all()


def test_each_prefix_is_nearly_as_good_as_a_fit_of_its_own():
    photo = torch.from_numpy(reduce_image(data.coffee() / np.float32(255), 96))
    leveled = prefix_psnrs(fit(photo, make_config("default", **SETTINGS, lod=True)), photo)
    plain = prefix_psnrs(fit(photo, make_config("default", **SETTINGS)), photo)
    for count in (16, 32, 64):
        own = fit(photo, make_config("default", **{**SETTINGS, "curves": count})).history[-1]["psnr"]
        assert leveled[count] > own - 1.5, count
    # What a fit without levels leaves below its last generation is far from that.
    assert max(psnr for count, psnr in plain.items() if count <= 32) < leveled[32] - 1.0


def test_adjoints_are_those_of_the_sum_of_both_errors():
    scene = fit(picture(), make_config("default", **{**SETTINGS, "iterations": 60})).scene
    canvas = Target(picture(), FitConfig(threads=1), "cpu")
    generations = sorted(set(scene.generation.tolist()))
    assert len(generations) > 2
    for turn in range(2 * len(generations)):
        part = scene.select(scene.generation <= generations[_whose_turn(turn, len(generations) - 1)])
        own = {name: getattr(canvas.fit_step(part, False), name).clone() for name in ("points", "color", "opacity")}
        whole = {name: getattr(canvas.fit_step(scene, False), name).clone() for name in own}
        both = with_prefix(canvas.fit_step(scene, False), scene, canvas, turn)
        for name, adj in own.items():
            expected = whole[name].clone()
            expected[: len(part)] += PREFIX_WEIGHT * adj
            torch.testing.assert_close(getattr(both, name), expected, rtol=0, atol=0)
    assert float(both.loss) == float(canvas.fit_step(scene, False).loss)


def test_each_generation_has_so_many_turns_for_each_of_the_one_below():
    counts = torch.tensor([_whose_turn(turn, 6) for turn in range(2000)]).bincount(minlength=6)
    torch.testing.assert_close(counts[1:] / counts[:-1], torch.full((5,), TURN_GROWTH), rtol=0.05, atol=0)
    assert _whose_turn(7, 1) == 0


def test_one_generation_is_left_alone():
    canvas = Target(picture(), FitConfig(threads=1), "cpu")
    scene = fit(picture(), make_config("default", curves=16, iterations=5, threads=1)).scene
    adjoints = canvas.fit_step(scene, False)
    assert with_prefix(adjoints, scene, canvas, 3) is adjoints


def test_a_recycling_moves_paths_of_one_generation_only():
    config = make_config("default", **{**SETTINGS, "recycle_gap": 0, "recycle_share": 0.25}, lod=True)
    scene = fit(picture(), config).scene
    canvas = Target(picture(), config, "cpu")
    policy = PrefixScaffolding(picture(), config, 0, canvas)
    people = Population(scene, config, 28.0)
    for turn in range(6):
        before = people.scene
        policy._recycle(people, torch.zeros(len(people)), canvas.squared_error)
        assert people.scene.generation.tolist() == before.generation.tolist()
        changed = (people.scene.points != before.points).any(-1).any(-1)
        assert set(before.generation[changed].tolist()) == {_whose_turn(turn, 3)}


def test_a_recycling_takes_what_is_not_wanted_first():
    config = make_config("default", **{**SETTINGS, "recycle_gap": 0, "recycle_share": 0.25}, lod=True)
    scene = fit(picture(), config).scene
    canvas = Target(picture(), config, "cpu")
    for turn in range(3):
        policy = PrefixScaffolding(picture(), config, 0, canvas)
        policy._turn = turn
        people = Population(scene, config, 28.0)
        level = _whose_turn(turn, 3)
        rows = (scene.generation == level).nonzero().flatten()
        count = int(len(rows) * 0.25)
        # Those that are missed most.
        cost = canvas.fit_step(scene.select(scene.generation <= level), True).removal_cost[rows]
        unwanted = rows[cost.topk(count).indices]
        removal_cost = torch.zeros(len(scene))
        removal_cost[unwanted] = -torch.inf
        before = people.serial.clone()
        policy._recycle(people, removal_cost, canvas.squared_error)
        assert set(before.tolist()) - set(people.serial.tolist()) == set(before[unwanted].tolist())


def test_counts_of_prefixes_are_read_once_for_each_population(monkeypatch):
    reads = []
    to_list = torch.Tensor.tolist
    monkeypatch.setattr(torch.Tensor, "tolist", lambda self: reads.append(self) or to_list(self))
    first, second = torch.tensor([0, 0, 1, 1, 1, 4]), torch.tensor([0, 0, 1, 1, 4, 4])
    for _ in range(3):
        assert _prefix_counts(first) == [2, 5, 6]
    assert len(reads) == 1
    for _ in range(2):
        assert _prefix_counts(second) == [2, 4, 6]
    assert _prefix_counts(first) == [2, 5, 6]
    assert len(reads) == 3


def test_levels_need_an_order_by_creation():
    with pytest.raises(InputError, match="lod must be off without policy scaffolding and z_order creation"):
        make_config("default", lod=True, z_order="area")

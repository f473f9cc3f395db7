"""The population's step against autograd and a torch version of Adan; its scenes and their memory."""

import math
from dataclasses import replace
from itertools import accumulate, pairwise

import pytest
import torch
from compound import compound_scene

from warpvec.config.fit_config import FitConfig
from warpvec.fit.population import Population
from warpvec.geometry.scene import Scene

HALF_SIDE = 40.0
BETAS = (0.98, 0.92, 0.99)
NAMES = ("segments", "color", "opacity", "background")
SETTINGS = [{}, {"color_parameter": "logit"}, {"backdrop": "white"}, {"axis_rates": True}, {"common_age": True}]
HALF_SIDES = (40.0, 25.0)


def random_scene(count, point_count=12, seed=0, dtype=torch.float64):
    generator = torch.Generator().manual_seed(seed)

    def uniform(*shape):
        return torch.rand(shape, generator=generator, dtype=dtype)

    generation = torch.arange(count) + 10 * seed
    points = uniform(count, point_count, 2) * 2 * HALF_SIDE
    return Scene.uniform(points, uniform(count, 3), 0.1 + 0.8 * uniform(count), 0.2 + 0.6 * uniform(3), generation)


def random_adjoints(scene, seed):
    generator = torch.Generator().manual_seed(seed)
    values = (getattr(scene, name) for name in NAMES)
    return [torch.randn(v.shape, generator=generator, dtype=v.dtype).to(v.device) for v in values]


def loop_counts(scene):
    """Return the number of segments of each loop of each path."""
    structure = scene.structure
    counts = structure.loop_first_segment.diff().tolist()
    return [counts[first:end] for first, end in pairwise(structure.path_first_loop.tolist())]


class Reference:
    """The same population in torch: each parameter with m, v, n, the previous gradient and the age of its rows."""

    def __init__(self, scene, config):
        self.config = config
        self.unit = torch.tensor(HALF_SIDES, dtype=torch.float64) if config.axis_rates else HALF_SIDE
        self.white = scene.background if config.backdrop == "white" else None
        self.parameters = {name: self.fresh(value) for name, value in self.raw(scene).items()}
        self.counts = loop_counts(scene)

    def raw(self, scene):
        color = torch.logit if self.config.color_parameter == "logit" else torch.clone
        values = {"segments": scene.segments / self.unit, "color": color(scene.color)}
        return values | {"opacity": scene.opacity.logit(), "background": color(scene.background)[None]}

    def fresh(self, raw):
        return [raw, *(torch.zeros_like(raw) for _ in range(4)), torch.zeros(len(raw), dtype=torch.float64)]

    def shown(self):
        color = torch.sigmoid if self.config.color_parameter == "logit" else torch.clone
        points, colors, opacity, background = (self.parameters[name][0] for name in NAMES)
        background = color(background)[0] if self.white is None else self.white
        return [points * self.unit, color(colors), opacity.sigmoid(), background]

    def step(self, adjoints, factor):
        for state in self.parameters.values():
            state[0] = state[0].detach().requires_grad_()
        values = [(v, adj) for v, adj in zip(self.shown(), adjoints, strict=True) if v.requires_grad]
        torch.autograd.backward(*zip(*values, strict=True))
        rates = (self.config.lr_points, self.config.lr_color, self.config.lr_opacity, self.config.lr_color)
        for name, rate in zip(NAMES, rates, strict=True):
            if name != "background" or self.white is None:
                self.parameters[name] = self.adan(*self.parameters[name], rate * factor)
                if name in ("color", "background") and self.config.color_parameter == "direct":
                    self.parameters[name][0].clamp_(0.0, 1.0)

    def adan(self, param, m, v, n, previous, age, lr):
        b1, b2, b3 = BETAS
        age = age + 1
        k = age.reshape(-1, *(1 for _ in param.shape[1:]))
        g = param.grad
        difference = torch.where(k > 1, g - previous, 0.0)
        m = b1 * m + (1 - b1) * g
        v = b2 * v + (1 - b2) * difference
        n = b3 * n + (1 - b3) * (g + b2 * difference) ** 2
        direction = m / (1 - b1**k) + b2 * v / (1 - b2**k)
        return [param.detach() - lr * direction / ((n / (1 - b3**k)).sqrt() + 1e-8), m, v, n, g, age]

    def keep(self, rows):
        ends = list(accumulate(map(sum, self.counts)))
        segments = [k for row in rows.tolist() for k in range(ends[row] - sum(self.counts[row]), ends[row])]
        self.counts = [self.counts[row] for row in rows.tolist()]
        for name, chosen in (("segments", segments), ("color", rows), ("opacity", rows)):
            self.parameters[name] = [value.detach()[chosen] for value in self.parameters[name]]

    def append(self, scene):
        self.counts += loop_counts(scene)
        for name, raw in self.raw(scene).items():
            if name != "background":
                new = self.fresh(raw)
                if self.config.common_age:
                    new[-1] += self.parameters["background"][-1]
                pairs = zip(self.parameters[name], new, strict=True)
                self.parameters[name] = [torch.cat([old.detach(), new]) for old, new in pairs]


def made_both(scene, config, device):
    """Return the paths as a population and as the reference."""
    return Population(scene.to(device), config, HALF_SIDE, None, HALF_SIDES), Reference(scene, config)


@pytest.fixture(params=["lanes", "scalar"])
def form(request, monkeypatch):
    """Run a test with the CPU's form of the kernel and with CUDA's, in which many threads share a path."""
    if request.param == "scalar":
        monkeypatch.setattr("warpvec.fit.population_step.TILE", 1)


def assert_shows(population, reference):
    for name, expected in zip(NAMES, reference.shown(), strict=True):
        got = getattr(population.scene, name)
        torch.testing.assert_close(got.cpu(), expected.detach(), rtol=1e-11, atol=1e-12, msg=lambda m, n=name: n + m)


@pytest.mark.usefixtures("form")
@pytest.mark.parametrize("settings", SETTINGS)
@pytest.mark.parametrize("point_count", [12, 24])
def test_steps_follow_autograd_and_the_formulas_while_paths_come_and_go(settings, point_count, device):
    scene, config = random_scene(7, point_count), FitConfig(**settings)
    population, reference = made_both(scene, config, device)
    assert_shows(population, reference)
    for k in range(28):
        if k == 8:
            new = random_scene(3, point_count, seed=1)
            population.append(new.to(device))
            reference.append(new)
        if k == 16:
            rows = torch.tensor([8, 0, 3, 9, 2])
            population.keep(rows.to(device))
            reference.keep(rows)
        if k == 20:
            population.append(new.to(device))
            reference.append(new)
        adjoints = random_adjoints(population.scene, k)
        population.step(*adjoints, factor=1.5 - k / 20)
        reference.step([adj.cpu() for adj in adjoints], 1.5 - k / 20)
        assert_shows(population, reference)
    assert population.live.generation.tolist() == [11, 0, 3, 12, 2, 10, 11, 12]
    assert population.serial.tolist() == [8, 0, 3, 9, 2, 10, 11, 12]


@pytest.mark.usefixtures("form")
@pytest.mark.parametrize("settings", SETTINGS)
def test_paths_of_loops_and_segments_of_other_ages_follow_the_formulas(settings, device):
    scene, config = compound_scene(0, 7, 80, 80), FitConfig(**settings)
    population, reference = made_both(scene, config, device)
    for k in range(24):
        if k in (5, 9):  # segments of several paths and loops start afresh
            fresh = torch.arange(k % 3, len(population.live.segments), 3 if k == 5 else 4)
            population._rows[0][1:, fresh.to(device)] = 0.0
            population._segment_age[fresh.to(device)] = 0
            for value in reference.parameters["segments"][1:]:
                value[fresh] = 0.0
        if k == 12:
            new = compound_scene(1, 4, 80, 80)
            population.append(new.to(device))
            reference.append(new)
        if k == 18:
            rows = torch.tensor([10, 0, 3, 8, 4, 7])
            population.keep(rows.to(device))
            reference.keep(rows)
            assert loop_counts(population.live) == reference.counts
        adjoints = random_adjoints(population.scene, k)
        population.step(*adjoints, factor=1.5 - k / 20)
        reference.step([adj.cpu() for adj in adjoints], 1.5 - k / 20)
        assert_shows(population, reference)
    assert len(population._segment_age.unique()) == (3 if config.common_age else 4)


def test_float32_is_close_to_float64():
    scene, config = random_scene(30), FitConfig()
    floats = {name: getattr(scene, name).float() for name in NAMES}
    single = Population(replace(scene, **floats), config, HALF_SIDE)
    double = Population(scene, config, HALF_SIDE)
    for k in range(50):
        adjoints = random_adjoints(scene, k)
        double.step(*adjoints, factor=1.0)
        single.step(*(adj.float() for adj in adjoints), factor=1.0)
    for name in NAMES:
        expected = getattr(double.scene, name)
        torch.testing.assert_close(getattr(single.scene, name).double(), expected, rtol=1e-5, atol=1e-5)


@pytest.mark.usefixtures("form")
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e200])
@pytest.mark.parametrize("name", NAMES)
def test_a_bad_adjoint_counts_as_zero_in_its_row_of_its_parameter(bad, name, device):
    scene = random_scene(4)
    poisoned, zeroed = (Population(scene.to(device), FitConfig(), HALF_SIDE) for _ in range(2))
    for k in range(12):
        first, second = ([adj.to(device) for adj in random_adjoints(scene, k)] for _ in range(2))
        if k == 6:
            place = NAMES.index(name)
            # The segments of a path, which are of one age, count as one row.
            rows = [values[place].view(4, -1) if name == "segments" else values[place] for values in (first, second)]
            rows[0][(..., 1) if name == "background" else (2, 5) if name == "segments" else 2] = bad
            rows[1][... if name == "background" else 2] = 0.0
        poisoned.step(*first, factor=1.0)
        zeroed.step(*second, factor=1.0)
    for each in NAMES:
        assert torch.equal(getattr(poisoned.scene, each), getattr(zeroed.scene, each)), each


def test_adjoints_may_be_columns_of_wider_sums():
    scene = random_scene(5)
    dense, strided = (Population(scene, FitConfig(), HALF_SIDE) for _ in range(2))
    for k in range(3):
        points, color, opacity, background = random_adjoints(scene, k)
        sums = torch.cat([color, opacity[:, None], torch.full((5, 2), math.nan)], 1)
        kept = sums.clone()
        dense.step(points, color, opacity, background, 1.0)
        strided.step(points, sums[:, :3], sums[:, 3], background, 1.0)
        assert torch.equal(sums.nan_to_num(), kept.nan_to_num())
    for name in NAMES:
        assert torch.equal(getattr(dense.scene, name), getattr(strided.scene, name))


def test_adjoints_may_have_strided_columns():
    scene = random_scene(5)
    dense, turned = (Population(scene, FitConfig(), HALF_SIDE) for _ in range(2))
    points, color, opacity, background = random_adjoints(scene, 0)
    dense.step(points, color, opacity, background, 1.0)
    turned.step(points.permute(2, 1, 0).contiguous().permute(2, 1, 0), color.T.contiguous().T, opacity, background, 1.0)
    for name in NAMES:
        assert torch.equal(getattr(dense.scene, name), getattr(turned.scene, name))


@pytest.mark.parametrize("change", ["step", "keep", "append"])
def test_a_scene_never_changes(change):
    population = Population(random_scene(6), FitConfig(), HALF_SIDE)
    population.step(*random_adjoints(population.scene, 1), factor=1.0)
    scene, live = population.scene, population.live
    assert population.scene is scene
    before = {name: getattr(scene, name).clone() for name in NAMES}
    if change == "step":
        population.step(*random_adjoints(scene, 0), factor=1.0)
        assert not torch.equal(population.scene.segments, before["segments"])
    elif change == "keep":
        population.keep(torch.arange(6).flip(0))
    else:
        population.append(random_scene(2, seed=1))
    assert population.scene is not scene
    if change != "step":  # the old live scene stays as it was once the population changes
        population.step(*random_adjoints(population.scene, 0), factor=1.0)
        assert all(torch.equal(getattr(live, name), before[name]) for name in NAMES if name != "background")
    assert all(torch.equal(getattr(scene, name), before[name]) for name in NAMES)


def test_the_scene_that_was_given_is_left_alone():
    for config in (FitConfig(), FitConfig(backdrop="white")):
        scene = random_scene(3)
        Population(scene, config, HALF_SIDE).step(*random_adjoints(scene, 0), factor=1.0)
        for name in NAMES:
            assert torch.equal(getattr(scene, name), getattr(random_scene(3), name)), name


def test_a_transparent_scene_keeps_its_background():
    scene = replace(random_scene(3), transparent=True, background=torch.zeros(3, dtype=torch.float64))
    population = Population(scene, FitConfig(), HALF_SIDE)
    population.step(*random_adjoints(scene, 0), factor=1.0)
    population.append(random_scene(2, seed=1))
    assert population.scene.transparent
    assert torch.equal(population.scene.background, scene.background)


def test_steps_stay_in_the_same_memory():
    population = Population(random_scene(6), FitConfig(), HALF_SIDE)
    live, before = population.live, [getattr(population.live, name).data_ptr() for name in NAMES]
    for k in range(3):
        population.step(*random_adjoints(live, k), factor=1.0)
    assert population.live is live
    assert [getattr(live, name).data_ptr() for name in NAMES] == before
    assert torch.equal(live.points, population.scene.points)


def test_kept_paths_show_the_same_bits():
    population = Population(random_scene(9, dtype=torch.float32), FitConfig(), HALF_SIDE)
    population.step(*random_adjoints(population.scene, 0), factor=1.0)
    before, rows = population.scene, torch.tensor([True, False, True] * 3)
    population.keep(rows)
    for name in ("points", "color", "opacity"):
        assert torch.equal(getattr(population.scene, name), getattr(before, name)[rows]), name


def test_direct_colours_stay_between_0_and_1():
    scene = random_scene(20)
    population = Population(scene, FitConfig(), HALF_SIDE)
    adjoints = random_adjoints(scene, 0)
    for _ in range(200):
        population.step(*adjoints, factor=1.0)
    assert set(population.scene.color.flatten().tolist()) == {0.0, 1.0}
    assert set(population.scene.background.tolist()) <= {0.0, 1.0}


def test_the_background_is_fitted_even_without_paths():
    population = Population(random_scene(3), FitConfig(), HALF_SIDE)
    population.keep(torch.tensor([], dtype=torch.int64))
    before = population.scene
    population.step(*random_adjoints(before, 0), factor=1.0)
    assert len(population) == 0
    assert (population.scene.background != before.background).all()
    population.append(random_scene(2, seed=1))
    population.step(*random_adjoints(population.scene, 1), factor=1.0)
    assert population.scene.points.isfinite().all()


def test_a_step_beyond_capacity_changes_nothing(device):
    population = Population(random_scene(5).to(device), FitConfig(), HALF_SIDE)
    fits = torch.ones(1, dtype=torch.float64, device=device)
    population.step(*random_adjoints(population.scene, 0), factor=1.0, fits=fits)
    state = (*population._rows, population._background, population._age)
    before = [value.clone() for value in state]
    shown = population.scene
    population.step(*random_adjoints(shown, 1), factor=1.0, fits=-fits)
    assert all(map(torch.equal, state, before)) and population.step_count == 1
    assert all(torch.equal(getattr(population.scene, name), getattr(shown, name)) for name in NAMES)

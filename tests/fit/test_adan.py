"""Adan against a scalar version of its formulas."""

import copy
import math

import pytest
import torch

from warpvec.errors import InputError
from warpvec.fit.adan import Adan

BETAS = (0.98, 0.92, 0.99)
LR = 0.03


def scalar_adan(value, gradients, lr=LR, betas=BETAS, eps=1e-8):
    """The value after each gradient, in Python floats, straight from Algorithm 1 with bias correction."""
    b1, b2, b3 = betas
    m = v = n = 0.0
    previous = gradients[0]
    path = []
    for k, g in enumerate(gradients, start=1):
        m = b1 * m + (1 - b1) * g
        v = b2 * v + (1 - b2) * (g - previous)
        n = b3 * n + (1 - b3) * (g + b2 * (g - previous)) ** 2
        direction = m / (1 - b1**k) + b2 * v / (1 - b2**k)
        value -= lr * direction / (math.sqrt(n) / math.sqrt(1 - b3**k) + eps)
        previous = g
        path.append(value)
    return path


def run(optimizer, param, gradients):
    for gradient in gradients:
        param.grad = gradient
        optimizer.step()


def random(*shape, seed=0, dtype=torch.float64):
    return torch.randn(shape, generator=torch.Generator().manual_seed(seed), dtype=dtype)


@pytest.mark.parametrize("shape", [(5, 4, 2), (5, 3), (5,), ()])
def test_follows_the_formulas(shape):
    start, gradients = random(*shape), random(60, *shape, seed=1)
    param = start.clone().requires_grad_()
    run(Adan([param], lr=LR), param, gradients)
    flat = gradients.reshape(60, -1)
    expected = [scalar_adan(start.flatten()[i].item(), flat[:, i].tolist())[-1] for i in range(start.numel())]
    expected = torch.tensor(expected, dtype=torch.float64)
    torch.testing.assert_close(param.detach().flatten(), expected, rtol=1e-12, atol=0)


def test_float32_stays_close_to_float64_over_a_long_run():
    start, gradients = random(20), random(2000, 20, seed=1)
    double, single = start.clone().requires_grad_(), start.float().requires_grad_()
    run(Adan([double], lr=LR), double, gradients)
    run(Adan([single], lr=LR), single, gradients.float())
    # 2000 steps of at most lr, each rounded to 6e-8 of a value of order 1.
    torch.testing.assert_close(single.detach().double(), double.detach(), rtol=0, atol=2e-5)


def test_first_step_moves_by_the_learning_rate_against_the_sign():
    param = random(7).requires_grad_()
    before = param.detach().clone()
    run(Adan([param], lr=LR), param, [random(7, seed=1)])
    torch.testing.assert_close(param.detach(), before - LR * random(7, seed=1).sign(), rtol=0, atol=1e-8)


def test_groups_have_their_own_settings():
    first, second = random(3).requires_grad_(), random(3).requires_grad_()
    optimizer = Adan([{"params": [first], "lr": 0.1}, {"params": [second], "betas": (0.9, 0.8, 0.95)}], lr=LR)
    gradients = random(10, 3, seed=1)
    for gradient in gradients:
        first.grad, second.grad = gradient, gradient
        optimizer.step()
    series, start = gradients[:, 0].tolist(), random(3)[0].item()
    assert first[0].item() == pytest.approx(scalar_adan(start, series, lr=0.1)[-1], rel=1e-12)
    assert second[0].item() == pytest.approx(scalar_adan(start, series, betas=(0.9, 0.8, 0.95))[-1], rel=1e-12)


def test_rows_with_a_state_of_zeros_start_afresh():
    """A palette's entry that moves elsewhere has its state set to zero."""
    gradients = random(80, 6, 3, seed=1)
    param = random(6, 3).requires_grad_()
    optimizer = Adan([param], lr=LR)
    run(optimizer, param, gradients[:50])
    start = param.detach().clone()
    for value in optimizer.state[param].values():
        value[4:] = 0
    run(optimizer, param, gradients[50:])

    old, new = random(6, 3)[:4].requires_grad_(), start[4:].clone().requires_grad_()
    run(Adan([old], lr=LR), old, gradients[:, :4])
    run(Adan([new], lr=LR), new, gradients[50:, 4:])
    torch.testing.assert_close(param.detach(), torch.cat([old, new]).detach(), rtol=1e-14, atol=0)
    assert optimizer.state[param]["step"].tolist() == [80] * 4 + [30] * 2


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e200])
def test_a_row_with_a_bad_gradient_takes_a_step_of_zero_gradient(bad):
    gradients = random(30, 4, 3, 2, seed=1)
    poisoned, zeroed = gradients.clone(), gradients.clone()
    poisoned[12, 2, 1, 0] = bad
    zeroed[12, 2] = 0.0
    first, second = random(4, 3, 2).requires_grad_(), random(4, 3, 2).requires_grad_()
    run(Adan([first], lr=LR), first, poisoned)
    run(Adan([second], lr=LR), second, zeroed)
    torch.testing.assert_close(first, second, rtol=0, atol=0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, 3e38, 1.5e19])
def test_a_bad_gradient_never_enters_a_float32_parameter_or_its_state(bad):
    param = random(3, 2, dtype=torch.float32).requires_grad_()
    optimizer = Adan([param], lr=LR)
    run(optimizer, param, [torch.full((3, 2), value) for value in (bad, 1.0, -bad, bad, 4e18, -4e18, 0.0)])
    assert param.isfinite().all()
    assert all(value.isfinite().all() for value in optimizer.state[param].values())


def test_the_gradient_itself_is_not_changed():
    gradient = torch.tensor([[1.0, math.nan], [2.0, 3.0]])
    param = torch.zeros(2, 2, requires_grad=True)
    run(Adan([param], lr=LR), param, [gradient])
    torch.testing.assert_close(gradient, torch.tensor([[1.0, math.nan], [2.0, 3.0]]), equal_nan=True)


def test_rows_that_never_had_a_gradient_do_not_move():
    param = random(3, 2).requires_grad_()
    run(Adan([param], lr=LR), param, torch.zeros(5, 3, 2, dtype=torch.float64))
    torch.testing.assert_close(param.detach(), random(3, 2), rtol=0, atol=0)


def test_parameters_without_a_gradient_are_left_alone():
    used, unused = random(2).requires_grad_(), random(2).requires_grad_()
    optimizer = Adan([used, unused], lr=LR)
    run(optimizer, used, [random(2, seed=1)])
    torch.testing.assert_close(unused.detach(), random(2), rtol=0, atol=0)
    assert unused not in optimizer.state


def test_state_dict_round_trip():
    gradients = random(40, 3, 2, seed=1)
    param, undisturbed = random(3, 2).requires_grad_(), random(3, 2).requires_grad_()
    optimizer = Adan([param], lr=LR)
    run(optimizer, param, gradients[:20])
    saved = copy.deepcopy(optimizer.state_dict())
    resumed = param.detach().clone().requires_grad_()
    second = Adan([resumed], lr=99.0)
    second.load_state_dict(saved)
    run(second, resumed, gradients[20:])
    run(Adan([undisturbed], lr=LR), undisturbed, gradients)
    torch.testing.assert_close(resumed, undisturbed, rtol=0, atol=0)
    assert second.state[resumed]["step"].dtype == torch.int64


def test_converges_on_a_quadratic():
    minimum = random(6, 2, seed=3)
    curvature = torch.logspace(-2, 2, 12, dtype=torch.float64).view(6, 2)
    param = random(6, 2).requires_grad_()
    optimizer = Adan([param], lr=0.05)

    def closure():
        optimizer.zero_grad()
        loss = (curvature * (param - minimum).square()).sum()
        loss.backward()
        return loss

    for step in range(1500):
        optimizer.param_groups[0]["lr"] = 0.05 * (1 - step / 1500)
        loss = optimizer.step(closure)
    assert loss.item() < 1e-6


@pytest.mark.parametrize("settings", [{"lr": -1.0}, {"lr": math.nan}, {"eps": -1e-8}, {"betas": (0.9, 1.0, 0.9)}])
def test_settings_outside_their_range_are_refused(settings):
    with pytest.raises(InputError, match=next(iter(settings))):
        Adan([torch.zeros(2, requires_grad=True)], **settings)


def test_a_parameter_that_is_not_contiguous_is_refused():
    with pytest.raises(InputError, match="contiguous"):
        Adan([random(4, 3).T.requires_grad_()])


def test_a_copy_of_the_optimizer_is_independent():
    param = random(5, 3).requires_grad_()
    optimizer = Adan([param], lr=LR)
    run(optimizer, param, random(10, 5, 3, seed=1))
    twin = copy.deepcopy(optimizer)
    (other,) = twin.param_groups[0]["params"]
    run(optimizer, param, random(10, 5, 3, seed=2))
    before = other.detach().clone()
    run(twin, other, random(10, 5, 3, seed=2))
    assert not torch.equal(before, other)
    torch.testing.assert_close(other, param, rtol=0, atol=0)


def test_a_replaced_state_is_used():
    param, gradients = random(5, 3).requires_grad_(), random(20, 5, 3, seed=1)
    optimizer = Adan([param], lr=LR)
    run(optimizer, param, gradients[:10])
    saved, value = copy.deepcopy(optimizer.state_dict()), param.detach().clone()
    run(optimizer, param, gradients[10:])
    after = param.detach().clone()
    optimizer.load_state_dict(saved)
    param.data = value
    run(optimizer, param, gradients[10:])
    torch.testing.assert_close(param.detach(), after, rtol=0, atol=0)

"""Adan against a scalar version of its formulas."""

import math

import pytest
import torch

from warpvec.fit.adan import Adan

BETAS = (0.98, 0.92, 0.99)
LR = 0.03


def scalar_adan(value, gradients, lr=LR, eps=1e-8):
    """The value after each gradient, in Python floats, straight from Algorithm 1 with bias correction."""
    b1, b2, b3 = BETAS
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


def run(param, gradients, state=None):
    """Step ``param`` in place; return the state after it."""
    optimizer = Adan(param, state)
    for gradient in gradients:
        optimizer.step(gradient, LR)
    return optimizer.state


def random(*shape, seed=0, dtype=torch.float64):
    return torch.randn(shape, generator=torch.Generator().manual_seed(seed), dtype=dtype)


@pytest.mark.parametrize("shape", [(5, 4, 2), (5, 3), (5,), ()])
def test_follows_the_formulas(shape):
    start, gradients = random(*shape), random(60, *shape, seed=1)
    param = start.clone()
    run(param, gradients)
    flat = gradients.reshape(60, -1)
    expected = [scalar_adan(start.flatten()[i].item(), flat[:, i].tolist())[-1] for i in range(start.numel())]
    expected = torch.tensor(expected, dtype=torch.float64)
    torch.testing.assert_close(param.flatten(), expected, rtol=1e-12, atol=0)


def test_float32_stays_close_to_float64_over_a_long_run():
    start, gradients = random(20), random(2000, 20, seed=1)
    double, single = start.clone(), start.float()
    run(double, gradients)
    run(single, gradients.float())
    # 2000 steps of at most lr, each rounded to 6e-8 of a value of order 1.
    torch.testing.assert_close(single.double(), double, rtol=0, atol=2e-5)


def test_first_step_moves_by_the_learning_rate_against_the_sign():
    param = random(7)
    before = param.clone()
    run(param, [random(7, seed=1)])
    torch.testing.assert_close(param, before - LR * random(7, seed=1).sign(), rtol=0, atol=1e-8)


def test_rows_with_a_state_of_zeros_start_afresh():
    """A palette's entry that moves elsewhere has its state set to zero."""
    gradients = random(80, 6, 3, seed=1)
    param = random(6, 3)
    optimizer = Adan(param)
    for gradient in gradients[:50]:
        optimizer.step(gradient, LR)
    start = param.clone()
    for value in optimizer.state.values():
        value[4:] = 0
    for gradient in gradients[50:]:
        optimizer.step(gradient, LR)

    old, new = random(6, 3)[:4], start[4:].clone()
    run(old, gradients[:, :4])
    run(new, gradients[50:, 4:])
    torch.testing.assert_close(param, torch.cat([old, new]), rtol=1e-14, atol=0)
    assert optimizer.state["step"].tolist() == [80] * 4 + [30] * 2


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e200])
def test_a_row_with_a_bad_gradient_takes_a_step_of_zero_gradient(bad):
    gradients = random(30, 4, 3, 2, seed=1)
    poisoned, zeroed = gradients.clone(), gradients.clone()
    poisoned[12, 2, 1, 0] = bad
    zeroed[12, 2] = 0.0
    first, second = random(4, 3, 2), random(4, 3, 2)
    run(first, poisoned)
    run(second, zeroed)
    torch.testing.assert_close(first, second, rtol=0, atol=0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, 3e38, 1.5e19])
def test_a_bad_gradient_never_enters_a_float32_parameter_or_its_state(bad):
    param = random(3, 2, dtype=torch.float32)
    state = run(param, [torch.full((3, 2), value) for value in (bad, 1.0, -bad, bad, 4e18, -4e18, 0.0)])
    assert param.isfinite().all()
    assert all(value.isfinite().all() for value in state.values())


def test_the_gradient_itself_is_not_changed():
    gradient = torch.tensor([[1.0, math.nan], [2.0, 3.0]])
    param = torch.zeros(2, 2)
    run(param, [gradient])
    torch.testing.assert_close(gradient, torch.tensor([[1.0, math.nan], [2.0, 3.0]]), equal_nan=True)


def test_rows_that_never_had_a_gradient_do_not_move():
    param = random(3, 2)
    run(param, torch.zeros(5, 3, 2, dtype=torch.float64))
    torch.testing.assert_close(param, random(3, 2), rtol=0, atol=0)


def test_a_copied_state_goes_on_to_the_same_bits():
    gradients = random(40, 3, 2, seed=1)
    param, undisturbed = random(3, 2), random(3, 2)
    state = run(param, gradients[:20])
    resumed = param.clone()
    second = run(resumed, gradients[20:], {name: value.clone() for name, value in state.items()})
    assert second["step"].tolist() == [40] * 3 and state["step"].tolist() == [20] * 3
    run(undisturbed, gradients)
    torch.testing.assert_close(resumed, undisturbed, rtol=0, atol=0)
    assert second["step"].dtype == torch.int64


def test_converges_on_a_quadratic():
    minimum = random(6, 2, seed=3)
    curvature = torch.logspace(-2, 2, 12, dtype=torch.float64).view(6, 2)
    param = random(6, 2)
    optimizer = Adan(param)
    for step in range(1500):
        optimizer.step(2 * curvature * (param - minimum), 0.05 * (1 - step / 1500))
    assert (curvature * (param - minimum).square()).sum() < 1e-6

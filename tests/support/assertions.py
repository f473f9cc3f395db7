"""Assertions about gradients (present, same direction, close) and images, modelled on those of gsplat.

Every function takes tensors of any device and precision and compares them in float64 on the host. Shapes must be equal,
not just broadcastable. A NaN or an infinity fails.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import torch
from torch import Tensor


def assert_grad_close(got: Tensor, want: Tensor, rtol: float, atol: float, name: str) -> None:
    """Fail if the L2 distance exceeds ``atol + rtol * |want|``; the message names the worst entry.

    ``atol`` bounds the length of the whole difference, not of each entry. A missing small row can stay below this
    bound, so use ``assert_grad_present`` too.
    """
    got, want = _comparable(got, want, name)
    error, scale = (got - want).norm().item(), want.norm().item()
    assert error <= atol + rtol * scale, (
        f"{name}: |got - want| = {error:.3e} exceeds {atol:.1e} + {rtol:.1e} * |want|, |want| = {scale:.3e}; "
        + _worst_entry(got, want)
    )


def assert_grad_present(got: Tensor, want: Tensor, name: str, min_ratio: float = 0.5, floor: float = 1e-6) -> None:
    """Fail if the length of a row of ``got`` differs from that of ``want`` by more than a factor ``1 / min_ratio``.

    This finds rows that are zero, doubled, or present by mistake, of any size. Rows of ``want`` shorter than ``floor``
    times the longest one count as zero, and must be as short in ``got``.
    """
    got, want = _comparable(got, want, name)
    entry_count = math.prod(want.shape[1:])
    lengths, expected = (tensor.reshape(-1, entry_count).norm(dim=1) for tensor in (got, want))
    shortest = floor * expected.max().item() if len(expected) else 0.0
    low, high = expected * min_ratio, expected.clamp(min=shortest) / min_ratio
    wrong = (lengths > high) | ((lengths < low) & (expected > shortest))
    rows = wrong.nonzero().flatten().tolist()
    shown = ", ".join(f"row {row} got {lengths[row]:.3e} want {expected[row]:.3e}" for row in rows[:5])
    assert not rows, f"{name}: {len(rows)} of {len(got)} rows have the wrong length: {shown}"


def assert_same_direction(got: Tensor, want: Tensor, min_cosine: float, name: str) -> None:
    """Fail if the cosine between the two, as flat vectors, is below ``min_cosine``, or if just one of them is zero."""
    got, want = _comparable(got, want, name)
    largest = (got.abs().amax().item(), want.abs().amax().item())
    if largest == (0.0, 0.0):
        return
    assert all(largest), f"{name}: one of the two is zero, max |got| = {largest[0]:.3e}, max |want| = {largest[1]:.3e}"
    # Scale both to order 1 first, because the square of a small entry underflows.
    got, want = got / largest[0], want / largest[1]
    cosine = ((got * want).sum() / (got.norm() * want.norm())).item()
    assert cosine >= min_cosine, f"{name}: the cosine is {cosine:.6f}, must be at least {min_cosine}"


def assert_close_off_edges(
    got: Tensor, want: Tensor, *, atol: float, outlier_share: float, outlier_atol: float, name: str = "image"
) -> None:
    """Fail if more than ``outlier_share`` of the pixels [h, w, c] differ by ``atol``, or any by ``outlier_atol``.

    A pixel's difference is that of its worst channel.
    """
    got, want = _comparable(got, want, name)
    error = (got - want).abs().amax(-1)
    share = (error > atol).double().mean().item()
    assert share <= outlier_share, (
        f"{name}: {share:.3%} of the pixels are off by more than {atol:.1e}, {outlier_share:.3%} may be; "
        + _worst_entry(got, want)
    )
    worst = error.max().item()
    assert worst <= outlier_atol, f"{name}: a pixel is off by more than {outlier_atol:.1e}; " + _worst_entry(got, want)


def check_gradients(draw: Callable[..., Tensor], leaves: Sequence[Tensor], *, one_by_one: bool = False) -> None:
    """Compare the derivatives of six random sums over the image that ``draw`` gives with finite differences.

    All pixels one by one would take a backward pass each. The values of a leaf move together, in a random direction,
    or ``one_by_one``, which takes as many renderings.
    """
    generator = torch.Generator().manual_seed(0)

    def sums(*values: Tensor) -> Tensor:
        image = draw(*values)
        weights = torch.randn(6, image.numel(), generator=generator.manual_seed(0), dtype=image.dtype)
        return weights @ image.flatten()

    assert torch.autograd.gradcheck(sums, tuple(leaves), eps=1e-7, atol=1e-5, rtol=1e-4, fast_mode=not one_by_one)


def finite_difference(
    f: Callable[[Tensor], Tensor], x: Tensor, eps: float, entries: Sequence[int] | None = None
) -> Tensor:
    """Return central differences of the scalar ``f`` at ``x``, one per flat index in ``entries`` (default: all)."""
    assert x.dtype == torch.float64, f"x must be float64 for finite differences, got {x.dtype}"
    indices = range(x.numel()) if entries is None else entries
    return torch.tensor([_central_difference(f, x.detach(), eps, index) for index in indices], dtype=torch.float64)


def _central_difference(f: Callable[[Tensor], Tensor], x: Tensor, eps: float, index: int) -> float:
    step = torch.zeros(x.numel(), dtype=x.dtype, device=x.device)
    step[index] = eps
    step = step.reshape(x.shape)
    with torch.no_grad():
        return (f(x + step) - f(x - step)).item() / (2 * eps)


def _comparable(got: Tensor, want: Tensor, name: str) -> tuple[Tensor, Tensor]:
    assert got.shape == want.shape, f"{name}: got shape {list(got.shape)}, want {list(want.shape)}"
    for side, tensor in (("got", got), ("want", want)):
        wrong = (~tensor.isfinite()).sum().item()
        assert not wrong, f"{name}: {side} has {wrong} entries that are not finite"
    return got.detach().cpu().double(), want.detach().cpu().double()


def _worst_entry(got: Tensor, want: Tensor) -> str:
    flat = (got - want).abs().argmax()
    index = tuple(int(axis) for axis in torch.unravel_index(flat, got.shape))
    return f"worst at {list(index)}: got {got[index]:.6e}, want {want[index]:.6e}"

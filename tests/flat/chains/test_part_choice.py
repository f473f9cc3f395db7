"""The kernels of the search of parts, against prices and ways that are found one by one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from chain_pictures import line, rounded_rectangle
from reference import part_choice as reference

from warpvec.flat.chains import choice
from warpvec.flat.chains.chain import Chain
from warpvec.flat.price import number_nats

NATS = number_nats(512)


@pytest.mark.parametrize("is_traced", [False, True])
def test_prices_and_the_cheapest_way_are_those_of_the_reference(is_traced, monkeypatch):
    monkeypatch.setattr(choice, "ROUNDING", np.inf)  # all parts have a price
    shape = np.concatenate([rounded_rectangle(10, 12, 24, 18, (8, 3, 0, 9)), line((10, 21), (20, 8))])
    chain = Chain.of(shape @ [[1.0, 0.13], [0.02, 1.1]], is_closed=False, is_traced=is_traced)  # no two ways are equal
    first, last = choice._pairs(chain)
    pairs, rules = list(zip(first.tolist(), last.tolist(), strict=True)), choice._rules(chain, 0.05, NATS)

    search = choice._Search(chain, first, last, rules)

    expected = np.array([reference.prices(chain, rules, *pair) for pair in pairs]).T
    np.testing.assert_allclose(search.prices, expected, rtol=1e-6, atol=1e-6)
    assert np.isfinite(expected).sum(1).min() > 20
    parts, costs = search.cheapest(), dict(zip(pairs, search.prices.T, strict=True))
    assert [parts[0].first, parts[-1].last] == [0, len(chain.points) - 1]
    assert all(before.last == after.first for before, after in pairwise(parts))
    least = reference.least_cost(chain, rules, pairs, search.prices)
    assert reference.cost_of(chain, rules, parts, costs) == pytest.approx(least)

"""Orders that are balanced over participants."""

from collections import Counter
from itertools import pairwise

import pytest

from nvcore.people.participants import counterbalanced_order


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 9])
def test_orders_are_balanced(n):
    rows = [counterbalanced_order(n, i).tolist() for i in range(n if n % 2 == 0 else 2 * n)]
    assert all(sorted(row) == list(range(n)) for row in rows)
    places = Counter((place, clip) for row in rows for place, clip in enumerate(row))
    assert set(places.values()) == {len(rows) // n}
    follows = Counter(pair for row in rows for pair in pairwise(row))
    assert len(follows) == n * (n - 1)
    assert len(set(follows.values())) <= 1

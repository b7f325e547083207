"""Boosting: weights and confidences counted by hand, trees that split as they should."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nvcore.subjects.detectors.icf.boosting import bin_edges, boost

OBJECT, BACKGROUND = True, False


def column(*values: int) -> np.ndarray:
    return np.array(values, np.int32)[:, None]


def test_confidence_and_weights_are_those_of_the_formula():
    # equal values on both sides: any tree is wrong about one of the five objects, of weight 1/10
    values = column(9, 9, 9, 9, 1, 1, 1, 1, 1, 1)
    kinds = np.array([OBJECT] * 5 + [BACKGROUND] * 5)
    boosted = boost(values, kinds, n_trees=2)
    alpha = 0.5 * math.log(0.9 / 0.1)
    assert sorted(set(boosted.trees.leaves[0])) == pytest.approx([-alpha, alpha])
    # Freund and Schapire: afterwards the wrong one weighs 1/2, the other nine 1/2 together. At 1
    # there are then 1/2 of object and 5/18 of background, so that the second tree calls 1 objects
    alphas = np.abs(boosted.trees.leaves).max(axis=1)
    assert alphas[1] == pytest.approx(0.5 * math.log((13 / 18) / (5 / 18)))
    sums = boosted.trees.running_sums(values)
    assert sums[0] == pytest.approx([alphas[0], alphas[0] + alphas[1]])
    assert sums[-1] == pytest.approx([-alphas[0], alphas[1] - alphas[0]])
    assert boosted.error == pytest.approx([0.1, 0.1])


def test_objects_and_background_weigh_the_same_at_first():
    # one object among nine background: called by the majority it would be background
    values = column(5, *[5] * 4, *[1] * 5)
    boosted = boost(values, np.arange(10) == 0, n_trees=1)
    alpha = 0.5 * math.log((14 / 18) / (4 / 18))
    assert np.abs(boosted.trees.leaves[0]) == pytest.approx(alpha)
    assert boosted.error[0] == pytest.approx(0.4)


def test_a_tree_of_two_levels_learns_what_no_single_split_can():
    x = np.array([0, 0, 1, 1, 0, 0, 1, 1], np.int32) * 10
    y = np.array([0, 1, 0, 1, 0, 1, 0, 1], np.int32) * 10
    is_object = (x > 0) & (y > 0)
    boosted = boost(np.stack([x, y], axis=1), is_object, n_trees=5)
    assert len(boosted.trees) == 1  # without error, and the next would be the same
    assert np.isfinite(boosted.trees.leaves).all()
    np.testing.assert_array_equal(boosted.trees.running_sums(np.stack([x, y], 1)) > 0,
                                  is_object[:, None])  # fmt: skip


def test_nothing_is_learned_from_features_that_are_all_equal():
    assert len(boost(column(*[7] * 10), np.arange(10) < 5, n_trees=3).trees) == 0


def overlapping(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    kinds = rng.random(600) < 0.4
    return (rng.normal(0, 100, (600, 12)) + 60 * kinds[:, None]).astype(np.int32), kinds


def test_the_training_error_falls():
    values, kinds = overlapping()
    boosted = boost(values, kinds, n_trees=60)
    error = boosted.error
    assert error[-1] < 0.5 * error[0]
    sums = boosted.trees.running_sums(values)  # of more windows than a block has
    is_wrong = (sums > 0) != kinds[:, None]
    np.testing.assert_array_equal(is_wrong.mean(axis=0), error)


def test_a_round_ends_where_the_error_no_longer_falls():
    values, kinds = overlapping()
    whole = boost(values, kinds, n_trees=80)
    early = boost(values, kinds, n_trees=80, patience=5)
    n = len(early.trees)
    assert n < 80
    assert early.error[-5:].min() >= early.error[:-5].min()
    np.testing.assert_array_equal(early.error, whole.error[:n])


@pytest.mark.parametrize("share", [1.0, 0.3])
def test_the_same_seed_gives_the_same_trees(share):
    values, kinds = overlapping()
    a, b = (boost(values, kinds, n_trees=9, feature_share=share, seed=4) for _ in range(2))
    np.testing.assert_array_equal(a.trees.feature, b.trees.feature)
    np.testing.assert_array_equal(a.trees.leaves, b.trees.leaves)


def test_no_number_of_threads_changes_the_trees(monkeypatch):
    values, kinds = overlapping()
    trees = []
    for n_threads in (1, 3):
        monkeypatch.setattr("os.cpu_count", lambda n=n_threads: n)
        trees.append(boost(values, kinds, n_trees=9).trees)
    np.testing.assert_array_equal(trees[0].feature, trees[1].feature)
    np.testing.assert_array_equal(trees[0].threshold, trees[1].threshold)


def test_bins_part_the_windows_about_equally():
    values = np.random.default_rng(0).permutation(5120).astype(np.int32)[:, None] ** 2
    edges = bin_edges(values)
    assert edges.shape == (1, 255)
    index = np.searchsorted(edges[0], values[:, 0], side="right")
    assert np.bincount(index, minlength=256).min() >= 5


def test_every_split_is_the_best_of_all_by_trying_each():
    rng = np.random.default_rng(7)
    values = rng.integers(0, 30, (80, 4)).astype(np.int32)
    kinds = rng.random(80) < 0.5
    tree = boost(values, kinds, n_trees=1).trees
    signed = np.where(kinds, 0.5 / kinds.sum(), -0.5 / (~kinds).sum())

    def best(rows: np.ndarray) -> float:
        return max(
            abs(signed[rows & (values[:, f] >= t)].sum() - signed[rows & (values[:, f] < t)].sum())
            for f in range(4)
            for t in range(1, 30)
        )

    f, t = tree.feature[0], tree.threshold[0]
    right = values[:, f[0]] >= t[0]
    for node, rows in ((0, np.ones(80, bool)), (1, ~right), (2, right)):
        is_above = values[:, f[node]] >= t[node]
        gain = abs(signed[rows & is_above].sum() - signed[rows & ~is_above].sum())
        assert gain == pytest.approx(best(rows))

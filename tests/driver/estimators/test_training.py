"""Training: the features that matter are chosen, pedestrians left out are estimated well."""

from __future__ import annotations

from concurrent.futures import CancelledError
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driver_trials import CHOSEN, PERIODS_S, made_features, made_table, true_detectability

from nvcore.common.errors import InputError, ParameterError
from nvcore.notes import Note
from nvcore.subjects.driver.estimators import Search, Training, train_estimator
from nvcore.subjects.driver.estimators.model_file import to_bytes
from nvcore.subjects.driver.estimators.search import draw_settings, feature_sets, folds_of
from nvcore.subjects.driver.estimators.training import out_of_fold, samples_of
from nvcore.subjects.driver.features import FEATURE_KEYS
from nvcore.subjects.driver.trials import TrainingTable

SEARCH = Search(n_settings=2, n_folds=3)


def test_singles_pairs_and_all_are_tried():
    sets = feature_sets(np.ones(8, dtype=bool))
    assert len(sets) == 8 + 28 + 1
    assert sets[-1] == tuple(range(8))
    assert feature_sets(np.array([1, 1, 0, 0, 0, 0, 0, 0], dtype=bool)) == ((0,), (1,), (0, 1))
    assert feature_sets(np.array([1, 1, 0, 1, 0, 0, 0, 0], dtype=bool))[-1] == (0, 1, 3)


def test_settings_are_drawn_with_both_kernels_and_the_same_by_the_same_seed():
    drawn = draw_settings(Search())
    assert len(set(drawn)) == 30
    assert sum(settings.kernel == "rbf" for settings in drawn) == 15
    assert drawn == draw_settings(Search())
    assert drawn != draw_settings(Search(seed=1))
    assert all(0.03 <= settings.cost <= 3 for settings in drawn)


def test_a_pedestrian_is_in_one_fold_and_folds_are_about_equal():
    group = np.repeat(np.arange(51), 6)
    fold = folds_of(group, 5, seed=0)
    assert [len(set(fold[group == number])) for number in range(51)] == [1] * 51
    assert sorted(np.bincount(fold) // 6) == [10, 10, 10, 10, 11]
    assert folds_of(np.arange(3), 5, seed=0).max() == 2


def test_the_features_that_matter_are_chosen(training: Training):
    for regression in training.estimator.regressions[:-1]:
        assert set(regression.features) == set(CHOSEN)
    assert set(training.estimator.features) == set(CHOSEN)


def test_pedestrians_left_out_are_estimated_better_than_by_the_single_one_and_by_a_constant(
    training: Training,
):
    assert (training.switched_errors < 0.25 * training.constant_errors).all()
    assert training.single_errors.mean() < training.constant_errors.mean()
    assert training.switched_errors.mean() < 0.5 * training.single_errors.mean()


def test_new_pedestrians_are_estimated_as_the_known_answer_says(training: Training):
    new = made_features(60, seed=9)
    for period_s in PERIODS_S:
        estimates = training.estimator.estimate(new[list(FEATURE_KEYS)].to_numpy(), period_s)
        truth = true_detectability(new, period_s)
        assert np.corrcoef(estimates.detectability, truth)[0, 1] > 0.9
        assert ((estimates.detectability >= 0) & (estimates.detectability <= 1)).all()


def test_the_uncertainty_is_that_of_pedestrians_left_out(training: Training):
    qualities = training.estimator.qualities
    np.testing.assert_allclose(
        [quality.sd for quality in qualities[:-1]], np.sqrt(training.switched_errors)
    )
    assert [quality.n_rows for quality in qualities] == [24] * 6 + [144]
    np.testing.assert_allclose(
        [quality.constant_error for quality in qualities[:-1]], training.constant_errors
    )


def test_the_constant_is_the_mean_of_the_other_pedestrians(table: TrainingTable):
    samples = samples_of(table)
    fold = samples.group % 3
    estimates = out_of_fold(
        samples, fold, Search(n_settings=1, n_folds=2), n_threads=1, progress=lambda *_: None
    )
    rows = (samples.period == 2) & (fold == 1)
    others = (samples.period == 2) & (fold != 1)
    np.testing.assert_allclose(estimates.constant[rows], samples.target[others].mean())
    np.testing.assert_allclose(
        estimates.constant_of_all[fold == 1], samples.target[fold != 1].mean()
    )
    assert np.isnan(estimates.pairs).all()


def test_a_pedestrian_left_out_has_no_part_in_their_own_estimate(table: TrainingTable):
    """Whatever is said of the pedestrian, their estimate stays."""
    search = Search(n_settings=1, n_folds=2)
    samples = samples_of(table)
    mine = samples.group == 3
    changed = replace(samples, target=np.where(mine, 1 - samples.target, samples.target))
    fold = samples.group % 2
    others = fold != fold[mine][0]
    first, second = (
        out_of_fold(part, fold, search, n_threads=1, progress=lambda *_: None, has_pairs=True)
        for part in (samples, changed)
    )
    np.testing.assert_array_equal(first.switched[mine], second.switched[mine])
    np.testing.assert_array_equal(first.single[mine], second.single[mine])
    np.testing.assert_array_equal(first.constant[mine], second.constant[mine])
    np.testing.assert_array_equal(first.constant_of_all[mine], second.constant_of_all[mine])
    np.testing.assert_array_equal(first.pairs[mine], second.pairs[mine])
    assert np.isfinite(first.pairs).all()
    for name in ("switched", "single", "constant", "pairs"):
        assert not np.array_equal(getattr(first, name)[others], getattr(second, name)[others])


def test_whoever_is_left_out_with_a_pedestrian_learns_nothing_of_his_features(table: TrainingTable):
    """Neither choice nor scaling has seen them."""
    search = Search(n_settings=1, n_folds=2)
    samples = samples_of(table)
    mine = samples.group == 3
    features = np.where(mine[:, None], 3 * samples.features + 40, samples.features)
    fold = samples.group % 2
    first, second = (
        out_of_fold(part, fold, search, n_threads=1, progress=lambda *_: None, has_pairs=True)
        for part in (samples, replace(samples, features=features))
    )
    beside, others = (fold == 1) & ~mine, fold == 0
    for name in ("switched", "single", "pairs"):
        np.testing.assert_array_equal(getattr(first, name)[beside], getattr(second, name)[beside])
        assert not np.array_equal(getattr(first, name)[others], getattr(second, name)[others])
    assert first.columns[1] == second.columns[1]


@pytest.mark.parametrize(("n_beside", "words"), [(0, "0 pedestrians are"), (1, "1 pedestrian is")])
def test_a_fold_that_leaves_too_little_at_a_period_is_refused(
    table: TrainingTable, n_beside: int, words: str
):
    samples = samples_of(table)
    fold = np.where(samples.group < n_beside, 0, 1)
    fold[samples.group >= 10] = 2  # at all periods but the third
    rows = np.flatnonzero((samples.period != 2) | (samples.group < 10))
    part = replace(
        samples,
        **{
            name: getattr(samples, name)[rows]
            for name in ("features", "target", "period", "group", "row")
        },
    )
    expected = rf"trials\.csv: at the period of 3 s {words} left to learn from .* 2 are needed"
    with pytest.raises(InputError, match=expected):
        out_of_fold(
            part, fold[rows], Search(n_settings=1, n_folds=2), n_threads=1, progress=lambda *_: None
        )


def test_the_same_table_and_seed_give_the_same_model_on_any_number_of_threads(table: TrainingTable):
    quick = Search(n_settings=1, n_folds=2)
    models = [
        to_bytes(train_estimator(table, name="a", search=search, n_threads=n).estimator)
        for n, search in ((1, quick), (3, quick), (2, replace(quick, seed=4)))
    ]
    assert models[0] == models[1] != models[2]


def test_a_feature_that_grey_pictures_lack_is_not_used(table: TrainingTable):
    rows = table.rows.copy()
    rows["lab_distance"] = np.nan
    samples = samples_of(replace(table, rows=rows))
    assert samples.notes == (Note("driver.features_not_used", features=["lab_distance"]),)
    assert np.isnan(samples.features[:, FEATURE_KEYS.index("lab_distance")]).all()
    assert len(samples) == 24 * 6


def test_a_pedestrian_that_lacks_a_feature_is_left_out(table: TrainingTable):
    rows = table.rows.copy()
    rows.loc[rows["image"] == "night_03.jpg", "edge_contrast"] = np.nan
    samples = samples_of(replace(table, rows=rows))
    assert samples.notes == (Note("driver.pedestrians_left_out", n=1),)
    assert len(samples) == 23 * 6


def test_too_few_pedestrians_are_refused(table: TrainingTable):
    rows = table.rows[table.rows["image"] <= "night_06.jpg"]
    words = r"trials\.csv: the period of 0\.5 s has 7 pedestrians .* 8 are needed"
    with pytest.raises(InputError, match=words):
        samples_of(replace(table, rows=rows))
    rows = table.rows.assign(**dict.fromkeys(FEATURE_KEYS, np.nan))
    with pytest.raises(InputError, match=r"features\.csv: no feature is defined"):
        samples_of(replace(table, rows=rows))


def test_it_ends_when_cancelled_and_tells_how_far_it_is(table: TrainingTable):
    told: list[tuple[float, str]] = []

    def progress(share: float, words: str) -> None:
        told.append((share, words))
        if share > 0.1:
            raise CancelledError

    with pytest.raises(CancelledError):
        train_estimator(table, name="a", search=SEARCH, n_threads=2, progress=progress)
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[-1] < 0.3
    assert told[0][1] == "35 searches with pedestrians left out"
    assert "left out, about " in told[-1][1]
    assert told[-1][1].endswith(" left")


def test_impossible_settings_of_the_search_are_refused():
    with pytest.raises(ParameterError, match="n_folds: expected 2 to 20, got 1"):
        Search(n_folds=1)


@pytest.mark.parametrize(
    ("share", "words"),
    [
        (0.0, "all 1,080 responses are wrong, or not seen: there is nothing to learn"),
        (1.0, "all 1,080 responses are right: there is nothing to learn"),
        (0.25, "25 % of the subjects see every pedestrian at every period: there is nothing"),
    ],
)
def test_where_all_pedestrians_are_equal_it_is_refused(tmp_path: Path, share: float, words: str):
    table = made_table(tmp_path, n=9)
    equal = replace(table, rows=table.rows.assign(detectability=share))
    with pytest.raises(InputError, match=rf"trials\.csv: {words}"):
        samples_of(equal)

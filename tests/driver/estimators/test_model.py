"""Prediction by numpy: scikit-learn's own, the nearest period, and where nothing is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from sklearn.svm import SVR

from nvcore.common.errors import ParameterError
from nvcore.subjects.driver.estimators import Estimator, Origin, Quality, Regression
from nvcore.subjects.driver.estimators.model import SvrSettings
from nvcore.subjects.driver.estimators.search import fit

ORIGIN = Origin(9, 4, 216, "no", 200.0, 0.5, 0.5, 0, "ab" * 32)


@pytest.mark.parametrize("kernel", ["linear", "rbf"])
@pytest.mark.parametrize("columns", [(4,), (0, 7), tuple(range(8))])
def test_predictions_equal_scikit_learn_s(kernel, columns):
    rng = np.random.default_rng(2)
    features = rng.normal(size=(60, 8)) * [40, 80, 9, 30, 12, 25, 2, 150] + 100
    target = rng.uniform(0.2, 0.8, 60)
    settings = SvrSettings(kernel, cost=0.7, epsilon=0.05, gamma=0.4)
    regression = fit(features, target, columns, settings)
    chosen = features[:, columns]
    centre, scale = chosen.mean(axis=0), chosen.std(axis=0)
    machine = SVR(kernel=kernel, C=0.7, epsilon=0.05, gamma=0.4 / len(columns))
    machine.fit((chosen - centre) / scale, target)
    new = rng.normal(size=(20_000, 8)) * 60 + 100
    expected = np.clip(machine.predict((new[:, columns] - centre) / scale), 0, 1)
    np.testing.assert_allclose(regression.predict(new), expected, atol=1e-9, rtol=0)


def test_a_feature_without_spread_says_nothing():
    features = np.full((12, 8), 5.0)
    target = np.linspace(0, 1, 12)
    regression = fit(features, target, (0,), SvrSettings("rbf", 1.0, 0.01, 1.0))
    assert np.isfinite(regression.predict(features)).all()
    assert len(np.unique(regression.predict(features))) == 1


def constant(value: float, column: int = 0) -> Regression:
    """It says the value, wherever its one feature is; trained on 10 to 20."""
    return Regression(
        columns=np.array([column]),
        centre=np.array([15.0]),
        scale=np.array([3.0]),
        low=np.array([10.0]),
        high=np.array([20.0]),
        vectors=np.zeros((1, 1)),
        weights=np.zeros(1),
        offset=value,
        settings=SvrSettings("linear", 1.0, 0.1, 1.0),
    )


@pytest.fixture
def estimator() -> Estimator:
    return made_estimator()


def made_estimator() -> Estimator:
    """0.1, 0.3 and 1.4 (so 1) at 0.5, 1.5 and 3 s, with uncertainties 0.1, 0.2 and 0.3."""
    values = ((0.1, 0), (0.3, 3), (1.4, 0), (0.6, 0))
    return Estimator(
        name="hand made",
        periods_s=np.array([0.5, 1.5, 3.0]),
        regressions=tuple(constant(*value) for value in values),
        qualities=tuple(Quality(9, sd**2, 0.4, 0.2) for sd in (0.1, 0.2, 0.3, 0.4)),
        origin=ORIGIN,
    )


INSIDE = np.full((1, 8), 15.0)


@pytest.mark.parametrize(
    ("period_s", "taken_s", "expected"),
    [
        (0.0, 0.5, 0.1),
        (0.9, 0.5, 0.1),
        (1.0, 0.5, 0.1),  # as near to both: the shorter
        (1.0 + 1e-12, 0.5, 0.1),  # likewise, but for rounding
        (1.1, 1.5, 0.3),
        (2.2, 1.5, 0.3),
        (2.3, 3.0, 1.0),
        (100.0, 3.0, 1.0),
        (np.nan, 3.0, 1.0),  # no change of light is known: adapted
    ],
)
def test_the_nearest_period_is_taken(estimator: Estimator, period_s, taken_s, expected):
    estimates = estimator.estimate(INSIDE, period_s)
    assert estimates.detectability == pytest.approx([expected])
    assert estimates.period_s == pytest.approx([taken_s])


@pytest.mark.parametrize(
    ("period_s", "expected", "sd", "taken_s"),
    [
        (0.2, 0.1, 0.1, 0.5),
        (0.5, 0.1, 0.1, 0.5),
        (0.75, 0.15, 0.125, np.nan),
        (1.5, 0.3, 0.2, 1.5),
        (1.5 - 1e-12, 0.3, 0.2, 1.5),
        (1.5 + 1e-12, 0.3, 0.2, 1.5),
        (2.25, 0.65, 0.25, np.nan),
        (3.0, 1.0, 0.3, 3.0),
        (9.0, 1.0, 0.3, 3.0),
        (np.nan, 1.0, 0.3, 3.0),
    ],
)
def test_between_periods_estimates_can_be_interpolated(
    estimator: Estimator, period_s, expected, sd, taken_s
):
    estimates = estimator.estimate(INSIDE, np.array([period_s]), interpolate=True)
    assert estimates.detectability == pytest.approx([expected])
    assert estimates.sd == pytest.approx([sd])
    assert estimates.period_s == pytest.approx([taken_s], nan_ok=True)


def test_only_features_that_are_taken_have_to_be_known(estimator: Estimator):
    features = np.tile(INSIDE, (3, 1))
    features[0, 5] = np.nan
    features[1, 0] = np.nan
    features[2, 3] = np.nan
    shorter = estimator.estimate(features, 0.5)
    np.testing.assert_allclose(shorter.detectability, [0.1, np.nan, 0.1])
    np.testing.assert_allclose(shorter.sd, [0.1, np.nan, 0.1])
    longer = estimator.estimate(features, 1.5)
    np.testing.assert_allclose(longer.detectability, [0.3, 0.3, np.nan])
    between = estimator.estimate(features, 1.0, interpolate=True)
    np.testing.assert_allclose(between.detectability, [0.2, np.nan, np.nan])
    assert not shorter.is_outside.any()
    assert estimator.features == ("width_px", "luminance_contrast")


def test_a_feature_outside_the_training_is_marked(estimator: Estimator):
    features = np.tile(INSIDE, (4, 1))
    features[1, 0] = 9.9
    features[2, 0] = 20.1
    features[3, 3] = 21
    assert estimator.estimate(features, 0.5).is_outside.tolist() == [False, True, True, False]
    assert estimator.estimate(features, 1.5).is_outside.tolist() == [False, False, False, True]
    between = estimator.estimate(features, 1.0, interpolate=True)
    assert between.is_outside.tolist() == [False, True, True, True]


@pytest.mark.parametrize(
    ("period_s", "row"), [(0.5, 0), (1.5, 1), (1.5 - 1e-12, 1), (1.5 + 1e-12, 1), (3.0, 2)]
)
def test_interpolated_at_a_period_its_estimator_alone_says_what_is_outside_or_lacking(
    estimator: Estimator, period_s: float, row: int
):
    features = np.tile(INSIDE, (5, 1))
    features[1:3, 0] = 21, np.nan
    features[3:, 3] = 21, np.nan
    between = estimator.estimate(features, period_s, interpolate=True)
    nearest = estimator.estimate(features, period_s)
    for name in ("detectability", "sd", "outside", "period_s"):
        np.testing.assert_array_equal(getattr(between, name), getattr(nearest, name))
    assert estimator.regression_rows(period_s, interpolate=True) == [row]


def test_each_row_has_its_own_period(estimator: Estimator):
    estimates = estimator.estimate(np.tile(INSIDE, (3, 1)), np.array([3.0, 0.5, 1.5]))
    np.testing.assert_allclose(estimates.detectability, [1.0, 0.1, 0.3])
    np.testing.assert_allclose(estimates.sd, [0.3, 0.1, 0.2])


def test_the_single_one_takes_no_period(estimator: Estimator):
    assert estimator.regressions[-1].predict(INSIDE) == pytest.approx([0.6])
    assert estimator.qualities[-1].sd == pytest.approx(0.4)


def test_the_features_of_one_pedestrian_are_one_row(estimator: Estimator):
    assert estimator.estimate(INSIDE[0], 0.5).detectability == pytest.approx([0.1])


@pytest.mark.parametrize(
    ("features", "period_s", "words"),
    [
        (np.ones((8, 3)), 1.0, r"features: expected the shape \(n, 8\), found \(8, 3\)"),
        (np.ones(16), 1.0, r"features: expected the shape \(n, 8\), found \(1, 16\)"),
        (np.ones((1, 2, 8)), 1.0, r"features: expected the shape \(n, 8\), found \(1, 2, 8\)"),
        (np.full((1, 8), np.inf), 1.0, "features: expected numbers, or NaN for not known"),
        (np.ones((2, 8)), np.ones(3), r"each of 2 rows, found the shape \(3,\)"),
        (np.ones((2, 8)), np.ones(1), r"each of 2 rows, found the shape \(1,\)"),
    ],
)
def test_features_and_periods_of_another_shape_are_refused(
    estimator: Estimator, features: np.ndarray, period_s: np.ndarray | float, words: str
):
    with pytest.raises(ParameterError, match=words):
        estimator.estimate(features, period_s)


@given(
    values=arrays(np.float64, (5, 8), elements=st.floats(-1e6, 1e6) | st.just(np.nan)),
    period_s=st.floats(-1, 100) | st.just(np.nan),
    interpolate=st.booleans(),
)
def test_an_estimate_is_a_share_and_each_row_is_estimated_by_itself(
    values: np.ndarray, period_s: float, interpolate: bool
):
    hand_made = made_estimator()
    together = hand_made.estimate(values, period_s, interpolate=interpolate)
    known = together.detectability[~np.isnan(together.detectability)]
    assert ((known >= 0) & (known <= 1)).all()
    assert (np.isnan(together.sd) == np.isnan(together.detectability)).all()
    assert together.outside.shape == values.shape
    for row in range(len(values)):
        alone = hand_made.estimate(values[[row]], period_s, interpolate=interpolate)
        np.testing.assert_allclose(alone.detectability, together.detectability[[row]])
        np.testing.assert_array_equal(alone.outside, together.outside[[row]])


def test_no_pedestrian_is_no_estimate(estimator: Estimator):
    for interpolate in (False, True):
        estimates = estimator.estimate(np.empty((0, 8)), np.empty(0), interpolate=interpolate)
        assert len(estimates.detectability) == len(estimates.is_outside) == 0

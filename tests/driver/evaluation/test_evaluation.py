"""Leave-one-pedestrian-out: tables with known answers, and the paper's figures beside them."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from driver_trials import CHOSEN, PERIODS_S, made_table
from places import ROOT

from nvcore.subjects.driver.estimators import Search
from nvcore.subjects.driver.estimators.search import PAIRS
from nvcore.subjects.driver.evaluation import (
    PUBLISHED_NOTE,
    Evaluation,
    evaluate_estimators,
    evaluation_tables,
    published,
)
from nvcore.subjects.driver.evaluation.estimator_report import (
    EVALUATION_FILES,
    evaluation_files,
    render_evaluation,
)
from nvcore.subjects.driver.features import FEATURE_KEYS

N = 10


@pytest.fixture(scope="module")
def evaluation(tmp_path_factory: pytest.TempPathFactory) -> Evaluation:
    table = made_table(tmp_path_factory.mktemp("trials"), n=N)
    return evaluate_estimators(table, search=Search(n_settings=1, n_folds=2), n_threads=2)


@pytest.fixture(scope="module")
def tables(evaluation: Evaluation) -> dict[str, pd.DataFrame]:
    return evaluation_tables(evaluation)


def test_every_pedestrian_is_left_out_once(evaluation: Evaluation):
    estimates = evaluation.estimates
    assert len(estimates.columns) == N
    for values in (estimates.switched, estimates.single, estimates.constant, estimates.pairs):
        assert np.isfinite(values).all()
    # the single estimator knows no period
    of_pedestrian = estimates.single.reshape(6, N)
    np.testing.assert_allclose(of_pedestrian, np.tile(of_pedestrian[0], (6, 1)), atol=1e-12)


def test_errors_are_means_of_squares_by_period(evaluation, tables):
    errors = tables["errors"]
    assert errors["period_s"].tolist()[:-1] == list(PERIODS_S)
    assert np.isnan(errors["period_s"].iloc[-1])
    target = evaluation.rows["detectability"].to_numpy()
    of_third = evaluation.samples.period == 2
    for name in ("switched", "single", "constant"):
        squares = (getattr(evaluation.estimates, name) - target) ** 2
        assert errors[name][2] == pytest.approx(squares[of_third].mean())
        assert errors[name].iloc[-1] == pytest.approx(errors[name][:-1].mean())
    assert (errors["switched"] < errors["constant"]).all()
    assert errors["n"].tolist() == [N] * 7  # at each period, and at all: pedestrians


def test_periods_that_are_near_to_each_other_are_told_apart(evaluation: Evaluation):
    periods_s = np.array([0.5, 0.55, 0.6, 4.5, 6.0, 7.5])
    near = replace(evaluation, samples=replace(evaluation.samples, periods_s=periods_s))
    assert [line.split()[0] for line in render_evaluation(near).splitlines() if " s  " in line] == [
        "0.5", "0.55", "0.6", "4.5", "6", "7.5"
    ]  # fmt: skip


def test_leaving_out_one_the_constant_errs_by_the_variance_of_the_others(evaluation, tables):
    """Against the mean of the other n - 1, each residual is n / (n - 1) times that of all."""
    of_period = evaluation.samples.target[evaluation.samples.period == 0]
    expected = of_period.var() * (N / (N - 1)) ** 2
    assert tables["errors"]["constant"][0] == pytest.approx(expected)


def test_no_estimator_does_better_than_few_subjects_allow(evaluation, tables):
    """Mean of d (1 - d) / (n - 1): 0.25 / 3 if two of four see everybody."""
    of_first = evaluation.rows[evaluation.rows["period_s"] == 0.5]["detectability"]
    expected = (of_first * (1 - of_first) / 19).mean()
    assert tables["errors"]["sampling"][0] == pytest.approx(expected)
    rows = evaluation.table.rows.assign(n_subjects=4, detectability=0.5)
    table = replace(evaluation.table, rows=rows)
    errors = evaluation_tables(replace(evaluation, table=table))["errors"]
    np.testing.assert_allclose(errors["sampling"], 0.25 / 3)
    table = replace(evaluation.table, rows=rows.assign(n_subjects=1))
    errors = evaluation_tables(replace(evaluation, table=table))["errors"]
    assert errors["sampling"].isna().all()


def test_the_paper_s_errors_stand_beside_ours_with_what_differs(evaluation, tables):
    errors = tables["errors"]
    assert errors["published_switched"].tolist()[:-1] == list(published.SWITCHED)
    assert errors["published_switched"].iloc[-1] == pytest.approx(0.1227, abs=5e-5)
    assert errors["published_single"].iloc[-1] == pytest.approx(0.1418, abs=5e-5)
    assert errors["published_single_printed"].iloc[-1] == 0.134
    assert errors["published_single_printed"][:-1].isna().all()
    text = render_evaluation(evaluation)
    assert PUBLISHED_NOTE in text
    assert "the mean of that row is 0.1418" in text
    assert "simulated observer, not by people" in text


def test_the_gain_that_the_paper_s_own_row_shows():
    gain = 1 - np.mean(published.SWITCHED) / np.mean(published.SINGLE)
    assert gain == pytest.approx(0.135, abs=5e-4)
    best = [min(pairs.values()) for pairs in published.PAIRS.values()]
    assert np.mean(best) == pytest.approx(0.066, abs=5e-4)


def test_all_28_pairs_are_ranked_at_each_period(evaluation, tables):
    pairs = tables["pairs"]
    assert len(pairs) == 28 * 6
    for number, period_s in enumerate(PERIODS_S):
        rows = pairs[pairs["period_s"] == period_s]
        assert rows["rank"].iloc[0] == 1
        assert rows["error"].is_monotonic_increasing
        best = rows.iloc[0]
        column = PAIRS.index(
            tuple(sorted(FEATURE_KEYS.index(best[f"feature_{side}"]) for side in (1, 2)))
        )
        mine = evaluation.samples.period == number
        residual = evaluation.estimates.pairs[mine, column] - evaluation.samples.target[mine]
        assert best["error"] == pytest.approx((residual**2).mean())
        assert rows["published_error"].notna().sum() == 3
    third = pairs[pairs["period_s"] == 3.0].iloc[0]
    assert {third["feature_1"], third["feature_2"]} == set(CHOSEN)


def test_rankings_that_are_the_same_correlate_by_one(tables):
    ranks = tables["pair_ranks"]
    assert len(ranks) == 15
    assert ranks["spearman"].between(-1, 1).all()
    late = ranks[(ranks["period_1_s"] == 6.0) & (ranks["period_2_s"] == 7.5)]
    assert late["spearman"].tolist() == pytest.approx([1.0])  # the known answer is the same


def test_choices_are_counted(tables):
    choices = tables["choices"]
    of_period = choices.groupby("period_s", dropna=False)["n"].sum()
    assert of_period.tolist() == [N] * 7
    first = choices[choices["period_s"] == 3.0].iloc[0]
    assert first["features"] == "Luminance contrast + Distance from fixation"
    assert first["share"] == first["n"] / N


def test_detectability_by_period_is_described(evaluation, tables):
    periods, rows = tables["periods"], evaluation.rows
    of_first = rows.loc[rows["period_s"] == 0.5, "detectability"]
    assert periods["n"].tolist() == [N] * 6
    assert periods["mean"][0] == pytest.approx(of_first.mean())
    assert periods["sd"][0] == pytest.approx(of_first.std(ddof=1))
    assert periods["share_zero"][0] == (of_first == 0).mean()


def test_histograms_count_every_pedestrian(tables):
    histograms = tables["histograms"]
    assert len(histograms) == 6 * 11  # 20 subjects
    assert histograms.groupby("period_s")["n"].sum().tolist() == [N] * 6
    assert histograms["detectability"][:11].tolist() == pytest.approx(np.arange(11) / 10)


def test_with_few_subjects_a_bar_is_a_value(evaluation: Evaluation):
    rows = evaluation.table.rows.assign(
        n_subjects=4, detectability=list(itertools.islice(itertools.cycle([0, 0.25, 1]), 60))
    )
    changed = replace(evaluation, table=replace(evaluation.table, rows=rows))
    histograms = evaluation_tables(changed)["histograms"]
    first = histograms[histograms["period_s"] == 0.5]
    assert first["detectability"].tolist() == [0, 0.25, 0.5, 0.75, 1]
    assert first["n"].tolist() == [4, 3, 0, 0, 3]


def test_a_share_of_fewer_subjects_stands_in_the_nearest_bar(evaluation: Evaluation):
    rows = evaluation.table.rows.assign(n_subjects=4, detectability=0.25)
    rows.loc[0, ["n_subjects", "detectability"]] = 3, 2 / 3
    changed = replace(evaluation, table=replace(evaluation.table, rows=rows))
    histograms = evaluation_tables(changed)["histograms"]
    assert histograms["n"][:5].tolist() == [0, 9, 0, 1, 0]


def test_the_documentation_names_the_columns_of_each_table_in_their_order(tables):
    page = (ROOT / "docs" / "driver-reference.md").read_text(encoding="utf-8")
    of_columns = page.partition("| File | Column | |\n|---|---|---|\n")[2].partition("\n\n")[0]
    columns: dict[str, list[str]] = {}
    for line in of_columns.splitlines():
        _, file, names, _, _ = line.split("|")
        if file.strip():
            columns[file.strip(" `").removesuffix(".csv")] = of_file = []
        of_file += re.findall("`([^`]+)`", names)
    assert columns == {name: table.columns.tolist() for name, table in tables.items()}


def test_equal_data_give_equal_files_without_the_time_taken(evaluation: Evaluation):
    files = dict(evaluation_files(evaluation))
    assert tuple(files) == EVALUATION_FILES
    slower = replace(evaluation, seconds=1e6)
    assert dict(evaluation_files(slower)) == files
    assert files["errors.csv"].startswith(b"period_s,n,switched,single,constant,sampling,published")

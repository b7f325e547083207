"""What is said of trials and of a training that are of little use."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driver_estimators import estimator
from driver_trials import made_table

from nvcore.subjects.driver.estimators import Training
from nvcore.subjects.driver.evaluation.estimator_report import render_table, render_training
from nvcore.subjects.driver.trials import TrainingTable


@pytest.fixture
def table(tmp_path: Path) -> TrainingTable:
    return made_table(tmp_path, n=9)


def test_how_many_responses_there_are_to_a_pedestrian_is_said(table: TrainingTable):
    assert "20 responses to each pedestrian per period" in render_table(table)
    rows = table.rows.copy()
    rows.loc[3, "n_subjects"] = 4
    assert "4 to 20 responses to each pedestrian per period" in render_table(
        replace(table, rows=rows)
    )
    once = replace(table, rows=rows.assign(n_subjects=1))
    assert any(
        line.startswith("1 response to each pedestrian per period: detectability is 0 or 1")
        for line in render_table(once)
    )


@pytest.mark.parametrize(("n_odd", "is_said"), [(1, False), (10, False), (11, True), (20, True)])
def test_where_most_subjects_are_odd_the_data_are_doubted(
    table: TrainingTable, n_odd: int, is_said: bool
):
    odd = np.where(np.arange(20) < n_odd, "touches are at chance", "")
    lines = render_table(replace(table, subjects=table.subjects.assign(odd=odd)))
    words = f"{n_odd} of 20 subjects are odd, so the data are more likely wrong than the people."
    assert any(line.startswith(words) for line in lines) is is_said


@pytest.mark.parametrize(
    ("late", "is_said"),
    [(0.04, False), (0.09, True)],
    ids=["better on average", "worse on average"],
)
def test_an_estimator_that_is_no_better_on_average_is_said_to_be(
    table: TrainingTable, late: float, is_said: bool
):
    training = Training(
        estimator(),
        table,
        switched_errors=np.array([0.12, late]),
        single_errors=np.array([0.01, 0.01]),
        constant_errors=np.array([0.1, 0.1]),
        notes=(),
        seconds=1.0,
    )
    text = render_training(training)
    assert "at 0.5 s, the estimator is no better than the mean detectability of the others" in text
    words = "over all periods (0.1050 vs 0.1000 on average), so overall the estimator is of no use"
    assert (words in text) is is_said

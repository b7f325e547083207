"""Trials, trainings and evaluations in words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driver_trials import made_table

from nvcore.common.wording import MOST_NAMED
from nvcore.notes import Note
from nvcore.subjects.driver.calls.commands import say_how_to_leave_out
from nvcore.subjects.driver.estimators import Search, Training, train_estimator
from nvcore.subjects.driver.evaluation.estimator_report import render_table, render_training


@pytest.fixture(scope="module")
def training(tmp_path_factory: pytest.TempPathFactory) -> Training:
    table = made_table(tmp_path_factory.mktemp("trials"), n=8)
    return train_estimator(table, name="a", search=Search(n_settings=1, n_folds=2))


def test_trials_say_who_took_them_and_what_is_odd(
    training: Training, capsys: pytest.CaptureFixture[str]
):
    table = replace(training.table, simulated="no", n_off_time=3, left_out=("S1",))
    table.subjects.loc[table.subjects["subject"] == "S2", "odd"] = "never touches"
    lines = render_table(table)
    assert lines[0].replace("\xa0", " ") == (
        "960 trials: 19 subjects, 8 pedestrians, 6 adaptation periods"
    )
    assert lines[1] == "20 responses to each pedestrian per period"
    assert lines[2].replace("\xa0", " ").startswith("3 trials came more than 50 ms early or late")
    assert lines[3:] == [
        "subject S1 is left out",
        "subject S2 is odd: never touches. The responses count nevertheless",
    ]
    say_how_to_leave_out(table)
    assert capsys.readouterr().out == "without odd subjects: --leave-out S2\n"
    assert (
        render_table(replace(table, simulated="some"))[0]
        .split(":")[0]
        .endswith(", some by a simulated observer")
    )


def test_what_was_not_answered_and_what_lies_outside_is_counted(training: Training):
    table = replace(training.table, n_unanswered=2, n_outside=1, picture_px=(960, 540))
    lines = [line.replace("\xa0", " ") for line in render_table(table)]
    assert "2 trials without an answer in time, used in training as not seen" in lines
    text = "1 touch outside the picture of 960 x 540 px: are touch_x and touch_y in its pixels?"
    assert text in lines
    assert len(render_table(training.table)) == len(lines) - 2


def test_where_most_subjects_are_odd_that_is_said_before_a_few_of_them(training: Training):
    table = replace(training.table, subjects=training.table.subjects.assign(odd="never touches"))
    first, *named, more = render_table(table)[2:]
    assert first.startswith("20 of 20")
    assert len(named) == MOST_NAMED
    assert more == f"and {20 - MOST_NAMED} more (subjects.csv)"


def test_where_nothing_was_learned_it_is_said(training: Training):
    useless = replace(
        training,
        switched_errors=np.array([0.1, 0.3, 0.1, 0.2, 0.1, 0.1]),
        constant_errors=np.full(6, 0.2),
    )
    assert "at 1.5, 4.5 s, the estimator is no better than the mean" in render_training(useless)
    good = replace(useless, switched_errors=np.full(6, 0.1))
    assert "no better" not in render_training(good)
    assert "mean" in render_training(good)


def test_where_the_single_estimator_is_worse_than_the_constant_it_is_said(training: Training):
    poor = replace(
        training,
        switched_errors=np.full(6, 0.1),
        single_errors=np.array([0.3, 0.25, 0.2, 0.1, 0.1, 0.1]),
        constant_errors=np.full(6, 0.2),
    )
    words = "at 0.5, 1.5 s, the single estimator, which does not know the period, is worse than"
    assert words in render_training(poor)
    good = replace(poor, single_errors=np.full(6, 0.2))
    assert "is worse than" not in render_training(good)


def test_what_was_left_out_is_said(training: Training):
    noted = replace(training, notes=(Note("driver.pedestrians_left_out", n=1),))
    assert "\nLeft out because a feature is missing: 1 pedestrian\n" in render_training(noted)


def test_a_choice_of_features_has_its_settings(training: Training, tmp_path: Path):
    lines = render_training(training).splitlines()
    chosen = lines[lines.index("chosen:") + 1 :]
    assert chosen[0].startswith("    0.5 s  ")
    assert chosen[6].startswith("   single  ")
    assert all("(rbf, C " in line or "(linear, C " in line for line in chosen[:7])

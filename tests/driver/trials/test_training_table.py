"""From trials to detectability beside features, and the subjects whose responses are odd."""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from driver_trials import PERIODS_S, made_features, made_table, made_trials, true_detectability

from nvcore.common.errors import InputError
from nvcore.common.findings import Remedy, Step
from nvcore.subjects.driver.features import FeatureSettings
from nvcore.subjects.driver.features.feature_record import record_beside, record_bytes
from nvcore.subjects.driver.trials import training_table

FEW = ("A", "B", "C", "D")


def written(folder: Path, trials: pd.DataFrame, features: pd.DataFrame) -> tuple[Path, Path]:
    files = folder / "trials.csv", folder / "features.csv"
    trials.to_csv(files[0], index=False)
    features.to_csv(files[1], index=False)
    return files


def test_detectability_is_the_share_of_subjects_who_are_right(tmp_path: Path):
    table = made_table(tmp_path, n=9)
    assert table.n_pedestrians == 9
    assert (table.n_subjects, table.n_trials) == (20, 9 * 6 * 20)
    assert table.periods_s == PERIODS_S
    features = made_features(9)
    for period_s in PERIODS_S:
        rows = table.rows[table.rows["period_s"] == period_s]
        expected = np.round(true_detectability(features, period_s) * 20) / 20
        np.testing.assert_allclose(rows["detectability"], expected)
    np.testing.assert_allclose(table.rows["width_px"][:9], features["width_px"])


def test_trials_without_an_answer_and_touches_outside_the_picture_are_counted(tmp_path: Path):
    features = made_features(3)
    trials = made_trials(features, FEW)
    trials.loc[:1, "device"] = "touch; marked: no answer"
    is_touch = trials["touch_x"].notna()
    trials.loc[is_touch.idxmax(), ["touch_x", "touch_y"]] = (64700.0, -330.0)
    files = written(tmp_path, trials, features)
    table = training_table(*files)
    assert (table.n_unanswered, table.n_outside) == (2, 0)  # how large it is, nobody says
    about = {files[1].name: files[1].read_bytes()}
    settings = {"features": asdict(FeatureSettings())}
    record = record_bytes(about, settings=settings, picture_px=[1920, 1080])
    record_beside(files[1]).write_bytes(record)
    assert training_table(*files).n_outside == 1


def test_the_interval_is_wilson_s(tmp_path: Path):
    features = made_features(3)
    trials = made_trials(features, FEW)
    trials["not_seen"] = 1
    trials[["touch_x", "touch_y"]] = np.nan
    trials.loc[trials["subject"] == "A", "not_seen"] = 0
    of_a = trials["subject"] == "A"
    trials.loc[of_a, "touch_x"] = trials.loc[of_a, "image"].map(
        (features["x"] + features["w"] / 2).set_axis(features["image"])
    )
    trials.loc[of_a, "touch_y"] = trials.loc[of_a, "image"].map(
        (features["y"] + features["h"] / 2).set_axis(features["image"])
    )
    row = training_table(*written(tmp_path, trials, features)).rows.iloc[0]
    assert (row["n_right"], row["n_subjects"], row["detectability"]) == (1, 4, 0.25)
    # Wilson: (p + z^2 / 2n -+ z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n), z = 1.96
    assert (row["low"], row["high"]) == pytest.approx((0.0456, 0.6994), abs=1e-4)


@pytest.mark.parametrize(
    ("device", "told"), [("simulated", "all"), ("tablet", "no"), ("mixed", "some")]
)
def test_simulated_trials_are_known_as_such(tmp_path: Path, device: str, told: str):
    features = made_features(3)
    trials = made_trials(features, FEW)
    if device == "mixed":
        trials.loc[0, "device"] = "tablet"
    else:
        trials["device"] = device
    assert training_table(*written(tmp_path, trials, features)).simulated == told


def test_a_subject_can_be_left_out(tmp_path: Path):
    features = made_features(3)
    files = written(tmp_path, made_trials(features, FEW), features)
    table = training_table(*files, leave_out=["B", "B"])
    assert (table.n_subjects, table.left_out) == (3, ("B",))
    assert set(table.rows["n_subjects"]) == {3}
    assert table.subjects["subject"].tolist() == list(FEW)
    with pytest.raises(InputError, match="there is no subject 'E'; there are A, B, C and D"):
        training_table(*files, leave_out=["E"])
    with pytest.raises(InputError, match="all subjects are left out"):
        training_table(*files, leave_out=FEW)


def test_what_lacks_boxes_or_features_is_refused(tmp_path: Path):
    features = made_features(3)
    trials = made_trials(features, FEW)
    without_boxes = features.drop(columns=["x", "y", "w", "h"])
    files = written(tmp_path, trials, without_boxes)
    with pytest.raises(InputError, match=r"features\.csv: .* the boxes .*") as raised:
        training_table(*files)
    assert raised.value.steps == (Step(Remedy.OPTION, "", "boxes"),)
    boxes = tmp_path / "boxes.csv"
    features[["image", "pedestrian", "x", "y", "w", "h"]].to_csv(boxes, index=False)
    assert training_table(*files, boxes=boxes).n_pedestrians == 3
    written(tmp_path, trials, without_boxes.iloc[1:])
    with pytest.raises(
        InputError,
        match=r"trials\.csv, line 2: features\.csv has no features .* p1 .*night_00\.jpg",
    ):
        training_table(*files, boxes=boxes)


@pytest.mark.parametrize("n_pedestrians", [1, 3])
def test_times_by_the_clock_in_place_of_the_planned_ones_are_refused(
    tmp_path: Path, n_pedestrians: int
):
    features = made_features(n_pedestrians)
    trials = made_trials(features, FEW[:3])
    assert len(trials) == 18 * n_pedestrians
    trials["adaptation_asked_s"] += np.arange(len(trials)) % 7 / 1000
    words = "the adaptation times 0 and 0.00[1-3] s are less than 50 ms apart: .* not the measured"
    with pytest.raises(InputError, match=words):
        training_table(*written(tmp_path, trials, features))


def test_many_adaptation_periods_may_be_planned(tmp_path: Path):
    features = made_features(1)
    (trial,) = made_trials(features, FEW[:1]).iloc[:1].to_dict("records")
    plan = pd.DataFrame([trial | {"adaptation_asked_s": n / 20} for n in range(25)])
    assert len(training_table(*written(tmp_path, plan, features)).periods_s) == 25


def subject_rows(tmp_path: Path, change) -> pd.Series:
    """What is said of the first subject after a change of their trials."""
    features = made_features(12)
    trials = made_trials(features)
    mine = trials["subject"] == "S0"
    trials.loc[mine] = change(trials[mine].copy(), features)
    subjects = training_table(*written(tmp_path, trials, features)).subjects
    assert not subjects["odd"][1:].any()
    return subjects.iloc[0]


def test_a_subject_like_the_others_is_not_odd(tmp_path: Path):
    row = subject_rows(tmp_path, lambda trials, _: trials)
    assert row["odd"] == ""
    assert row["share"] == pytest.approx(row["share_expected"], abs=0.1)


def test_a_subject_who_never_sees_anything_is_odd(tmp_path: Path):
    def blind(trials: pd.DataFrame, _: pd.DataFrame) -> pd.DataFrame:
        return trials.assign(not_seen=1, touch_x=np.nan, touch_y=np.nan)

    odd = subject_rows(tmp_path, blind)["odd"]
    assert re.search(r"right in 0.% of the trials, the others in \d+.% of the same", odd)
    assert "never touches" in odd


@pytest.mark.parametrize(("n_missed", "is_odd"), [(6, False), (7, True)])
def test_who_misses_more_than_a_quarter_of_what_all_others_see_is_odd(
    tmp_path: Path, n_missed: int, is_odd: bool
):
    features = made_features(4)
    trials = made_trials(features, FEW)
    place = features.set_index("image")
    trials["touch_x"] = trials["image"].map(place["x"] + place["w"] / 2)
    trials["touch_y"] = trials["image"].map(place["y"] + place["h"] / 2)
    trials["not_seen"] = 0
    mine = trials.index[trials["subject"] == "B"]
    assert len(mine) == 24
    trials.loc[mine[:n_missed], "not_seen"] = 1
    trials.loc[mine[:n_missed], ["touch_x", "touch_y"]] = np.nan
    row = training_table(*written(tmp_path, trials, features)).subjects.iloc[1]
    assert row["n_easy"] == 24
    assert row["share_easy"] == pytest.approx(1 - n_missed / 24)
    reason = "misses 29 % of 24 trials in which nearly all others are right"
    assert (reason in row["odd"].replace("\xa0", " ")) == is_odd


def test_touches_at_random_are_at_chance(tmp_path: Path):
    def at_random(trials: pd.DataFrame, _: pd.DataFrame) -> pd.DataFrame:
        rng = np.random.default_rng(5)
        n = len(trials)
        x, y = rng.uniform(0, 1800, n).round(), rng.uniform(300, 800, n).round()
        return trials.assign(not_seen=0, touch_x=x, touch_y=y)

    row = subject_rows(tmp_path, at_random)
    assert "touches are at chance: as often right on other pictures" in row["odd"]
    assert row["share_touches_right"] == pytest.approx(row["share_chance"], abs=0.15)


def test_touches_in_one_place_are_odd(tmp_path: Path):
    def in_one_place(trials: pd.DataFrame, _: pd.DataFrame) -> pd.DataFrame:
        return trials.assign(not_seen=0, touch_x=5.0, touch_y=5.0)

    row = subject_rows(tmp_path, in_one_place)
    assert "100 % of the touches are in one place, with " in row["odd"]
    assert row["share_one_place"] == 1

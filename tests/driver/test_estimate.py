"""Estimates over recordings: by which estimator, for which boxes, and in which files."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from driver_estimators import CONTRAST, LAB, estimator, regression
from picture_files import write_picture

from nvcore.api.driver_run import estimate_driver
from nvcore.comparison import compare
from nvcore.driver.estimate import DETECTABILITY_COLUMNS, EstimateRun, run_estimate
from nvcore.driver.estimators import Estimator, Quality, write_estimator
from nvcore.driver.features import FeatureSettings
from nvcore.driver.run import run_features
from nvcore.driver.steps import steps_between_periods
from nvcore.errors import InputError, ParameterError
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from nvcore.report.verdict.driver import describe_source


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """40 frames at 4 a second with a person 60 brighter than his surround; it is dark from 5 s."""
    rows = [f"drive,{frame},20,10,8,16,5" for frame in range(40)]
    (tmp_path / "truth.csv").write_text("\n".join(["recording,frame,x,y,w,h,track", *rows]) + "\n")
    grey = np.full((48, 64), 40, np.uint8)
    grey[10:26, 20:28] = 100
    for frame in range(40):
        write_picture(tmp_path / "drive" / f"{frame:03}.png", grey)
    readings = [f"{i / 20},{1000 if i < 100 else 10}" for i in range(220)]
    (tmp_path / "lux.csv").write_text("\n".join(["time_s,lux", *readings]) + "\n")
    (tmp_path / "session.toml").write_text(
        '[defaults]\nsize = "64x48"\nfps = 4\n[truth]\npath = "truth.csv"\n'
        '[[system]]\nname = "FIR"\npath = "truth.csv"\n'
        '[[recording]]\nname = "drive"\nframes = "0:39"\nvisible = "drive"\nlight = "lux.csv"\n'
    )
    return tmp_path


def run(place: Path, of: Estimator, **options: bool) -> EstimateRun:
    dataset = load(read_session(place / "session.toml"))
    return run_estimate(run_features(dataset), of, **options)


def test_each_box_has_the_estimate_of_its_adaptation_period(place: Path):
    table = run(place, estimator()).table
    assert tuple(table.columns) == DETECTABILITY_COLUMNS
    # before the change the eyes are adapted: the longest period; frame 19 ends at the change
    assert table["period_s"][:20].isna().all()
    np.testing.assert_allclose(table["detectability"][:20], 0.6)
    # from 0 s to 2.5 s after it the nearest estimator is that of 0.5 s, then that of 4.5 s
    assert table["period_s"][[20, 29, 30]].tolist() == pytest.approx([0.25, 2.5, 2.75])
    np.testing.assert_allclose(table["detectability"][20:30], 0.3)
    np.testing.assert_allclose(table["detectability"][30:], 0.6)
    np.testing.assert_allclose(table["sd"][[20, 39]], [0.1, 0.2])
    assert not table["is_outside"].any()


def test_between_two_periods_it_may_be_interpolated(place: Path):
    table = run(place, estimator(), interpolate=True).table
    assert table["detectability"][29] == pytest.approx(0.45)  # 2.5 s, in the middle


def test_steps_from_one_estimator_to_the_next_are_counted(place: Path):
    result = run(place, estimator())  # from 0.3 to 0.6, with a sd of 0.1 and 0.2
    assert result.steps == (1, 1)
    assert "the estimate of 1 of 1 pedestrian steps by more than its sd where" in str(result)
    vague = replace(estimator(), qualities=tuple(Quality(51, 0.1, 0.5, 0.1) for _ in range(3)))
    assert run(place, vague).steps == (1, 0)
    assert "--interpolate" not in str(run(place, vague))
    assert run(place, estimator(), interpolate=True).steps == (0, 0)


def test_without_tracks_no_steps_are_known_and_a_new_change_is_none():
    rows = {"recording": "a", "frame": range(4), "track": [1, 1, None, None]}
    table = pd.DataFrame(rows).assign(detectability=[0.0, 1, 0, 1], sd=0.1, period_s=[4, 5, 4, 5])
    table["track"] = table["track"].astype("Int64")
    assert steps_between_periods(table, np.array([3.0, 4.5, 3.0, 4.5])) == (1, 1)
    assert steps_between_periods(table, np.array([4.5, 0.5, 3.0, 4.5])) == (0, 0)
    assert steps_between_periods(table[:0], np.empty(0)) == (0, 0)


def test_a_feature_that_is_needed_and_missing_leaves_no_estimate(place: Path):
    result = run(place, estimator(LAB))
    assert result.table[["detectability", "sd"]].isna().all(axis=None)
    assert not result.table["is_outside"].any()
    assert "detectability of 0 of 40 pedestrian boxes: the estimator needs lab_distance" in (
        str(result)
    )


def test_grey_pictures_that_nobody_calls_visible_give_no_estimate(place: Path):
    session = place / "session.toml"
    session.write_text(session.read_text().replace("visible =", "pictures ="))
    result = run(place, estimator())
    assert result.features.table["luminance_contrast"].notna().all()
    assert result.n_estimated == 0
    assert "from grey pictures that may be far infrared: drive; where they are of visible" in (
        str(result)
    )


def test_print_says_what_to_take_with_care(place: Path):
    text = str(run(place, estimator(simulated="all")))
    assert "detectability of 40 of 40 pedestrian boxes: 0.53 on average" in text
    assert "estimates are learnt from simulated subjects" in text
    assert "learnt in part from simulated subjects" in str(run(place, estimator(simulated="some")))
    assert "20 estimates without a known change of light" in text
    assert "outside the range" not in text
    assert "simulated" not in str(run(place, estimator()))


def test_where_the_estimator_is_no_better_than_a_constant_is_said_and_recorded(place: Path):
    qualities = tuple(Quality(9, error, 0.5, 0.1) for error in (0.1, 0.04, 0.2))
    write_estimator(replace(estimator(simulated="all"), qualities=qualities), place / "m.npz")
    with (place / "session.toml").open("a") as session:
        session.write('[[system]]\nname = "RGB"\npath = "truth.csv"\n')
    written = estimate_driver(place / "session.toml", place / "m.npz", place / "out")
    said = "learnt from simulated subjects and no better than a constant at 0.5 s"
    assert f"estimates are {said}" in str(written.run)
    record = json.loads(written.record.read_text())
    assert record["estimator"]["no_better_at_s"] == [0.5]
    dataset = load(read_session(written.session))
    assert dataset.estimate is not None
    assert dataset.estimate.caution == said
    assert said in dataset.inputs["conversion"].iloc[-1]
    text = describe_source(compare(dataset))
    assert f"{said}; he is taken to see" in text
    assert "no better" not in str(run(place, estimator()))


def test_features_outside_the_training_are_named(place: Path):
    dim = replace(estimator(), regressions=tuple(regression(CONTRAST, high=50) for _ in range(3)))
    result = run(place, dim)
    assert (result.table["outside_features"] == "luminance_contrast").all()
    assert result.n_outside == {"Luminance contrast": 40}
    assert (
        "40 estimates with features outside the range of the training (Luminance contrast in 40)"
        in (str(result))
    )
    assert (run(place, estimator()).table["outside_features"] == "").all()


def test_where_nothing_is_known_of_the_light_is_counted(place: Path):
    readings = [f"{i / 10},1000" for i in range(50)]  # the last, at 4.9 s, holds a second
    (place / "lux.csv").write_text("\n".join(["time_s,lux", *readings]) + "\n")
    result = run(place, estimator())
    assert result.n_without_light == 16
    text = str(result)
    assert "40 estimates without a known change of light (16 where nothing is known of" in text
    assert result.counts_json() == {"n": 40, "n_without_light": 16, "outside": {}}


def test_files_are_a_session_that_names_the_estimates(place: Path):
    write_estimator(estimator(), place / "model.npz")
    written = estimate_driver(place / "session.toml", place / "model.npz", place / "out")
    session = read_session(written.session)
    assert session.driver.detectability == str(place / "out" / "detectability.csv")
    assert session.driver.provenance == str(place / "out" / "driver.json")
    assert session.recordings[0].light == str(place / "lux.csv")
    table = pd.read_csv(written.detectability)
    assert tuple(table.columns) == DETECTABILITY_COLUMNS
    assert table[["recording", "frame", "track", "x", "y", "w", "h"]].iloc[7].tolist() == [
        *("drive", 7, 5, 20, 10, 8, 16)
    ]
    assert len(pd.read_csv(written.features)) == 40
    record = json.loads(written.record.read_text())
    said = record["estimator"]
    assert (said["name"], said["simulated"], said["n_subjects"]) == ("test", "no", 4)
    assert said["features"] == ["luminance_contrast"]
    digest = hashlib.sha256(written.detectability.read_bytes()).hexdigest()
    assert record["files"]["detectability.csv"] == digest


def test_estimates_again_replace_those_before(place: Path):
    write_estimator(estimator(), place / "model.npz")
    first = estimate_driver(place / "session.toml", place / "model.npz", place / "out")
    before = first.detectability.read_bytes()
    again = estimate_driver(first.session, place / "model.npz", place / "again")
    assert again.detectability.read_bytes() == before
    assert read_session(again.session).driver.detectability == str(again.detectability.absolute())


def test_features_are_computed_as_those_that_the_estimator_was_trained_on(place: Path):
    wide = replace(estimator(), feature_settings=FeatureSettings(surround=3))
    write_estimator(wide, place / "model.npz")
    files = place / "session.toml", place / "model.npz", place / "out"
    written = estimate_driver(*files)
    assert json.loads(written.record.read_text())["settings"]["features"]["surround"] == 3
    assert "does not say with which settings" not in str(written.run)
    estimate_driver(*files, settings={"surround": 3})
    with pytest.raises(ParameterError, match="surround: the estimator was trained on features w"):
        estimate_driver(*files, settings={"surround": 2})
    with pytest.raises(ParameterError, match="with 3, found 2"):
        run(place, wide)


def test_an_estimator_that_does_not_say_its_settings_is_used_and_that_is_noted(place: Path):
    assert (
        "the estimator does not say with which settings its features were computed; these: "
        "surround 2, bin distance 1"
    ) in str(run(place, estimator()))


@pytest.mark.parametrize(
    ("pictures", "column", "words"),
    [
        (
            "pictures =",
            CONTRAST,
            "no estimate from grey pictures that may be far infrared: drive; where they are of "
            "visible light, name them as visible",
        ),
        ("visible =", LAB, "the estimator needs lab_distance, which no box has$"),
    ],
)
def test_where_no_pedestrian_can_be_estimated_it_is_refused(
    place: Path, pictures: str, column: int, words: str
):
    session, out = place / "session.toml", place / "out"
    session.write_text(session.read_text().replace("visible =", pictures))
    write_estimator(estimator(column), place / "m.npz")
    with pytest.raises(InputError, match=f"none of 40 pedestrian boxes can be estimated: {words}"):
        estimate_driver(session, place / "m.npz", out)
    assert not out.exists()


def test_pedestrians_without_a_picture_are_refused_and_recordings_without_any_are_fine(place: Path):
    (place / "truth.csv").write_text("recording,frame,x,y,w,h,track\ndrive,39,20,10,8,16,5\n")
    (place / "drive" / "039.png").unlink()
    write_estimator(estimator(), place / "m.npz")
    files = place / "session.toml", place / "m.npz", place / "out"
    with pytest.raises(InputError, match="box can be estimated: they are in frames without a pic"):
        estimate_driver(*files)
    (place / "truth.csv").write_text("recording,frame,x,y,w,h,track\n")
    assert estimate_driver(*files).run.n_estimated == 0


def test_what_is_read_is_not_replaced(place: Path):
    write_estimator(estimator(), place / "model.npz")
    with pytest.raises(InputError, match="is an input, and would be replaced"):
        estimate_driver(place / "session.toml", place / "model.npz", place)
    with pytest.raises(InputError, match=r"session\.toml: is not an estimator"):
        estimate_driver(place / "session.toml", place / "session.toml", place / "out")

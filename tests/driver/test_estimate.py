"""Estimates over recordings: by which estimator, for which boxes, and in which files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from driver_estimators import CONTRAST, LAB, estimator, origin, regression
from picture_files import write_picture

from nvcore.common.errors import InputError, ParameterError
from nvcore.comparison.compare import compare
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.driver.calls.python import estimate_driver
from nvcore.subjects.driver.comparison.notes import source
from nvcore.subjects.driver.estimators import Estimator, Quality, write_estimator
from nvcore.subjects.driver.features import FEATURE_KEYS, FeatureSettings
from nvcore.subjects.driver.running.estimate import (
    DETECTABILITY_COLUMNS,
    EstimateRun,
    Steps,
    run_estimate,
    steps_between_periods,
)
from nvcore.subjects.driver.running.run import FeatureRun, run_features


def made(tmp_path: Path) -> Path:
    """40 frames at 4 a second with a person 60 brighter than the surround; it is dark from 5 s."""
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


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return made(tmp_path)


def features_in(place: Path) -> FeatureRun:
    return run_features(load(read_session(place / "session.toml")))


def run(place: Path, of: Estimator, **options: bool) -> EstimateRun:
    return run_estimate(features_in(place), of, **options)


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., EstimateRun]:
    """Estimates by any estimator in the recording as it is made."""
    return partial(run_estimate, features_in(made(tmp_path_factory.mktemp("usual"))))


def test_each_box_has_the_estimate_of_its_adaptation_period(usual: Callable):
    table = usual(estimator()).table
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
    assert table["estimator_s"].tolist() == [4.5] * 20 + [0.5] * 10 + [4.5] * 10


def test_boxes_without_an_estimate_are_counted_though_no_feature_is_lacking(usual: Callable):
    """As by an estimator that somebody made who did not compute it."""
    hollow = replace(regression(CONTRAST), offset=np.nan)
    made = estimator()
    result = usual(replace(made, regressions=(hollow, *made.regressions[1:])))
    assert (
        "10 boxes in pictures without an estimate (10 boxes are 0.25 to 2.5 s after a change of "
        "light)"
    ) in str(result).splitlines()


def test_between_two_periods_it_may_be_interpolated(usual: Callable):
    table = usual(estimator(), interpolate=True).table
    assert table["detectability"][29] == pytest.approx(0.45)  # 2.5 s, in the middle
    assert table["estimator_s"][[0, 20, 21, 37]].tolist() == [4.5, 0.5, 0.5, 4.5]
    assert table["estimator_s"][22:37].isna().all()  # between two


def test_steps_from_one_estimator_to_the_next_are_counted(usual: Callable):
    result = usual(estimator())  # from 0.3 to 0.6, with a sd of 0.1 and 0.2
    assert result.steps == (1, 1)
    assert "of 1 track that changes to the estimator of another adaptation period" in str(result)
    vague = replace(estimator(), qualities=tuple(Quality(51, 0.1, 0.5, 0.1) for _ in range(3)))
    assert usual(vague).steps == (1, 0)
    assert "interpolation" not in str(usual(vague))
    assert usual(estimator(), interpolate=True).steps == (0, 0)


def followed(contrasts: list[float], taken_s: list[float], track: list[int | None]) -> Steps:
    """Steps of one pedestrian, and of boxes without a track, by the contrast in each frame."""
    features = np.full((len(contrasts), 8), np.nan)
    features[:, CONTRAST] = contrasts
    taken = np.array(taken_s, np.float64)
    estimates = estimator().estimate(features, taken)
    rows = {"recording": "a", "frame": range(len(taken)), "period_s": taken}
    table = pd.DataFrame(rows).assign(detectability=estimates.detectability, sd=estimates.sd)
    table["track"] = pd.array(track, dtype="Int64")
    return steps_between_periods(estimator(), features, table, taken)


def test_without_tracks_no_steps_are_known_and_a_new_change_is_none():
    track = [1, 1, None, None]
    assert followed([60] * 4, [0.5, 4.5, 0.5, 4.5], track) == (1, 1)
    assert followed([60] * 4, [4.5, 0.5, 0.5, 4.5], track) == (0, 0)
    assert followed([], [], []) == (0, 0)


@pytest.mark.parametrize(
    ("contrasts", "n_jumping"),
    [
        ([60, 60], 1),  # 0.3 and 0.6 of the same
        ([0, 30], 0),  # from 0 to 0.3, but 0.15 and 0.3 of the later frame
        ([100, 50], 1),  # 0.5 twice, but 0.25 and 0.5
    ],
)
def test_a_step_is_what_the_next_estimator_alone_changes(contrasts: list[float], n_jumping: int):
    assert followed(contrasts, [0.5, 4.5], [1, 1]) == (1, n_jumping)


def test_a_feature_that_is_needed_and_missing_leaves_no_estimate(usual: Callable):
    result = usual(estimator(LAB))
    assert result.table[["detectability", "sd", "estimator_s"]].isna().all(axis=None)
    assert not result.table["is_outside"].any()
    assert "detectability known for 0 of 40 boxes: the estimator needs lab_distance" in (
        str(result)
    )


def test_boxes_that_lack_what_one_periods_estimator_needs_are_counted(usual: Callable):
    soon_by_colour = replace(
        estimator(), regressions=(regression(LAB), *estimator().regressions[1:])
    )
    result = usual(soon_by_colour)
    is_lacking = result.table["detectability"].isna()
    assert is_lacking.tolist() == [False] * 20 + [True] * 10 + [False] * 10
    assert result.table["is_outside"].isna().tolist() == is_lacking.tolist()
    assert (
        "10 boxes in pictures without an estimate (10 boxes are 0.25 to 2.5 s after a change of "
        "light): the estimator needs Lab distance there"
    ) in str(result)
    assert "without an estimate" not in str(usual(estimator()))


def test_print_says_what_to_take_with_care(usual: Callable):
    text = str(usual(estimator(simulated="all")))
    assert "detectability known for 40 of 40 boxes: 0.53 on average" in text
    assert "estimates are learnt from simulated subjects" in text
    assert "learnt in part from simulated subjects" in str(usual(estimator(simulated="some")))
    assert "20 estimates without a known change of light" in text
    assert "outside the range" not in text
    assert "simulated" not in str(usual(estimator()))
    assert "no better" not in str(usual(estimator()))


def with_second_system(place: Path) -> Path:
    with (place / "session.toml").open("a") as session:
        session.write('[[system]]\nname = "RGB"\npath = "truth.csv"\n')
    return place / "session.toml"


def test_why_the_estimator_is_to_be_doubted_is_said_and_recorded(place: Path):
    qualities = tuple(Quality(9, error, 0.5, 0.1) for error in (0.1, 0.04, 0.2))
    quick = replace(origin("all"), search="quick", picture_px=(128, 48))
    heights = estimator(FEATURE_KEYS.index("height_px"))
    write_estimator(replace(heights, qualities=qualities, origin=quick), place / "m.npz")
    written = estimate_driver(with_second_system(place), place / "m.npz", place / "out")
    caution = (
        "learnt from simulated subjects by a quick search and no better than a constant at 0.5 s"
    )
    assert f"estimates are {caution}" in str(written.run)
    record = json.loads(written.record.read_text())
    assert record["estimator"]["no_better_at_s"] == [0.5]
    assert record["estimator"]["search"] == "quick"
    assert record["estimator"]["picture_px"] == [128, 48]
    assert record["recordings"][0]["picture_px"] == [64, 48]
    dataset = load(read_session(written.session))
    assert dataset.of("driver") is not None
    of_all = (
        "learnt from simulated subjects by a quick search, no better than a constant at 0.5 s and "
        "in drive made on pictures of another width than in training"
    )
    assert dataset.of("driver").caution == of_all
    assert of_all in dataset.inputs["conversion"].iloc[-1]
    assert source(compare(dataset))[0]["caution"] == of_all


def trained_on(width: int, feature: str = "height_px") -> Estimator:
    plain = estimator(FEATURE_KEYS.index(feature))
    return replace(plain, origin=replace(origin(), picture_px=(width, 48)))


@pytest.mark.parametrize(("width", "is_other"), [(128, True), (48, True), (70, False), (58, True)])
def test_pictures_of_another_width_than_the_training_s_are_named(
    usual: Callable, width: int, is_other: bool
):
    result = usual(trained_on(width))  # they are 64 wide
    words = (
        f"pictures of drive are 64 px wide and the training pictures are {width} px wide, so the "
        "scale of Height"
    )
    assert (words in str(result)) == is_other
    assert result.counts_json().get("other_width") == ({"drive": 64} if is_other else None)
    of_colours = usual(trained_on(width, "luminance_contrast"))
    for is_silent in (of_colours, usual(estimator())):  # trained before it was kept
        assert "px wide" not in str(is_silent)
        assert "other_width" not in is_silent.counts_json()


def test_features_outside_the_training_are_named(usual: Callable):
    dim = replace(estimator(), regressions=tuple(regression(CONTRAST, high=50) for _ in range(3)))
    result = usual(dim)
    assert (result.table["outside_features"] == "luminance_contrast").all()
    assert result.outside_by_feature == {"Luminance contrast": 40}
    assert "40 estimates with features outside the training range (Luminance contrast in 40)" in (
        str(result)
    )
    assert (usual(estimator()).table["outside_features"] == "").all()


def test_where_nothing_is_known_of_the_light_is_counted(place: Path):
    readings = [f"{i / 10},1000" for i in range(50)]  # the last, at 4.9 s, holds a second
    (place / "lux.csv").write_text("\n".join(["time_s,lux", *readings]) + "\n")
    result = run(place, estimator())
    assert result.n_light_unknown == 28  # 12 before readings for 3 s, 16 after their end
    text = str(result)
    assert "40 estimates without a known change of light (for 28, it is not known when the" in text
    assert result.counts_json() == {
        "n": 40,
        "n_light_unknown": 28,
        "outside": {},
        "light_doubts": {"drive": "readings in 60 % of the recording"},
    }


def test_files_are_a_session_that_names_the_estimates_and_is_as_good_a_source(place: Path):
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
    model = record["estimator"]
    assert (model["name"], model["simulated"], model["n_subjects"]) == ("test", "no", 4)
    assert model["features"] == ["luminance_contrast"]
    digest = hashlib.sha256(written.detectability.read_bytes()).hexdigest()
    assert record["files"]["detectability.csv"] == digest
    again = estimate_driver(written.session, place / "model.npz", place / "again")
    assert again.detectability.read_bytes() == written.detectability.read_bytes()
    assert read_session(again.session).driver.detectability == str(again.detectability.absolute())


def test_features_are_computed_as_those_that_the_estimator_was_trained_on(
    place: Path, usual: Callable
):
    wide = replace(estimator(), feature_settings=FeatureSettings(surround=3))
    write_estimator(wide, place / "model.npz")
    files = place / "session.toml", place / "model.npz", place / "out"
    written = estimate_driver(*files)
    assert json.loads(written.record.read_text())["settings"]["features"]["surround"] == 3
    assert "does not state the settings" not in str(written.run)
    with pytest.raises(ParameterError, match="surround: the estimator was trained on features w"):
        estimate_driver(*files, settings={"surround": 2})
    with pytest.raises(ParameterError, match="with 3, found 2"):
        usual(wide)


def test_an_estimator_that_does_not_say_its_settings_is_used_and_that_is_noted(usual: Callable):
    assert (
        "the estimator does not state the settings of its features; settings here: "
        "surround 2, bin distance 1"
    ) in str(usual(estimator()))


@pytest.mark.parametrize(
    ("pictures", "column", "words"),
    [
        (
            "pictures =",
            CONTRAST,
            "no estimate from grey pictures that may be far infrared: drive; if they show "
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
    with pytest.raises(InputError, match=f"none of 40 boxes can be estimated: {words}"):
        estimate_driver(session, place / "m.npz", out)
    assert not out.exists()


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        (
            'gaze = "gaze.csv"',
            r"the estimator needs fixation_distance_px, which no box has \(drive: the gaze file "
            r"has frames 1000 to 1299, but the recording has 0 to 39\)$",
        ),
        (
            "visible_map = [1, 1, 640, 0]",
            r"the estimator needs fixation_distance_px, which no box has \(drive: with its "
            r"visible_map all boxes lie outside the picture\)$",
        ),
    ],
)
def test_why_no_box_has_a_feature_is_said(place: Path, keys: str, words: str):
    (place / "gaze.csv").write_text("frame,x,y\n1000,24,21\n1299,5,18\n")
    session = place / "session.toml"
    session.write_text(f"{session.read_text()}{keys}\n")
    write_estimator(estimator(FEATURE_KEYS.index("fixation_distance_px")), place / "m.npz")
    with pytest.raises(InputError, match=words):
        estimate_driver(session, place / "m.npz", place / "out")


def test_a_wrong_map_is_named_before_the_grey_pictures_of_other_recordings(place: Path):
    with (place / "truth.csv").open("a") as truth:
        truth.write("heat,0,20,10,8,16,5\n")
    write_picture(place / "heat" / "000.png", np.full((48, 64), 90, np.uint8))
    session = place / "session.toml"
    heat = '[[recording]]\nname = "heat"\nframes = "0:0"\npictures = "heat"\n'
    session.write_text(f"{session.read_text()}visible_map = [1, 1, 640, 0]\n{heat}")
    write_estimator(estimator(), place / "m.npz")
    with pytest.raises(InputError) as refused:
        estimate_driver(session, place / "m.npz", place / "out")
    cause, advice = str(refused.value).split("; no estimate from")
    assert "drive: with its visible_map all boxes lie outside the picture" in cause
    assert advice.startswith(" grey pictures that may be far infrared: heat;")


def test_pedestrians_without_a_picture_are_refused_and_recordings_without_any_are_fine(place: Path):
    (place / "truth.csv").write_text("recording,frame,x,y,w,h,track\ndrive,39,20,10,8,16,5\n")
    (place / "drive" / "039.png").unlink()
    write_estimator(estimator(), place / "m.npz")
    files = place / "session.toml", place / "m.npz", place / "out"
    with pytest.raises(InputError, match="box cannot be estimated: it is in a frame without a pic"):
        estimate_driver(*files)
    (place / "truth.csv").write_text("recording,frame,x,y,w,h,track\n")
    assert estimate_driver(*files).run.n_estimated == 0


def test_what_is_read_is_not_replaced(place: Path):
    write_estimator(estimator(), place / "model.npz")
    with pytest.raises(InputError, match="is an input, and would be replaced"):
        estimate_driver(place / "session.toml", place / "model.npz", place)
    with pytest.raises(InputError, match=r"session\.toml: is not an estimator"):
        estimate_driver(place / "session.toml", place / "session.toml", place / "out")

"""Speed alerts: stored limits and episodes countable by hand, and those of the sample drives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import NAN, Box, Place, make_dataset, result_of
from inputs import nvcore as run
from places import SAMPLE

import nvcore as nv
from nvcore.common.errors import ParameterError
from nvcore.dataset import Dataset
from nvcore.settings.params import Params
from nvcore.subjects.alerts.speeding import (
    NO_LIMIT,
    Speeding,
    find_speeding,
    judge_speeding,
    limit_of,
)

LABELS = ("30", "50", "80", "end of speed limit", "give way")
N_FRAMES = 12
HALF_SECOND = Place(range(N_FRAMES), fps=2.0)
"""2 s are four frames."""


def sign(frame: int, shows: str, track: int = -1, **more: object) -> Box:
    size = more.pop("size", 20)
    return Box(frame, 10, 10, size, size, track, label=LABELS.index(shows), **more)


def drive(truth=(), x=(), y=(), *, kmh: object = 60.0, places=(HALF_SECOND,)) -> Dataset:
    dataset = make_dataset(truth, x, y, places=places, labels=LABELS)
    return replace(dataset, frames=dataset.frames.assign(speed_kmh=np.asarray(kmh, dtype=float)))


def judged(*args: object, match_class: str = "any", after_s: float = 2.0, **more) -> Speeding:
    result = result_of(drive(*args, **more), match_class=match_class, speeding_after_s=after_s)
    return judge_speeding(result)


def rows(speeding: Speeding, *columns: str) -> list[tuple[object, ...]]:
    table = speeding.episodes[["subject", "state", *columns]].round(6).astype(object)
    return [tuple(row) for row in table.where(table.notna(), None).itertuples(index=False)]


TRUTH = [
    *(sign(1, "30", 1), sign(2, "30", 1)),
    *(sign(5, "50", 2), sign(6, "50", 2), sign(7, "50", 2)),
    *(sign(8, "end of speed limit", 3), sign(9, "end of speed limit", 3)),
    *(sign(10, "give way", 4), sign(11, "80", 5)),
]


def test_the_truth_stores_a_limit_from_the_last_annotated_frame_of_its_sign():
    stored = judged(TRUTH).stored["truth"].limit_kmh
    expected = [NAN, NAN, 30, 30, 30, 30, 30, 50, 50, NO_LIMIT, NAN, NAN]  # 80 is not passed
    np.testing.assert_array_equal(stored, expected)


def test_a_system_stores_what_it_read_last_and_of_several_the_highest_box():
    x = [
        sign(1, "80"),  # misread
        sign(2, "30"),
        *(sign(6, "50", size=9), sign(6, "80", size=30)),
        sign(7, "50", score=0.2),  # below the threshold
        sign(8, "give way"),  # no limit: what it had stays
    ]
    dataset = drive(
        TRUTH, [box._replace(score=box.score if box.score == 0.2 else 0.9) for box in x]
    )
    stored = judge_speeding(result_of(dataset, threshold_x=0.5)).stored
    np.testing.assert_array_equal(stored["x"].limit_kmh, [NAN, 80, *[30] * 4, *[80] * 6])
    assert np.isnan(stored["y"].limit_kmh).all()


def test_every_recording_begins_without_a_limit_and_lanes_are_runs_of_it():
    later = [box._replace(recording=1, frame=box.frame + 3) for box in TRUTH[:2]]
    speeding = judged([*TRUTH[:2], *later], places=(HALF_SECOND, HALF_SECOND))
    lanes = speeding.limits()
    own = lanes[lanes["subject"] == "truth"]
    shown = own[["recording", "first_row", "last_row", "start_s", "stop_s", "limit_kmh"]]
    np.testing.assert_array_equal(
        shown,
        [
            (0, 0, 1, 0, 1, NAN),
            (0, 2, 11, 1, 6, 30),
            (1, 12, 16, 0, 2.5, NAN),
            (1, 17, 23, 2.5, 6, 30),
        ],
    )
    assert (lanes["subject"] == "x").sum() == 2


def found(limit: object, kmh: object, after_s: float = 2.0, **more) -> list[tuple[int, ...]]:
    frames = drive(kmh=kmh, **more).frame_columns
    limit_kmh = np.broadcast_to(np.asarray(limit, dtype=float), len(frames))
    table = find_speeding(limit_kmh, frames.speed_kmh, frames, after_s=after_s)
    return [tuple(row) for row in table.itertuples(index=False)]


def test_an_alert_begins_two_seconds_after_the_car_was_first_above_the_limit():
    kmh = [50, 51, *[60] * 8, 50, 60]
    assert found(50, kmh) == [(5, 9)]  # 50 is not above 50; frame 1 is at 0.5 s, frame 5 at 2.5
    assert found(50, kmh, after_s=4.0) == [(9, 9)]
    assert found(50, kmh, after_s=4.1) == []
    assert found(50, kmh, after_s=0.0) == [(1, 9), (11, 11)]


def test_the_end_of_a_recording_ends_an_alert_and_the_two_seconds():
    assert found(50, [*[50] * 7, *[60] * 5]) == [(11, 11)]
    assert found(50, [*[50] * 8, *[60] * 8, *[50] * 8], places=[HALF_SECOND] * 2) == []


def test_an_unknown_limit_or_speed_interrupts_and_another_limit_does_not():
    assert found([50] * 5 + [30] * 7, [60] * 12) == [(4, 11)]
    assert found([50] * 5 + [NAN] + [50] * 6, [60] * 12) == [(4, 4), (10, 11)]
    assert found(50, [60] * 3 + [NAN] + [60] * 8) == [(8, 11)]
    assert found([NO_LIMIT] * 6 + [50] * 6, [200] * 12) == [(10, 11)]


FIFTY = [sign(frame, "50", 1) for frame in range(3)]
"""Passed in frame 2: at 60 km/h the driver is to be alerted from frame 6 on."""


def test_alerts_are_right_early_or_late_by_their_first_frame():
    speeding = judged(FIFTY, [sign(1, "50")], [sign(4, "50")])
    assert rows(speeding, "first_row", "last_row", "late_s", "limit_kmh", "top_kmh") == [
        ("truth", "true", 6, 11, None, 50, 60),
        ("x", "right", 5, 11, -0.5, 50, 60),
        ("y", "right", 8, 11, 1.0, 50, 60),
    ]
    summary = speeding.summary()
    assert summary[["system", "true", "alerted", "right", "false"]].to_numpy().tolist() == [
        ["x", 1, 1, 1, 0],
        ["y", 1, 1, 1, 0],
    ]
    assert summary["right_limit"].tolist() == [1.0, 0.8]  # of 10 frames; Y lacks 2 and 3
    assert summary["no_limit_s"].tolist() == [0.5, 2.0]
    assert summary["true_no_limit_s"].tolist() == [1.0, 1.0]


@pytest.mark.parametrize("match_class", ["any", "same"])
def test_a_misread_sign_misses_the_alert_and_its_cause_is_told(match_class: str):
    speeding = judged(FIFTY, [sign(2, "80")], match_class=match_class)
    assert rows(speeding, "cause", "first_row", "true_limit_kmh") == [
        ("truth", "true", "", 6, 50),
        ("x", "missed", "misread", 6, 50),
        ("y", "missed", "not_read", 6, 50),
    ]
    assert speeding.summary()["missed_misread"].tolist() == [1, 0]
    assert speeding.summary()["median_late_s"].isna().all()


EIGHTY = [sign(0, "80", 1), *(sign(frame, "80", 2) for frame in range(4, 9))]
"""Passed in frames 0 and 8; at 60 km/h nobody is to be alerted."""


@pytest.mark.parametrize(
    ("truth", "read", "cause"),
    [
        (EIGHTY, [sign(0, "30")], "misread"),
        (EIGHTY, [sign(2, "30")], "no_sign"),
        ([sign(0, "30", 1), sign(1, "80", 2)], [sign(0, "30")], "not_read"),
        ([sign(0, "80", 1), *(sign(f, "50", 2) for f in range(3, 12))], [sign(4, "50")], "ahead"),
    ],
)
def test_a_false_alert_has_a_cause(truth: list[Box], read: list[Box], cause: str):
    speeding = judged(truth, read)
    assert [row for row in rows(speeding, "cause") if row[0] == "x"] == [("x", "false", cause)]
    assert speeding.summary().loc[0, ["true", "alerts", f"false_{cause}"]].tolist() == [0, 1, 1]


def test_the_right_limit_at_other_times_is_a_matter_of_timing():
    passed = [sign(frame, "50", 1) for frame in range(1, 4)]
    early = judged(passed, [sign(1, "50")], kmh=[60] * 7 + [50] * 5)
    assert rows(early, "cause", "first_row") == [("x", "false", "timing", 5)]
    read_again = [*FIFTY, *(sign(frame, "50", 2) for frame in (4, 5))]
    late = judged(read_again, [sign(5, "50")], kmh=[60] * 9 + [50] * 3)
    assert rows(late, "cause", "first_row")[1] == ("x", "missed", "timing", 6)


def test_an_alert_where_the_truth_knows_no_limit_is_neither_right_nor_false():
    speeding = judged([sign(11, "50", 1)], [sign(1, "50")])
    assert rows(speeding, "cause") == [("x", "not_known", "")]
    assert speeding.summary().loc[0, ["alerts", "false", "not_known"]].tolist() == [1, 0, 1]


def test_without_a_speed_nobody_is_alerted_and_the_seconds_are_told():
    speeding = judged(FIFTY, [sign(1, "50")], kmh=NAN)
    assert speeding.episodes.empty
    assert speeding.summary()["no_speed_s"].tolist() == [6.0, 6.0]


def test_without_signs_or_frames_there_is_nothing():
    nothing = judged()
    assert nothing.episodes.empty
    assert np.isnan(nothing.summary()["right_limit"]).all()
    assert judged(places=(Place(()),), kmh=[]).limits().empty


def test_limits_may_be_in_miles_per_hour():
    truth = [sign(0, "30", 1), sign(4, "end of speed limit", 2), sign(6, "give way", 3)]
    stored = judge_speeding(result_of(drive(truth), limit_unit="mph")).stored["truth"].limit_kmh
    np.testing.assert_allclose(stored[[0, 4, 6]], [48.28032, NO_LIMIT, NAN])


def test_the_command_shows_what_is_not_known_and_writes_names_of_recordings(tmp_path):
    path = SAMPLE.parent / "speed_signs" / "session.toml"
    result = run("alerts", path, "--limit-unit", "mph", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "while no true limit is known" in result.output
    assert "time without a known speed (s)" in result.output
    written = pd.read_csv(tmp_path / "speeding.csv")
    assert set(written["recording"]) <= {"into_village", "open_road", "past_school"}
    assert written["limit_kmh"].dropna().isin([48.28032, 80.4672, 128.74752]).all()


def test_classes_that_speak_of_an_end_are_ends():
    ends = ["restriction ends 80", "end_of_speed_limit", "No limit", "derestricted"]
    assert {limit_of(label) for label in ends} == {NO_LIMIT}
    assert np.isnan([limit_of("give way"), limit_of("bend"), limit_of("")]).all()


def test_an_impossible_setting_is_refused():
    with pytest.raises(ParameterError, match="speeding_after_s: expected 0 to 60"):
        Params(speeding_after_s=-1)


def test_the_sample_drives_have_an_alert_of_each_kind():
    speeding = judge_speeding(nv.compare(SAMPLE.parent / "speed_signs" / "session.toml").result)
    # into_village, open_road, past_school; seconds from their first frame
    assert rows(speeding, "cause", "recording", "start_s", "stop_s", "limit_kmh", "late_s") == [
        ("truth", "true", "", 0, 8.05, 10.2, 50, None),
        ("truth", "true", "", 2, 8.5, 12.1, 30, None),
        ("x", "right", "", 0, 9.0, 10.2, 50, 0.95),
        ("x", "false", "no_sign", 1, 12.65, 15.0, 80, None),
        ("x", "right", "", 2, 5.5, 12.1, 30, -3.0),
        ("y", "right", "", 0, 6.2, 10.2, 50, -1.85),
        ("y", "false", "not_read", 1, 8.8, 15.0, 80, None),
        ("y", "missed", "misread", 2, 8.5, 12.1, 80, None),
    ]
    summary = speeding.summary()
    assert summary["system"].tolist() == ["Mono", "Stereo"]
    assert summary["right_limit"].tolist() == pytest.approx([0.7674, 0.4945], abs=1e-4)


def test_nothing_is_said_of_urgency_where_no_object_is_braked_for():
    session = SAMPLE.parent / "speed_signs" / "session.toml"
    result = run("alerts", session, "--policy", "eager")
    assert result.exit_code == 0, result.output
    assert "alerted" in result.output
    assert "in time" not in result.output
    assert "urgent" not in result.output

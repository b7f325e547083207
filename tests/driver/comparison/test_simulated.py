"""A simulated change of light in words."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from nvcore.notes import say
from nvcore.settings.objects import PEDESTRIAN
from nvcore.subjects.driver.comparison.notes import simulated_change
from nvcore.subjects.driver.illumination.clock import period_after

NAN = np.nan


def course(*detectability: float, n_up_to: int = 3) -> pd.DataFrame:
    n = len(detectability)
    return pd.DataFrame(
        {
            "time_s": np.arange(n) / 10,
            "detectability": detectability,
            "is_up_to_relevant": np.arange(n) < n_up_to,
        }
    )


def simulated(*detectability: float, since: int = 1) -> pd.DataFrame:
    is_after = np.arange(len(detectability)) >= since
    return pd.DataFrame({"detectability": detectability, "is_simulated": is_after})


def words(was: pd.DataFrame, would: pd.DataFrame, change_s: float = 0.1) -> str:
    return say(simulated_change(was, would, threshold=0.5, change_s=change_s), PEDESTRIAN)


NOBODY_THERE = "The pedestrian is in no frame after the change, so nothing changes."


def test_frames_until_he_sees_the_pedestrian_are_counted_from_the_change():
    text = words(course(0.1, 0.8, 0.8, 0.8, 0.8), simulated(0.1, 0.1, 0.2, 0.4, 0.5))
    assert (
        "3 frames (0.30 s) later; without the change, the driver sees the pedestrian at once"
        in text
    )
    assert (
        "By the first frame that counts, at 0.20 s, the driver would **not** have seen the "
        "pedestrian" in text
    )


def test_where_a_real_change_ends_the_simulated_one_frames_until_then_are_meant():
    would = simulated(0.1, 0.1, 0.1, 0.9)
    would["is_simulated"] = [False, True, True, False]
    text = words(course(0.1, 0.1, 0.1, 0.9, n_up_to=4), would)
    assert "in 0 of 2 frames until the next real change, as without the change" in text


def test_of_a_pedestrian_who_comes_later_frames_count_from_where_he_appears():
    later = course(0.9, 0.9, 0.9)
    later["time_s"] += 4.1
    would = simulated(0.1, 0.1, 0.9, since=0)
    assert (
        "2 frames after the pedestrian appears, 4.20 s after the change; without the change, the "
        "driver sees the pedestrian as soon as the pedestrian appears, 4.00 s after the change"
    ) in words(later, would)


@pytest.mark.parametrize(
    ("was", "would", "expected"),
    [
        (
            (0.9, 0.9),
            (0.9, 0.1),
            "in 0 of 1 frame; without the change, the driver sees the pedestrian at once",
        ),
        (
            (0.9, 0.9),
            (0.9, 0.1),
            "the driver would have seen the pedestrian, with or without the change",
        ),
        (
            (0.1, 0.1),
            (0.1, 0.1),
            "the driver would not have seen the pedestrian, with or without the change",
        ),
        (
            (0.1, 0.1),
            (0.1, 0.9),
            "the driver would have seen the pedestrian; without the change, the driver would not "
            "have",
        ),
        ((0.9, 0.9), (0.9, 0.9), "at once, as without the change"),
    ],
)
def test_what_would_be_stands_beside_what_was(was, would, expected):
    assert expected in words(course(*was, n_up_to=2), simulated(*would))


BEFORE = "The driver had seen the pedestrian before, at 0.00 s: the change comes too late to matter"


def test_a_change_after_he_has_seen_the_pedestrian_comes_too_late_for_an_alert():
    text = words(course(0.5, 0.9, 0.9, 0.9), simulated(0.5, 0.1, 0.1, 0.9))
    assert BEFORE in text
    assert "would see the pedestrian again 2 frames (0.20 s) later; without" in text
    assert (
        "at 0.20 s, the driver would have seen the pedestrian, with or without the change" in text
    )


@pytest.mark.parametrize("n_up_to", [0, 1])
def test_a_frame_after_the_first_that_counts_is_no_alert_s_and_seeing_then_no_confirmation(
    n_up_to: int,
):
    """The pedestrian is seen in the frames that follow alone, and it is dark from the third on."""
    was, would = course(0.1, 0.9, 0.9, n_up_to=n_up_to), simulated(0.1, 0.9, 0.1, since=2)
    text = words(was, would, 0.2)
    assert "had seen" not in text
    assert "would see the pedestrian again in 0 of 1 frame" in text


def test_of_a_pedestrian_whom_he_has_not_seen_yet_nothing_is_said_of_before():
    text = words(course(0.49, 0.9, 0.9), simulated(0.49, 0.1, 0.9))
    assert "before, at" not in text
    assert "again" not in text
    assert "before, at" not in words(course(NAN, 0.9, 0.9), simulated(NAN, 0.1, 0.9))


def test_a_distant_pedestrian_need_not_be_seen_by_a_certain_frame():
    text = words(course(0.9, 0.9, n_up_to=0), simulated(0.9, 0.1))
    assert "The encounter is distant" in text


def test_a_change_after_the_last_frame_changes_nothing():
    assert NOBODY_THERE in words(course(0.9, 0.9), simulated(0.9, 0.9, since=2))


@pytest.mark.parametrize("fps", [10.0, 20.0, 25.0, 29.97])
def test_the_frame_before_the_change_is_seen_as_it_was(fps: float):
    frames = np.arange(60)
    table = pd.DataFrame(
        {"time_s": frames / fps, "detectability": 0.9, "is_up_to_relevant": frames < 20}
    )
    for k in range(1, 60):
        change_s = k / fps
        end_s = table["time_s"].to_numpy() + 1 / fps
        period_s, is_simulated = period_after(np.full(60, np.nan), end_s, change_s)
        would = np.where(period_s < 5.5 / fps, 0.1, 0.9)  # not in five frames
        after = pd.DataFrame({"detectability": would, "is_simulated": is_simulated})
        text = words(table, after, change_s)
        if k < 55:
            assert f"5 frames ({5 / fps:.2f} s) later" in text
        assert "the driver would have seen the pedestrian, with or without the change" in text
    text = words(table, after.assign(is_simulated=False), 60 / fps)
    assert NOBODY_THERE in text


def test_who_was_seen_by_the_frame_that_counts_still_is_where_it_becomes_dark_after_it():
    was = course(*[0.1, 0.1, 0.9, *[0.9] * 7])
    end_s = was["time_s"].to_numpy() + 0.1
    _, is_simulated = period_after(np.full(10, np.nan), end_s, 0.3)
    would = pd.DataFrame(
        {
            "detectability": np.where(is_simulated, 0.1, was["detectability"]),
            "is_simulated": is_simulated,
        }
    )
    text = words(was, would, 0.3)
    assert (
        "at 0.20 s, the driver would have seen the pedestrian, with or without the change" in text
    )


def test_where_nothing_is_known_after_the_change_nothing_is_said_of_who_sees():
    text = words(course(NAN, NAN, NAN), simulated(NAN, NAN, NAN))
    assert "After the change, it is not known in any frame whether the driver would see" in text
    assert "at 0.20 s, it is not known whether the driver would have seen the pedestrian." in text
    assert "in 0 of" not in text


def test_frames_in_which_it_is_not_known_are_neither_seen_nor_unseen():
    text = words(course(0.9, NAN, NAN, NAN), simulated(0.1, 0.1, NAN, NAN))
    assert (
        "in 0 of 1 frame in which it is known (3 in all); without the change, it is not known"
        in text
    )
    assert (
        "the driver would **not** have seen the pedestrian; without the change, the driver would "
        "have." in text
    )
    later = words(course(NAN, NAN, NAN, 0.9), simulated(0.1, NAN, 0.1, 0.9))
    assert "at the latest 2 frames (0.20 s) later, as without the change" in later
    assert (
        "the driver would **not** have seen the pedestrian; without the change, it is not known."
        in later
    )


def test_a_simulated_observer_is_named():
    note = simulated_change(
        course(0.9, 0.9),
        simulated(0.9, 0.1),
        threshold=0.5,
        change_s=0.1,
        caution="learnt from simulated subjects",
    )
    assert note["caution"] == "learnt from simulated subjects"

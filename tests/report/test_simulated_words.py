"""A simulated change of light in words."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from nvcore.report.verdict.simulated import NOBODY_THERE, describe_change


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


def words(was: pd.DataFrame, would: pd.DataFrame) -> str:
    return describe_change(was, would, threshold=0.5, change_s=0.1)


def test_frames_until_he_sees_the_pedestrian_are_counted_from_the_change():
    text = words(course(0.1, 0.8, 0.8, 0.8, 0.8), simulated(0.1, 0.1, 0.2, 0.4, 0.5))
    assert "3 frames (0.30 s) later; as it was, at once" in text
    assert "By the first frame that counts, at 0.20 s, he would **not** have seen him" in text


@pytest.mark.parametrize(
    ("was", "would", "expected"),
    [
        ((0.9, 0.9), (0.9, 0.1), "in none of 1 frame; as it was, at once"),
        ((0.9, 0.9), (0.9, 0.1), "he would have seen him, as it was"),
        ((0.1, 0.1), (0.1, 0.1), "he would not have seen him, as it was"),
        ((0.1, 0.1), (0.1, 0.9), "he would have seen him; as it was, he had not"),
        ((0.9, 0.9), (0.9, 0.9), "at once; so he does as it was"),
    ],
)
def test_what_would_be_stands_beside_what_was(was, would, expected):
    assert expected in words(course(*was, n_up_to=2), simulated(*would))


def test_a_distant_pedestrian_need_not_be_seen_by_a_certain_frame():
    text = words(course(0.9, 0.9, n_up_to=0), simulated(0.9, 0.1))
    assert "The encounter is distant" in text


def test_a_change_after_the_last_frame_changes_nothing():
    assert NOBODY_THERE in words(course(0.9, 0.9), simulated(0.9, 0.9, since=2))

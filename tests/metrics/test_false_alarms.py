from __future__ import annotations

import numpy as np
import pytest
from builders import at, make_dataset, result_of

from nvcore.metrics.false_alarms import EPISODE_COLUMNS, find_episodes, summarise_false_alarms


def test_a_warning_that_flickers_annoys_once() -> None:
    dataset = make_dataset(x=[at(f, 50) for f in (2, 3, 6, 8)], n_frames=20)
    episodes = result_of(dataset).x.episodes
    assert list(episodes) == list(EPISODE_COLUMNS)
    assert episodes.to_numpy().tolist() == [[0, 2, 8, 4, pytest.approx(0.7)]]


def test_rates_by_hand() -> None:
    # 20 frames at 10 Hz are 2 s: two episodes of 0.3 s and 0.1 s, four boxes
    boxes = [at(0, 20), at(1, 20), at(2, 20), at(9, 70)]
    summary = result_of(make_dataset(x=boxes, n_frames=20)).x.false_alarm_summary
    assert (summary.count, summary.episodes) == (4, 2)
    assert summary.per_frame == 0.2
    assert summary.per_minute == pytest.approx(120)
    assert summary.episodes_per_hour == pytest.approx(3600)
    assert summary.mean_episode_s == pytest.approx(0.2)
    assert summary.longest_episode_s == pytest.approx(0.3)


def test_without_false_alarms_rates_are_0_and_durations_undefined() -> None:
    summary = result_of(make_dataset(n_frames=5)).x.false_alarm_summary
    assert (summary.count, summary.per_frame, summary.episodes_per_hour) == (0, 0, 0)
    assert np.isnan([summary.mean_episode_s, summary.longest_episode_s]).all()


def test_without_frames_rates_are_undefined() -> None:
    dataset = make_dataset()
    episodes = find_episodes(dataset.system("x"), np.empty(0, bool), dataset.frame_columns)
    summary = summarise_false_alarms(0, episodes, n_frames=0, duration_s=0.0)
    assert np.isnan([summary.per_frame, summary.per_minute, summary.episodes_per_hour]).all()

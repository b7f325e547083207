"""Lost similarity and the worst window, by recording and over all."""

from __future__ import annotations

import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.notes import Note, say
from nvcore.settings.objects import PEDESTRIAN
from nvcore.tables.windows import ALL, windows_table, worst_windows_note


def test_the_recording_that_loses_most_follows_the_row_over_all():
    """At 10 fps a window of 0.2 s holds three frames. X misses one of 10, Y three of 5."""
    places = [Place(range(10)), Place([]), Place(range(5))]
    truth = [at(i, 50, track=1) for i in range(10)]
    truth += [at(i, 50, track=1, recording=2) for i in range(5)]
    x = [box for box in truth if (box.recording, box.frame) != (0, 4)]
    y = [box for box in truth if (box.recording, box.frame) not in [(2, 1), (2, 2), (2, 3)]]
    table = windows_table(result_of(make_dataset(truth, x, y, places=places), window=0.2))
    assert table["recording"].tolist() == [ALL, "r2", "r0"]
    assert table["recording_index"].tolist() == [-1, 2, 0]
    # X loses 0.9 * 0.1 s of 1.5 s, Y 3 * 0.9 * 0.1 s
    assert table["lost_s_per_min_x"].to_numpy() == pytest.approx([3.6, 0, 5.4])
    assert table["lost_s_per_min_y"].to_numpy() == pytest.approx([10.8, 32.4, 0])
    assert table["window_similarity_y"].to_numpy() == pytest.approx([0.1, 0.1, 1])
    assert table["window_lost_s_y"].to_numpy() == pytest.approx([0.27, 0.27, 0])
    assert table["window_row_y"].tolist() == [12, 12, 0]
    assert table["window_recording_y"].tolist() == ["r2", "r2", "r0"]
    assert table["window_time_s_y"].to_numpy() == pytest.approx([0.2, 0.2, 0])
    note = Note("moments.worst_windows", x="r0", x_s=0.3, y="r2", y_s=0.2)
    assert say(worst_windows_note(table), PEDESTRIAN) == say(note, PEDESTRIAN)
    # the missed frame is the last of the first window that holds it
    assert table["window_row_x"].tolist() == [3, 10, 3]


def test_of_a_single_recording_there_is_one_row():
    truth = [at(i, 50, track=1) for i in range(4)]
    table = windows_table(result_of(make_dataset(truth, truth, truth[:2])))
    assert table["recording"].tolist() == ["r0"]


def test_without_frames_the_table_is_empty():
    table = windows_table(result_of(make_dataset(places=[Place([])])))
    assert len(table) == 0
    assert "window_time_s_x" in table

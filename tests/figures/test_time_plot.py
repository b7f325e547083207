"""Similarity over time."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import shape, trace, words

from nvcore.comparison import Result
from nvcore.figures import over_time as time_plot
from nvcore.figures.over_time import similarity_plot


def missed_by_y(**more: int) -> Result:
    """Ten frames at 10 fps, a pedestrian in the middle; Y misses it in frames 3 and 4."""
    frames = range(10)
    truth = [at(i, 50, track=3) for i in frames]
    y = [at(i, 50) for i in frames if i not in (3, 4)]
    return result_of(make_dataset(truth, truth, y), window=0.0, **more)


def test_the_traces_hold_the_similarity_of_every_frame() -> None:
    result = missed_by_y()
    figure = similarity_plot(result, 0, theme="light", cursor_row=4)
    assert trace(figure, "X, frame by frame").y.tolist() == [1.0] * 10
    drawn = trace(figure, "Y, frame by frame")
    assert drawn.y == pytest.approx([1, 1, 1, 0.1, 0.1, 1, 1, 1, 1, 1])
    assert drawn.x == pytest.approx(np.arange(10) / 10)
    assert [trace(figure, name).line.dash for name in ("X: x", "Y: y")] == ["solid", "dash"]
    assert shape(figure, "cursor").x0 == shape(figure, "cursor").x1 == pytest.approx(0.4)
    elsewhere = similarity_plot(result, 0, theme="light", cursor_row=99)
    assert [part.name for part in elsewhere.layout.shapes] == ["low limit"]


def test_a_recording_of_a_single_frame_is_drawn_and_without_frames_it_says_so() -> None:
    result = result_of(make_dataset([at(0, 50, track=1)], places=[Place([0]), Place([])]))
    figure = similarity_plot(result, 0, theme="light", cursor_row=0)
    assert trace(figure, "X, frame by frame").x.tolist() == [0.0]
    assert figure.layout.xaxis.range[1] > 0
    assert "no frames" in words(similarity_plot(result, 1, theme="light"))


def test_a_low_interval_is_shaded_between_the_limit_and_the_trace() -> None:
    figure = similarity_plot(missed_by_y(), 0, theme="light")
    area = trace(figure, "Y, low similarity")
    # from the limit of 0.9 down to 0.1 and back; a ninth of a step before frame 3 and after 4
    assert area.x[:-1] == pytest.approx([0.2 + 1 / 90, 0.3, 0.4, 0.5 - 1 / 90, 0.2 + 1 / 90])
    assert area.y[:-1] == pytest.approx([0.9, 0.1, 0.1, 0.9, 0.9])
    assert len(trace(figure, "X, low similarity").x) == 0


def test_only_the_worst_intervals_are_drawn_and_the_number_of_all_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    truth = [at(i, 50, track=3) for i in range(9)]
    y = [at(i, 50) for i in (0, 2, 5, 8)]  # missed: 1; 3, 4; 6, 7
    result = result_of(make_dataset(truth, truth, y))
    monkeypatch.setattr(time_plot, "MAX_INTERVALS", 2)
    figure = similarity_plot(result, 0, theme="light")
    area = trace(figure, "Y, low similarity")
    assert np.count_nonzero(np.isnan(area.x)) == 2
    assert not np.any(np.isclose(area.x, 0.1))
    assert "low-similarity intervals: X 0, Y 3" in words(figure)


def test_an_event_is_a_bar_of_its_duration() -> None:
    figure = similarity_plot(missed_by_y(), 0, theme="light")
    bar = trace(figure, "Y, saliency events")
    assert (bar.base.tolist(), bar.x.tolist()) == ([0.3], [pytest.approx(0.2)])
    mark = trace(figure, "Y, events")
    assert mark.customdata.tolist() == [3]
    assert "Y misses pedestrian 3 for 0.20 s" in mark.text[0]
    assert len(trace(figure, "X, saliency events").x) == 0


def test_a_click_gives_the_row_of_the_frame_over_all_recordings() -> None:
    places = [Place(range(3)), Place(range(4))]
    truth = [at(i, 50, track=1, recording=1) for i in range(4)]
    result = result_of(make_dataset(truth, truth, truth, places=places))
    frames = trace(similarity_plot(result, 1, theme="dark"), "frames")
    assert frames.customdata.tolist() == [3, 4, 5, 6]
    assert frames.marker.opacity == 0
    assert frames.text[1].startswith("frame 1, 0.10 s")


def test_upright_time_runs_upwards_and_the_middle_is_perfect() -> None:
    figure = similarity_plot(missed_by_y(), 0, theme="light", layout="upright", cursor_row=4)
    x, y = trace(figure, "X, frame by frame"), trace(figure, "Y, frame by frame")
    assert (x.xaxis, y.xaxis, x.yaxis, y.yaxis) == ("x", "x3", "y", "y")
    assert y.x == pytest.approx([1, 1, 1, 0.1, 0.1, 1, 1, 1, 1, 1])
    assert y.y == pytest.approx(np.arange(10) / 10)
    assert figure.layout.xaxis.domain[1] < figure.layout.xaxis3.domain[0]
    left, right = figure.layout.xaxis.range, figure.layout.xaxis3.range
    assert left[1] > left[0]
    assert right[1] < right[0]
    assert shape(figure, "cursor").y0 == pytest.approx(0.4)
    assert figure.layout.height > similarity_plot(missed_by_y(), 0, theme="light").layout.height


def test_side_by_side_similarity_grows_to_the_right_for_both_systems() -> None:
    figure = similarity_plot(missed_by_y(), 0, theme="light", layout="side_by_side", cursor_row=4)
    assert trace(figure, "Y, frame by frame").xaxis == "x3"
    left, right = figure.layout.xaxis.range, figure.layout.xaxis3.range
    assert left == right
    assert right[1] > right[0]
    assert shape(figure, "cursor").y0 == pytest.approx(0.4)


def test_a_long_recording_is_drawn_by_at_most_4000_points_a_line() -> None:
    truth = [at(i, 50, track=3) for i in range(9000)]
    y = [at(i, 50) for i in range(9000) if i != 4321]
    figure = similarity_plot(result_of(make_dataset(truth, truth, y)), 0, theme="light")
    assert max(len(part.x) for part in figure.data) <= 4000
    drawn = trace(figure, "Y, frame by frame")
    assert drawn.y.min() == pytest.approx(0.1)
    assert 432.1 in drawn.x.tolist()
    assert "9,000 frames" in words(figure)


def test_names_are_text_and_not_markup() -> None:
    result = missed_by_y()
    result.dataset.recordings.loc[0, "name"] = "<a href='x'>night</a>"
    figure = similarity_plot(result, 0, theme="light")
    assert "<a" not in words(figure)
    assert "&lt;a href" in words(figure)

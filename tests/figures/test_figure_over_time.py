"""Similarity over time, and what each frame loses to misses and to false alarms."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import shape, trace, words

from nvcore.comparison.compare import Result
from nvcore.figures import over_time
from nvcore.figures.over_time import keep_peaks, loss_plot, similarity_plot

Y_MISSES = [1, 1, 1, 0.1, 0.1, 1, 1, 1, 1, 1]
"""A pedestrian in the middle is missed in frames 3 and 4."""
X_ALARM = 0.1 * 25 / 50
"""A tenth of 25 px from the edge (and from the pedestrian), of a half width of 50 px."""


def failing(n_frames: int, missed: tuple[int, ...], alarm: int) -> Result:
    truth = [at(i, 50, track=3) for i in range(n_frames)]
    y = [at(i, 50) for i in range(n_frames) if i not in missed]
    return result_of(make_dataset(truth, [*truth, at(alarm, 25)], y), window=0.0)


@pytest.fixture(scope="module")
def result() -> Result:
    """Ten frames at 10 fps: Y misses the pedestrian in two, X has a false alarm in another."""
    return failing(10, (3, 4), 7)


@pytest.fixture(scope="module")
def second() -> Result:
    """Two recordings, in the second a pedestrian whom Y misses."""
    truth = [at(i, 50, track=1, recording=1) for i in range(4)]
    places = [Place(range(3)), Place(range(4))]
    return result_of(make_dataset(truth, truth, [], places=places))


@pytest.fixture(scope="module")
def long() -> Result:
    """A long recording with one lost frame of each system."""
    return failing(9000, (4321,), 77)


def test_the_traces_hold_the_similarity_of_every_frame(result: Result) -> None:
    figure = similarity_plot(result, 0, theme="light", cursor_row=4)
    drawn = trace(figure, "X, frame by frame")
    assert drawn.y == pytest.approx([1] * 7 + [1 - X_ALARM] + [1] * 2)
    assert trace(figure, "Y, frame by frame").y == pytest.approx(Y_MISSES)
    assert drawn.x == pytest.approx(np.arange(10) / 10)
    assert [trace(figure, name).line.dash for name in ("X: x", "Y: y")] == ["solid", "dash"]
    assert shape(figure, "cursor").x0 == shape(figure, "cursor").x1 == pytest.approx(0.4)
    elsewhere = similarity_plot(result, 0, theme="light", cursor_row=99)
    assert [part.name for part in elsewhere.layout.shapes] == ["low limit"]


def test_a_low_interval_is_shaded_between_the_limit_and_the_trace(result: Result) -> None:
    figure = similarity_plot(result, 0, theme="light")
    area = trace(figure, "Y, low similarity")
    # from the limit of 0.9 down to 0.1 and back; a ninth of a step before frame 3 and after 4
    assert area.x[:-1] == pytest.approx([0.2 + 1 / 90, 0.3, 0.4, 0.5 - 1 / 90, 0.2 + 1 / 90])
    assert area.y[:-1] == pytest.approx([0.9, 0.1, 0.1, 0.9, 0.9])
    assert len(trace(figure, "X, low similarity").x) == 0


def test_an_event_is_a_bar_of_its_duration(result: Result) -> None:
    figure = similarity_plot(result, 0, theme="light")
    bar, mark = trace(figure, "Y, saliency events"), trace(figure, "Y, events")
    assert (bar.base.tolist(), bar.x.tolist()) == ([0.3], [pytest.approx(0.2)])
    assert mark.customdata.tolist() == [3]
    assert "Y misses pedestrian 3 for 0.20 s" in mark.text[0]
    assert len(trace(figure, "X, saliency events").x) == 0


def test_only_the_worst_intervals_are_drawn_and_the_number_of_all_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    result = failing(9, (1, 3, 4, 6, 7), 0)
    monkeypatch.setattr(over_time, "MAX_INTERVALS", 2)
    figure = similarity_plot(result, 0, theme="light")
    area = trace(figure, "Y, low similarity")
    assert np.count_nonzero(np.isnan(area.x)) == 2
    assert not np.any(np.isclose(area.x, 0.1))
    assert "low-similarity intervals: X 0, Y 3" in words(figure)


@pytest.mark.parametrize(("layout", "way"), [("upright", -1), ("side_by_side", 1)])
def test_upright_time_runs_upwards_and_similarity_from_or_to_the_middle(
    result: Result, layout: over_time.TimeLayout, way: int
) -> None:
    figure = similarity_plot(result, 0, theme="light", layout=layout, cursor_row=4)
    x, y = trace(figure, "X, frame by frame"), trace(figure, "Y, frame by frame")
    assert (x.xaxis, y.xaxis, x.yaxis, y.yaxis) == ("x", "x3", "y", "y")
    assert y.x == pytest.approx(Y_MISSES)
    assert y.y == pytest.approx(np.arange(10) / 10)
    assert figure.layout.xaxis.domain[1] < figure.layout.xaxis3.domain[0]
    left, right = figure.layout.xaxis.range, figure.layout.xaxis3.range
    assert left[1] > left[0]
    assert right == left[::way]
    assert shape(figure, "cursor").y0 == pytest.approx(0.4)
    assert figure.layout.height > similarity_plot(result, 0, theme="light").layout.height


def test_losses_to_misses_and_to_false_alarms_are_stacked_to_one_minus_similarity(
    result: Result,
) -> None:
    figure = loss_plot(result, 0, theme="light", cursor_row=4)
    assert trace(figure, "Y, misses").y == pytest.approx(1 - np.array(Y_MISSES))
    assert trace(figure, "X, false alarms").y == pytest.approx([0] * 7 + [X_ALARM] + [0] * 2)
    for letter, system in result.sides:
        pair = [trace(figure, f"{letter.upper()}, {kind}") for kind in ("misses", "false alarms")]
        assert pair[0].y + pair[1].y == pytest.approx(1 - system.similarity)
        assert {part.stackgroup for part in pair} == {letter}
        assert pair[0].x == pytest.approx(np.arange(10) / 10)
    assert shape(figure, "cursor").x0 == pytest.approx(0.4)
    assert figure.layout.yaxis.range == figure.layout.yaxis2.range == (0, 1)
    # of 1 s Y loses 2 * 0.1 s * 0.9, X 0.1 s * 0.05
    assert "X 0.30, Y 10.80" in words(figure)


def test_a_click_gives_the_row_of_the_frame_over_all_recordings(second: Result) -> None:
    frames = trace(similarity_plot(second, 1, theme="dark"), "frames")
    assert frames.customdata.tolist() == [3, 4, 5, 6]
    assert frames.marker.opacity == 0
    assert frames.text[1] == "frame 1, 0.10 s<br>X 1.00   Y 0.10"
    clicks = [part for part in loss_plot(second, 1, theme="light").data if part.name == "frames"]
    assert [part.customdata.tolist() for part in clicks] == [[3, 4, 5, 6]] * 2
    assert {part.yaxis for part in clicks} == {"y", "y2"}
    assert "Y loses 0.900 to misses" in clicks[0].text[0]


def test_a_recording_of_one_frame_is_drawn_without_frames_it_says_so_and_names_are_text() -> None:
    result = result_of(make_dataset([at(0, 50)], [at(0, 50)], places=[Place([0]), Place([])]))
    result.dataset.recordings.loc[0, "name"] = "<a href='x'>night</a>"
    figure = similarity_plot(result, 0, theme="light", cursor_row=0)
    assert trace(figure, "X, frame by frame").x.tolist() == [0.0]
    assert figure.layout.xaxis.range[1] > 0
    assert "<a" not in words(figure)
    assert "&lt;a href" in words(figure)
    assert trace(loss_plot(result, 0, theme="light"), "X, misses").y.tolist() == [0]
    for plot in (similarity_plot, loss_plot):
        assert "no frames" in words(plot(result, 1, theme="light"))


def test_a_single_lost_frame_of_a_long_recording_is_drawn(long: Result) -> None:
    similarity, losses = (plot(long, 0, theme="light") for plot in (similarity_plot, loss_plot))
    assert max(len(part.x) for part in (*similarity.data, *losses.data)) <= 4000
    drawn = trace(similarity, "Y, frame by frame")
    assert drawn.y.min() == pytest.approx(0.1)
    assert 432.1 in drawn.x.tolist()
    assert "9,000 frames" in words(similarity)
    misses, alarms = trace(losses, "Y, misses"), trace(losses, "X, false alarms")
    assert misses.x[misses.y > 0] == pytest.approx([432.1])
    assert alarms.x[alarms.y > 0] == pytest.approx([7.7])


@pytest.mark.parametrize("n", [30, 61, 120])
@pytest.mark.parametrize("n_points", [14, 25, 40])
def test_the_rows_kept_hold_the_largest_value_of_each_stretch(n: int, n_points: int) -> None:
    first, second = np.random.default_rng(n).integers(0, 9, size=(2, n)) / 8  # with equal values
    rows = keep_peaks(first, second, n_points=n_points)
    if n <= n_points:
        assert rows.tolist() == list(range(n))
        return
    assert len(rows) <= n_points
    assert (rows[0], rows[-1]) == (0, n - 1)
    starts = np.linspace(0, n, (n_points - 2) // 3, endpoint=False).astype(int)
    for stretch in np.split(np.arange(n), starts[1:]):
        drawn = np.intersect1d(stretch, rows)
        for series in (first, second, -first - second):
            assert series[drawn].max() == series[stretch].max()

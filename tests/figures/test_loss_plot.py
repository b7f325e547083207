"""What each frame loses to misses and to false alarms."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import shape, trace, words
from hypothesis import given
from hypothesis import strategies as st

from nvcore.comparison import Result
from nvcore.figures.over_time import keep_peaks, loss_plot


def failing() -> Result:
    """Ten frames, a pedestrian in the middle; Y misses it in frames 3 and 4.

    In frame 7, X has a false alarm halfway to the edge.
    """
    truth = [at(i, 50, track=3) for i in range(10)]
    y = [at(i, 50) for i in range(10) if i not in (3, 4)]
    return result_of(make_dataset(truth, [*truth, at(7, 25)], y))


def test_losses_to_misses_and_to_false_alarms_are_stacked_to_one_minus_similarity():
    result = failing()
    figure = loss_plot(result, 0, theme="light", cursor_row=4)
    of_misses = trace(figure, "Y, misses")
    assert of_misses.y == pytest.approx([0, 0, 0, 0.9, 0.9, 0, 0, 0, 0, 0])
    of_alarms = trace(figure, "X, false alarms")
    # a tenth of 25 px from the edge (and from the pedestrian), of a half width of 50 px
    assert of_alarms.y == pytest.approx([0] * 7 + [0.1 * 25 / 50] + [0] * 2)
    for letter, system in result.sides:
        pair = [trace(figure, f"{letter.upper()}, {kind}") for kind in ("misses", "false alarms")]
        assert pair[0].y + pair[1].y == pytest.approx(1 - system.similarity)
        assert {part.stackgroup for part in pair} == {letter}
        assert pair[0].x == pytest.approx(np.arange(10) / 10)
    assert shape(figure, "cursor").x0 == pytest.approx(0.4)


def test_both_systems_have_one_scale_and_the_lost_seconds_per_minute_are_named():
    figure = loss_plot(failing(), 0, theme="dark")
    assert figure.layout.yaxis.range == figure.layout.yaxis2.range == (0, 1)
    # of 1 s Y loses 2 * 0.1 s * 0.9, X 0.1 s * 0.05
    assert "X 0.30, Y 10.80" in words(figure)


def test_a_click_in_either_panel_gives_the_row_of_the_frame():
    places = [Place(range(3)), Place(range(4))]
    truth = [at(i, 50, track=1, recording=1) for i in range(4)]
    result = result_of(make_dataset(truth, truth, [], places=places))
    figure = loss_plot(result, 1, theme="light")
    clicks = [part for part in figure.data if part.name == "frames"]
    assert [part.customdata.tolist() for part in clicks] == [[3, 4, 5, 6]] * 2
    assert {part.yaxis for part in clicks} == {"y", "y2"}
    assert "Y loses 0.900 to misses" in clicks[0].text[0]


def test_without_frames_it_says_so_and_a_perfect_pair_has_empty_areas():
    result = result_of(make_dataset([at(0, 50)], [at(0, 50)], places=[Place([0]), Place([])]))
    assert "no frames" in words(loss_plot(result, 1, theme="light"))
    assert trace(loss_plot(result, 0, theme="light"), "X, misses").y.tolist() == [0]


def test_a_single_lost_frame_of_a_long_recording_is_drawn():
    truth = [at(i, 50, track=3) for i in range(9000)]
    y = [at(i, 50) for i in range(9000) if i != 4321]
    figure = loss_plot(result_of(make_dataset(truth, [*truth, at(77, 25)], y)), 0, theme="light")
    assert max(len(part.x) for part in figure.data) <= 4000
    misses, alarms = trace(figure, "Y, misses"), trace(figure, "X, false alarms")
    assert misses.x[misses.y > 0] == pytest.approx([432.1])
    assert alarms.x[alarms.y > 0] == pytest.approx([7.7])


@given(
    st.lists(st.floats(0, 1), min_size=30, max_size=120),
    st.integers(14, 40),
    st.randoms(use_true_random=False),
)
def test_the_rows_kept_hold_the_largest_value_of_each_stretch(values, n_points, random):
    first = np.array(values)
    second = np.array(random.sample(values, len(values)))
    rows = keep_peaks(first, second, n_points=n_points)
    assert len(rows) <= n_points or len(first) <= n_points
    assert rows[0] == 0
    assert rows[-1] == len(first) - 1
    if len(first) > n_points:
        starts = np.linspace(0, len(first), (n_points - 2) // 3, endpoint=False).astype(int)
        for stretch in np.split(np.arange(len(first)), starts[1:]):
            drawn = np.intersect1d(stretch, rows)
            for series in (first, second, -first - second):
                assert series[drawn].max() == series[stretch].max()

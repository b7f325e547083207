"""The strip of all recordings."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import trace, words

from nvcore.comparison import Result
from nvcore.figures.lanes import MAX_STRIP_CLICKS, loss_strip_plot
from nvcore.tables.loss_strip import loss_strip


def drives(n_recordings: int, n_frames: int = 40) -> Result:
    """In recording r both systems miss the pedestrian of frame r alone."""
    truth = [at(r, 50, recording=r) for r in range(n_recordings)]
    places = [Place(range(n_frames))] * n_recordings
    return result_of(make_dataset(truth, [], [], places=places))


def test_colours_are_losses_and_a_click_opens_the_frame_that_loses_most():
    result = drives(3)
    figure = loss_strip_plot(result, loss_strip(result, n_bins=10), theme="light")
    heat, clicks = trace(figure, "loss"), trace(figure, "frames")
    assert heat.z[:, 0] == pytest.approx([0.9] * 3)
    assert heat.zmax == 1
    # four frames a bin; in the third recording frame 2 of the first bin
    worst = next(row for row, y in zip(clicks.customdata, clicks.y, strict=True) if y == 2)
    assert worst == 2 * 40 + 2
    assert "frame 2, 0.20 s" in clicks.text[20]
    assert clicks.x[0] == pytest.approx(0.2)
    assert figure.layout.yaxis.ticktext[2] == "r2"


def test_with_many_recordings_neighbours_share_a_click_and_the_worst_frame_stays():
    result = drives(50, n_frames=60)
    strip = loss_strip(result)
    figure = loss_strip_plot(result, strip, theme="dark")
    clicks = trace(figure, "frames")
    assert len(clicks.x) <= MAX_STRIP_CLICKS
    assert set(60 * np.arange(50) + np.arange(50)) <= set(clicks.customdata.tolist())
    assert "50 recordings" in words(figure)
    few = loss_strip_plot(result, loss_strip(result, most=10), theme="dark")
    assert "the 10 in which most is lost drawn" in words(few)


def test_without_frames_it_says_so():
    result = result_of(make_dataset(places=[Place([])]))
    assert "no evaluated frame" in words(loss_strip_plot(result, loss_strip(result), theme="light"))

"""Clips: the rule by which they are cut, and that they are compared as recordings are."""

import numpy as np
import pytest
from builders import NAN, at, make_dataset, result_of

from nvcore.common.errors import InputError
from nvcore.subjects.ratings.clips import clip_name, compare_clips, cut_clips, stretch_of
from nvcore.subjects.ratings.validation import clip_saliency


def frames(begin_s, end_s):
    return range(round(10 * begin_s), round(10 * end_s))


@pytest.fixture(scope="module")
def result():
    """A minute at 10 frames a second: two pedestrians, and false alerts of both systems."""
    truth = [at(f, 50, track=3) for f in frames(10, 14)] + [
        at(f, 30, track=4) for f in frames(58, 60)
    ]
    x = [box for box in truth if box.frame >= 110] + [at(f, 90) for f in frames(12, 12.5)]
    y = [*truth, *(at(f, 80) for f in frames(21, 22))]
    return result_of(make_dataset(truth, x, y, n_frames=600))


def test_clips_begin_before_what_happens_and_what_begins_inside_belongs_to_them(result):
    clips = cut_clips(result)
    assert clips.to_numpy().tolist() == [
        ["r0 [5-20 s]", "r0", 5.0, 20.0, "encounter 3; false alert of x"],
        ["r0 [20-35 s]", "r0", 20.0, 35.0, "false alert of y"],  # not from 16 s: no overlap
        ["r0 [45-60 s]", "r0", 45.0, 60.0, "encounter 4"],  # not from 53 s: as long as the others
    ]
    short = cut_clips(result, length_s=2, lead_s=0.5)
    assert short["start_s"].tolist() == [9.5, 11.5, 20.5, 57.5]
    assert short["end_s"].tolist() == [11.5, 13.5, 22.5, 59.5]
    long = cut_clips(result, length_s=100)
    assert long["clip"].tolist() == ["r0 [0-60 s]"]  # the whole recording, once
    with pytest.raises(InputError, match="begins 0 to 2 s before"):
        cut_clips(result, length_s=2, lead_s=2)


def test_no_two_clips_overlap_and_every_event_begins_in_one(result):
    rng = np.random.default_rng(3)
    for length_s, lead_s in zip(rng.uniform(1, 30, 20), rng.uniform(0, 1, 20), strict=True):
        clips = cut_clips(result, length_s=length_s, lead_s=lead_s)
        start_s, end_s = clips["start_s"].to_numpy(), clips["end_s"].to_numpy()
        assert (start_s[1:] >= end_s[:-1]).all()
        assert (end_s - start_s <= length_s + 0.002).all()
        assert (start_s.min(), end_s.max() - 60) == pytest.approx(
            (max(start_s.min(), 0), min(end_s.max() - 60, 0))
        )
        for begin_s in (10, 12, 21, 58):
            assert ((start_s <= begin_s) & (begin_s < end_s)).sum() == 1


def test_a_clips_name_says_what_it_is_of():
    assert stretch_of(clip_name("night [x]", 1.5, 16.25)) == ("night [x]", 1.5, 16.25)
    assert stretch_of(clip_name("night", NAN, NAN))[0] == "night"


def test_clips_that_make_up_a_recording_lose_what_it_loses(result):
    halves = compare_clips(
        result, ["r0 [0-30 s]", "r0 [30-60 s]", "another [0-3 s]", "r0 [70-80 s]"]
    )
    assert halves.dataset.recordings["name"].tolist() == ["r0 [0-30 s]", "r0 [30-60 s]"]
    for letter in "xy":
        of_halves, whole = halves.system(letter), result.system(letter)
        np.testing.assert_array_equal(of_halves.similarity, whole.similarity)
        np.testing.assert_array_equal(of_halves.false_alarms, whole.false_alarms)
    clips = clip_saliency(halves)
    assert clips["recording"].tolist() == ["r0"] * 4
    whole = clip_saliency(result)
    for of in ("loss_miss", "loss_false"):
        assert clips[of].to_numpy().reshape(2, 2).mean(axis=1) == pytest.approx(whole[of])
    assert clips["missed_s"].tolist() == [1.0, 0, 0, 0]  # X misses the first for a second
    assert np.isnan(clips["recency"].to_numpy()).tolist() == [False, True, True, True]


def test_recency_of_a_clip_counts_to_its_end(result):
    one = compare_clips(result, ["r0 [1-21 s]"])  # the miss ends at 11 s: in the middle
    assert clip_saliency(one)["recency"][0] == pytest.approx(0.5)
    assert clip_saliency(one)["saliency_s"][0] == pytest.approx(0.5)


def test_whole_recordings_are_the_comparison_itself(result):
    assert compare_clips(result, ["r0"]) is result
    assert compare_clips(result, ["r0", "r0 [0-5 s]"]).dataset.recordings["name"].tolist() == [
        "r0", "r0 [0-5 s]",
    ]  # fmt: skip

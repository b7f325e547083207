from __future__ import annotations

from builders import Box, Place, at, make_dataset

from nvcore.dataset import Dataset
from nvcore.metrics.linking import TruthTracks, track_truth


def tracks(dataset: Dataset) -> TruthTracks:
    return track_truth(dataset.truth, dataset.frame_columns)


def test_truth_without_tracks_is_linked_and_the_result_says_where() -> None:
    truth = [at(0, 50, track=4), at(0, 50, recording=1), at(1, 50, recording=1)]
    result = tracks(make_dataset(truth, places=[Place([0]), Place([0, 1])]))
    assert result.track.tolist() == [4, 1, 1]
    assert result.linked_recordings.tolist() == [1]


def test_new_tracks_never_meet_given_ones_of_their_recording() -> None:
    truth = [at(0, 20, track=12), at(0, 50), at(1, 50), at(0, 80, track=30, ignore=True)]
    track = tracks(make_dataset(truth)).track
    assert track.tolist() == [12, 31, 30, 31]


def test_ignored_boxes_are_not_linked() -> None:
    result = tracks(make_dataset([at(0, 50, ignore=True), at(1, 50)]))
    assert result.track.tolist() == [-1, 1]


def test_no_truth_has_no_tracks() -> None:
    result = tracks(make_dataset(n_frames=2))
    assert result.track.size == result.linked_recordings.size == 0


def test_linking_does_not_change_the_dataset() -> None:
    dataset = make_dataset([Box(0, 0, 0, 9, 9), Box(1, 0, 0, 9, 9)])
    tracks(dataset)
    assert dataset.truth.track.tolist() == [-1, -1]

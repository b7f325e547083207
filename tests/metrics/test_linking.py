from __future__ import annotations

import numpy as np
from builders import Box, Place, at, make_dataset

from nvcore.dataset import Dataset
from nvcore.metrics.kernels.linking import assign, assign_in_parts
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


def test_boxes_assigned_in_parts_are_assigned_as_all_at_once() -> None:
    rng = np.random.default_rng(3)
    for _ in range(300):
        n_rows, n_columns = rng.integers(1, 12, 2)
        gain = np.zeros((n_rows, max(n_rows, n_columns)))
        is_allowed = rng.random((n_rows, n_columns)) < rng.uniform(0.05, 0.6)
        gain[:, :n_columns] = is_allowed * rng.uniform(0.3, 1, (n_rows, n_columns))
        assert assign_in_parts(gain).tolist() == assign(gain).tolist()


def test_the_best_total_is_found_among_hundreds_of_boxes() -> None:
    # pairs of neighbours, each with a rival: 0.9 + 0.4 is less than 0.8 + 0.7
    gain = np.zeros((400, 400))
    for i in range(0, 400, 2):
        gain[i, i], gain[i, i + 1], gain[i + 1, i], gain[i + 1, i + 1] = 0.9, 0.8, 0.7, 0.4
    crossed = np.arange(400).reshape(-1, 2)[:, ::-1].ravel()
    assert assign_in_parts(gain).tolist() == crossed.tolist()

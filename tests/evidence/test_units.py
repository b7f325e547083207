from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from builders import Place, at, make_dataset, result_of
from scenes import draw_scene

from nvcore.comparison.compare import Result
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence.units import BLOCKS, RECORDINGS, find_units, sum_units


def drive(n_recordings: int, n_frames: int = 6, **params: object) -> Result:
    """Y misses the pedestrian of every other recording and has a false alarm in the others."""
    truth, x, y = [], [], []
    for number in range(n_recordings):
        for frame in range(n_frames):
            truth.append(at(frame, 50, track=1, recording=number))
            x.append(at(frame, 50, recording=number))
            y.append(at(frame, 50 if number % 2 else 10, recording=number))
    places = [Place(range(n_frames)) for _ in range(n_recordings)]
    return result_of(make_dataset(truth, x, y, places=places), **params)


def long_drive(n_frames: int = 400, seed: int = 0) -> Result:
    """One recording; Y loses a pedestrian at the middle for random stretches."""
    rng = np.random.default_rng(seed)
    is_lost = np.repeat(rng.random(n_frames // 10 + 1) < 0.3, 10)[:n_frames]
    truth = [at(frame, 50, track=frame // 20) for frame in range(n_frames)]
    x = [at(frame, 50) for frame in range(n_frames)]
    y = [at(frame, 50) for frame in range(n_frames) if not is_lost[frame]]
    return result_of(make_dataset(truth, x, y, n_frames=n_frames))


def test_eight_recordings_are_the_units() -> None:
    units = find_units(drive(8))
    assert (units.kind, len(units), units.n_recordings) == (RECORDINGS, 8, 8)
    assert units.unit_of_frame.tolist() == np.repeat(np.arange(8), 6).tolist()
    assert units.text == "8 recordings"
    assert units.note == ""
    assert np.isnan(units.block_s)


def test_fewer_than_six_recordings_are_cut_into_blocks_of_time() -> None:
    assert find_units(drive(6)).kind == RECORDINGS
    result = drive(5)
    units = find_units(result)
    assert units.kind == BLOCKS
    assert len(units) >= 5
    assert units.note.startswith("5 recordings only: intervals over blocks of time hold within")
    assert "6 recordings are needed" in units.note
    # no block has frames of two recordings
    recording = result.dataset.frame_columns.recording
    assert (units.recording[units.unit_of_frame] == recording).all()


def test_one_recording_is_cut_into_blocks_of_equal_length() -> None:
    result = long_drive()
    units = find_units(result)
    sizes = np.bincount(units.unit_of_frame)
    assert units.kind == BLOCKS
    assert 8 <= len(units) < 200
    assert sizes.max() - sizes.min() <= 1
    assert (np.diff(units.unit_of_frame) >= 0).all()
    assert units.block_s == pytest.approx(40 / len(units))
    assert units.note.startswith("one recording only")
    assert units.scope == "these recordings"


def test_a_long_recording_has_at_most_1000_blocks() -> None:
    rng = np.random.default_rng(1)
    truth = [at(frame, 50) for frame in range(3000)]
    y = [box for box in truth if rng.random() < 0.5]
    units = find_units(result_of(make_dataset(truth, truth, y)))
    assert 500 < len(units) <= 1000


def test_recordings_without_frames_are_no_units() -> None:
    places = [Place(range(3) if number != 4 else []) for number in range(9)]
    units = find_units(result_of(make_dataset(places=places)))
    assert (len(units), units.n_recordings) == (8, 8)
    assert 4 not in units.recording


def test_units_are_numbered_by_the_recordings_names() -> None:
    recordings = pd.DataFrame(
        {"name": list("hgfedcba"), "width": 100.0, "height": 100.0, "fps": 10.0}
    )
    boxes = pd.DataFrame(
        {"frame_index": [0], "source": [0], "x": [1.0], "y": 1.0, "w": 1.0, "h": 50.0}
    )
    dataset = dataset_from_tables(recordings, [np.arange(2)] * 8, boxes, ["x", "y"])
    units = find_units(result_of(dataset))
    assert units.unit_of_frame.tolist() == np.repeat(np.arange(8)[::-1], 2).tolist()
    assert units.recording.tolist() == list(range(7, -1, -1))


def test_a_dataset_without_frames_has_no_units() -> None:
    result = result_of(make_dataset(n_frames=0))
    units = find_units(result)
    assert len(units) == 0
    assert len(sum_units(result, units)) == 0


def test_sums_by_hand() -> None:
    result = drive(8)
    sums = sum_units(result, find_units(result))
    assert (sums["n_frames"] == 6).all()
    assert sums["duration_s"].tolist() == pytest.approx([0.6] * 8)
    assert (sums["n_encounters"] == 1).all()
    assert sums["encounters_detected_by_unit_x"].tolist() == [1] * 8
    assert sums["encounters_detected_by_unit_y"].tolist() == [0, 1] * 4
    assert sums["false_alert_episodes_per_hour_x"].tolist() == [0] * 8
    assert sums["false_alert_episodes_per_hour_y"].tolist() == [1, 0] * 4
    assert sums["mean_similarity_x"].tolist() == pytest.approx([6.0] * 8)
    # missed by 40 px of 50: D(G, S) = 40; the false alarm at 10 px is 10 px from the border
    lack = (0.9 * 40 + 0.1 * 10) / 50
    assert sums["mean_similarity_y"].tolist() == pytest.approx([6 * (1 - lack), 6.0] * 4)
    assert sums["share_low_y"].tolist() == [6, 0] * 4
    assert (sums["share_of_recording"] == 1).all()


def test_frames_with_exactly_the_limit_are_not_low() -> None:
    result = drive(8, low=1.0)
    assert sum_units(result, find_units(result))["share_low_x"].tolist() == [0] * 8


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("aggregate", ["max", "sum"])
def test_sums_of_all_units_are_the_measures_of_the_result(seed: int, aggregate: str) -> None:
    result = result_of(draw_scene(seed).dataset(), saliency_aggregate=aggregate)
    units = find_units(result)
    sums = sum_units(result, units)
    total = sums.sum()
    assert total["n_frames"] == len(result.dataset.frames)
    assert total["duration_s"] == pytest.approx(result.duration_s)
    assert total["n_encounters"] == result.venn.n_near
    assert total["share_of_recording"] == pytest.approx(len(result.dataset.recordings))
    for letter, system in (("x", result.x), ("y", result.y)):
        assert total[f"mean_similarity_{letter}"] == pytest.approx(system.similarity.sum())
        assert total[f"share_low_{letter}"] == (system.similarity < result.params.low).sum()
        assert total[f"false_alert_episodes_per_hour_{letter}"] == len(system.episodes)
        n_detected = system.encounters["is_detected"].sum()
        assert total[f"encounters_detected_by_unit_{letter}"] == n_detected
        if aggregate == "sum":
            of_all = total[f"saliency_{letter}"] / result.dataset.recordings.shape[0]
            assert of_all == pytest.approx(system.saliency_s)
        else:
            assert sums[f"saliency_{letter}"].isna().all()  # at most 3 recordings: blocks
            of_recordings = result.saliency_of_recordings(system)
            assert of_recordings.mean() == pytest.approx(system.saliency_s)


def test_saliency_of_a_recording_is_its_own_largest_event() -> None:
    result = drive(8)
    sums = sum_units(result, find_units(result))
    events = result.y.events
    assert len(events) == 4
    assert sums["saliency_y"].tolist()[::2] == pytest.approx(events["saliency_s"].tolist())
    assert sums["saliency_y"].tolist()[1::2] == [0] * 4

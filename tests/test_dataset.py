from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import Box, Place, at, make_dataset, tagged

from nvcore.common.errors import InputError
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.dataset.columns import frame_gaps
from nvcore.dataset.schema import (
    DATASET_BOX_DTYPES,
    FRAME_DTYPES,
    LEFT_OUT_DTYPES,
    RECORDING_DTYPES,
)
from nvcore.dataset.tables import dataset_from_tables, frames_table
from nvcore.settings.params import Params


def recordings(**columns: object) -> pd.DataFrame:
    return pd.DataFrame({"name": ["r"], "width": 100.0, "height": 50.0, "fps": 10.0, **columns})


def boxes(*rows: tuple[int, int, float]) -> pd.DataFrame:
    table = pd.DataFrame(rows, columns=["source", "frame_index", "x"])
    return table.assign(y=0.0, w=1.0, h=1.0)


@pytest.mark.parametrize(
    ("frames", "fps", "time_s", "step_s"),
    [
        ([9, 29, 49], 20, [0, 1, 2], [1, 1, 1]),
        ([0, 1, 5, 6], 10, [0, 0.1, 0.5, 0.6], [0.1, 0.4, 0.1, 0.1]),
        ([0, 1, 5], 10, [0, 0.1, 0.5], [0.1, 0.4, 0.25]),  # the last one is the median gap
        ([17], 25, [0], [0.04]),
    ],
)
def test_time_counts_from_the_first_listed_frame_and_steps_are_the_gaps_to_the_next(
    frames: list[int], fps: float, time_s: list[float], step_s: list[float]
) -> None:
    dataset = make_dataset(frames=frames, fps=fps)
    assert dataset.frames["frame"].tolist() == frames
    assert dataset.frames["time_s"].tolist() == pytest.approx(time_s)
    assert dataset.frames["step_s"].tolist() == pytest.approx(step_s)


def test_time_and_steps_start_anew_in_every_recording() -> None:
    dataset = make_dataset(places=[Place([0, 2, 4], fps=10), Place([7, 8], fps=5)])
    assert dataset.frames["time_s"].tolist() == [0, 0.2, 0.4, 0, 0.2]
    assert dataset.frame_columns.gap.tolist() == [2, 2, 2, 1, 1]
    assert dataset.frame_columns.duration_s == pytest.approx(1.0)


def test_a_recording_without_frames_takes_no_rows() -> None:
    dataset = make_dataset(places=[Place([]), Place([3, 4]), Place([])])
    assert dataset.frames["recording"].tolist() == [1, 1]
    assert dataset.frame_columns.first.tolist() == [0, 0, 2, 2]
    assert dataset.frame_columns.gap.tolist() == [1, 1]


def test_the_sampling_step_is_the_median_gap_of_each_recording() -> None:
    places = [Place([9, 29, 49, 69, 80]), Place([]), Place([3, 4, 5, 9]), Place([7])]
    assert make_dataset(places=places).frame_columns.sampling_step.tolist() == [20, 1, 1, 1]


def test_boxes_are_sorted_by_source_and_frame_and_keep_their_order_otherwise() -> None:
    table = boxes((1, 1, 11), (0, 1, 1), (1, 0, 10), (0, 0, 0), (1, 1, 12), (1, 0, 9))
    dataset = dataset_from_tables(recordings(), [np.arange(2)], table, ["x"])
    assert dataset.boxes["x"].tolist() == [0, 1, 10, 9, 11, 12]
    assert dataset.truth.offsets.tolist() == [0, 1, 2]
    assert dataset.system("x").offsets.tolist() == [0, 2, 4]


def test_many_boxes_of_one_frame_keep_their_order() -> None:
    table = boxes(*((i % 2, 0, i) for i in range(2000)))
    dataset = dataset_from_tables(recordings(), [np.arange(1)], table, ["x"])
    assert dataset.truth.x.tolist() == list(range(0, 2000, 2))
    assert dataset.system("x").x.tolist() == list(range(1, 2000, 2))


def test_a_source_knows_the_row_at_which_it_starts() -> None:
    dataset = make_dataset(truth=[(0, 1, 1, 2, 2, 5)], x=[(0, 3, 1, 2, 2)], y=[(0, 4, 1, 2, 2)])
    assert dataset.truth.first_row == 0
    assert dataset.system("y").first_row == 2
    assert dataset.system("y").x.tolist() == [4]
    assert len(dataset.system("y")) == 1


def test_frames_without_boxes_keep_their_place_in_the_offsets() -> None:
    dataset = make_dataset(x=[(2, 1, 1, 2, 2)], n_frames=4)
    assert dataset.system("x").offsets.tolist() == [0, 0, 0, 1, 1]
    assert dataset.truth.offsets.tolist() == [0, 0, 0, 0, 0]


def test_an_unknown_system_is_refused_with_the_known_ones() -> None:
    with pytest.raises(InputError, match="there is no system 'z'; there are x, y"):
        make_dataset().system("z")


@pytest.mark.parametrize("name", ["width", "height", "fps"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_a_size_or_frame_rate_that_is_no_positive_number_is_refused(
    name: str, value: float
) -> None:
    with pytest.raises(InputError, match=f"recording 'r': expected a positive {name}, found"):
        dataset_from_tables(recordings(**{name: value}), [np.arange(2)], boxes(), [])


def test_an_unknown_horizon_is_nan() -> None:
    dataset = dataset_from_tables(recordings(), [np.arange(1)], boxes(), [])
    assert np.isnan(dataset.frame_columns.horizon[0])
    given = dataset_from_tables(recordings(horizon=20.0), [np.arange(1)], boxes(), [])
    assert given.frame_columns.horizon[0] == 20


def test_tables_have_the_dtypes_of_the_schema_with_and_without_boxes() -> None:
    for dataset in (make_dataset(n_frames=1), make_dataset(truth=[Box(0, 1, 1, 2, 2)])):
        assert {n: str(d) for n, d in dataset.boxes.dtypes.items()} == DATASET_BOX_DTYPES
        assert {n: str(d) for n, d in dataset.frames.dtypes.items()} == FRAME_DTYPES
        assert list(dataset.recordings) == list(RECORDING_DTYPES)


def test_the_fingerprint_changes_with_any_value_and_name() -> None:
    table = boxes((0, 0, 1), (1, 0, 2))
    listed = [np.arange(2)]
    fingerprint = dataset_from_tables(recordings(), listed, table, ["a"]).fingerprint
    assert dataset_from_tables(recordings(), listed, table.copy(), ["a"]).fingerprint == fingerprint
    others = [
        dataset_from_tables(recordings(), listed, table, ["b"]),
        dataset_from_tables(recordings(fps=11.0), listed, table, ["a"]),
        dataset_from_tables(recordings(name=["s"]), listed, table, ["a"]),
        dataset_from_tables(recordings(), [np.array([0, 2])], table, ["a"]),
        dataset_from_tables(recordings(), listed, table.assign(x=[1, 2.5]), ["a"]),
    ]
    assert len({fingerprint, *(other.fingerprint for other in others)}) == 6


def test_a_given_fingerprint_is_kept() -> None:
    dataset = dataset_from_tables(recordings(), [np.arange(1)], boxes(), [], fingerprint="abc")
    assert dataset.fingerprint == "abc"


def test_the_given_tables_are_not_changed() -> None:
    table, sizes = boxes((1, 0, 2), (0, 0, 1)), recordings()
    before = table.copy(), sizes.copy()
    dataset_from_tables(sizes, [np.arange(1)], table, ["a"])
    pd.testing.assert_frame_equal(table, before[0])
    pd.testing.assert_frame_equal(sizes, before[1])


def test_nothing_left_out_keeps_its_columns() -> None:
    boxes = pd.DataFrame({"frame_index": [], "source": []})
    table = dataset_from_tables(recordings(), [np.arange(1)], boxes, ["a"]).left_out
    assert table.empty
    assert list(table) == list(LEFT_OUT_DTYPES)


def test_no_recording_at_all_gives_an_empty_frames_table() -> None:
    assert frames_table([], []).empty
    assert frame_gaps(np.empty(0, np.int64), np.array([0])).size == 0


def of_three() -> Dataset:
    """Three recordings of two frames; the box of a system in frame f is f px wide."""
    made = make_dataset(
        [Box(0, 1, 1, 9, 9, recording=r) for r in range(3)],
        [Box(f, 1, 1, 10 * r + f + 1, 9, recording=r) for r in range(3) for f in range(2)],
        places=[Place(range(2))] * 3,
    )
    return tagged(made, ("night", "rain"), ("day",), ("night",))


def test_only_recordings_with_all_tags_are_left() -> None:
    night = of_three().only(["night"])
    assert night.recordings["name"].tolist() == ["r0", "r2"]
    assert night.frames["recording"].tolist() == [0, 0, 1, 1]
    assert night.system("x").w.tolist() == [1, 2, 21, 22]
    assert night.system("x").frame_index.tolist() == [0, 1, 2, 3]
    assert night.notes == ("2 of 3 recordings: night",)
    assert of_three().only(["night"], ["r2"]).notes == ("1 of 3 recordings: night, of these r2",)
    assert of_three().only(["rain"], ["r0"]).notes == ("1 of 3 recordings: rain",)
    assert of_three().only(names=["r0"]).notes == ("1 of 3 recordings: r0",)
    assert of_three().only(["night", "rain"]).recordings["name"].tolist() == ["r0"]
    assert night.fingerprint != of_three().fingerprint


def test_the_part_is_compared_like_the_recordings_by_themselves() -> None:
    part, alone = of_three().only(names=["r1"]), of_three()
    similarity = compare(part, Params(proximity="none")).x.similarity
    whole = compare(alone, Params(proximity="none")).x.similarity
    assert np.array_equal(similarity, whole[2:4])


def test_all_recordings_chosen_are_the_same_data() -> None:
    made = of_three()
    assert made.only() is made
    assert made.only(names=["r0", "r1", "r2"]) is made


@pytest.mark.parametrize(
    ("tags", "names", "match"),
    [
        (["snow"], [], "no recording has the tag snow; the tags are day, night and rain"),
        (["nihgt"], [], "tag nihgt; did you mean 'night'\\? The tags are day, night and rain"),
        (["day"], ["r0"], "the tag day and one of these names"),
        ([], ["r9"], "there is no recording 'r9'"),
    ],
)
def test_a_choice_that_leaves_nothing_is_refused(tags, names, match: str) -> None:
    with pytest.raises(InputError, match=match):
        of_three().only(tags, names)


def test_rows_left_out_go_with_their_recording() -> None:
    lost = pd.DataFrame(
        [("x", name, 9, 0, 1, "frame not listed") for name in ("r0", "r1", "nowhere")],
        columns=list(LEFT_OUT_DTYPES)[:6],
    )
    part = replace(of_three(), left_out=lost).only(names=["r0"])
    assert part.left_out["recording"].tolist() == ["r0", "nowhere"]


def test_other_names_change_no_box() -> None:
    made = of_three()
    new = made.renamed({"x": "FIR"}, {"r1": "town"})
    assert new.systems == ("FIR", "y")
    assert new.recordings["name"].tolist() == ["r0", "town", "r2"]
    assert new.boxes is made.boxes
    assert new.fingerprint != made.fingerprint
    assert made.renamed({"x": "x"}, {}) is made


def test_two_of_a_name_are_refused() -> None:
    with pytest.raises(InputError, match="two systems would be called 'y'"):
        of_three().renamed({"x": "y"}, {})
    with pytest.raises(InputError, match="two recordings would be called 'r2'"):
        of_three().renamed({}, {"r1": "r2"})
    lost = pd.DataFrame(
        [("x", "B", 9, 0, 1, "unknown recording")], columns=list(LEFT_OUT_DTYPES)[:6]
    )
    with pytest.raises(InputError, match="two recordings would be called 'B'"):
        replace(of_three(), left_out=lost).renamed({}, {"r1": "B"})


def test_the_boxes_of_some_frames_know_their_frames_and_their_rows():
    dataset = make_dataset([at(f, 10 * f) for f in (0, 1, 1, 3)], [at(2, 9)], n_frames=4)
    boxes = dataset.truth.of_frames(1, 3)
    assert dataset.truth.rows_of(1, 3) == slice(1, 3)
    assert boxes.frame_index.tolist() == [1, 1]
    assert boxes.offsets.tolist() == [0, 2, 2]
    assert boxes.x.tolist() == dataset.truth.x[1:3].tolist()
    assert boxes.first_row == 1
    assert len(dataset.system("x").of_frames(0, 2)) == 0
    assert dataset.system("x").of_frames(2, 4).first_row == len(dataset.truth)

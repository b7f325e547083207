from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from places import DATA

from nvcore.errors import FormatError, MissingFactError
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.readers.coco import result_columns, results
from nvcore.inputs.readers.coco.truth import read as read_truth

FOLDER = DATA / "coco"
IMAGES = pd.DataFrame({"recording": ["a", "a", "b"], "frame": [5, 25, 5], "image_id": [0, 1, 2]})


def result(**fields: object) -> dict[str, object]:
    return {"image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5, **fields}


@pytest.fixture
def read_results(tmp_path: Path):
    def read_one(document: object, name: str = "results.json", **options: object) -> Reading:
        path = tmp_path / "results.json"
        text = document if isinstance(document, str) else json.dumps(document)
        path.write_text(text, encoding="utf-8")
        given = {"role": "detections", "images": IMAGES} | options
        return results.read([SourceFile(path, name)], ReadOptions(**given))

    return read_one


def test_results_take_recording_and_frame_from_the_truths_images():
    truth = read_truth([SourceFile(FOLDER / "kaist.json", "kaist.json")], ReadOptions())
    reading = results.read(
        [SourceFile(FOLDER / "results.json", "results.json")],
        ReadOptions(role="detections", images=truth.images),
    )
    columns = ["recording", "frame", "x", "y", "w", "h", "score"]
    assert reading.boxes[columns].to_numpy().tolist() == [
        ["set06/V000", 19, 500.5, 210.25, 20, 51, 0.75],
        ["set09/V000", 19, 99, 200, 31, 60, 0.5],
    ]


def test_flir_results_take_the_frame_from_the_picture():
    truth = read_truth([SourceFile(FOLDER / "flir.json", "flir.json")], ReadOptions())
    for images in (truth.images, None):
        reading = results.read(
            [SourceFile(FOLDER / "flir_results.json", "flir_results.json")],
            ReadOptions(role="detections", images=images),
        )
        columns = ["recording", "frame", "track", "score"]
        assert reading.boxes[columns].to_numpy().tolist() == [["BzZs", 124, 4, 0.9]]


def test_pictures_are_found_among_known_recordings(read_results):
    reading = read_results(
        [{"bbox": [1, 2, 3, 4], "image_filepath": "out/set06/V000/I00019.png"}],
        images=None,
        recordings=("set06/V000",),
    )
    assert reading.boxes[["recording", "frame"]].to_numpy().tolist() == [["set06/V000", 19]]


def test_a_picture_without_number_is_an_error(read_results):
    with pytest.raises(FormatError, match=r"results.json.*frame number .* found 'left.png'"):
        read_results([{"bbox": [1, 2, 3, 4], "image_filepath": "left.png"}], images=None)


def test_an_empty_list_is_a_system_that_detected_nothing(read_results):
    # peers 36
    reading = read_results([])
    assert reading.boxes.empty
    assert "nothing was detected" in reading.conversion


def test_results_may_be_wrapped_in_an_object(read_results):
    assert read_results({"annotations": [result()]}).boxes["frame"].tolist() == [25]


def test_a_wrapped_image_list_of_its_own_comes_first(read_results):
    images = [{"id": 1, "file_name": "drive/I00077.png"}]
    boxes = read_results({"images": images, "annotations": [result()]}).boxes
    assert boxes[["recording", "frame"]].to_numpy().tolist() == [["drive", 77]]


def test_ids_as_text_and_as_numbers_are_one(read_results):
    assert read_results([result(image_id="1")]).boxes["frame"].tolist() == [25]
    as_text = IMAGES.assign(image_id=["0", "1", "2"])
    assert read_results([result()], images=as_text).boxes["frame"].tolist() == [25]
    assert read_results([result(image_id=1.0)]).boxes["frame"].tolist() == [25]


def test_an_unknown_image_is_kept_out_and_reported(read_results):
    reading = read_results([result(), result(image_id=3), result(image_id=4)])
    assert len(reading.boxes) == 1
    (finding,) = reading.findings
    assert (finding.severity, finding.code, finding.count) == ("error", "unknown-image", 2)
    assert finding.example == "result 2, image 3"


def test_without_the_truths_images_the_error_says_to_give_them(read_results):
    with pytest.raises(MissingFactError, match=r"results.json: .*give a truth with an image list"):
        read_results([result()], images=None)


def test_ids_that_stand_for_two_images_need_a_file_per_recording(read_results):
    images = IMAGES.assign(image_id=[0, 1, 1])
    with pytest.raises(FormatError, match="one file per recording"):
        read_results([result()], images=images)
    assert read_results([result()], name="b.json", images=images).boxes["frame"].tolist() == [5]


def test_other_categories_are_left_out_and_counted_in_the_conversion(read_results):
    reading = read_results([result(), result(category_id=3), result(category_id=3)])
    assert len(reading.boxes) == 1
    assert "category_id 1 counted, 3 (2 results) left out" in reading.conversion


def test_classes_are_taken_as_numbers_or_as_person(read_results):
    rows = [result(), result(category_id=3)]
    assert len(read_results(rows, classes=("3",)).boxes) == 1
    assert len(read_results(rows, classes=("person", "3")).boxes) == 2


def test_class_names_cannot_be_found_in_numbered_results(read_results):
    with pytest.raises(FormatError, match="give the classes as numbers"):
        read_results([result(), result(category_id=3)], classes=("person", "cyclist"))


def test_a_single_category_other_than_one_counts_with_a_warning(read_results):
    reading = read_results([result(category_id=0)])
    assert len(reading.boxes) == 1
    assert [finding.code for finding in reading.findings] == ["unusual-category"]


def test_several_categories_without_a_person_are_an_error(read_results):
    with pytest.raises(FormatError, match="expected results of category_id 1"):
        read_results([result(category_id=2), result(category_id=3)])


def test_a_missing_score_is_unknown(read_results):
    row = result()
    del row["score"]
    assert read_results([row, result()]).boxes["score"].isna().tolist() == [True, False]


def test_track_ids_are_kept(read_results):
    assert read_results([result(track_id=3)]).boxes["track"].tolist() == [3]
    assert read_results([result(track_id="p")]).boxes["track"].tolist() == [0]


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (result(bbox=[1, 2, 3]), "found 3 values"),
        (result(bbox=[1, 2, 3, "4"]), "expected four numbers"),
        (result(score="high"), 'expected a number as "score"'),
        (result(category_id=[1]), "expected a number or text as category_id"),
        (result(image_id=None), '"image_id"'),
        (7, "expected an object"),
    ],
)
def test_a_faulty_result_is_named_with_its_number(read_results, row, message):
    with pytest.raises(FormatError, match=rf"line 1: result 2 of 2: .*{message}"):
        read_results([result(), row])


def test_a_result_without_image_is_an_error(read_results):
    with pytest.raises(FormatError, match='expected the field "image_id" or "image_filepath"'):
        read_results([{"bbox": [1, 2, 3, 4], "score": 1}])


@pytest.mark.parametrize("text", ["", "[{", '{"annotations": 3}', '"x"', "[" * 100_000])
def test_absurd_json_is_an_error(read_results, text):
    with pytest.raises(FormatError, match=r"results.json"):
        read_results(text)


def test_half_a_character_is_an_error_and_a_whole_pair_is_not(read_results):
    with pytest.raises(FormatError, match="half a character"):
        read_results(json.dumps([result(track_id="\ud800")]))
    assert len(read_results(json.dumps([result(track_id="\U0001f6b6")])).boxes) == 1


def test_fast_and_careful_parser_agree(tmp_path, monkeypatch):
    generator = np.random.default_rng(1)
    rows = [
        result(image_id=int(i % 3), bbox=box, score=score)
        for i, (*box, score) in enumerate(generator.random((50, 5)).tolist())
    ]
    path = tmp_path / "results.json"
    path.write_text(json.dumps(rows), encoding="utf-8")
    options = ReadOptions(role="detections", images=IMAGES)
    source = [SourceFile(path, "results.json")]
    assert result_columns._fast(source[0]) is not None
    fast = results.read(source, options)
    monkeypatch.setattr(result_columns, "_fast", lambda _: None)
    careful = results.read(source, options)
    pd.testing.assert_frame_equal(fast.boxes, careful.boxes, check_exact=True)
    assert fast.conversion == careful.conversion


def test_the_fast_parser_leaves_what_is_unusual_to_the_careful_one(tmp_path):
    path = tmp_path / "results.json"
    for row in (
        result(score=None), result(bbox=[1, 2, 3]), result(image_id="x"), result(note="},{"),
        result(category_id=True),
    ):  # fmt: skip
        path.write_text(json.dumps([result(), row]), encoding="utf-8")
        assert result_columns._fast(SourceFile(path, "results.json")) is None


def test_results_are_recognised_and_truth_is_not():
    truth = (FOLDER / "kaist.json").read_text(encoding="utf-8")
    for name in ("results.json", "flir_results.json"):
        text = (FOLDER / name).read_text(encoding="utf-8")
        assert results.recognise("a.json", text, "detections")
        assert not results.recognise("a.json", text, "truth")
    assert results.recognise("a.json", "[]\n", "detections")
    assert results.recognise("a.json", '{"annotations": [', "detections")
    assert not results.recognise("a.json", truth, "truth")
    assert not results.recognise("a.json", '[{"a": 1}]', "detections")
    assert not results.recognise("a.csv", "frame,x,y,w,h", "detections")

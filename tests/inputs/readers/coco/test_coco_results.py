from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from reader_files import golden, rows, source

from nvcore.common.errors import FormatError, MissingFactError
from nvcore.inputs.readers.base import LeftOut, Reading, ReadOptions
from nvcore.inputs.readers.coco import results
from nvcore.inputs.readers.coco.truth import read as read_truth

IMAGES = pd.DataFrame({"recording": ["a", "a", "b"], "frame": [5, 25, 5], "image_id": [0, 1, 2]})


def result(**fields: object) -> dict[str, object]:
    return {"image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5, **fields}


@pytest.fixture
def read_results(tmp_path: Path):
    def read_one(document: object, name: str = "results.json", **options: object) -> Reading:
        text = document if isinstance(document, str) else json.dumps(document)
        given = {"role": "detections", "images": IMAGES} | options
        return results.read([source(tmp_path, text, name)], ReadOptions(**given))

    return read_one


def golden_images(name: str) -> pd.DataFrame | None:
    return read_truth(golden("coco", name), ReadOptions()).images


def read_golden(name: str, images: pd.DataFrame | None) -> Reading:
    return results.read(golden("coco", name), ReadOptions(role="detections", images=images))


def test_results_take_recording_and_frame_from_the_truths_images():
    boxes = read_golden("results.json", golden_images("kaist.json")).boxes
    assert rows(boxes, "recording frame x y w h score") == [
        ["set06/V000", 19, 500.5, 210.25, 20, 51, 0.75],
        ["set09/V000", 19, 99, 200, 31, 60, 0.5],
    ]


def test_flir_results_take_the_frame_from_the_picture():
    for images in (golden_images("flir.json"), None):
        boxes = read_golden("flir_results.json", images).boxes
        assert rows(boxes, "recording frame track score") == [["BzZs", 124, 4, 0.9]]


def test_pictures_are_found_among_known_recordings_and_need_a_number(read_results):
    known = {"images": None, "recordings": ("set06/V000",)}
    picture = {"bbox": [1, 2, 3, 4], "image_filepath": "out/set06/V000/I00019.png"}
    assert rows(read_results([picture], **known).boxes, "recording frame") == [["set06/V000", 19]]
    with pytest.raises(FormatError, match=r"results.json.*frame number .* found 'left.png'"):
        read_results([picture | {"image_filepath": "left.png"}], **known)


def test_pictures_are_found_by_name_in_the_truths_list_or_else_by_their_number(read_results):
    images = IMAGES.assign(file_name=["left.png", "right.png", "b.png"])
    for name, place in (("out/right.png", ["a", 25]), ("drive/I00077.png", ["drive", 77])):
        picture = {"bbox": [1, 2, 3, 4], "image_filepath": name}
        assert rows(read_results([picture], images=images).boxes, "recording frame") == [place]


def test_an_empty_list_is_a_system_that_detected_nothing(read_results):
    reading = read_results([])
    assert reading.boxes.empty
    assert "nothing was detected" in reading.conversion


def test_results_may_be_wrapped_in_an_object_with_images_of_its_own(read_results):
    wrapped = {"annotations": [result()]}
    assert read_results(wrapped).boxes["frame"].tolist() == [25]
    wrapped["images"] = [{"id": 1, "file_name": "drive/I00077.png"}]
    assert rows(read_results(wrapped).boxes, "recording frame") == [["drive", 77]]


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


COCO: dict[str, object] = {"categories": {"1": "person", "3": "car"}, "numbering": "coco"}


def test_other_categories_are_left_out_and_counted(read_results):
    reading = read_results([result(), result(category_id=3), result(category_id=3)], **COCO)
    assert len(reading.boxes) == 1
    assert "person (1) counted; car (3) left out" in reading.conversion
    assert reading.left_out == (LeftOut("class", "car", 2),)


def test_a_result_without_a_category_has_no_name_and_is_left_out(read_results):
    unnamed = result()
    del unnamed["category_id"]
    reading = read_results([result(), unnamed], **COCO)
    assert len(reading.boxes) == 1
    assert [finding.code for finding in reading.findings] == ["unknown-class"]


def test_classes_are_taken_as_numbers_or_by_the_truths_names(read_results):
    rows = [result(), result(category_id=3)]
    assert len(read_results(rows, classes=("3",)).boxes) == 1
    assert len(read_results(rows, classes=("person", "3"), **COCO).boxes) == 2


@pytest.mark.parametrize(
    ("categories", "classes", "message"),
    [
        ((1, 3), ("person", "cyclist"), "several classes, and no names"),
        ((2, 3), None, "several classes, and no names"),
    ],
)
def test_classes_that_cannot_be_found_are_an_error(read_results, categories, classes, message):
    with pytest.raises(FormatError, match=message):
        read_results([result(category_id=number) for number in categories], classes=classes)


def test_a_single_category_other_than_one_counts_with_a_warning(read_results):
    reading = read_results([result(category_id=0)])
    assert len(reading.boxes) == 1
    assert [finding.code for finding in reading.findings] == ["unusual-category"]


def test_a_missing_score_is_unknown_and_track_ids_are_kept(read_results):
    row = result(track_id=3)
    del row["score"]
    assert rows(read_results([row, result()]).boxes, "score track") == [[None, 3], [0.5, -1]]
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
    random_results = [
        result(image_id=int(i % 3), bbox=box, score=score)
        for i, (*box, score) in enumerate(generator.random((50, 5)).tolist())
    ]
    options = ReadOptions(role="detections", images=IMAGES)
    file = source(tmp_path, json.dumps(random_results), "results.json")
    assert results._fast(file) is not None
    fast = results.read([file], options)
    monkeypatch.setattr(results, "_fast", lambda _: None)
    careful = results.read([file], options)
    pd.testing.assert_frame_equal(fast.boxes, careful.boxes, check_exact=True)
    assert fast.conversion == careful.conversion


def test_the_fast_parser_leaves_what_is_unusual_to_the_careful_one(tmp_path):
    unusual = {
        "score": None,
        "bbox": [1, 2, 3],
        "image_id": "x",
        "note": "},{",
        "category_id": True,
    }
    for field, value in unusual.items():
        text = json.dumps([result(), result(**{field: value})])
        file = source(tmp_path, text, "results.json")
        assert results._fast(file) is None

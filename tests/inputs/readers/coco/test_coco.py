from __future__ import annotations

import json
from pathlib import Path

import pytest
from places import DATA

from nvcore.errors import FormatError
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.readers.coco import truth as reader
from nvcore.schema import NO_TRACK

FOLDER = DATA / "coco"


def read_golden(name: str, **options: object) -> Reading:
    return reader.read([SourceFile(FOLDER / name, name)], ReadOptions(**options))


@pytest.fixture
def read_document(tmp_path: Path):
    def read_one(document: object, name: str = "truth.json", **options: object) -> Reading:
        path = tmp_path / "truth.json"
        text = document if isinstance(document, str) else json.dumps(document)
        path.write_text(text, encoding="utf-8")
        return reader.read([SourceFile(path, name)], ReadOptions(**options))

    return read_one


def document(images=None, annotations=None, categories=None, **more: object) -> dict[str, object]:
    return {
        "images": images if images is not None else [{"id": 1, "file_name": "a/I5.png"}],
        "annotations": annotations if annotations is not None else [],
        "categories": categories if categories is not None else [{"id": 1, "name": "person"}],
        **more,
    }


def annotation(**fields: object) -> dict[str, object]:
    return {"id": 1, "image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4], **fields}


def test_boxes_are_kept_as_they_are():
    boxes = read_golden("kaist.json").boxes
    assert boxes[["x", "y", "w", "h"]].to_numpy().tolist() == [
        [505, 212, 20, 50], [10.5, 20, 5, 12], [100, 200, 30, 60],
    ]  # fmt: skip


def test_recording_and_frame_come_from_kaists_image_name():
    boxes = read_golden("kaist.json").boxes
    assert boxes["recording"].tolist() == ["set06/V000", "set06/V000", "set09/V000"]
    assert boxes["frame"].tolist() == [19, 19, 19]


def test_image_and_annotation_ids_may_start_at_zero():
    # peers 34: other tools take id 0 for "no match"
    reading = read_golden("kaist.json")
    assert len(reading.boxes) == 3
    assert reading.images["image_id"].tolist() == [0, 1, 2]


def test_an_image_without_annotations_is_an_evaluated_frame():
    # peers 30
    images = read_golden("kaist.json").images
    assert list(zip(images["recording"], images["frame"], strict=True)) == [
        ("set06/V000", 19), ("set06/V000", 39), ("set09/V000", 19),
    ]  # fmt: skip


def test_flagged_boxes_and_cyclists_are_ignore_regions():
    assert read_golden("kaist.json").boxes["ignore"].tolist() == [False, True, True]


def test_ignore_is_kept_beside_iscrowd(read_document):
    # peers 35 (cocoapi PR#307): iscrowd 0 overwrote ignore 1
    flags = [(1, 0), (0, 1), (0, 0)]
    rows = [annotation(id=i, ignore=a, iscrowd=b) for i, (a, b) in enumerate(flags)]
    assert read_document(document(annotations=rows)).boxes["ignore"].tolist() == [True, True, False]


def test_iscrowd_may_be_absent(read_document):
    boxes = read_document(document(annotations=[annotation()])).boxes
    assert boxes["ignore"].tolist() == [False]


def test_classes_option_counts_cyclists_and_ignores_persons():
    reading = read_golden("kaist.json", classes=("cyclist",))
    assert reading.boxes["ignore"].tolist() == [True, True, False]


def test_classes_option_takes_numbers():
    assert read_golden("kaist.json", classes=("1", "2")).boxes["ignore"].tolist() == [
        False, True, False,
    ]  # fmt: skip


def test_an_unknown_class_is_an_error_that_lists_the_known():
    with pytest.raises(
        FormatError, match=r"no class 'walker'; found .*person \(1\), cyclist \(2\)"
    ):
        read_golden("kaist.json", classes=("walker",))


def test_a_category_called_nothing_like_a_person_is_an_error(read_document):
    with pytest.raises(FormatError, match=r"found car \(1\); name the classes"):
        read_document(document(categories=[{"id": 1, "name": "car"}]))


def test_cars_are_left_out_and_the_conversion_says_so():
    reading = read_golden("flir.json")
    assert len(reading.boxes) == 3
    assert "bike (2), car (3) left out" in reading.conversion


def test_occlusion_levels_of_kaist_are_kept():
    assert read_golden("kaist.json").boxes["occlusion"].tolist() == [0, 2, 1]


def test_occlusion_words_of_flir_become_levels():
    assert read_golden("flir.json").boxes["occlusion"].tolist() == [0, 1, 2]


def test_visible_share_becomes_levels(read_document):
    rows = [annotation(id=i, vis_ratio=share) for i, share in enumerate([1.0, 0.65, 0.64])]
    assert read_document(document(annotations=rows)).boxes["occlusion"].tolist() == [0, 1, 2]


def test_occluded_yes_or_no_is_read_as_nightowls_does(read_document):
    rows = [annotation(id=i, occluded=flag) for i, flag in enumerate([False, True])]
    assert read_document(document(annotations=rows)).boxes["occlusion"].tolist() == [0, 2]


def test_an_odd_occlusion_level_is_reported(read_document):
    reading = read_document(document(annotations=[annotation(occlusion=7)]))
    assert reading.boxes["occlusion"].tolist() == [-1]
    assert [finding.code for finding in reading.findings] == ["unknown-occlusion"]


def test_recording_and_frame_come_from_flirs_file_name():
    boxes = read_golden("flir.json").boxes
    assert boxes["recording"].unique().tolist() == ["BzZs"]
    assert boxes["frame"].tolist() == [123, 124, 124]


def test_text_track_ids_are_numbered_by_first_appearance():
    reading = read_golden("flir.json")
    assert reading.boxes["track"].tolist() == [0, 0, 1]
    assert "numbered by first appearance" in reading.conversion


def test_whole_track_ids_are_kept_and_missing_ones_are_none(read_document):
    rows = [annotation(id=1, track_id=12), annotation(id=2, track_id=3.0), annotation(id=3)]
    boxes = read_document(document(annotations=rows)).boxes
    assert boxes["track"].tolist() == [12, 3, NO_TRACK]


def test_distance_is_kept(read_document):
    rows = [annotation(distance_m=31.5)]
    assert read_document(document(annotations=rows)).boxes["distance_m"].tolist() == [31.5]


def test_category_zero_that_is_on_no_list_is_ignored_as_in_citypersons(read_document):
    rows = [annotation(category_id=0), annotation(id=2)]
    assert read_document(document(annotations=rows)).boxes["ignore"].tolist() == [True, False]


def test_video_table_gives_name_size_and_frame_rate(read_document):
    reading = read_document(
        document(
            images=[
                {"id": 1, "file_name": "x.png", "video_id": 3, "frame_index": 40, "width": 640,
                 "height": 480},
            ],
            annotations=[annotation()],
            videos=[{"id": 3, "name": "night drive", "fps": 20}],
        )
    )  # fmt: skip
    assert reading.recordings.to_numpy().tolist() == [["night drive", 640, 480, 20]]
    assert reading.boxes["frame"].tolist() == [40]


def test_names_without_number_are_numbered_by_their_order_and_reported(read_document):
    images = [{"id": 5, "file_name": "a/left.png"}, {"id": 6, "file_name": "a/right.png"}]
    reading = read_document(document(images=images, annotations=[annotation(image_id=6)]))
    assert reading.boxes[["recording", "frame"]].to_numpy().tolist() == [["a", 1]]
    assert [finding.code for finding in reading.findings] == ["frames-by-order"]
    assert "order of the list" in reading.conversion


def test_hashes_as_names_do_not_become_recordings(read_document):
    names = ["58c5a1.png", "58c5b2.png", "58c6c7.png", "59d8d9.png"]
    images = [{"id": i, "file_name": name} for i, name in enumerate(names)]
    reading = read_document(document(images=images), name="night.json")
    assert reading.images["recording"].tolist() == ["night"] * 4
    assert reading.images["frame"].tolist() == [0, 1, 2, 3]


def test_pictures_without_folder_belong_to_the_files_recording(read_document):
    reading = read_document(
        document(images=[{"id": 1, "file_name": "000012.png"}]), name="dusk.json"
    )
    assert reading.images[["recording", "frame"]].to_numpy().tolist() == [["dusk", 12]]


def test_pictures_of_one_recording_that_differ_in_size_are_reported(read_document):
    images = [
        {"id": i, "file_name": f"a/I{i}.png", "width": 640 if i else 320, "height": 512}
        for i in range(3)
    ]
    reading = read_document(document(images=images))
    assert reading.recordings[["width", "height"]].to_numpy().tolist() == [[640, 512]]
    assert reading.findings[0].code == "picture-size"
    assert reading.findings[0].count == 1


def test_missing_picture_size_is_unknown(read_document):
    assert read_document(document()).recordings[["width", "height"]].isna().all(axis=None)


def test_an_annotation_of_an_unknown_image_is_kept_out_and_reported(read_document):
    reading = read_document(document(annotations=[annotation(image_id=9), annotation(id=2)]))
    assert len(reading.boxes) == 1
    (finding,) = reading.findings
    assert (finding.severity, finding.code, finding.count) == ("error", "unknown-image", 1)
    assert "annotation 1, image_id 9" in finding.example


def test_an_image_listed_twice_in_the_same_words_is_taken_once(read_document):
    image = {"id": 1, "file_name": "a/I5.png"}
    reading = read_document(document(images=[image, image], annotations=[annotation()]))
    assert len(reading.images) == 1
    assert [finding.code for finding in reading.findings] == ["duplicate-image"]


def test_one_id_for_two_images_is_an_error(read_document):
    images = [{"id": 1, "file_name": "a/I5.png"}, {"id": 1, "file_name": "a/I6.png"}]
    with pytest.raises(FormatError, match="image 2 of 2: id 1 stands for two different images"):
        read_document(document(images=images))


def test_two_images_of_one_frame_are_an_error(read_document):
    images = [{"id": i, "file_name": "a/I5.png", "frame_index": 5} for i in (1, 2)]
    with pytest.raises(FormatError, match="two images are frame 5 of recording 'a'"):
        read_document(document(images=images))


def test_one_frame_in_two_files_is_an_error(tmp_path):
    path = tmp_path / "a.json"
    path.write_text(json.dumps(document()), encoding="utf-8")
    with pytest.raises(
        FormatError, match=r"second.json: frame 5 of recording 'a' is in an earlier"
    ):
        reader.read(
            [SourceFile(path, "first.json"), SourceFile(path, "second.json")], ReadOptions()
        )


def test_equal_ids_in_two_files_are_kept_apart(tmp_path):
    sources = []
    for name in ("a", "b"):
        path = tmp_path / f"{name}.json"
        images = [{"id": 1, "file_name": f"{name}/I5.png"}]
        path.write_text(json.dumps(document(images, [annotation()])), encoding="utf-8")
        sources.append(SourceFile(path, path.name))
    boxes = reader.read(sources, ReadOptions()).boxes
    assert boxes["recording"].tolist() == ["a", "b"]
    assert boxes["file"].tolist() == [0, 1]


def test_nan_in_a_box_is_passed_on(read_document):
    boxes = read_document(document(annotations=[annotation(bbox=[float("nan"), 2, 3, 4])])).boxes
    assert boxes["x"].isna().tolist() == [True]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"bbox": [1, 2, 3]}, "found 3 values"),
        ({"bbox": "1,2,3,4"}, r"expected bbox \[x, y, width, height\]"),
        ({"bbox": [1, 2, None, 4]}, "expected four numbers as bbox"),
        ({"bbox": None}, 'expected the field "bbox", found none'),
        ({"image_id": None}, 'expected the field "image_id", found none'),
        ({"image_id": [1]}, "expected a number or text as image id"),
        ({"category_id": 77}, r"found 77"),
        ({"ignore": "yes"}, 'expected 0 or 1 as "ignore"'),
        ({"occlusion": {}}, 'expected 0, 1, 2 as "occlusion"'),
        ({"occlusion": "some"}, 'expected 0, 1, 2 as "occlusion"'),
        ({"track_id": [3]}, "expected a number or text as track id"),
        ({"vis_ratio": "half"}, 'expected a number as "vis_ratio"'),
    ],
)
def test_a_faulty_annotation_is_named_with_its_number_and_line(read_document, fields, message):
    text = json.dumps(
        document(annotations=[annotation(occlusion=0), annotation(id=2) | fields]), indent=0
    )
    lines = text.split("\n")
    line = max(i for i, part in enumerate(lines[: lines.index('"categories": [')]) if part == "{")
    with pytest.raises(FormatError, match=rf"annotation 2 of 2: .*{message}") as caught:
        read_document(text)
    assert caught.value.line == line + 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected JSON"),
        ("{", "expected JSON"),
        ("[]", "a list of results is no ground truth"),
        ("{}", '"images" to be a list'),
        ('{"images": 3}', '"images" to be a list'),
        ('{"images": [3]}', "image 1 of 1: expected an object"),
        ('{"images": [], "annotations": {}}', '"annotations" to be a list'),
        ('{"images": [{"id": 1, "file_name": 3}]}', "expected text as file_name"),
        ('{"images": [{"id": 1, "file_name": "\\ud800"}]}', "half a character"),
        ('{"images": [], "annotations": [], "categories": 1}', '"categories" to be a list'),
        ("[" * 100_000, "nesting"),
        ('{"images": [{"id": 1' + "0" * 5000 + "}]}", "nesting or a number"),
    ],
)
def test_absurd_json_is_an_error_with_the_file(read_document, text, message):
    with pytest.raises(FormatError, match=rf"truth.json.*{message}"):
        read_document(text)


def test_occlusion_as_number_and_truth_value_in_one_file_is_a_level(read_document):
    rows = [annotation(occlusion=2), annotation(id=2, occlusion=True)]
    assert read_document(document(annotations=rows)).boxes["occlusion"].tolist() == [2, 1]


def test_a_number_beyond_all_floats_is_an_error(read_document):
    with pytest.raises(FormatError, match='numbers below 1e308 as "occlusion"'):
        read_document(document(annotations=[annotation(occlusion=10**400)]))


def test_no_categories_and_one_category_id_counts_all(read_document):
    content = document(annotations=[annotation(category_id=4)])
    del content["categories"]
    assert len(read_document(content).boxes) == 1


def test_no_categories_and_several_ids_ask_for_the_classes(read_document):
    content = document(annotations=[annotation(), annotation(id=2, category_id=2)])
    del content["categories"]
    with pytest.raises(FormatError, match="annotations of category_id 1, 2; name the category ids"):
        read_document(content)
    assert len(read_document(content, classes=("2",)).boxes) == 1


def test_no_annotations_give_an_empty_table_and_all_frames(read_document):
    reading = read_document(document())
    assert reading.boxes.empty
    assert len(reading.images) == 1


def test_truth_is_recognised_and_results_are_not():
    truth = (FOLDER / "kaist.json").read_text(encoding="utf-8")
    results = (FOLDER / "results.json").read_text(encoding="utf-8")
    assert reader.recognise("a.json", truth, "truth")
    assert not reader.recognise("a.json", truth, "detections")
    assert not reader.recognise("a.json", results, "truth")
    assert not reader.recognise("a.json", '{"openlabel": {}}', "truth")
    assert not reader.recognise("a.txt", "1,2,3,4,5,6,1", "truth")


@pytest.mark.realdata
def test_kaist_test_set_is_read_whole(realdata):
    name = "kaist/KAIST_annotation.json"
    reading = reader.read([SourceFile(realdata / name, name)], ReadOptions())
    assert len(reading.images) == 2252
    assert len(reading.boxes) == 4254
    assert int(reading.boxes["ignore"].sum()) == 775 + 54 + 35
    assert len(reading.recordings) == 16
    assert reading.findings == ()

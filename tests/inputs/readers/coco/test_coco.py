from __future__ import annotations

import json
from pathlib import Path

import pytest
from reader_files import golden, rows, source

from nvcore.common.errors import FormatError
from nvcore.inputs.readers.base import Reading, ReadOptions
from nvcore.inputs.readers.coco import truth as reader


def read_golden(name: str, **options: object) -> Reading:
    return reader.read(golden("coco", name), ReadOptions(**options))


@pytest.fixture
def read_document(tmp_path: Path):
    def read_one(document: object, name: str = "truth.json", **options: object) -> Reading:
        text = document if isinstance(document, str) else json.dumps(document)
        return reader.read([source(tmp_path, text, name)], ReadOptions(**options))

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


def test_kaists_truth_has_recordings_and_frames_in_its_image_names():
    # Other tools take id 0 for "no match". An image without annotations, here frame
    # 39, is an evaluated frame. A flagged box and a cyclist are ignore regions
    reading = read_golden("kaist.json")
    assert rows(reading.boxes, "recording frame x y w h ignore occlusion") == [
        ["set06/V000", 19, 505, 212, 20, 50, False, 0],
        ["set06/V000", 19, 10.5, 20, 5, 12, True, 2],
        ["set09/V000", 19, 100, 200, 30, 60, True, 1],
    ]
    assert rows(reading.images, "recording frame image_id") == [
        ["set06/V000", 19, 0],
        ["set06/V000", 39, 1],
        ["set09/V000", 19, 2],
    ]


def test_flirs_truth_has_tracks_and_words_for_occlusion():
    reading = read_golden("flir.json")
    assert rows(reading.boxes, "recording frame track occlusion") == [
        ["BzZs", 123, 0, 0],
        ["BzZs", 124, 0, 1],
        ["BzZs", 124, 1, 2],
    ]
    assert "numbered by first appearance" in reading.conversion
    assert "bike (2), car (3) left out" in reading.conversion


@pytest.mark.parametrize(
    ("fields", "column", "expected"),
    [
        # cocoapi PR#307: iscrowd 0 overwrote ignore 1
        (
            [{"ignore": 1, "iscrowd": 0}, {"ignore": 0, "iscrowd": 1}, {"ignore": 0, "iscrowd": 0}],
            "ignore",
            [True, True, False],
        ),
        ([{}], "ignore", [False]),
        # category 0 that is on no list, as in CityPersons
        ([{"category_id": 0}, {}], "ignore", [True, False]),
        ([{"vis_ratio": share} for share in (1.0, 0.65, 0.64)], "occlusion", [0, 1, 2]),
        # NightOwls
        ([{"occluded": False}, {"occluded": True}], "occlusion", [0, 2]),
        ([{"occlusion": 2}, {"occlusion": True}], "occlusion", [2, 1]),
        ([{"track_id": 12}, {"track_id": 3.0}, {}], "track", [12, 3, -1]),
        ([{"distance_m": 31.5}], "distance_m", [31.5]),
        ([{"bbox": [float("nan"), 2, 3, 4]}], "x", [None]),
    ],
)
def test_fields_of_annotations_become_columns(read_document, fields, column, expected):
    annotations = [annotation(id=i, **more) for i, more in enumerate(fields)]
    boxes = read_document(document(annotations=annotations)).boxes
    assert rows(boxes, column) == [[value] for value in expected]


MASK = {"counts": [100, 20], "size": [480, 640]}
POLYGON = [[1, 2, 4, 2, 4, 6]]
SINGLE, WIDE = [1, 2, 3, 9], [1, 2, 30, 9]


def drawn(number: int, **fields: object) -> list[dict[str, object]]:
    """Annotations of one kind; all are masks with iscrowd of one pedestrian each unless stated."""
    usual = {"bbox": SINGLE, "iscrowd": 1, "segmentation": MASK}
    return [annotation(**{**usual, **fields})] * number


BOXES = drawn(4, iscrowd=0, segmentation=None)
UNSEEN = "ignore and iscrowd = ignore"


@pytest.mark.parametrize(
    ("annotations", "classes", "n_ignored", "severity"),
    [
        # CVAT: everything drawn with the brush has iscrowd, boxes and polygons have not
        (BOXES + drawn(10), None, 0, "note"),
        (
            drawn(4, iscrowd=0, segmentation=POLYGON) + drawn(8) + drawn(2, bbox=WIDE),
            None,
            0,
            "note",
        ),
        (BOXES + drawn(10, segmentation=POLYGON), None, 0, "note"),
        (drawn(3), None, 0, "note"),
        (drawn(3, segmentation=None), None, 0, "note"),
        # regions of COCO: wide, few, or without a mask
        (BOXES + drawn(10, bbox=WIDE), None, 10, None),
        (BOXES + drawn(10, segmentation=None), None, 10, None),
        (BOXES + drawn(10) + drawn(1, iscrowd=0), None, 10, None),
        # in doubt: too few, half of them wide, or nothing else to detect
        (BOXES + drawn(9), None, 9, "warning"),
        (BOXES + drawn(10) + drawn(10, bbox=WIDE), None, 20, "warning"),
        (drawn(3, bbox=WIDE), None, 3, "warning"),
        # the user decides
        (BOXES + drawn(10), ("person",), 10, "warning"),
        (BOXES + drawn(10, bbox=WIDE), ("person", "iscrowd"), 0, None),
        (BOXES + drawn(9), ("iscrowd",), 0, None),
        (BOXES + drawn(10, ignore=1), None, 10, None),
    ],
)
def test_iscrowd_of_a_mask_of_one_pedestrian_ignores_nobody(
    read_document, annotations, classes, n_ignored, severity
):
    reading = read_document(document(annotations=annotations), classes=classes)
    assert reading.boxes["ignore"].sum() == n_ignored
    assert (UNSEEN in reading.conversion) == (n_ignored > 0 or (not severity and classes is None))
    assert [finding.severity for finding in reading.findings] == [severity] * bool(severity)
    for finding in reading.findings:
        n_crowds = sum(given["iscrowd"] for given in annotations)
        assert f"iscrowd is set for {n_crowds} annotations of pedestrians" in finding.message
        # one step further, and the reader does the opposite
        (step,) = finding.steps
        named = tuple(step.value.split(","))
        other = read_document(document(annotations=annotations), classes=named)
        assert other.boxes["ignore"].sum() == n_crowds - n_ignored


@pytest.mark.parametrize(
    ("classes", "ignored"),
    [(("cyclist",), [True, True, False]), (("1", "2"), [False, True, False])],
)
def test_classes_that_count_are_named_or_numbered(classes, ignored):
    assert read_golden("kaist.json", classes=classes).boxes["ignore"].tolist() == ignored


def test_an_unknown_class_is_an_error_that_lists_the_known():
    with pytest.raises(
        FormatError, match=r"no class 'walker'; the classes are .*person \(1\), cyclist \(2\)"
    ):
        read_golden("kaist.json", classes=("walker",))


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"categories": [{"id": 1, "name": "car"}]}, r"found car \(1\); name the classes"),
        (
            {"images": [{"id": 1, "file_name": f"a/I{n}.png"} for n in (5, 6)]},
            "image 2 of 2: id 1 stands for two different images",
        ),
        (
            {"images": [{"id": i, "file_name": "a/I5.png", "frame_index": 5} for i in (1, 2)]},
            "two images are frame 5 of recording 'a'",
        ),
        ({"annotations": [annotation(occlusion=10**400)]}, 'numbers below 1e308 as "occlusion"'),
    ],
)
def test_what_a_document_contradicts_or_lacks_is_an_error(read_document, parts, message):
    with pytest.raises(FormatError, match=message):
        read_document(document(**parts))


def test_an_odd_occlusion_level_is_reported(read_document):
    reading = read_document(document(annotations=[annotation(occlusion=7)]))
    assert reading.boxes["occlusion"].tolist() == [-1]
    assert [finding.code for finding in reading.findings] == ["unknown-occlusion"]


def test_video_table_gives_name_size_and_frame_rate(read_document):
    image = {"id": 1, "file_name": "x.png", "video_id": 3, "frame_index": 40}
    videos = [{"id": 3, "name": "night drive", "fps": 20}]
    reading = read_document(
        document([image | {"width": 640, "height": 480}], [annotation()], videos=videos)
    )
    assert reading.recordings.to_numpy().tolist() == [["night drive", 640, 480, 20]]
    assert reading.boxes["frame"].tolist() == [40]


def test_names_without_number_are_numbered_by_their_order_and_reported(read_document):
    images = [{"id": 5, "file_name": "a/left.png"}, {"id": 6, "file_name": "a/right.png"}]
    reading = read_document(document(images=images, annotations=[annotation(image_id=6)]))
    assert reading.boxes[["recording", "frame"]].to_numpy().tolist() == [["a", 1]]
    assert [finding.code for finding in reading.findings] == ["frames-by-order"]
    assert "order of the list" in reading.conversion


@pytest.mark.parametrize(
    ("names", "frames"),
    [
        (["58c5a1.png", "58c5b2.png", "58c6c7.png", "59d8d9.png"], [0, 1, 2, 3]),
        (["000012.png"], [12]),
    ],
    ids=["hashes are no recordings", "without folder"],
)
def test_pictures_belong_to_the_files_recording(read_document, names, frames):
    images = [{"id": i, "file_name": name} for i, name in enumerate(names)]
    reading = read_document(document(images=images), name="night.json")
    assert rows(reading.images, "recording frame") == [["night", frame] for frame in frames]


def test_pictures_of_one_recording_that_differ_in_size_are_reported(read_document):
    images = [
        {"id": i, "file_name": f"a/I{i}.png", "width": 640 if i else 320, "height": 512}
        for i in range(3)
    ]
    reading = read_document(document(images=images))
    assert reading.recordings[["width", "height"]].to_numpy().tolist() == [[640, 512]]
    assert reading.findings[0].code == "picture-size"
    assert reading.findings[0].count == 1


def test_no_annotations_and_no_sizes_give_an_empty_table_and_all_frames(read_document):
    reading = read_document(document())
    assert reading.boxes.empty
    assert len(reading.images) == 1
    assert rows(reading.recordings, "width height") == [[None, None]]


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


def test_equal_ids_in_two_files_are_kept_apart_and_equal_frames_are_an_error(tmp_path):
    def read_files(*pictures: str) -> Reading:
        images = [[{"id": 1, "file_name": name}] for name in pictures]
        texts = [json.dumps(document(image, [annotation()])) for image in images]
        files = [source(tmp_path, text, f"{i}.json") for i, text in enumerate(texts)]
        return reader.read(files, ReadOptions())

    assert rows(read_files("a/I5.png", "b/I5.png").boxes, "recording file") == [["a", 0], ["b", 1]]
    with pytest.raises(FormatError, match=r"1.json: frame 5 of recording 'a' is in an earlier"):
        read_files("a/I5.png", "a/I5.png")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"bbox": [1, 2, 3]}, "found 3 values"),
        ({"bbox": "1,2,3,4"}, r"expected bbox \[x, y, width, height\]"),
        ({"bbox": [1, 2, None, 4]}, "expected four numbers as bbox"),
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


def test_no_categories_and_one_category_id_counts_all(read_document):
    content = document(annotations=[annotation(category_id=4)])
    del content["categories"]
    assert len(read_document(content).boxes) == 1


def test_no_categories_and_several_ids_ask_for_the_classes(read_document):
    content = document(annotations=[annotation(), annotation(id=2, category_id=2)])
    del content["categories"]
    with pytest.raises(
        FormatError, match=r"several classes.* category_id 1 \(1 box\), 2 \(1 box\)"
    ):
        read_document(content)
    assert len(read_document(content, classes=("2",)).boxes) == 1


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ("child;with dog", "child;with dog"),
        (["child", 3, "with dog "], "child;with dog"),
        ({"age": "child", "with_dog": True, "occluded": True, "track_id": 4}, "child;with_dog"),
        ({"with_dog": False, "age": None, "n": 2.5, "more": {"deep": True}}, None),
        (7, None),
    ],
)
def test_attributes_name_classes_as_text_list_or_object(read_document, attributes, expected):
    boxes = [annotation(id=2), annotation(attributes=attributes)]
    reading = read_document(document(annotations=boxes))
    if expected is None:
        assert reading.attributes is None
    else:
        assert rows(reading.attributes, "file line attributes") == [[0, 2, expected]]


def test_attributes_of_what_is_left_out_are_not_those_of_others(read_document):
    boxes = [annotation(category_id=2, attributes="car"), annotation(id=2, attributes="child")]
    categories = [{"id": 1, "name": "person"}, {"id": 2, "name": "car"}]
    reading = read_document(document(annotations=boxes, categories=categories))
    assert rows(reading.attributes, "line attributes") == [[2, "child"]]

"""Classes as other tools write them: what a number means, and who is asked where nothing tells."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from field_scene import (
    FPS,
    PERSON,
    RIGHT,
    SIZE,
    coco_results,
    coco_truth,
    detections,
    found,
    truth,
    write_yolo,
)

import nvcore as nv
from nvcore.common.errors import (
    FormatError,
    MissingFactError,
    UnknownFormatError,
    UnnamedClassesError,
)
from nvcore.common.findings import Remedy, Step
from nvcore.inputs.load import load, read_source
from nvcore.inputs.readers.base import LeftOut, SourceFile
from nvcore.inputs.readers.meaning.classes import MAX_BYTES, class_names_beside, names_of_yaml
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.tables.inputs import inputs_table

SIDES = ("truth", "x", "y")
BY_LETTER = {"bicycle": 0, "car": 1, PERSON: 2}
NAMES = "names: ['bicycle', 'car', 'person']"


def session_of(folder: Path, ending: str = "", **classes: tuple[str, ...]) -> Session:
    truth_file, *system_files = (f"{side}{ending}" for side in SIDES)
    return Session(
        folder=folder,
        truth=Source(truth_file, classes=classes.get("truth")),
        systems=tuple(
            SystemSource(file, name=side, classes=classes.get(side))
            for file, side in zip(system_files, "xy", strict=True)
        ),
        size=SIZE,
        fps=FPS,
    )


def frame_name(frame: int) -> str:
    return f"drive_{frame:06d}.txt"


def as_yolo(folder: Path, sides: tuple[str, ...] = SIDES) -> None:
    for side in sides:
        write_yolo(folder / side / "labels", side, frame_name, BY_LETTER)


def as_coco(
    folder: Path, ids: Mapping[str, int], of_results: Mapping[str, int] | None = None
) -> None:
    document = coco_truth(lambda frame: f"drive/{frame:06d}.jpg", ids=ids)
    (folder / "truth.json").write_text(json.dumps(document))
    for side in "xy":
        results = coco_results(side, lambda frame: {"image_id": frame + 1}, of_results or ids)
        (folder / f"{side}.json").write_text(json.dumps(results))


def as_rows(
    folder: Path, ending: str, row: str, first: str = "", *, kind: Mapping[str, int]
) -> None:
    """Files with a `row` for each box, the class numbered by `kind`, below a `first` line."""
    for side in SIDES:
        table = truth() if side == "truth" else detections(side).assign(track=-1)
        if side == "truth":
            table = table.assign(score=1)
        table = table.assign(kind=table["name"].map(kind))
        lines = [row.format(**fields) for fields in table.to_dict("records")]
        (folder / f"{side}{ending}").write_text("\n".join([*filter(None, [first]), *lines, ""]))


def compared(session: Session) -> dict[str, object]:
    return found(nv.compare(load(session)))


def test_coco_results_are_read_by_the_names_that_their_truth_gives_the_ids(tmp_path):
    as_coco(tmp_path, {"bicycle": 7, "car": 8, PERSON: 9})
    assert compared(session_of(tmp_path, ".json")) == RIGHT


def test_results_of_a_class_that_the_truth_calls_otherwise_never_count(tmp_path):
    as_coco(tmp_path, {PERSON: 3, "car": 1, "bicycle": 2}, {"car": 1})
    with pytest.raises(FormatError, match=r"expected results of category_id 3 \(person\)"):
        load(session_of(tmp_path, ".json"))


def test_an_id_that_the_truth_does_not_know_is_a_finding(tmp_path):
    as_coco(tmp_path, {PERSON: 1, "car": 2, "bicycle": 3}, {PERSON: 1, "car": 44})
    dataset = load(session_of(tmp_path, ".json"))
    assert found(nv.compare(dataset)) == RIGHT
    assert "unknown-class" in {finding.code for finding in nv.audit(dataset)}


@pytest.mark.parametrize("place", ["labels/classes.txt", "obj.names", "labels.txt"])
def test_yolo_takes_the_names_of_a_list_beside_or_above(tmp_path, place):
    as_yolo(tmp_path)
    for side in SIDES:
        (tmp_path / side / place).write_text("bicycle\ncar\nperson\n")
    assert compared(session_of(tmp_path)) == RIGHT


@pytest.mark.parametrize("named", [("truth",), ("x", "y")])
def test_one_side_takes_the_names_of_the_other_and_says_so(tmp_path, named):
    as_yolo(tmp_path)
    for side in named:
        (tmp_path / side / "classes.txt").write_text("bicycle\ncar\nperson\n")
    dataset = load(session_of(tmp_path))
    assert found(nv.compare(dataset)) == RIGHT
    taken = "x" if named == ("truth",) else "truth"
    conversions = inputs_table(dataset).set_index("subject")["conversion"]
    other = "ground truth" if taken == "x" else "systems"
    assert f"class names from the {other}" in conversions[taken]


def test_a_written_session_states_the_classes_and_needs_the_names_no_more(tmp_path):
    as_yolo(tmp_path)
    for side in SIDES:
        (tmp_path / side / "data.yaml").write_text(NAMES)
    dataset = load(session_of(tmp_path))
    assert isinstance(dataset.settings, Session)
    assert {source.classes for source, _ in dataset.settings.sources} == {("2",)}
    file = tmp_path / "again.toml"
    file.write_text(write_session(dataset.settings, version="0", fingerprint=dataset.fingerprint))
    for side in SIDES:
        (tmp_path / side / "data.yaml").unlink()
    assert load(read_session(file)).fingerprint == dataset.fingerprint


def test_coco_ids_say_nothing_about_numbers_of_yolo(tmp_path):
    as_coco(tmp_path, {PERSON: 1, "car": 2, "bicycle": 3})
    as_yolo(tmp_path, sides=("x", "y"))
    session = replace(session_of(tmp_path), truth=Source("truth.json"))
    with pytest.raises(UnnamedClassesError) as caught:
        load(session)
    assert caught.value.steps == (Step(Remedy.CLASSES, "", "x"),)


def test_several_classes_without_names_are_asked_for(tmp_path):
    as_yolo(tmp_path)
    with pytest.raises(UnnamedClassesError, match=r"class 0 .40 boxes., 1 .80") as caught:
        load(session_of(tmp_path))
    assert caught.value.steps == (Step(Remedy.CLASSES, "", "truth"),)
    every = dict.fromkeys(SIDES, ("2",))
    assert compared(session_of(tmp_path, **every)) == RIGHT


def test_a_child_beside_pedestrians_is_ignored_and_a_finding_offers_to_count_it(tmp_path):
    as_coco(tmp_path, {PERSON: 1, "car": 2, "bicycle": 3})
    document = json.loads((tmp_path / "truth.json").read_text())
    document["categories"].append({"id": 4, "name": "child"})
    for annotation in document["annotations"]:
        if annotation["track_id"] == 3:
            annotation["category_id"] = 4
    (tmp_path / "truth.json").write_text(json.dumps(document))
    dataset = load(session_of(tmp_path, ".json"))
    assert found(nv.compare(dataset))["false_alarms"] == RIGHT["false_alarms"]
    finding = next(finding for finding in nv.audit(dataset) if finding.code == "other-kinds")
    assert (finding.count, finding.steps) == (30, (Step(Remedy.CLASSES, "person,child", "truth"),))
    assert compared(session_of(tmp_path, ".json", truth=("person", "child"))) == RIGHT


VISDRONE = {PERSON: 1, "bicycle": 3, "car": 4}


def test_visdrone_video_text_is_told_from_mot15(tmp_path):
    row = "{frame},{track},{x},{y},{w},{h},{score},{kind},0,1"
    as_rows(tmp_path, ".txt", row, kind=VISDRONE)
    dataset = load(session_of(tmp_path, ".txt"))
    assert found(nv.compare(dataset)) == RIGHT
    assert set(dataset.boxes["occlusion"][: len(dataset.truth)]) == {1}


def test_visdrone_detection_text_has_one_file_a_picture(tmp_path):
    for side in SIDES:
        table = truth().assign(score=1) if side == "truth" else detections(side)
        (tmp_path / side).mkdir()
        for frame, rows in table.groupby("frame"):
            lines = [
                f"{row.x:g},{row.y:g},{row.w:g},{row.h:g},{row.score},{VISDRONE[row.kind]},0,0,"
                for _, row in rows.rename(columns={"name": "kind"}).iterrows()
            ]
            (tmp_path / side / frame_name(frame)).write_text("\n".join(lines))
    assert compared(session_of(tmp_path)) == RIGHT


@pytest.mark.parametrize("separator", [" ", "\t"])
def test_mot_may_be_separated_by_blanks(tmp_path, separator):
    row = "{frame} {track} {x} {y} {w} {h} {score} {kind} 1 ".replace(" ", separator)
    as_rows(tmp_path, ".txt", row, kind={PERSON: 1, "car": 3, "bicycle": 4})
    assert compared(session_of(tmp_path, ".txt")) == RIGHT


def test_cvats_labels_number_the_classes_of_its_mot_export_from_1(tmp_path):
    row = "{frame},{track},{x},{y},{w},{h},{score},{kind},1"
    as_rows(tmp_path, ".txt", row, kind={"bicycle": 1, "car": 2, PERSON: 3})
    (tmp_path / "labels.txt").write_text("bicycle\ncar\nperson\n")
    assert compared(session_of(tmp_path, ".txt")) == RIGHT


def test_pixels_of_cvats_mot_export_count_from_0(tmp_path):
    (tmp_path / "gt.txt").write_text("1,1,60,180,50,130,1,1,1.0\n")
    (tmp_path / "labels.txt").write_text("person\n")
    boxes = read_source(Source("gt.txt"), role="truth", folder=tmp_path).boxes
    assert boxes[[*"xywh"]].to_numpy().tolist() == [[60, 180, 50, 130]]


@pytest.mark.parametrize("header", ["class,name", "class_id,class_name"])
def test_a_name_goes_before_the_number_of_a_class_in_csv(tmp_path, header):
    row = "{frame},{x},{y},{w},{h},{track},{score},{kind},{name}"
    as_rows(tmp_path, ".csv", row, f"frame,x,y,w,h,track,score,{header}", kind=BY_LETTER)
    assert compared(session_of(tmp_path, ".csv")) == RIGHT
    assert compared(session_of(tmp_path, ".csv", x=("2",), y=("person",))) == RIGHT


def test_csv_numbers_of_systems_have_the_names_that_the_truth_states(tmp_path):
    row = "{frame},{x},{y},{w},{h},{track},{score},{kind}"
    as_rows(tmp_path, ".csv", row, "frame,x,y,w,h,track,score,class", kind=BY_LETTER)
    with pytest.raises(UnnamedClassesError, match="class 0"):
        load(session_of(tmp_path, ".csv"))
    lines = (tmp_path / "truth.csv").read_text().splitlines()
    names = {str(number): name for name, number in BY_LETTER.items()}
    named = [f"{line},{names[line.rpartition(',')[2]]}" for line in lines[1:]]
    (tmp_path / "truth.csv").write_text("\n".join([f"{lines[0]},name", *named]))
    assert compared(session_of(tmp_path, ".csv")) == RIGHT


@pytest.mark.parametrize("bbox", [[], None])
def test_one_empty_bbox_leaves_itself_out(tmp_path, bbox):
    as_coco(tmp_path, {PERSON: 1, "car": 2, "bicycle": 3})
    document = json.loads((tmp_path / "truth.json").read_text())
    document["annotations"].append({**document["annotations"][0], "id": 999, "bbox": bbox})
    (tmp_path / "truth.json").write_text(json.dumps(document))
    dataset = load(session_of(tmp_path, ".json"))
    assert found(nv.compare(dataset)) == RIGHT
    assert len(dataset.left_out) == 1


def test_a_polygon_without_bbox_is_the_box_around_it(tmp_path):
    as_coco(tmp_path, {PERSON: 1, "car": 2, "bicycle": 3})
    document = json.loads((tmp_path / "truth.json").read_text())
    for annotation in document["annotations"]:
        x, y, w, h = annotation.pop("bbox")
        annotation["segmentation"] = [[x, y + h, x + w / 2, y, x + w, y + h]]
    (tmp_path / "truth.json").write_text(json.dumps(document))
    assert compared(session_of(tmp_path, ".json")) == RIGHT


def test_masks_without_boxes_are_refused_with_a_way_on(tmp_path):
    as_coco(tmp_path, {PERSON: 1, "car": 2, "bicycle": 3})
    document = json.loads((tmp_path / "truth.json").read_text())
    for annotation in document["annotations"]:
        del annotation["bbox"]
        annotation["segmentation"] = {"counts": "abc", "size": [480, 640]}
    (tmp_path / "truth.json").write_text(json.dumps(document))
    with pytest.raises(FormatError, match=r"masks \(RLE\) alone.*add the box around each mask"):
        read_source(Source("truth.json"), role="truth", folder=tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "names: *others",
        "names: [a, [b]]",
        "names: coco.names",
        "names: [a",
        "names:\n- a: b",
        "names:\n  0: a\n  0: b",
        "names: [a]\nnames: [b]",
        'names: ["\\x"]',
        "names: |\n  a",
    ],
)
def test_other_yaml_is_refused_with_its_line(text):
    with pytest.raises(FormatError, match=r"data.yaml, line [1-3]: expected names: "):
        names_of_yaml(text, SourceFile(Path("data.yaml"), "data.yaml"))


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("names: [a, 'it''s', \"b c\",]  # all", ["a", "it's", "b c"]),
        ("nc: 2\nnames:\n- a  # first\n\n- 'b'\nval: x", ["a", "b"]),
        ("names: {0: a, 1: b}", ["a", "b"]),
        ('"names": [\n  a, # one\n  b\n]', ["a", "b"]),
        ("path: x", []),
    ],
)
def test_names_of_yaml_are_a_list_or_a_mapping(text, names):
    given = names_of_yaml(text, SourceFile(Path("data.yaml"), "data.yaml"))
    assert given == {str(number): name for number, name in enumerate(names)}


def test_names_that_differ_in_one_place_are_an_error(tmp_path):
    as_yolo(tmp_path, sides=("truth",))
    (tmp_path / "truth" / "classes.txt").write_text("person\ncar\n")
    (tmp_path / "truth" / "data.yaml").write_text(NAMES)
    with pytest.raises(FormatError, match=r"differ from those in classes\.txt"):
        load(session_of(tmp_path))


def test_a_list_of_classes_is_bounded(tmp_path):
    for name in ("classes.txt", "other.yaml"):
        (tmp_path / name).write_text("a" * (MAX_BYTES + 1))
    (tmp_path / "1.txt").touch()
    with pytest.raises(FormatError, match="1 MiB at most"):
        class_names_beside([SourceFile(tmp_path / "1.txt", "1.txt")])
    (tmp_path / "classes.txt").unlink()
    assert class_names_beside([SourceFile(tmp_path / "1.txt", "1.txt")]).names == {}


def test_names_that_are_numbers_are_none(tmp_path):
    (tmp_path / "data.yaml").write_text("names: ['0', '1']")
    assert class_names_beside([SourceFile(tmp_path / "1.txt", "1.txt")]).names == {}


def test_what_is_left_out_is_counted_by_class(tmp_path):
    as_coco(tmp_path, {PERSON: 1, "car": 2, "bicycle": 3})
    reading = read_source(Source("truth.json"), role="truth", folder=tmp_path)
    assert reading.left_out == (LeftOut("class", "car", 80), LeftOut("class", "bicycle", 40))


def test_yolo_polygons_become_the_boxes_around_them(tmp_path):
    as_yolo(tmp_path)
    for side in SIDES:
        (tmp_path / side / "classes.txt").write_text("bicycle\ncar\nperson\n")
        for file in sorted((tmp_path / side / "labels").iterdir()):
            lines = []
            for line in file.read_text().splitlines():
                kind, x, y, w, h, *score = map(float, line.split())
                corners = [(x - w / 2, y), (x, y - h / 2), (x + w / 2, y + h / 2)]
                fields = [*(share for corner in corners for share in corner), *score]
                lines.append(f"{kind:g} " + " ".join(f"{field:.6f}" for field in fields))
            file.write_text("\n".join(lines))
    assert compared(session_of(tmp_path)) == RIGHT


@pytest.mark.parametrize(
    ("header", "share"),
    [
        ("frame,cx,cy,w,h", (1, 1)),
        ("frame,x_center,y_center,width,height", (1, 1)),
        ("frame,xc,yc,w,h", SIZE),
    ],
)
def test_centres_are_told_by_the_names_of_their_columns(tmp_path, header, share):
    wide, high = share
    for side in SIDES:
        table = truth().assign(score=1) if side == "truth" else detections(side)
        rows = [
            f"{frame},{(x + w / 2) / wide},{(y + h / 2) / high},{w / wide},{h / high},{score}"
            for frame, x, y, w, h, score in table.query("name == 'person'")[
                ["frame", *"xywh", "score"]
            ].itertuples(index=False)
        ]
        last = "ignored_by_all" if side == "truth" else "score"
        (tmp_path / f"{side}.csv").write_text("\n".join([f"{header},{last}", *rows]))
    assert compared(session_of(tmp_path, ".csv")) == RIGHT


def test_shares_in_csv_need_the_size_of_the_pictures(tmp_path):
    (tmp_path / "a.csv").write_text("frame,xc,yc,w,h\n1,0.5,0.5,0.1,0.2\n")
    with pytest.raises(MissingFactError) as caught:
        read_source(Source("a.csv"), role="truth", folder=tmp_path)
    assert (caught.value.facts, caught.value.steps) == (("size",), (Step(Remedy.SIZE),))


@pytest.mark.parametrize(("first", "separator"), [("sep=;\n", ";"), ("", "\t")])
def test_excels_first_line_and_decimal_commas_are_read(tmp_path, first, separator):
    text = "frame,x,y,w,h\n1,60.5,2,3,4\n2,61.5,2,3,4\n".replace(",", separator).replace(".", ",")
    (tmp_path / "a.csv").write_text(first + text)
    boxes = read_source(Source("a.csv"), role="truth", folder=tmp_path).boxes
    assert boxes["x"].tolist() == [60.5, 61.5]
    assert boxes["line"].tolist() == ([3, 4] if first else [2, 3])


def test_kaists_own_xml_has_sizes_and_levels(tmp_path):
    (tmp_path / "I00019.xml").write_text(
        "<annotation><object><name>person</name><bndbox><x>282</x><y>205</y><w>20</w><h>43</h>"
        "</bndbox><occlusion>2</occlusion></object></annotation>"
    )
    boxes = read_source(Source("I00019.xml"), role="truth", folder=tmp_path).boxes
    assert boxes[[*"xywh", "occlusion"]].to_numpy().tolist() == [[282, 205, 20, 43, 2]]


@pytest.mark.parametrize(("word", "level"), [("none", 0), ("part", 1), ("full", 2)])
def test_jaads_words_are_levels_of_occlusion(tmp_path, word, level):
    (tmp_path / "video_0001.xml").write_text(
        '<annotations><track id="0" label="pedestrian"><box frame="0" outside="0" occluded="0" '
        f'keyframe="1" xtl="1" ytl="2" xbr="3" ybr="4"><attribute name="occlusion">{word}'
        "</attribute></box></track></annotations>"
    )
    boxes = read_source(Source("video_0001.xml"), role="truth", folder=tmp_path).boxes
    assert boxes["occlusion"].tolist() == [level]


FOREIGN = {
    "Label Studio": '[{"data": {}, "annotations": [{"result": [{"from_name": "label"}]}]}]',
    "labelme": '{"version": "5", "shapes": [{"points": []}], "imagePath": "a.png"}',
    "BDD100K": '[{"name": "a.jpg", "labels": [{"box2d": {"x1": 60}}]}]',
    "EuroCity Persons": '{"imagename": "a.png", "children": []}',
    "OpenLABEL": '{"openlabel": {"frames": {}}}',
    "FiftyOne": '{"samples": [{"filepath": "a.jpg", "x": {"_cls": "Detections"}}]}',
    "Supervisely": '{"frames": [{"figures": [{"geometryType": "rectangle"}]}]}',
    "CrowdHuman": '{"ID": "a", "gtboxes": []}\n{"ID": "b", "gtboxes": []}',
    "Datumaro": '{"categories": {"label": {}}, "items": [{"annotations": [1]}]}',
    "VATIC": '1 60 180 110 310 0 0 0 0 "Pedestrian"',
    "keras-retinanet": "images/a.jpg,60,180,110,310,person",
    "VIA": "filename,file_size,file_attributes,region_count\na.jpg,1,{},1",
    "Oxford Town Centre": "1,0,1,1,60.0,180.0,70.0,190.0,60.0,180.0,110.0,310.0",
    "Cartucho": "person 60 180 110 310",
    "supervision": '[{"x_min": 60.0, "y_min": 180.0, "x_max": 110.0, "class_id": 0}]',
    "Ultralytics' JSON": '[{"name": "person", "class": 0, "box": {"x1": 60.0}}]',
    "Ultralytics' CSV": "name,class,confidence,box\nperson,0,0.6,\"{'x1': 60.41}\"",
    "Label Studio's CSV": '"annotation_id","id","image","label","lead_time"\n1,1,"a.png","[]",1',
    "Open Images' CSV": "ImageID,Source,LabelName,Confidence,XMin,XMax\na,,person,1,0,1",
    "Open Images' tree": '{"LabelName": "/m/0bl9f", "Subcategory": []}',
    "LabelMe's XML": "<annotation><filename>a.png</filename><imagesize></imagesize></annotation>",
    "Pascal VOC's results": "000012 0.687 60.04 181.35 108.97 312.7",
    "labelme's JSON": '{"imageHeight": 480, "imagePath": "a.png", "shapes": []}',
    "labelme.s": '{"flags": {}, "imageData": "' + "A" * 70_000 + '", "shapes": []}',
    "DeepStream": f"person 7 0.0 0 0.0 60.04 181.35 108.97 312.7{' 0.0' * 7} 0.6",
    "DeepStream's tracker": f"person 1 0.0 0 0.0 60.04 181.35 108.97 312.7{' 0.0' * 7}",
    "MegaDetector": '{"images": [{"file": "a.jpg", "detections": [{"category": "2", "conf": 0.9, '
    '"bbox": [0.1, 0.4, 0.1, 0.3]}]}], "detection_categories": {"2": "person"}}',
    "SageMaker": '{"source-ref": "s3://a/a.png", "boxes": {"image_size": [{"width": 640}], '
    '"annotations": [{"class_id": 0, "top": 1, "left": 2, "width": 3, "height": 4}]}}',
    "V7 Darwin": '{"version": "2.0", "item": {"name": "a.png"}, "annotations": '
    '[{"bounding_box": {"h": 130, "w": 50, "x": 60, "y": 180}, "name": "person"}]}',
    "DIVE's JSON": '{"tracks": {"0": {"id": 0, "confidencePairs": [["person", 1]]}}}',
    "VIAME": "# 1: Detection or Track-id,2: Video or Image Identifier\n0,a.png,0,6,8,10,30,1,-1",
    "VIAME's CSV": "0,a.png,0,60,180,110,310,1,-1,person,0.9",
    "Waymo": "key.segment_context_name,[CameraBoxComponent].box.center.x\na,85",
    "WIDER FACE": "0--Parade/0_a_1_849.jpg\n1\n449 330 122 149 0 0 0 0 0 0 \n",
}


@pytest.mark.parametrize("role", ["truth", "detections"])
@pytest.mark.parametrize("name", FOREIGN)
def test_a_format_that_is_not_read_is_refused_by_its_name_with_a_way_on(tmp_path, name, role):
    (tmp_path / "a.txt").write_text(FOREIGN[name])
    with pytest.raises(UnknownFormatError, match=f"{name}.*not read") as caught:
        read_source(Source("a.txt"), role=role, folder=tmp_path)
    assert [step.remedy for step in caught.value.steps] == [Remedy.TABLE]

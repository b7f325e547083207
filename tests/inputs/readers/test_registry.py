"""Every golden file is recognised as its own format, and no row of it is lost."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from places import DATA
from reader_files import golden

from nvcore.common.errors import InputError, UnknownFormatError
from nvcore.inputs.load import load
from nvcore.inputs.readers import FORMATS, MAX_LOOKS, detect_format, format_named
from nvcore.inputs.readers.base import ReadOptions, Role, SourceFile
from nvcore.inputs.session import Session, Source, SystemSource

GOLDEN: list[tuple[str, Role, str]] = [
    ("bbgt/set06/V000/I00019.txt", "truth", "bbgt"),
    ("bbgt/set06/V000/I00039.txt", "truth", "bbgt"),
    ("bbgt/set06/V000/I00059.txt", "truth", "bbgt"),
    ("coco/kaist.json", "truth", "coco"),
    ("coco/flir.json", "truth", "coco"),
    ("coco/results.json", "detections", "coco-results"),
    ("coco/flir_results.json", "detections", "coco-results"),
    ("csv/truth.csv", "truth", "csv"),
    ("csv/corners.csv", "truth", "csv"),
    ("cvat_images/annotations.xml", "truth", "cvat-images"),
    ("cvat_video/annotations.xml", "truth", "cvat-video"),
    ("kaist_results/MBNet_result.txt", "detections", "kaist-results"),
    ("kaist_results/set06/V000.txt", "detections", "kaist-results"),
    ("kitti_detections/ab3dmot.txt", "detections", "kitti-detections"),
    ("kitti_detections/corners.txt", "detections", "kitti-detections"),
    ("kitti_object/label_2/000007.txt", "truth", "kitti-object"),
    ("kitti_tracking/0016.txt", "truth", "kitti-tracking"),
    ("mot/MOT16-02/gt/gt.txt", "truth", "mot"),
    ("mot/MOT16-02/det/det.txt", "detections", "mot"),
    ("voc/drive1/000007.xml", "truth", "voc"),
    ("voc/drive1/000008.xml", "truth", "voc"),
    ("yolo/drive1/000001.txt", "truth", "yolo"),
    ("yolo/drive1/000003.txt", "truth", "yolo"),
]
EMPTY = {"kitti_object/label_2/000008.txt", "yolo/drive1/000002.txt"}
ASIDE = {"mot/MOT16-02/seqinfo.ini", "written/session.toml"}


def source(name: str) -> SourceFile:
    return golden("", name)[0]


def test_every_golden_file_is_listed_here():
    files = {path.relative_to(DATA).as_posix() for path in DATA.rglob("*") if path.is_file()}
    assert files == {name for name, *_ in GOLDEN} | EMPTY | ASIDE


@pytest.mark.parametrize(("name", "role", "expected"), GOLDEN)
def test_a_golden_file_is_recognised_as_its_own_format_and_no_other_claims_it(
    name: str, role: Role, expected: str
):
    assert detect_format([source(name)], role).name == expected
    head = (DATA / name).read_text(encoding="utf-8")
    claims = [
        form.name for form in FORMATS if role in form.roles and form.recognise(name, head, role)
    ]
    assert claims == [expected]


KITTI = "Pedestrian 0 1 -0.2 712.4 143 810.7 307.9 1.9 0.5 1.2 1.8 1.5 8.4 0.01"
CORNERS, SIZES = "1,502.3,212.4,522.2,254.0,0.9\n", "1,502.3,212.4,19.9,41.6,0.9\n"
EITHER = "kitti-detections kaist-results"
CLAIMS = [
    ("", "", ""),
    ("% bbGt version=3\n", "bbgt", ""),
    ("person 1 2 3 4 0 0 0 0 0\n", "bbgt", ""),
    ("1 1 2 3 4 0 0 0 0 0\n", "mot", "mot"),
    ("person,1,2,3,4,0.5\n", "", ""),
    ("frame,id,x,y,w,h,score\n1,1,1,1,9,9,1\n", "csv", "csv"),
    ("<annotations><mode>annotation</mode>", "cvat-images", "cvat-images"),
    ('<annotations><image id="0">', "cvat-images", "cvat-images"),
    ("<annotations><mode>interpolation</mode>", "cvat-video", "cvat-video"),
    ('<annotations><track id="0">', "cvat-video", "cvat-video"),
    ("<annotation><track >", "voc", "voc"),
    ('\ufeff<?xml version="1.0"?>\n<!-- a -->\n<annotation x="">', "voc", "voc"),
    ("<a/>", "", ""),
    (CORNERS, "", EITHER),
    (re.sub(r"[\d.]+", r'"\g<0>"', CORNERS), "", EITHER),
    (SIZES, "", "kaist-results"),
    (re.sub(r"[\d.]+", r'"\g<0>"', SIZES), "", "kaist-results"),
    ("0,1,2,3,4,0.5\n", "", "kitti-detections"),  # KAIST's pictures count from 1
    ("0.5,1,2,3,4,5", "", ""),
    ("1,1,2,3,4\n", "", ""),
    ("1,2,3,40,50,0.5\n1,2,3\n", "", ""),
    (",".join(map(str, range(15))), "", "kitti-detections"),
    (KITTI, "kitti-object", "kitti-object"),
    (f"{KITTI} 0.5", "kitti-object", "kitti-object"),
    (f"0 5 {KITTI}", "kitti-tracking", "kitti-tracking"),
    (f"0 5 {KITTI} 0.5", "kitti-tracking", "kitti-tracking"),
    ("1 " * 15, "", ""),
    ("1 " * 17, "", ""),
    ("1,1,1,1,9,9,1", "mot", "mot"),
    ("1,-1,1.5,2,3,4,0.5,-1,-1,-1\n", "mot", "mot"),
    ("\ufeff1,1,,1,9,9,1\n", "mot", "mot"),
    ("1.5,1,1,1,9,9,1\n", "", ""),
    ("684,8,273,116,0,0,0,0\n", "visdrone mot", "visdrone mot"),
    ("684,8,273,116,0.5,4,-1,-1,\n", "visdrone mot", "visdrone mot"),
    ("1 2 3 4 5 6 7\n", "mot", "mot"),
    ("0 0.5 0.5 0.25 0.5\n", "yolo", "yolo"),
    ("0 0.5 0.5 0.25 0.5 0.9\n", "yolo", "yolo"),
    ("0 320 240 64 96\n", "", ""),
    ('"0" "0.5" "0.5" "0.1" "0.1"\n', "", ""),
    ("images/1.jpg\n", "", ""),
    ("00003.ppm;742;443;765;466;4\n", "gtsdb", ""),
    ("00003.ppm;742;443;765;466;4.5\n", "", ""),
    ("3;742;443;765;466;4\n", "", ""),
    ('{"images": []}', "coco", ""),
    ('{"annotations": [', "coco", "coco-results"),
    ("[]\n", "", "coco-results"),
    ('[{"a": 1}]', "", ""),
    ('{"openlabel": {}}', "", ""),
]
"""How a file begins, and the formats that claim it as truth and as detections."""


@pytest.mark.parametrize(("head", "as_truth", "as_detections"), CLAIMS)
def test_a_beginning_is_claimed_by_its_own_formats_only(
    head: str, as_truth: str, as_detections: str
):
    for role, claims in (("truth", as_truth), ("detections", as_detections)):
        formats = [form for form in FORMATS if role in form.roles]
        names = [form.name for form in formats if form.recognise("I00019.txt", head, role)]
        assert names == claims.split()


def test_the_format_is_told_from_the_first_file_that_is_not_empty():
    files = [source("kitti_object/label_2/000008.txt"), source("kitti_object/label_2/000007.txt")]
    assert detect_format(files, "truth").name == "kitti-object"


def test_empty_files_and_no_file_tell_no_format():
    with pytest.raises(UnknownFormatError, match=r"000002\.txt: .* first 50 files are empty"):
        detect_format([source("yolo/drive1/000002.txt")] * (MAX_LOOKS + 1), "truth")
    with pytest.raises(UnknownFormatError, match="cannot be told"):
        detect_format([], "truth")


def test_an_unknown_content_is_quoted_and_the_readable_formats_listed(tmp_path: Path):
    path = tmp_path / "a.txt"
    path.write_text("once upon a time")
    with pytest.raises(UnknownFormatError, match=r"a\.txt: .*'once upon a time'.*one of .*mot"):
        detect_format([SourceFile(path, "a.txt")], "truth")


def test_a_file_that_cannot_be_opened_is_an_input_error(tmp_path: Path):
    with pytest.raises(InputError, match=r"a\.txt: cannot be opened"):
        detect_format([SourceFile(tmp_path / "a.txt", "a.txt")], "truth")


@pytest.mark.parametrize(("name", "role", "format_name"), GOLDEN)
def test_every_row_of_a_golden_file_is_placed_or_left_out(name: str, role: Role, format_name: str):
    options, systems = ReadOptions(size=(640, 480)), ()
    truth = Source((name,), format=format_name)
    if role == "detections":
        listed = "coco/flir.json" if name == "coco/flir_results.json" else "coco/kaist.json"
        images = format_named("coco").read([source(listed)], ReadOptions())
        recordings = tuple(images.recordings["name"])
        options = replace(options, role=role, recordings=recordings, images=images.images)
        truth, systems = Source((listed,)), (SystemSource((name,), format=format_name),)
    n_rows = len(format_named(format_name).read([source(name)], options).boxes)
    # one frame only: nearly all rows lose their place
    dataset = load(Session(DATA, truth, systems, size=(640, 480), fps=20.0, frames="0:0"))
    subject = dataset.systems[0] if systems else "truth"
    placed = dataset.system(subject) if systems else dataset.truth
    lost = (dataset.left_out["subject"] == subject).sum()
    assert len(placed) + lost == n_rows

"""An empty file is a system that detected nothing; as ground truth it is an error."""

from __future__ import annotations

import gzip
import json
import lzma
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from inputs import drive, mot_layout, nvcore, session_of, write

from nvcore.common.errors import InputError
from nvcore.dataset import Dataset
from nvcore.inputs.load import load, read_source
from nvcore.inputs.readers import format_named
from nvcore.inputs.readers.base import ReadOptions, Role, SourceFile
from nvcore.inputs.session import Session, Source, SystemSource

TRUTH = "frame,x,y,w,h,track\n0,100,200,40,100,1"


def load_with_empty(folder: Path, name: str, file_format: str | None) -> Dataset:
    """One pedestrian, and a system whose only file is empty."""
    write(folder / "truth.csv", TRUTH)
    (folder / name).write_text("\n")
    return load(session_of(folder, "truth.csv", SystemSource((name,), format=file_format)))


@pytest.mark.parametrize("file_format", [None, "csv", "mot", "kitti-tracking", "kaist-results"])
@pytest.mark.parametrize("name", ["fir.txt", "fir.csv"])
def test_an_empty_detection_file_is_a_system_that_detected_nothing(
    tmp_path: Path, name: str, file_format: str | None
):
    dataset = load_with_empty(tmp_path, name, file_format)
    assert len(dataset.system("fir")) == 0
    assert dataset.inputs["conversion"].tolist()[1] == "empty file: no detections"


@pytest.mark.parametrize("name", ["fir.json", "fir.xml"])
def test_an_empty_document_is_an_error_that_says_what_no_detections_look_like(
    tmp_path: Path, name: str
):
    with pytest.raises(InputError, match=rf"{name}: the file is empty; .* empty list \(\[\]\)"):
        load_with_empty(tmp_path, name, None)


@pytest.mark.parametrize("file_format", [None, "csv", "mot", "coco", "yolo"])
def test_empty_ground_truth_is_one_and_the_same_error(tmp_path: Path, file_format: str | None):
    write(tmp_path / "fir.csv", "frame,x,y,w,h,score")
    (tmp_path / "truth.txt").write_text("")
    source = Source(("truth.txt",), format=file_format)
    session = Session(tmp_path, source, (SystemSource(("fir.csv",)),), size=(640, 480), fps=20.0)
    with pytest.raises(InputError, match=r"truth\.txt: the file is empty; expected ground truth"):
        load(session)


def test_the_empty_csv_file_of_one_recording_among_others_has_no_detections(tmp_path: Path):
    for name in ("A", "B"):
        write(tmp_path / "truth" / f"{name}.csv", TRUTH)
    write(tmp_path / "fir" / "A.csv", "frame,x,y,w,h,score", "0,100,200,40,100,0.5")
    (tmp_path / "fir" / "B.csv").write_text("")
    dataset = load(session_of(tmp_path, "truth", "fir"))
    assert dataset.recordings["name"].tolist() == ["A", "B"]
    assert len(dataset.system("fir")) == 1


COLUMNS = "recording,frame,x,y,w,h,score"
IMAGES = [{"id": i, "file_name": f"A/I{i}.png", "width": 640, "height": 480} for i in (1, 2)]
BOX = {"id": 1, "image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4]}


def coco(image: int, *annotations: object) -> str:
    """Ground truth of one of the images."""
    categories = [{"id": 1, "name": "person"}]
    truth = {"images": IMAGES[image - 1 : image], "annotations": annotations}
    return json.dumps(truth | {"categories": categories})


@pytest.mark.parametrize("is_first_empty", [True, False])
@pytest.mark.parametrize(
    ("kind", "role", "empty", "filled"),
    [
        ("csv", "detections", COLUMNS, f"{COLUMNS}\nA,1,1,2,3,4,0.5"),
        ("coco", "truth", coco(2), coco(1, BOX)),
        ("coco-results", "detections", "[]", json.dumps([BOX | {"score": 0.5}])),
    ],
)
def test_one_file_without_boxes_among_others_adds_none(
    tmp_path: Path, kind: str, role: Role, empty: str, filled: str, is_first_empty: bool
):
    texts = [empty, filled] if is_first_empty else [filled, empty]
    for name, text in zip("ab", texts, strict=True):
        (tmp_path / f"{name}.txt").write_text(text + "\n")
    listed = pd.DataFrame({"recording": ["A"], "frame": [1], "image_id": [1]})
    options = ReadOptions(role=role, images=None if kind == "csv" else listed)
    files = [SourceFile(tmp_path / f"{name}.txt", f"{name}.txt") for name in "ab"]
    boxes = format_named(kind).read(files, options).boxes
    assert boxes[["recording", "frame", "x", "file"]].to_numpy().tolist() == [
        ["A", 1, 1, int(is_first_empty)]
    ]


def test_all_empty_files_of_a_mot_layout_have_no_detections(tmp_path: Path):
    mot_layout(tmp_path)
    for name in ("A", "B"):
        (tmp_path / name / "det" / "det.txt").write_text("")
    session = Session(tmp_path, Source((".",)), (SystemSource(("*/det/det.txt",), name="X"),))
    assert len(load(session).system("X")) == 0


def test_no_detections_convert_to_a_file_with_the_header_only(tmp_path: Path):
    (tmp_path / "fir.txt").write_text("")
    arguments = (tmp_path / "fir.txt", tmp_path / "fir.csv", "--to", "csv")
    assert nvcore("convert", *arguments, "--role", "detections").exit_code == 0
    (header,) = (tmp_path / "fir.csv").read_text().splitlines()
    assert header.startswith("recording,frame,x,y,w,h,score")


@pytest.mark.parametrize("pack", [bytes, gzip.compress, lzma.compress], ids=["", "gz", "xz"])
@pytest.mark.parametrize("end", [b"", b"\r\n"])
def test_a_header_whose_line_has_no_end_is_a_file_without_boxes(
    tmp_path: Path, pack: Callable[[bytes], bytes], end: bytes
):
    content = b"recording,frame,x,y,w,h,score" + end
    (tmp_path / "fir.csv").write_bytes(pack(content))
    reading = read_source(Source(("fir.csv",)), role="detections", folder=tmp_path)
    assert len(reading.boxes) == 0


def test_reading_empty_detections_alone_gives_no_recording(tmp_path: Path):
    (tmp_path / "fir.txt").write_text("")
    reading = read_source(Source(("fir.txt",)), role="detections", folder=tmp_path)
    assert (len(reading.boxes), len(reading.recordings)) == (0, 0)


def test_ground_truth_of_a_header_only_says_what_may_be_wrong(tmp_path: Path):
    write(drive(tmp_path) / "truth.csv", "frame,x,y,w,h,track")
    with pytest.raises(InputError, match=r"no box \(only a header, or other .*right file"):
        load(session_of(tmp_path))

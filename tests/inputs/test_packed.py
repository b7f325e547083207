"""Packed files are read as their content is, within limits; their hashes are of the files."""

from __future__ import annotations

import gzip
import hashlib
import json
import lzma
from pathlib import Path

import pytest
from inputs import drive, flags, mot_layout, nvcore, session_of, write
from packing import PACK, zstd
from places import DATA
from reader_files import source

from nvcore.common.errors import FormatError, InputError
from nvcore.inputs.files import packed
from nvcore.inputs.files.find import find_files, system_names
from nvcore.inputs.load import load
from nvcore.inputs.readers import detect_format
from nvcore.inputs.readers.base import ReadOptions, Role, SourceFile
from nvcore.inputs.readers.meaning.names import recording_and_frame_of, recording_of
from nvcore.inputs.session import Source

FILES: list[tuple[str, Role]] = [
    ("bbgt/set06/V000/I00019.txt", "truth"),
    ("coco/kaist.json", "truth"),
    ("coco/flir_results.json", "detections"),
    ("csv/truth.csv", "truth"),
    ("cvat_images/annotations.xml", "truth"),
    ("cvat_video/annotations.xml", "truth"),
    ("kaist_results/set06/V000.txt", "detections"),
    ("kitti_detections/ab3dmot.txt", "detections"),
    ("kitti_object/label_2/000007.txt", "truth"),
    ("kitti_tracking/0016.txt", "truth"),
    ("mot/MOT16-02/gt/gt.txt", "truth"),
    ("voc/drive1/000007.xml", "truth"),
    ("yolo/drive1/000001.txt", "truth"),
]


@pytest.mark.parametrize("ending", PACK)
@pytest.mark.parametrize(("name", "role"), FILES)
def test_a_packed_file_of_every_format_is_read_as_its_content(
    tmp_path: Path, name: str, role: Role, ending: str
):
    plain = SourceFile(DATA / name, name)
    file = source(tmp_path, PACK[ending](plain.path.read_bytes()), name + ending)
    file_format = detect_format([plain], role)
    assert detect_format([file], role) is file_format
    options = ReadOptions(role=role, size=(640, 480))
    ours, theirs = (file_format.read([source_file], options) for source_file in (file, plain))
    assert ours.boxes.equals(theirs.boxes)
    assert ours.recordings["name"].tolist() == theirs.recordings["name"].tolist()
    # nothing lies beside the packed file, such as MOTChallenge's seqinfo.ini
    assert theirs.conversion.startswith(ours.conversion)


def test_a_comparison_of_packed_files_is_that_of_the_files(tmp_path: Path):
    drive(tmp_path)
    plain = nvcore("compare", *flags(tmp_path), "--json").stdout
    for name, ending in zip(("truth", "fir", "nir"), (".gz", ".xz", ".zst"), strict=True):
        path = tmp_path / f"{name}.csv"
        path.with_name(path.name + ending).write_bytes(PACK[ending](path.read_bytes()))
        path.unlink()
    given = [
        *("--truth", tmp_path / "truth.csv.gz", "--x", tmp_path / "fir.csv.xz"),
        *("--y", tmp_path / "*.zst", "--size", "640x480", "--fps", "20"),
    ]
    run = nvcore("compare", *given, "--name-y", "nir", "--json")
    assert run.exit_code == 0, run.output
    ours, theirs = json.loads(run.stdout), json.loads(plain)
    # the fingerprint is of the files as they are stored
    assert ours.pop("fingerprint") != theirs.pop("fingerprint")
    assert ours == theirs


def test_the_hash_is_that_of_the_file_as_it_is_stored(tmp_path: Path):
    drive(tmp_path)
    content = gzip.compress((tmp_path / "truth.csv").read_bytes())
    (tmp_path / "truth.csv.gz").write_bytes(content)
    dataset = load(session_of(tmp_path, "truth.csv.gz", "fir.csv"))
    assert dataset.inputs["sha256"].iloc[0] == hashlib.sha256(content).hexdigest()
    assert dataset.inputs["file"].iloc[0].endswith("truth.csv.gz")


def test_folders_and_mot_layouts_of_packed_files_are_found(tmp_path: Path):
    for path in mot_layout(tmp_path / "mot").rglob("gt.txt"):
        path.with_name("gt.txt.gz").write_bytes(gzip.compress(path.read_bytes()))
        if "A" in path.parts:
            path.unlink()
    files, _ = find_files(Source("mot"), tmp_path, "truth")
    # a plain file goes before the packed one beside it
    assert [file.name for file in files] == ["A/gt/gt.txt.gz", "B/gt/gt.txt"]
    source(tmp_path, gzip.compress(b"frame,x,y,w,h\n1,1,1,5,9\n"), "csv/night.csv.gz")
    source(tmp_path, gzip.compress(b"about"), "csv/readme.txt.gz")
    files, _ = find_files(Source("csv"), tmp_path, "truth")
    assert [file.name for file in files] == ["night.csv.gz"]


def test_recordings_frames_and_systems_are_named_as_by_the_unpacked_files():
    assert recording_of("night/V000.csv.gz") == "V000"
    assert recording_and_frame_of("V000/I00019.txt.xz") == ("V000", 19)
    assert system_names([Source("out/FIR.csv.zst")], ()) == ["FIR"]


def test_packed_lists_of_frames_and_of_recordings_are_read(tmp_path: Path):
    drive(tmp_path)
    frames = tmp_path / "frames.txt.gz"
    frames.write_bytes(gzip.compress(b"3\n4\n5\n"))
    table = tmp_path / "recordings.csv.xz"
    table.write_bytes(lzma.compress(b"recording,context\nurban,rural\n"))
    run = nvcore("check", *flags(tmp_path, "--frames", frames, "--recordings", table))
    assert run.exit_code == 0, run.output
    assert "(6 in all)" in run.stdout


def test_parts_one_after_another_are_one_content(tmp_path: Path):
    for ending, pack in PACK.items():
        file = source(tmp_path, pack(b"frame,x,y,") + pack(b"w,h\n"), f"a.csv{ending}")
        with file.open() as stream:
            assert stream.read() == b"frame,x,y,w,h\n"


@pytest.mark.parametrize("ending", PACK)
def test_a_line_at_fault_is_named_with_the_packed_file(tmp_path: Path, ending: str):
    file = source(
        tmp_path, PACK[ending](b"frame,x,y,w,h\n1,1,1,9,9\n2,a,1,9,9\n"), "a.csv" + ending
    )
    with pytest.raises(FormatError, match=rf"a\.csv\{ending}, line 3: expected a number as x"):
        detect_format([file], "truth").read([file], ReadOptions())


@pytest.mark.parametrize("ending", PACK)
@pytest.mark.parametrize("damage", ["cut", "behind", "head"])
def test_a_damaged_packed_file_is_refused(tmp_path: Path, ending: str, damage: str):
    lines = "".join(f"{frame},{frame * 7919 % 640},1,9,9\n" for frame in range(2000))
    content = PACK[ending](f"frame,x,y,w,h\n{lines}".encode())
    content = {"cut": content[:-20], "behind": content + b"garbage!", "head": content[:12]}[damage]
    file = source(tmp_path, content, "a.csv" + ending)
    with pytest.raises(FormatError, match=r"a\.csv\.\w+: expected a whole file packed by"):
        detect_format([file], "truth").read([file], ReadOptions())


@pytest.mark.parametrize("ending", PACK)
def test_a_bomb_is_refused_long_before_it_is_whole(
    tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(packed, "RATIO_FROM_BYTES", 1 << 18)
    file = source(tmp_path, PACK[ending](b"frame,x,y,w,h\n" + bytes(10 << 20)), "a.csv" + ending)
    with file.open() as stream:
        content = stream.raw
        with pytest.raises(FormatError, match="unpacks to more than 200 times its size"):
            stream.read()
    assert content._n_unpacked < 5 << 20


def test_a_content_beyond_the_limit_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(packed, "MAX_UNPACKED_BYTES", 1000)
    file = source(tmp_path, zstd(bytes(range(256)) * 8), "a.csv.zst")
    with pytest.raises(InputError, match="unpacks to more than"), file.open() as stream:
        stream.read()


def test_an_xz_file_that_asks_for_much_memory_is_refused(tmp_path: Path):
    filters = [{"id": lzma.FILTER_LZMA2, "dict_size": 1 << 29, "mf": lzma.MF_HC3, "nice_len": 3}]
    file = source(tmp_path, lzma.compress(b"frame,x,y,w,h\n", filters=filters), "a.csv.xz")
    with pytest.raises(FormatError, match=r"[Mm]emory"), file.open() as stream:
        stream.read()


def test_a_file_packed_twice_says_what_to_do(tmp_path: Path):
    file = source(tmp_path, gzip.compress(zstd(b"frame,x,y,w,h\n")), "a.csv.zst.gz")
    with pytest.raises(InputError, match="found a file packed by Zstandard: unpack it"):
        detect_format([file], "truth")


def test_an_empty_packed_file_is_a_system_that_detected_nothing(tmp_path: Path):
    drive(tmp_path)
    (tmp_path / "none.txt.gz").write_bytes(gzip.compress(b""))
    write(tmp_path / "frames.txt", "1")
    dataset = load(session_of(tmp_path, "truth.csv", "none.txt.gz"))
    assert dataset.inputs["format"].tolist() == ["csv", "empty"]

"""A network of one's own: fed as it wants, refused where it cannot be trusted."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from onnx import TensorProto, helper
from onnx_models import blob_model, constant, external_model, fixed_model, save
from places import ROOT

from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.onnx import open_onnx


def bright_at(x: int, y: int, *, width: int = 128, height: int = 64) -> np.ndarray:
    """A dark picture with a bright square of 16 px."""
    picture = np.zeros((height, width, 3), np.uint8)
    picture[y : y + 16, x : x + 16] = 255
    return picture


def test_a_network_finds_what_is_in_the_picture(tmp_path: Path):
    detector = open_onnx(blob_model(tmp_path / "blobs.onnx"), {"threshold": 0.9, "fill": 0})
    detections = detector.detect(bright_at(48, 32))
    assert (detections.x, detections.y, detections.w, detections.h) == ([48], [32], [16], [16])
    assert detections.score == pytest.approx([1.0])
    assert detector.about.name == "blobs"
    assert detector.about.threshold == 0.9


@pytest.mark.parametrize("kind", ["grey", "16 bit"])
def test_grey_and_16_bit_pictures_are_fed_as_8_bit_colours(kind: str, tmp_path: Path):
    detector = open_onnx(blob_model(tmp_path / "blobs.onnx"), {"threshold": 0.9, "fill": 0})
    grey = bright_at(48, 32)[..., 1]
    picture = grey if kind == "grey" else grey.astype(np.uint16) * 10 + 7000
    assert detector.detect(picture).x == [48]


def test_grey_levels_become_what_the_network_wants(tmp_path: Path):
    path = blob_model(tmp_path / "blobs.onnx")
    white = np.full((64, 64, 3), 255, np.uint8)
    given = {"overlap": 1, "threshold": 0}

    def brightness(**more: object) -> float:
        return float(open_onnx(path, {**given, **more}).detect(white).score.max())

    assert brightness() == pytest.approx(1)
    assert brightness(values="0..255") == pytest.approx(255)
    # (1 - mean) / spread of the three colours, on average
    expected = np.mean([(1 - 0.485) / 0.229, (1 - 0.456) / 0.224, (1 - 0.406) / 0.225])
    assert brightness(values="imagenet") == pytest.approx(expected, rel=1e-5)


def test_the_order_of_the_colours(tmp_path: Path):
    red = np.zeros((64, 64, 3), np.uint8)
    red[..., 0] = 255
    first = model_of_channel(tmp_path / "first.onnx", 0)
    assert len(open_onnx(first, {"colour": "rgb"}).detect(red)) == 1
    assert len(open_onnx(first, {"colour": "bgr"}).detect(red)) == 0


def model_of_channel(path: Path, channel: int) -> Path:
    """One box whose score is the mean of one channel of the input."""
    nodes = [
        constant("which", np.array([channel], np.int64)),
        helper.make_node("Gather", ["images", "which"], ["plane"], axis=1),
        helper.make_node("ReduceMean", ["plane"], ["mean"], axes=[1, 2, 3], keepdims=0),
        constant("form", np.array([1, 1, 1], np.int64)),
        helper.make_node("Reshape", ["mean", "form"], ["score"]),
        constant("box", np.array([[[8.0, 8.0, 40.0, 40.0]]], np.float32)),
        constant("class", np.zeros((1, 1, 1), np.float32)),
        helper.make_node("Concat", ["box", "score", "class"], ["output0"], axis=2),
    ]
    return save(path, nodes, {"output0": TensorProto.FLOAT})


def test_sides_that_are_open_are_640_unless_given(tmp_path: Path):
    output = {"output0": np.zeros((1, 30, 6))}
    path = fixed_model(tmp_path / "m.onnx", output, shape=("n", 3, "height", "width"))
    assert (open_onnx(path, {}).settings.width, open_onnx(path, {}).settings.height) == (640, 640)
    assert open_onnx(path, {"width": 320}).settings.width == 320


def test_a_side_that_is_fixed_cannot_be_given(tmp_path: Path):
    path = fixed_model(tmp_path / "m.onnx", {"output0": np.zeros((1, 30, 6))})
    with pytest.raises(DetectorError, match="width: its input is fixed to 64 px, found 320"):
        open_onnx(path, {"width": 320})


def test_torchvision_s_input_has_no_axis_for_pictures(tmp_path: Path):
    outputs = {
        "boxes": np.array([[8.0, 8.0, 24.0, 40.0]]),
        "labels": np.array([1]),
        "scores": np.array([0.75]),
    }
    path = fixed_model(tmp_path / "m.onnx", outputs, shape=(3, 64, 64))
    detections = open_onnx(path, {}).detect(np.zeros((64, 64), np.uint8))
    assert (detections.x, detections.w, detections.score) == ([8], [16], [0.75])


def test_numbers_that_are_none_are_no_boxes(tmp_path: Path):
    rows = np.zeros((1, 30, 6))
    rows[0, :5, :5] = [
        (np.nan, 0, 9, 9, 0.9),
        (0, 0, np.inf, 9, 0.9),
        (0, 0, 9, 9, np.nan),
        (9, 9, 0, 0, 0.9),  # right of its right side
        (0, 0, 9, 9, 0.9),
    ]
    rows[0, 5] = (0, 0, 9, 9, 0.9, np.nan)  # of no class
    path = fixed_model(tmp_path / "m.onnx", {"output0": rows})
    assert open_onnx(path, {}).detect(np.zeros((64, 64), np.uint8)).w.tolist() == [9]


def test_threads_change_no_fingerprint_but_a_threshold_does(tmp_path: Path):
    path = blob_model(tmp_path / "blobs.onnx")
    single, double, other = (
        open_onnx(path, given).about.fingerprint
        for given in ({"threads": 1}, {"threads": 2}, {"threshold": 0.1})
    )
    assert single == double != other


def test_nothing_is_reported_to_the_maker_of_the_runtime(tmp_path: Path):
    # its telemetry keeps a number of the machine in the user's cache
    home = tmp_path / "home"
    home.mkdir()
    path = blob_model(tmp_path / "blobs.onnx")
    code = (
        "import numpy as np\n"
        "from nvcore.subjects.detectors.registry import open_detector\n"
        f"detector = open_detector({str(path)!r})\n"
        "detector.detect(np.zeros((64, 64), np.uint8))\n"
    )
    clean = {key: value for key, value in os.environ.items() if not key.startswith(("ORT", "XDG"))}
    environment = {**clean, "HOME": str(home)}
    subprocess.run([sys.executable, "-c", code], env=environment, cwd=ROOT, check=True)
    assert not [*home.rglob("*onnxruntime*")]


def test_weights_beside_the_model_belong_to_it(tmp_path: Path):
    path = external_model(tmp_path / "m.onnx", "weights.bin")
    weights = np.zeros((300, 6), np.float32)
    weights[0] = (8, 8, 24, 40, 0.75, 0)
    weights.tofile(tmp_path / "weights.bin")
    detector = open_onnx(path, {})
    assert detector.detect(np.zeros((64, 64), np.uint8)).score == [0.75]
    weights[0, 4] = 0.5
    weights.tofile(tmp_path / "weights.bin")
    assert open_onnx(path, {}).about.fingerprint != detector.about.fingerprint


@pytest.mark.parametrize("in_node", [False, True], ids=["initializer", "constant"])
@pytest.mark.parametrize("place", ["../outside.bin", "absolute", "link.bin", "a/../../outside.bin"])
def test_weights_outside_its_folder_are_refused(place: str, in_node: bool, tmp_path: Path):
    np.zeros(1800, np.float32).tofile(tmp_path / "outside.bin")
    folder = tmp_path / "models"
    (folder / "a").mkdir(parents=True)
    (folder / "link.bin").symlink_to(tmp_path / "outside.bin")
    location = str(tmp_path / "outside.bin") if place == "absolute" else place
    path = external_model(folder / "m.onnx", location, in_node=in_node)
    with pytest.raises(DetectorError, match="outside its own folder, and is refused"):
        open_onnx(path, {})


def test_weights_that_are_not_there_are_named(tmp_path: Path):
    path = external_model(tmp_path / "m.onnx", "gone.bin")
    with pytest.raises(DetectorError, match=r"'gone\.bin', which is not there"):
        open_onnx(path, {})


def test_a_damaged_file_is_refused(tmp_path: Path):
    path = blob_model(tmp_path / "blobs.onnx")
    content = path.read_bytes()
    for damaged in (content[:200], content[:-20], b"\x08\x08" + bytes(100), content * 2):
        path.write_bytes(damaged)
        with pytest.raises(DetectorError, match=r"blobs\.onnx: (is damaged|ONNX Runtime cannot)"):
            open_onnx(path, {})


@pytest.mark.parametrize("seed", range(30))
def test_whatever_is_changed_in_a_file_it_opens_or_is_refused(seed: int, tmp_path: Path):
    path = blob_model(tmp_path / "blobs.onnx", names="{0: 'person'}")
    rng = np.random.default_rng(seed)
    content = bytearray(path.read_bytes())
    for place in rng.integers(0, len(content), 3):
        content[place] = rng.integers(256)
    path.write_bytes(bytes(content))
    with suppress(DetectorError):
        assert open_onnx(path, {}).detect(np.zeros((64, 64), np.uint8)) is not None


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"shape": (8, 3, 64, 64)}, r"expected one picture: \(1, 3, height, width\)"),
        ({"shape": (1, 512)}, "expected one picture"),
        ({"shape": (1, 4, 64, 64)}, "its input has 4 channels"),
        ({"kind": TensorProto.INT64}, "expected one picture"),
        ({"shape": (1, 3, 64, 20000)}, "its input is 20,000 px in width"),
    ],
)
def test_an_input_that_is_no_picture_is_refused(options: dict, words: str, tmp_path: Path):
    path = fixed_model(tmp_path / "m.onnx", {"output0": np.zeros((1, 30, 6))}, **options)
    with pytest.raises(DetectorError, match=words):
        open_onnx(path, {})


def test_classes_that_are_not_there_are_refused(tmp_path: Path):
    output = {"output0": np.zeros((1, 6, 84))}
    named = fixed_model(tmp_path / "named.onnx", output, names="{0: 'car', 1: 'sign'}")
    plain = fixed_model(tmp_path / "plain.onnx", output)
    with pytest.raises(DetectorError, match="has no class person or pedestrian, but car, sign"):
        open_onnx(named, {})
    with pytest.raises(DetectorError, match=r"classes: there is no 'bus' \(car, sign\)"):
        open_onnx(named, {"classes": "bus"})
    with pytest.raises(DetectorError, match="has 2 classes; expected one of the numbers 7"):
        open_onnx(plain, {"classes": "7"}).detect(np.zeros((64, 64), np.uint8))
    assert open_onnx(plain, {"names": "car,person"}).about.labels == ("person",)


@pytest.mark.parametrize(
    "names",
    ["__import__('os')", "[[[", "{'a': 1}", "7", "(" * 5000, "{[]: 'a'}", f"[0x{'f' * 5000}]"],
)
def test_names_that_are_no_names_are_passed_over(names: str, tmp_path: Path):
    output = {"output0": np.zeros((1, 6, 84))}
    path = fixed_model(tmp_path / "m.onnx", output, names=names)
    assert open_onnx(path, {}).about.labels == ("person",)

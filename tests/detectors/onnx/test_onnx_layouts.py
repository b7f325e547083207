"""Outputs of the common families: the same box, detections in the same place of the picture.

The picture is 128 x 64 px and the input 64 x 64; the box is around the middle of the input, 16 px
wide and high, as the network has it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from onnx import TensorProto, helper
from onnx_models import constant, fixed_model

from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.onnx import open_onnx
from nvcore.subjects.detectors.onnx.layouts import PRESETS, cell_count, recognise

PICTURE = np.zeros((64, 128, 3), np.uint8)
BOX = (32.0, 32.0, 16.0, 16.0)
LETTERBOX, STRETCHED, CORNER = (48, 16, 32, 32), (48, 24, 32, 16), (48, 48, 32, 32)
"""Where it is in the picture, by how the picture was brought to the input's size."""
N = cell_count((64, 64), (8, 16, 32))
"""Cells of a YOLO network with this input: 84."""


def rows(n: int, columns: int, **values: float) -> np.ndarray:
    """An output (1, n, columns) whose row 7 has the box, and these values by column ("c4")."""
    array = np.zeros((1, n, columns), np.float32)
    array[0, 7, :4] = BOX
    for column, value in values.items():
        array[0, 7, int(column[1:])] = value
    return array


def yolox() -> np.ndarray:
    """Row 7 is the last cell of the first row of 8 px cells: x = 56, y = 0."""
    array = rows(N, 7, c4=0.5, c5=0.8)
    array[0, 7, :4] = (32 - 56) / 8, 32 / 8, np.log(2), np.log(2)
    return array


def detr() -> dict[str, np.ndarray]:
    logits, boxes = np.zeros((1, 10, 4)), np.zeros((1, 10, 4))
    logits[..., 3] = 20  # nothing
    logits[0, 7] = (0, np.log(8), 0, -50)  # 0.8 person, of what is something
    boxes[0, 7] = np.array(BOX) / 64
    return {"logits": logits, "pred_boxes": boxes}


def rtdetr() -> dict[str, np.ndarray]:
    logits, boxes = np.full((1, 10, 80), -9.0), np.zeros((1, 10, 4))
    logits[0, 7, 0] = np.log(4)  # 0.8, whatever the others are
    boxes[0, 7] = np.array(BOX) / 64
    return {"logits": logits, "pred_boxes": boxes}


CASES = {
    "yolov5": ({"output": rows(3 * N, 7, c4=0.5, c5=0.8)}, LETTERBOX, 0.4),
    "yolov8": ({"output0": np.moveaxis(rows(N, 6, c4=0.8), 1, 2)}, LETTERBOX, 0.8),
    "yolox": ({"output": yolox()}, CORNER, 0.4),
    "end_to_end": (
        {"output0": rows(30, 6, c0=24, c1=24, c2=40, c3=40, c4=0.8, c5=0)},
        LETTERBOX,
        0.8,
    ),
    "ssd": (
        {
            "boxes": np.array([[0, 0, 9, 9], [24, 24, 40, 40]], np.float32),
            "labels": np.array([3, 1]),
            "scores": np.array([0.9, 0.8], np.float32),
        },
        STRETCHED,
        0.8,
    ),
    "detr": (detr(), STRETCHED, 0.8),
    "rtdetr": (rtdetr(), STRETCHED, 0.8),
}


@pytest.mark.parametrize("layout", CASES)
def test_a_layout_is_recognised_and_read(layout: str, tmp_path: Path):
    outputs, place, score = CASES[layout]
    detector = open_onnx(fixed_model(tmp_path / "model.onnx", outputs), {})
    assert detector.settings.layout == layout
    detections = detector.detect(PICTURE)
    assert len(detections) == 1
    assert (detections.x[0], detections.y[0], detections.w[0], detections.h[0]) == pytest.approx(
        place, abs=1e-3
    )
    assert detections.score[0] == pytest.approx(score, abs=1e-6)


@pytest.mark.parametrize("layout", CASES)
def test_a_layout_can_be_named(layout: str, tmp_path: Path):
    path = fixed_model(tmp_path / "model.onnx", CASES[layout][0])
    assert len(open_onnx(path, {"layout": layout}).detect(PICTURE)) == 1


@pytest.mark.parametrize(
    ("layout", "words"),
    [
        ("detr", "expected outputs logits"),
        ("ssd", "expected outputs named boxes, scores and labels"),
        ("yolox", "expected 84 rows for 64 x 64 px, found 6"),
    ],
)
def test_a_layout_that_it_has_not_is_refused(layout: str, words: str, tmp_path: Path):
    path = fixed_model(tmp_path / "model.onnx", CASES["yolov8"][0])
    with pytest.raises(DetectorError, match=rf"{words}.*\(layout {layout}\)"):
        open_onnx(path, {"layout": layout})


@pytest.mark.parametrize("layout", ["ssd", "end_to_end"])
def test_softmax_of_one_score_a_box_is_refused(layout: str, tmp_path: Path):
    path = fixed_model(tmp_path / "model.onnx", CASES[layout][0])
    with pytest.raises(DetectorError, match="softmax needs the scores of all classes"):
        open_onnx(path, {"layout": layout, "activation": "softmax"}).detect(PICTURE)


def test_every_layout_has_its_case():
    assert [*CASES] == [*PRESETS]


def test_rt_detr_is_fed_with_values_from_0_to_1_and_numbers_persons_from_0(tmp_path: Path):
    detector = open_onnx(fixed_model(tmp_path / "model.onnx", rtdetr()), {})
    assert (detector.settings.values, detector.settings.activation) == ("0..1", "sigmoid")
    assert detector.about.labels == ("person",)
    logits = np.moveaxis(rtdetr()["logits"], 2, 0)
    others = {**rtdetr(), "logits": np.moveaxis(logits[[0, 0, 1]], 0, 2)}
    path = fixed_model(tmp_path / "own.onnx", others)
    named = open_onnx(path, {"layout": "rtdetr", "names": "person,car,dog"})
    assert named.detect(PICTURE).score == pytest.approx([0.8])


@pytest.mark.parametrize("layout", ["auto", "detr", "rtdetr"])
def test_a_batch_of_none_is_refused(layout: str, tmp_path: Path):
    outputs = {name: array[:0] for name, array in detr().items()}
    path = fixed_model(tmp_path / "model.onnx", outputs)
    with pytest.raises(DetectorError, match="expected outputs logits"):
        open_onnx(path, {"layout": layout})


def test_outputs_that_are_texts_are_refused(tmp_path: Path):
    path = tmp_path / "model.onnx"
    fixed_model(path, {"labels": np.array([["a", "b"]], object)})
    with pytest.raises(DetectorError, match="none of its outputs is an array of numbers"):
        open_onnx(path, {})
    with pytest.raises(DetectorError, match="none of its outputs is an array of numbers"):
        open_onnx(path, {"layout": "yolov8"})


def test_an_output_that_is_a_sequence_is_refused(tmp_path: Path):
    nodes = [
        constant("a", np.zeros((1, 6, 4), np.float32)),
        helper.make_node("SequenceConstruct", ["a"], ["all"]),
    ]
    kind = helper.make_tensor_sequence_value_info("all", TensorProto.FLOAT, None)
    shape = helper.make_tensor_value_info("images", TensorProto.FLOAT, [1, 3, 64, 64])
    graph = helper.make_graph(nodes, "test", [shape], [kind])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    path = tmp_path / "model.onnx"
    path.write_bytes(model.SerializeToString())
    with pytest.raises(DetectorError, match="none of its outputs is an array of numbers"):
        open_onnx(path, {})


def test_numbers_of_classes_beyond_all_reason_are_passed_over(tmp_path: Path):
    names = f"{{{10**30}: 'person', -1: 'person', 0: 'car', 1: 'person'}}"
    path = fixed_model(tmp_path / "model.onnx", CASES["yolov8"][0], names=names)
    assert open_onnx(path, {}).about.labels == ("person",)


def test_tensorflow_s_ssd_has_its_corners_the_other_way_and_shares(tmp_path: Path):
    outputs = {
        "detection_boxes": np.array([[[24, 16, 40, 48]]]) / 64,
        "detection_classes": np.array([[1.0]]),
        "detection_scores": np.array([[0.8]]),
        "num_detections": np.array([1.0]),
    }
    path = fixed_model(
        tmp_path / "model.onnx", outputs, shape=("batch", "height", "width", 3), kind=2
    )
    given = {"box": "yxyx", "width": 64, "height": 64}
    detections = open_onnx(path, given).detect(PICTURE)
    assert np.stack([detections.x, detections.y, detections.w, detections.h]).ravel().tolist() == [
        32,
        24,
        64,
        16,
    ]


def test_outputs_of_ssd_without_names_are_told_by_shape_and_type(tmp_path: Path):
    boxes, labels, scores = CASES["ssd"][0].values()
    path = fixed_model(tmp_path / "model.onnx", {"a": labels, "b": scores, "c": boxes})
    assert open_onnx(path, {}).detect(PICTURE).score == pytest.approx([0.8])


def test_scores_that_are_no_probabilities_yet(tmp_path: Path):
    output = np.full((1, N, 6), -20.0)
    output[0, 7, :5] = (*BOX, np.log(4))
    path = fixed_model(tmp_path / "model.onnx", {"output0": np.moveaxis(output, 1, 2)})
    detections = open_onnx(path, {"activation": "sigmoid"}).detect(PICTURE)
    assert detections.score == pytest.approx([0.8])


def test_the_best_of_the_chosen_classes_counts_and_names_the_box(tmp_path: Path):
    output = np.zeros((1, 7, N))
    output[0, :4, 7], output[0, 4:, 7] = BOX, (0.9, 0.3, 0.6)
    output[0, :4, 9], output[0, 4:, 9] = BOX, (0.9, 0.5, 0.1)
    path = tmp_path / "model.onnx"
    fixed_model(path, {"output0": output}, names="{0: 'car', 1: 'person', 2: 'rider'}")
    default, both = (open_onnx(path, given) for given in ({}, {"classes": "person, rider"}))
    assert default.about.labels == ("person",)
    assert default.detect(PICTURE).score == pytest.approx([0.5])
    assert default.detect(PICTURE).label is None
    detections = both.detect(PICTURE)
    assert detections.score == pytest.approx([0.6, 0.5])
    assert detections.label is not None
    assert detections.label.tolist() == ["rider", "person"]
    assert len(open_onnx(path, {"classes": "1,2", "overlap": 1}).detect(PICTURE)) == 2


@pytest.mark.parametrize(
    ("shape", "layout"),
    [
        ((1, 25200, 85), "yolov5"),
        ((1, 25200, 6), "yolov5"),
        ((1, 8400, 85), "yolox"),
        ((1, 84, 8400), "yolov8"),
        ((1, 5, 8400), "yolov8"),
        ((1, 300, 6), "end_to_end"),
        ((1, 100, 6), "end_to_end"),
        ((1, 34000, 6), "yolox"),
        ((1, 102000, 85), "yolov5"),
    ],
)
def test_networks_of_the_usual_sizes(shape: tuple[int, ...], layout: str):
    size = (1280, 1280) if shape[1] > 30000 else (640, 640)
    assert recognise({"output": np.broadcast_to(np.float32(0), shape)}, size, "m") == layout


def test_an_unknown_output_is_shown(tmp_path: Path):
    path = fixed_model(tmp_path / "model.onnx", {"embedding": np.zeros((1, 512))})
    with pytest.raises(DetectorError, match=r"outputs \(embedding \(1, 512\)\) are of no known"):
        open_onnx(path, {})

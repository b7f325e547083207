"""Model files: the same again to the byte, and nothing damaged or hostile gets in."""

from __future__ import annotations

import io
import json
import pickle
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from damaged_models import (
    about_of,
    members,
    npy,
    packed,
    with_about,
    with_changed_members,
    with_odd_values,
)

from nvcore.dataset.provenance import TrainedOn
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.classifier import N_VALUES, Classifier
from nvcore.subjects.detectors.icf import IcfDetector, read_model, write_model
from nvcore.subjects.detectors.icf.model import from_bytes, to_bytes
from nvcore.subjects.detectors.icf.regions import Band


def test_a_model_is_read_as_it_was_written(model, tmp_path, drawn):
    part = TrainedOn("ab" * 32, "drive", 0, 399)
    whole = replace(model, band=Band(0.1, 0.5, 0.02, 0.03), trained_on=(part,), name="signs, day")
    path = tmp_path / "signs.npz"
    write_model(whole, path)
    detector = read_model(path)
    assert to_bytes(detector.model) == path.read_bytes()
    assert detector.about == IcfDetector(whole).about
    assert detector.model.band == whole.band
    assert detector.model.trained_on == (part,)
    picture = drawn(100).picture
    np.testing.assert_array_equal(
        detector.detect(picture).score, IcfDetector(whole).detect(picture).score
    )


def test_numpy_opens_a_model_without_pickle(model, tmp_path):
    write_model(model, tmp_path / "m.npz")
    with np.load(tmp_path / "m.npz", allow_pickle=False) as arrays:
        assert json.loads(arrays["about"].tobytes())["label"] == "disc"
        np.testing.assert_array_equal(arrays["leaves"], model.trees.leaves)


def with_array(name: str, change: Callable[[np.ndarray], np.ndarray]):
    def altered(files: dict[str, bytes]) -> None:
        array = np.lib.format.read_array(io.BytesIO(files[f"{name}.npy"]))
        files[f"{name}.npy"] = npy(change(array.copy()))

    return altered


def put(name: str, index: object, value: float):
    def change(array: np.ndarray) -> np.ndarray:
        array[index] = value
        return array

    return with_array(name, change)


def with_fact(name: str, value: object):
    def altered(files: dict[str, bytes]) -> None:
        files.update(with_about(files, {**about_of(files), name: value}))

    return altered


def with_setting(name: str, value: object):
    def altered(files: dict[str, bytes]) -> None:
        with_fact("settings", {**about_of(files)["settings"], name: value})(files)

    return altered


def with_text(text: bytes):
    return lambda files: files.update({"about.npy": npy(np.frombuffer(text, np.uint8))})


def with_pickle(files: dict[str, bytes]) -> None:
    files["trace.npy"] = npy(np.array([print], dtype=object), allow_pickle=True)


def stating_more(files: dict[str, bytes]) -> None:
    """A header that states 8 TB."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)}
    )
    files["trace.npy"] = header.getvalue() + bytes(80)


CASES = {
    "no array": lambda files: files.pop("trace.npy"),
    "one more": lambda files: files.update({"more.npy": npy(np.zeros(1))}),
    "a path": lambda files: files.update({"../trace.npy": files.pop("trace.npy")}),
    "pickle": with_pickle,
    "huge": stating_more,
    "cut off": lambda files: files.update({"leaves.npy": files["leaves.npy"][:-3]}),
    "no magic": lambda files: files.update({"leaves.npy": pickle.dumps([1])}),
    "other type": with_array("leaves", lambda a: a.astype(np.float32)),
    "Fortran": with_array("leaves", np.asfortranarray),
    "fewer leaves": with_array("leaves", lambda a: a[:-1]),
    "no trees": with_array("trace", lambda a: a[:0]),
    "half a band": with_array("band", lambda _: np.zeros(3)),
    "NaN": put("leaves", (0, 0), np.nan),
    "infinite": put("trace", 0, -np.inf),
    "feature beyond": put("node_feature", (0, 0), 10_000),
    "feature below": put("node_feature", (0, 1), -1),
    "channel beyond": put("features", (0, 0), 10),
    "right of the window": put("features", (0, 3), 25),
    "left of the window": put("features", (0, 1), -2),
    "turned": put("features", (0, 2), 24),
    "half a difference": put("features", (0, 5), 0),
    "stages": put("stage_ends", -1, 5),
    "a stage of none": put("stage_ends", 0, 0),
    "rounds": put("round_ends", 0, 61),
    "powers": put("powers", 0, 9.0),
    "other powers": with_array("powers", lambda a: a[:-1]),
    "version": with_fact("version", 2),
    "format": with_fact("format", "other"),
    "name": with_fact("name", "a\x1b[31m"),
    "no name": with_fact("name", ""),
    "seed": with_fact("seed", True),
    "trained on": with_fact("trained_on", [{"fingerprint": 3}]),
    "trained on what": with_fact("trained_on", [7]),
    "trained on nothing": with_fact("trained_on", [{"fingerprint": "", "recording": ""}]),
    "trained on endless frames": with_fact(
        "trained_on", [{"recording": "drive", "first_frame": 10**20}]
    ),
    "trained on a long name": with_fact("trained_on", [{"recording": 5000 * "a"}]),
    "trained on too much": with_fact("trained_on", [{"recording": "a"}] * 100_001),
    "a window of millions": with_setting("window_width", 10**9),
    "stride": with_setting("stride", 0),
    "a stride of half a pixel": with_setting("stride", 0.5),
    "no scale": with_setting("scales", []),
    "channels": with_setting("channels", ["luv", ["hsv"]]),
    "an unknown setting": with_setting("colour", 1),
    "grey": with_fact("is_colour", False),
    "no JSON": with_text(b"{"),
    "a list": with_text(b"[]"),
    "NaN in JSON": with_text(b'{"format": NaN}'),
    "deep": with_text(b"[" * 100_000),
    "no text": with_text(b"\xff\xfe"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_hostile_model_is_refused_with_its_name(model, case):
    files = members(to_bytes(model))
    CASES[case](files)
    with pytest.raises(DetectorError, match=r"^signs\.npz: .{8}"):
        from_bytes(packed(files), "signs.npz")


def test_the_cases_differ_from_a_model_that_is_accepted(model):
    content = packed(members(to_bytes(model)))
    assert to_bytes(from_bytes(content, "signs.npz")) == to_bytes(model)


def detects_or_is_refused(content: bytes, picture: np.ndarray) -> bool:
    """Whether it is a model, which looks at a picture; else it is refused by its name."""
    message = ""
    try:
        IcfDetector(from_bytes(content, "signs.npz")).detect(picture)
    except DetectorError as error:
        message = str(error)
    assert not message or message.startswith("signs.npz: ")
    return not message


def test_no_changed_member_breaks_the_reader_or_a_run(reading, drawn):
    picture = drawn(100).picture[:48, :64]
    variants = list(with_changed_members(to_bytes(reading)))
    n_models = sum(detects_or_is_refused(content, picture) for content in variants)
    assert 0 < n_models < len(variants) / 2  # a changed confidence is still a model


def test_no_value_of_another_type_breaks_the_reader_or_a_run(reading, drawn):
    part = TrainedOn("ab" * 32, "drive", 0, 399)
    picture = drawn(100).picture[:48, :64]
    variants = dict(with_odd_values(to_bytes(replace(reading, trained_on=(part,)))))
    assert any("/settings/object_width" in change for change in variants)
    n_models = sum(detects_or_is_refused(content, picture) for content in variants.values())
    assert 0 < n_models < len(variants) / 2


def test_more_data_than_a_model_may_have_is_not_unpacked(model):
    files = members(to_bytes(model))
    files["trace.npy"] = bytes(100 << 20)
    with pytest.raises(DetectorError, match="at most 64 MiB"):
        from_bytes(packed(files), "signs.npz")


def test_a_file_that_is_not_there_is_said(tmp_path):
    with pytest.raises(DetectorError, match=r"none\.npz: cannot be opened"):
        read_model(tmp_path / "none.npz")


@pytest.fixture(scope="module")
def reading(model):
    """The model with a classifier of two limits."""
    weights = np.zeros((N_VALUES + 1, 2))
    weights[-1] = 0, 1
    return replace(model, classifier=Classifier(("30", "100"), weights))


def test_a_classifier_is_stored_with_its_model(model, reading, tmp_path, drawn):
    write_model(reading, tmp_path / "signs.npz")
    detector = read_model(tmp_path / "signs.npz")
    assert detector.about.labels == ("30", "100")
    assert detector.about.fingerprint != IcfDetector(model).about.fingerprint
    boxes = detector.detect(drawn(100).picture)
    assert len(boxes)
    assert boxes.label.tolist() == ["100"] * len(boxes)
    assert to_bytes(detector.model) == to_bytes(reading)


def test_a_model_without_one_says_nothing_of_classes(model):
    assert "class_weights.npy" not in members(to_bytes(model))
    again = from_bytes(to_bytes(model), "discs.npz")
    assert again.classifier is None
    assert again.labels == ("disc",)


CLASS_CASES = {
    "no weights": lambda files: files.pop("class_weights.npy"),
    "no names": with_fact("classes", None),
    "a name too few": with_fact("classes", ["30"]),
    "a name twice": with_fact("classes", ["30", "30"]),
    "a number": with_fact("classes", [30, 100]),
    "a text": with_fact("classes", "ab"),
    "no name": with_fact("classes", ["30", ""]),
    "a name for the terminal": with_fact("classes", ["30", "\x1b[31m"]),
    "a row too few": with_array("class_weights", lambda a: a[:-1]),
    "another type": with_array("class_weights", lambda a: a.astype(np.float32)),
    "NaN": put("class_weights", (0, 0), np.nan),
    "beyond all measure": put("class_weights", (0, 0), 1e300),
    "one class": with_array("class_weights", lambda a: a[:, :1].copy()),
    "no class": with_array("class_weights", lambda a: a[:, :0].copy()),
}


@pytest.mark.parametrize("case", CLASS_CASES)
def test_a_hostile_classifier_is_refused(reading, case):
    files = members(to_bytes(reading))
    CLASS_CASES[case](files)
    with pytest.raises(DetectorError, match=r"^signs\.npz: .{8}"):
        from_bytes(packed(files), "signs.npz")

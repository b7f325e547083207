"""Model files: the same again to the byte, and nothing damaged or hostile gets in."""

from __future__ import annotations

import gzip
import io
import json
import pickle
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

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

from nvcore.common.errors import EstimatorError
from nvcore.subjects.driver.estimators import (
    Estimator,
    Origin,
    Quality,
    Training,
    fingerprint,
    read_estimator,
    write_estimator,
)
from nvcore.subjects.driver.estimators.model import SvrSettings
from nvcore.subjects.driver.estimators.model_file import SAMPLE_ESTIMATOR, from_bytes, to_bytes
from nvcore.subjects.driver.estimators.search import fit
from nvcore.subjects.driver.evaluation.estimator_report import render_estimator
from nvcore.subjects.driver.features import FeatureSettings


def test_an_estimator_is_read_as_it_was_written(training: Training, tmp_path: Path):
    path = tmp_path / "driver.npz"
    write_estimator(training.estimator, path)
    again = read_estimator(path)
    assert to_bytes(again) == path.read_bytes() == to_bytes(training.estimator)
    assert fingerprint(again) == fingerprint(training.estimator)
    assert again.origin == training.estimator.origin
    assert again.qualities == training.estimator.qualities
    features = np.random.default_rng(3).uniform(0, 300, (500, 8))
    period_s = np.random.default_rng(4).uniform(0, 9, 500)
    for interpolate in (False, True):
        ours, theirs = (
            model.estimate(features, period_s, interpolate=interpolate)
            for model in (training.estimator, again)
        )
        np.testing.assert_allclose(ours.detectability, theirs.detectability, atol=1e-12)
        np.testing.assert_array_equal(ours.is_outside, theirs.is_outside)


def test_the_settings_of_its_features_are_kept(training: Training):
    assert training.estimator.feature_settings is None
    assert "feature_settings" not in about_of(
        members(to_bytes(training.estimator))
    )  # as in old files
    wide = replace(training.estimator, feature_settings=FeatureSettings(surround=3))
    again = from_bytes(to_bytes(wide), "wide.npz")
    assert again.feature_settings == FeatureSettings(surround=3)
    assert fingerprint(again) == fingerprint(wide) != fingerprint(training.estimator)


def test_a_quick_search_is_kept_and_any_other_leaves_the_file_as_it_was(training: Training):
    quick = training.estimator
    assert quick.origin.search == "quick"  # few settings
    assert from_bytes(to_bytes(quick), "m.npz").origin == quick.origin
    full = replace(quick, origin=replace(quick.origin, search=""))
    assert "search" not in about_of(members(to_bytes(full)))["origin"]
    assert from_bytes(to_bytes(full), "m.npz").origin == full.origin
    assert fingerprint(full) != fingerprint(quick)


def test_the_size_of_its_pictures_is_kept_where_it_is_known(training: Training):
    unknown = training.estimator
    assert "picture_px" not in about_of(members(to_bytes(unknown)))["origin"]  # as in old files
    known = replace(unknown, origin=replace(unknown.origin, picture_px=(960, 540)))
    assert from_bytes(to_bytes(known), "m.npz").origin == known.origin
    assert fingerprint(known) != fingerprint(unknown)


def test_numpy_opens_it_without_pickle(training: Training):
    with np.load(io.BytesIO(to_bytes(training.estimator)), allow_pickle=False) as arrays:
        assert json.loads(arrays["about"].tobytes())["origin"]["simulated"] == "all"
        np.testing.assert_array_equal(arrays["periods_s"], training.estimator.periods_s)


def changed(content: bytes, change: Callable[[dict[str, np.ndarray], dict], None]) -> bytes:
    files = members(content)
    with np.load(io.BytesIO(content), allow_pickle=False) as stored:
        arrays = {name: stored[name].copy() for name in stored}
    about = about_of(files)
    del arrays["about"]
    change(arrays, about)
    new = {f"{name}.npy": npy(np.ascontiguousarray(array)) for name, array in arrays.items()}
    return packed({**with_about(files, about), **new})


def put(name: str, index: object, value: object):
    def change(arrays: dict[str, np.ndarray], _: dict) -> None:
        arrays[name][index] = value

    return change


def shorter(name: str):
    def change(arrays: dict[str, np.ndarray], _: dict) -> None:
        arrays[name] = arrays[name][:-1]

    return change


def told(**facts: object):
    def change(_: dict[str, np.ndarray], about: dict) -> None:
        about.update(facts)

    return change


def of_origin(**facts: object):
    def change(_: dict[str, np.ndarray], about: dict) -> None:
        about["origin"].update(facts)

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (told(format="nvcore-icf"), "is not an estimator that nvcore driver train wrote"),
        (told(version=2), "has version 2; this program reads 1"),
        (told(name=""), "name: expected 1 to 200 printable"),
        (told(name=7), "name: expected a text, found 7"),
        (told(features=["width_px"]), "features: expected those of this program"),
        (told(feature_settings=3), "feature_settings: expected a table, found 3"),
        (
            told(feature_settings={"surround": 2.0}),
            "settings of the features: expected a bin_distance",
        ),
        (
            told(feature_settings={"surround": 99, "bin_distance": 1}),
            "settings of the features: surround: expected 1.1 to 10",
        ),
        (of_origin(seed="x"), "origin: seed: expected a whole number, found 'x'"),
        (of_origin(simulated="perhaps"), "simulated: expected no, all or some"),
        (of_origin(search="slow"), "search: expected quick, or none"),
        (of_origin(picture_px=960), "origin: picture_px: expected two whole numbers, found 960"),
        (of_origin(picture_px=[960, 0]), "picture_px: expected width and height"),
        (of_origin(picture_px=[960, 540, "x"]), "origin: picture_px: expected two whole numbers"),
        (of_origin(search=True), "origin: search: expected a text, found True"),
        (of_origin(n_subjects=-1), "n_subjects: expected 0 to 4294967296, got -1"),
        (of_origin(display_s=float("inf")), ".*numbers must be finite, found Infinity"),
        (of_origin(seed=10**400), "seed: expected 0 to 4294967296, got 1000"),
        (
            told(feature_settings={"surround": 10**400, "bin_distance": 1}),
            "settings of the features: surround: expected a number",
        ),
        (of_origin(more=1), "origin has no key 'more'"),
        (put("periods_s", 0, 9.0), "periods_s: expected ascending"),
        (put("periods_s", 0, -1.0), "periods_s: expected 0 to 3660, found -1"),
        (put("weights", 0, np.nan), "weights has values that are no numbers"),
        (put("scale", slice(None), 0.0), "scale: expected 1e-12"),
        (put("is_used", slice(None), 0), "is_used: expected a feature"),
        (put("is_used", 0, 2), "is_used: expected 0 to 1, found 2"),
        (put("kernel", 0, 2), "kernel: expected 0 or 1"),
        (put("vector_ends", -1, 10**6), "vector_ends: expected ascending"),
        (put("vector_ends", 0, -1), "vector_ends: expected ascending"),
        (put("error", 0, -1.0), "error: expected 0 to 1, found -1"),
        (put("error", 0, 1e308), r"error: expected 0 to 1, found 1e\+308"),
        (put("constant", 0, -5.0), "constant: expected 0 to 1, found -5"),
        (put("constant_error", 0, 2.0), "constant_error: expected 0 to 1, found 2"),
        (put("n_rows", 0, 0), r"n_rows: expected 1 to 1e\+06, found 0"),
        (put("periods_s", -1, 1e308), r"periods_s: expected 0 to 3660, found 1e\+308"),
        (put("low", slice(None), 1e5), "low, centre, high: expected them in this order"),
        (put("high", slice(None), -1e5), "low, centre, high: expected them in this order"),
        (put("centre", slice(None), 1.7e308), r"centre: expected -1e\+06 to 1e\+06"),
        (put("scale", slice(None), 1e-300), r"scale: expected 1e-12 to 1e\+06, found 1e-300"),
        (put("scale", slice(None), 1e308), "scale: expected 1e-12"),
        (put("gamma", 0, 1e308), "gamma: expected 0 to 1000"),
        (put("cost", 0, 1e308), "cost: expected 0 to 1000"),
        (put("cost", 0, -1.0), "cost: expected 0 to 1000, found -1"),
        (put("epsilon", 0, -1.0), "epsilon: expected 0 to 1, found -1"),
        (put("offset", 0, -1e308), r"offset: expected -1e\+06 to 1e\+06"),
        (put("vectors", slice(None), 1e300), "vectors: expected -1000 to 1000"),
        (put("weights", 0, 1e308), "weights: expected no more than the cost"),
        (put("weights", -1, -3.1), "weights: expected no more than the cost"),
        (shorter("periods_s"), "expected a regression for each period"),
        (shorter("cost"), "cost has the shape"),
    ],
)
def test_a_hostile_model_is_refused_with_its_name(training: Training, change, message):
    content = changed(to_bytes(training.estimator), change)
    with pytest.raises(EstimatorError, match=f"^bad.npz: {message}"):
        from_bytes(content, "bad.npz")


def estimates_or_is_refused(content: bytes) -> bool:
    """Whether it is a model, which estimates; else it is refused by its name."""
    try:
        estimator, message = from_bytes(content, "bad.npz"), ""
    except EstimatorError as error:
        estimator, message = None, str(error)
    if estimator is None:
        assert message.startswith("bad.npz: ")
        return False
    render_estimator(estimator)
    estimates = estimator.estimate(np.linspace(0, 300, 80).reshape(10, 8), np.arange(10.0))
    assert np.isfinite(estimates.detectability).all()
    return True


def test_no_changed_member_breaks_the_reader_or_an_estimate(training: Training):
    variants = list(with_changed_members(to_bytes(training.estimator)))
    n_models = sum(map(estimates_or_is_refused, variants))
    assert 0 < n_models < len(variants) / 2


def test_no_value_of_another_type_breaks_the_reader_or_an_estimate(training: Training):
    whole = replace(training.estimator, feature_settings=FeatureSettings(surround=3))
    whole = replace(whole, origin=replace(whole.origin, picture_px=(960, 540)))
    variants = [content for _, content in with_odd_values(to_bytes(whole))]
    n_models = sum(map(estimates_or_is_refused, variants))
    assert 0 < n_models < len(variants) / 2


def extreme(arrays: dict[str, np.ndarray], _: dict) -> None:
    """Every number as far out as it may be."""
    is_used = arrays["is_used"] == 1
    arrays["low"][:], arrays["centre"][:], arrays["high"][:] = -1e6, 1e6, 1e6
    arrays["scale"][is_used] = 1e-12
    arrays["cost"][:] = arrays["gamma"][:] = 1000
    arrays["vectors"][:] = np.where(np.arange(len(arrays["vectors"])) % 2, 1000, -1000)[:, None]
    arrays["weights"][:] = np.where(np.arange(len(arrays["weights"])) % 3, 1000, -1000)
    arrays["offset"][:] = 1e6
    arrays["error"][:] = arrays["constant_error"][:] = 1


@pytest.mark.parametrize("kernel", [0, 1])
def test_what_is_not_refused_can_be_computed(training: Training, kernel: int):
    """Warnings are errors here."""
    content = changed(
        changed(to_bytes(training.estimator), extreme), put("kernel", slice(None), kernel)
    )
    model = from_bytes(content, "extreme.npz")
    features = np.random.default_rng(0).uniform(-1e6, 1e6, (50, 8))
    for interpolate in (False, True):
        estimates = model.estimate(features, 1.0, interpolate=interpolate)
        assert np.isfinite(estimates.detectability).all()
        assert np.isfinite(estimates.sd).all()
    assert model.is_of_no_use
    assert len(render_estimator(model))


def test_a_regression_without_support_vectors_is_read_as_it_was_written(tmp_path: Path):
    """All residuals of its training are below epsilon: it is a constant."""
    features = np.random.default_rng(0).normal(50, 9, (12, 8))
    flat = fit(features, np.full(12, 0.5), (0, 3), SvrSettings("rbf", 1.0, 0.2, 1.0))
    assert len(flat.weights) == 0
    origin = Origin(12, 4, 48, "no", 200.0, 0.5, 0.5, 0, "ab" * 32)
    model = Estimator("flat", np.array([0.5]), (flat, flat), (Quality(12, 0.01, 0.5, 0.1),) * 2,
                      origin)  # fmt: skip
    write_estimator(model, tmp_path / "flat.npz")
    again = read_estimator(tmp_path / "flat.npz")
    assert to_bytes(again) == to_bytes(model)
    np.testing.assert_allclose(again.estimate(features, 0.5).detectability, 0.5, atol=0.2)


@pytest.mark.parametrize(
    "content", [b"", b"PK\x03\x04", pickle.dumps([1]), b"\x00" * (1 << 24) + b"\x00"]
)
def test_what_is_no_model_is_refused(content: bytes):
    with pytest.raises(EstimatorError, match=r"^x\.npz: (is not an estimator|a model has at most)"):
        from_bytes(content, "x.npz")


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("fir.csv", b"frame,x,y,w,h\n0,1,2,3,4\n", "it is text$"),
        (
            "fir.csv.gz",
            gzip.compress(b"frame,x", mtime=0),
            "it is a file packed by gzip: unpack it$",
        ),
        ("a.parquet", b"PAR1\x15\x04", "it is a Parquet table$"),
        ("empty.npz", b"", "it is empty$"),
        ("a.onnx", b"\x08\x08\x12\x04nvco", r"it is a binary file; networks \(\.onnx\) are for n"),
    ],
)
def test_what_a_file_is_that_is_no_model_is_said(name: str, content: bytes, words: str):
    expected = f"^{re.escape(name)}: is not an estimator that nvcore driver train wrote: {words}"
    with pytest.raises(EstimatorError, match=expected):
        from_bytes(content, name)


def test_a_cut_model_is_refused(training: Training):
    content = to_bytes(training.estimator)
    for length in (50, len(content) // 2, len(content) - 1):
        with pytest.raises(EstimatorError, match="damaged"):
            from_bytes(content[:length], "cut.npz")


def test_a_file_that_is_not_there_is_named(tmp_path: Path):
    words = r"gone\.npz: there is no such file; expected an estimator .*, or sample: that of the s"
    with pytest.raises(EstimatorError, match=words):
        read_estimator(tmp_path / "gone.npz")
    with pytest.raises(EstimatorError, match=r"cannot be opened \(File name too long"):
        read_estimator(tmp_path / ("long" * 100))
    with pytest.raises(EstimatorError, match="cannot be opened"):
        read_estimator(tmp_path)


def test_the_samples_estimator_says_that_its_observer_is_simulated():
    estimator = read_estimator(SAMPLE_ESTIMATOR)
    assert (estimator.origin.simulated, estimator.origin.n_pedestrians) == ("all", 51)
    assert estimator.origin.search == ""
    assert estimator.origin.picture_px == (960, 540)
    assert estimator.periods_s.tolist() == [0.5, 1.5, 3.0, 4.5, 6.0, 7.5]
    for quality in estimator.qualities[:-1]:
        assert quality.error < quality.constant_error

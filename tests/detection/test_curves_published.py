"""Detection curves against figures that others published of their own systems."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from published import MEASURED, PUBLISHED

from nvcore.dataset import Dataset
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.metrics.detection.curves import DetectionCurve, detection_curve
from nvcore.metrics.detection.filtered_truth import filter_truth
from nvcore.metrics.detection.miss_rate import ROUNDED_REFERENCES, log_average_miss_rate
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS

pytestmark = pytest.mark.realdata

SUBSETS = {"all": (), "day": ("day",), "night": ("night",)}


def curve_of(dataset: Dataset, system: str, subset: str) -> DetectionCurve:
    protocol = replace(PROTOCOLS["kaist-reasonable"], tags=SUBSETS[subset])
    return detection_curve(dataset, system, Params(), protocol)


def test_the_subsets_have_the_published_numbers_of_images(kaist: Dataset):
    subsets = {
        name: filter_truth(kaist, replace(PROTOCOLS["kaist-reasonable"], tags=tags))
        for name, tags in SUBSETS.items()
    }
    assert {name: subset.n_images for name, subset in subsets.items()} == {
        "all": 2252, "day": 1455, "night": 797,
    }  # fmt: skip
    assert subsets["all"].n_truth == subsets["day"].n_truth + subsets["night"].n_truth


@pytest.mark.parametrize("system", PUBLISHED | MEASURED)
def test_kaist_s_log_average_miss_rates_are_as_published(kaist: Dataset, system: str):
    ours = [100 * log_average_miss_rate(curve_of(kaist, system, name)) for name in SUBSETS]
    assert ours == pytest.approx((PUBLISHED | MEASURED)[system], abs=0.02)


def test_the_published_figures_need_the_exact_references(kaist: Dataset):
    # 46 false positives in 1455 images lie between 0.0316 and 10^-1.5
    curve = curve_of(kaist, "GAFF", "day")
    rounded = 100 * log_average_miss_rate(curve, references=ROUNDED_REFERENCES)
    assert rounded == pytest.approx(8.38, abs=0.005)
    assert 100 * log_average_miss_rate(curve) == pytest.approx(8.35, abs=0.005)


def test_forgetting_the_frames_without_detections_does_not_give_the_published_figures(
    kaist: Dataset,
):
    # what KAIST's Python script does with the 370 images in which GAFF finds nothing
    truth = filter_truth(kaist, PROTOCOLS["kaist-reasonable"])
    is_silent = np.diff(kaist.system("GAFF").offsets) == 0
    n_seen = np.count_nonzero(truth.counts & ~is_silent[truth.truth.frame_index])
    curve = curve_of(kaist, "GAFF", "all")
    assert is_silent.sum() == 370
    assert n_seen < curve.n_truth
    flattered = log_average_miss_rate(replace(curve, n_truth=int(n_seen)))
    assert 100 * flattered == pytest.approx(6.38, abs=0.005)
    assert 100 * log_average_miss_rate(curve) == pytest.approx(PUBLISHED["GAFF"][0], abs=0.005)


def test_every_system_is_measured_on_the_same_truth(kaist: Dataset):
    n_truth = {curve_of(kaist, system, "all").n_truth for system in kaist.systems}
    assert n_truth == {1455}


def pets(realdata: Path) -> Dataset:
    folder = realdata / "mot15"
    truth = Source(("PETS09-S2L1",))
    systems = (SystemSource(("PETS09-S2L1/res_devkit/PETS09-S2L1.txt",), name="tracker"),
               SystemSource(("PETS09-S2L1/det_frcnn/det.txt",), name="detector"))  # fmt: skip
    return load(Session(folder, truth, systems))


def test_mot15_s_recall_and_precision_of_the_tracker_are_as_published(realdata: Path):
    dataset = pets(realdata)
    # the published evaluation deletes the people that are not to be considered
    boxes = dataset.boxes[~dataset.boxes["ignore"]].reset_index(drop=True)
    curve = detection_curve(replace(dataset, boxes=boxes), "tracker", Params())
    point = curve.at(None)
    assert not curve.is_ranked
    assert len(curve) == 1
    assert (point.fp, point.fn) == (368, 367)
    assert (round(100 * point.recall, 1), round(100 * point.precision, 1)) == (91.8, 91.8)


def test_with_ignored_people_as_regions_the_tracker_has_fewer_false_positives(realdata: Path):
    point = detection_curve(pets(realdata), "tracker", Params()).at(None)
    assert point.fn == 367
    assert point.fp == 221  # 147 lie on people who are not to be considered

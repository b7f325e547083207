"""Significance on recordings and detections that other people published."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest

from nvcore.comparison import Result, compare
from nvcore.dataset import Dataset
from nvcore.evidence.measures import significance_table
from nvcore.evidence.pairwise import pairwise_table
from nvcore.evidence.subgroup_table import subgroup_table
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.params import Params

pytestmark = pytest.mark.realdata

KAIST = ("MBNet", "MLPD", "GAFF", "TCDet-thermal", "YOLOv3-visible")


@pytest.fixture(scope="module")
def kaist(realdata: Path) -> Dataset:
    systems = tuple(SystemSource((f"results/{name}_result.txt",), name=name) for name in KAIST)
    truth = Source(("KAIST_annotation.json",))
    return load(Session(realdata / "kaist", truth, systems, fps=20.0))


@pytest.fixture(scope="module")
def pairs(kaist: Dataset) -> pd.DataFrame:
    return pairwise_table(kaist, thresholds=dict.fromkeys(KAIST, 0.5))


@pytest.fixture(scope="module")
def mot15(realdata: Path) -> Result:
    systems = (
        SystemSource(("*/det_frcnn/det.txt",), name="frcnn"),
        SystemSource(("*/res_devkit/*.txt",), name="tracker"),
    )
    dataset = load(Session(realdata / "mot15", Source((".",)), systems))
    return compare(dataset, Params(threshold_x=0.5))


def test_the_five_kaist_systems_make_ten_pairs_of_the_same_pedestrians(pairs: pd.DataFrame):
    assert len(pairs) == 10
    assert (pairs["n_encounters"] == pairs["n_encounters"].iloc[0]).all()
    assert (pairs["n_units"] == 16).all()
    assert (pairs["unit"] == "recordings").all()
    for row in pairs.to_dict("records"):
        split = row["x_only"] + row["y_only"]
        assert row["mcnemar_p"] == pytest.approx(binomtest(row["x_only"], split).pvalue)
        # every second of the drives is annotated: few pedestrians are there twice
        assert "most encounters are one frame long" in row["note"]


def test_a_shared_threshold_tells_kaist_s_systems_apart_but_for_two(pairs: pd.DataFrame):
    found = pairs.set_index(["x", "y"])
    alike = found.loc[("MLPD", "GAFF")]
    assert alike["mcnemar_p_holm"] > 0.5
    assert alike["low"] < 0 < alike["high"]
    rest = found.drop(index=("MLPD", "GAFF"))
    assert (rest["mcnemar_p_holm"] < 0.001).all()
    # whole recordings are fewer than pedestrians: they tell fewer pairs apart
    assert (found["detected_by_unit_p_holm"] < 0.05).sum() < (found["mcnemar_p_holm"] < 0.05).sum()
    assert found.loc[("MLPD", "YOLOv3-visible"), "detected_by_unit_p_holm"] < 0.05


def test_kaist_s_sign_flip_test_is_that_of_all_65536_signs(kaist: Dataset, pairs: pd.DataFrame):
    result = compare(kaist, Params(threshold_x=0.5, threshold_y=0.5), x="GAFF", y="YOLOv3-visible")
    trace = result.x.similarity - result.y.similarity
    sums = np.bincount(result.dataset.frame_columns.recording, weights=trace)
    signs = np.array(list(product((1, -1), repeat=16)))
    reached = np.abs(signs @ sums) >= abs(sums.sum()) - 1e-9
    row = pairs.set_index(["x", "y"]).loc[("GAFF", "YOLOv3-visible")]
    assert len(signs) == 65536
    assert row["similarity_p"] == pytest.approx(reached.mean())
    assert row["similarity_difference"] == pytest.approx(trace.mean())


def test_kaist_s_occluded_pedestrians_are_where_gaff_is_ahead_of_mlpd(kaist: Dataset):
    result = compare(kaist, Params(), x="GAFF", y="MLPD")
    # encounters of KAIST are mostly single frames: judged by recordings
    table = subgroup_table(result, ["encounters_detected_by_unit"])
    table = table.set_index(["factor", "group"])
    visible, occluded = (table.loc[("occlusion", group)] for group in ("visible", "occluded"))
    assert occluded["difference"] > visible["difference"] > 0
    assert occluded["low"] > visible["difference"]
    assert occluded["p_holm"] < 0.05


def test_mot15_has_too_few_recordings_and_is_judged_by_blocks(mot15: Result):
    table = significance_table(mot15).set_index("figure")
    by_unit = table.drop(index="encounters_detected")
    assert (by_unit["unit"] == "blocks").all()
    assert by_unit["note"].str.contains("4 recordings are too few to resample").all()
    saliency = table.loc["saliency"]
    assert saliency[["low", "high", "p"]].isna().all()
    assert saliency[["x", "y"]].notna().all()
    rest = by_unit.drop(index="saliency")
    assert rest[["low", "high"]].notna().all().all()
    for row in rest.to_dict("records"):
        assert np.isnan(row["p"]) == ("too few tell X and Y apart" in row["note"])


def test_mot15_s_detector_finds_more_people_than_the_tracker_and_alarms_more(mot15: Result):
    table = significance_table(mot15).set_index("figure")
    found = table.loc["encounters_detected"]
    assert found["n"] == mot15.venn.n_near
    assert found["low"] > 0
    assert found["p_holm"] < 0.001
    alarms = table.loc["false_alert_episodes_per_hour"]
    assert alarms["low"] > 0
    assert alarms["p_holm"] < 0.05

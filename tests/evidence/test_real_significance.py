"""Significance on recordings and detections that other people published."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from places import ROOT
from scipy.stats import binomtest

from nvcore.comparison import Result, compare
from nvcore.dataset import Dataset
from nvcore.evidence.measures import significance_table
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.pairwise import pairwise_table
from nvcore.evidence.units import find_units
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.params import Params
from nvcore.protocols import PROTOCOLS

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


ROW = re.compile(
    r"^\| ([\w-]+) \| ([\w-]+) \| ([+-][\d.]+) \| ([+-][\d.]+) to ([+-][\d.]+) \| (\S+) \|"
)


@pytest.mark.parametrize("pair", [("MBNet", "GAFF"), ("TCDet-thermal", "YOLOv3-visible")])
def test_docs_validation_shows_the_pairs_of_kaist_as_they_are(
    kaist: Dataset, pair: tuple[str, str]
):
    result = compare(kaist, Params(), x=pair[0], y=pair[1])
    found = judge_miss_rate(result, find_units(result), PROTOCOLS["kaist-reasonable"])
    lines = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8").splitlines()
    shown = next(row for row in map(ROW.match, lines) if row and (row[1], row[2]) == pair)
    assert [float(shown[i]) for i in (3, 4, 5)] == pytest.approx(
        [100 * found.difference, 100 * found.low, 100 * found.high], abs=0.006
    )
    assert float(shown[6]) == pytest.approx(found.p, rel=0.05)

"""Significance on recordings and detections that other people published."""

from __future__ import annotations

import re

import pytest
from places import ROOT

from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.pairwise import pairwise_table
from nvcore.evidence.units import find_units
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS

pytestmark = pytest.mark.realdata


def test_a_shared_threshold_tells_kaist_s_systems_apart_but_for_two(kaist: Dataset):
    pairs = pairwise_table(kaist, thresholds=dict.fromkeys(kaist.systems, 0.5))
    assert len(pairs) == 10
    assert (pairs["n_units"] == 16).all()
    for row in pairs.to_dict("records"):
        # every second of the drives is annotated: few pedestrians are there twice
        assert "most encounters are one frame long" in row["mcnemar_note"]
    assert pairs["mcnemar_p"].isna().all()
    by_pair = pairs.set_index(["x", "y"])
    alike = by_pair.loc[("MLPD", "GAFF")]
    assert alike["detected_by_unit_p_holm"] > 0.5
    assert alike["detected_by_unit_low"] < 0 < alike["detected_by_unit_high"]
    assert by_pair.loc[("MLPD", "YOLOv3-visible"), "detected_by_unit_p_holm"] < 0.05


ROW = re.compile(
    r"^\| ([\w-]+) \| ([\w-]+) \| ([+-][\d.]+) \| ([+-][\d.]+) to ([+-][\d.]+) \| (\S+) \|"
)


@pytest.mark.parametrize("pair", [("MBNet", "GAFF"), ("TCDet-thermal", "YOLOv3-visible")])
def test_docs_validation_shows_the_pairs_of_kaist_as_they_are(
    kaist: Dataset, pair: tuple[str, str]
):
    result = compare(kaist, Params(), x=pair[0], y=pair[1])
    evidence = judge_miss_rate(result, find_units(result), PROTOCOLS["kaist-reasonable"]).evidence
    lines = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8").splitlines()
    shown = next(row for row in map(ROW.match, lines) if row and (row[1], row[2]) == pair)
    assert [float(shown[i]) for i in (3, 4, 5)] == pytest.approx(
        [100 * evidence.difference, 100 * evidence.low, 100 * evidence.high], abs=0.006
    )
    assert float(shown[6]) == pytest.approx(evidence.p, rel=0.05)

"""Figures of an independent implementation (see README there) on real recordings, to 1e-6."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from nvcore.comparison.compare import Result, compare
from nvcore.comparison.scoring import SystemResult
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.settings.params import params_from
from nvcore.subjects.time_left.steps import time_left_in, time_left_of
from nvcore.tables.result import encounters_table

pytestmark = pytest.mark.realdata

SETS = [
    (name, kind)
    for name in ("TUD-Campus", "TUD-Stadtmitte", "PETS09-S2L1")
    for kind in ("default", "rural")
]


def compare_golden(name: str, settings: dict[str, Any], realdata: Path) -> Result:
    """The comparison of a reference set with its parameters."""
    settings = dict(settings)
    settings["saliency_aggregate"] = settings.pop("aggregate")
    thresholds = settings.pop("threshold_x"), settings.pop("threshold_y")
    files = f"{name}/det_frcnn/det.txt", f"{name}/res_devkit/{name}.txt"
    session = Session(
        folder=realdata / "mot15",
        truth=Source((f"{name}/gt/gt.txt",)),
        systems=tuple(
            SystemSource((file,), threshold=threshold)
            for file, threshold in zip(files, thresholds, strict=True)
        ),
        params=params_from({k: v for k, v in settings.items() if v is not None}),
    )
    return compare(load(session))


class Case:
    """One reference set: its summary, its traces and our result."""

    def __init__(self, name: str, folder: Path, realdata: Path):
        self.summary: dict[str, Any] = json.loads((folder / "summary.json").read_text())
        self.frames = pd.read_csv(folder / "frames.csv")
        self.result: Result = compare_golden(name, self.summary["parameters"], realdata)

    def systems(self) -> list[tuple[str, SystemResult]]:
        return [("x", self.result.x), ("y", self.result.y)]

    def tracks(self, system: SystemResult) -> np.ndarray:
        rows = system.salient_row
        return np.where(rows >= 0, self.result.tracks.track[rows], -1)


@pytest.fixture(scope="module", params=SETS, ids="/".join)
def case(request: pytest.FixtureRequest, golden: Path, realdata: Path) -> Case:
    name, kind = request.param
    return Case(name, golden / name / kind, realdata)


def test_every_frame_agrees(case: Case) -> None:
    frames = case.result.dataset.frames
    ours = {"frame": frames["frame"], "time_s": frames["time_s"], "n_truth": case.result.n_truth}
    for letter, system in case.systems():
        tracks = case.tracks(system)
        measures = {
            "d_miss": system.distances.d_miss, "d_false": system.distances.d_false,
            "similarity": system.similarity, "n_det": system.n_det, "matched": system.matched,
            "false_alarms": system.false_alarms,
            "salient_track": np.where(tracks >= 0, tracks, np.nan),
        }  # fmt: skip
        ours |= {f"{name}_{letter}": values for name, values in measures.items()}
    for name, values in ours.items():
        theirs = case.frames[name].to_numpy(dtype=float)
        assert np.asarray(values) == pytest.approx(theirs, abs=1e-6, nan_ok=True), name


def test_the_saliency_events_agree(case: Case) -> None:
    frame = case.result.dataset.frames["frame"].to_numpy()
    for letter, system in case.systems():
        expected = pd.DataFrame(case.summary[letter]["events"])
        events = system.events
        assert events["track"].tolist() == expected["track"].tolist()
        assert frame[events["first_row"]].tolist() == expected["first"].tolist()
        assert frame[events["last_row"]].tolist() == expected["last"].tolist()
        for ours, theirs in (("duration_s", "duration_s"), ("recency", "recency"),
                             ("saliency_s", "saliency")):  # fmt: skip
            assert events[ours].to_numpy() == pytest.approx(expected[theirs].to_numpy(), abs=1e-6)
        assert system.saliency_s == pytest.approx(case.summary[letter]["saliency"], abs=1e-6)


def test_the_encounters_agree(case: Case) -> None:
    encounters = case.result.encounters
    frame = case.result.dataset.frames["frame"].to_numpy()
    for letter, system in case.systems():
        expected = pd.DataFrame(case.summary[letter]["encounters"])
        judged = system.encounters
        assert encounters.track.tolist() == expected["track"].tolist()
        assert frame[encounters.first_row].tolist() == expected["first"].tolist()
        assert frame[encounters.last_row].tolist() == expected["last"].tolist()
        pairs = {"n_relevant": "relevant", "matched": "matched", "is_detected": "detected"}
        for ours, theirs in {**pairs, "miss_class": "miss_class"}.items():
            assert judged[ours].tolist() == expected[theirs].tolist()
        assert (judged["n_relevant"] == 0).tolist() == expected["distant"].tolist()
        for name in ("coverage", "lag_s", "gap_s", "tail_s"):
            theirs = expected[name].to_numpy(dtype=float)
            assert judged[name].to_numpy() == pytest.approx(theirs, abs=1e-6, nan_ok=True)


def test_the_venn_counts_agree(case: Case) -> None:
    assert case.result.venn.counts() == case.summary["venn"]


def test_the_mean_and_the_minimum_of_similarity_agree(case: Case) -> None:
    for letter, system in case.systems():
        expected = case.summary[letter]
        assert system.summary.mean == pytest.approx(expected["mean_similarity"], abs=1e-6)
        assert system.summary.minimum == pytest.approx(expected["min_similarity"], abs=1e-6)


WEIGHED = [
    (name, kind)
    for name in ("TUD-Campus", "TUD-Stadtmitte", "PETS09-S2L1", "ETH-Sunnyday")
    for kind in ("default", "rural", "strict")
]


@pytest.mark.parametrize(("name", "kind"), WEIGHED)
def test_the_weights_agree(name: str, kind: str, golden: Path, realdata: Path) -> None:
    expected = json.loads((golden / name / kind / "weights.json").read_text())
    result = compare_golden(name, expected["parameters"], realdata)
    assert result.venn.counts() == expected["venn"]
    for letter, system in result.sides:
        theirs = expected[letter]
        assert system.summary.mean == pytest.approx(theirs["mean_similarity"], abs=1e-6)
        assert system.saliency_s == pytest.approx(theirs["saliency"], abs=1e-6)
        assert system.lost_s_per_min == pytest.approx(theirs["lost_s_per_min"], abs=1e-6)
        assert system.failures["severity_s"].sum() == pytest.approx(theirs["severity_s"], abs=1e-6)
        encounters = pd.DataFrame(theirs["encounters"])
        assert result.encounters.track.tolist() == encounters["track"].tolist()
        for measure in ("severity_s", "peak_cost"):
            values = system.failures[measure].to_numpy()
            assert values == pytest.approx(encounters[measure].to_numpy(), abs=1e-6)


@pytest.mark.parametrize(("name", "kind"), WEIGHED)
def test_the_time_left_agrees(name: str, kind: str, golden: Path, realdata: Path) -> None:
    expected = json.loads((golden / name / kind / "weights.json").read_text())
    result = compare_golden(name, expected["parameters"], realdata)
    columns = ["urgent_frame", "confirmed_frame", "margin_s", "impact_kmh", "min_ttc_s"]
    urgency, ours = time_left_in(result).urgency, encounters_table(result)
    for letter, system in result.sides:
        theirs = pd.DataFrame(expected[letter]["encounters"])
        judged = time_left_of(system)["time_left"].where(
            time_left_in(result).is_urgent, urgency["urgency"]
        )
        assert judged.tolist() == theirs["time_left"].tolist()
        for column in columns:
            values = ours.get(f"{column}_{letter}", ours.get(column)).to_numpy(float)
            expected_values = theirs.get(column, pd.Series(np.nan, theirs.index)).to_numpy(float)
            rows = slice(None) if column == "min_ttc_s" else time_left_in(result).is_urgent
            assert values[rows] == pytest.approx(expected_values[rows], abs=1e-6, nan_ok=True)

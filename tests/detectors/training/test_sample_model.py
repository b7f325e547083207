"""The model that ships: as its script says, small, and known to the audit."""

from __future__ import annotations

from pathlib import Path

import pytest
from inputs import nvcore
from places import SAMPLE

import nvcore as nv
from nvcore.subjects.detectors.icf import PEDESTRIANS, read_model
from nvcore.subjects.detectors.registry import SAMPLE_MODEL, open_detector
from nvcore.subjects.detectors.training.overlap import trained_part
from nvcore.subjects.detectors.training.run import preset_settings
from scripts.detectors.train_sample import SEED, SETTINGS, TESTED, TRAINED

FRAMES = range(40, 300, 40)


@pytest.fixture(scope="module")
def dataset() -> nv.Dataset:
    return nv.load(SAMPLE)


def test_it_was_trained_as_the_script_says(dataset: nv.Dataset):
    model = read_model(SAMPLE_MODEL).model
    assert model.settings == preset_settings("pedestrians", SETTINGS) != PEDESTRIANS
    assert (model.seed, model.label, model.is_colour) == (SEED, "pedestrian", False)
    parts = [trained_part(dataset, name) for name in TRAINED]
    assert sorted(model.trained_on, key=str) == sorted(parts, key=str)
    assert {*TRAINED, *TESTED} == {*dataset.recordings["name"]}
    assert SAMPLE_MODEL.stat().st_size < 1_000_000


def test_it_runs_by_its_name_with_other_settings():
    detector = open_detector("icf:sample", {"stride": "8"})
    assert (detector.about.kind, detector.about.settings["stride"]) == ("icf", 8)


def test_the_list_says_that_it_knows_drawings():
    assert "icf:sample     trained on seven sample recordings: drawings" in nvcore("models").stdout


def test_it_detects_where_it_was_not_trained_and_is_not_believed_elsewhere(tmp_path: Path):
    part = nv.load(SAMPLE, frames=FRAMES)
    written = nv.detect(part, "icf:sample", tmp_path / "out", only=["urban_sidewalk", "rural_road"])
    result = nv.compare(written.session)
    truth = result.dataset.truth
    near = (truth.h >= 30) & ~truth.ignore
    assert (result.y.matches.truth_det[near] >= 0).mean() > 0.8
    findings = {finding.code: finding for finding in nv.audit(result.dataset)}
    assert findings["trained-on-tested"].count == len(FRAMES)
    assert "rural_road." in findings["trained-on-tested"].message

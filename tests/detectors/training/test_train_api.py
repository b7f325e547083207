"""``nv.train``: a model of the sample that is repeatable, finds people, and notes its training."""

from __future__ import annotations

from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import pytest
from builders import at, make_dataset
from places import SAMPLE

import nvcore as nv
from nvcore.subjects.detectors.icf import read_model

TRAINED = ("urban_crossing", "winter_frost")
SMALL = {"trees_per_round": (4,), "features": 80}


@pytest.fixture(scope="module")
def dataset() -> nv.Dataset:
    return nv.load(SAMPLE)


def trained(dataset: nv.Dataset, out: Path, settings: dict[str, Any], **options: Any) -> Any:
    options = {"only": TRAINED, "every": 10, "seed": 1, **options}
    return nv.train(dataset, out, settings=settings, **options)


def test_it_finds_people_in_recordings_that_it_has_not_seen(
    dataset: nv.Dataset, quick: dict[str, Any], tmp_path: Path
):
    training = trained(dataset, tmp_path / "night.npz", quick)
    assert (training.model.name, training.model.label) == ("night", "pedestrian")
    assert not training.model.is_colour
    assert training.n_kept == training.n_held_out > 0
    assert training.n_found <= training.n_kept
    part = nv.load(SAMPLE, frames=range(0, 300, 30))
    options = {"only": ["urban_sidewalk"], "name": "ICF"}
    written = nv.detect(part, tmp_path / "night.npz", tmp_path / "out", **options)
    result = nv.compare(written.session)
    assert result.y.name == "ICF"
    assert (result.y.matches.truth_det >= 0).sum() >= 4
    codes = {finding.code for finding in nv.audit(result.dataset)}
    assert not {code for code in codes if code.startswith("trained")}


def test_the_same_seed_gives_the_same_file(
    dataset: nv.Dataset, quick: dict[str, Any], tmp_path: Path
):
    quick |= SMALL
    files = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        trained(dataset, tmp_path / name, quick, seed=seed, name="same", frames=":99")
        files.append((tmp_path / name).read_bytes())
    assert files[0] == files[1] != files[2]


def test_the_audit_finds_what_it_was_trained_on(
    dataset: nv.Dataset, quick: dict[str, Any], tmp_path: Path
):
    quick |= SMALL
    trained(dataset, tmp_path / "m.npz", quick, hold_out=["winter_frost"], frames=":99")
    only = [*TRAINED, "odd_pose"]
    part = nv.load(SAMPLE, frames=range(0, 200, 20))
    written = nv.detect(part, tmp_path / "m.npz", tmp_path / "out", only=only)
    findings = {finding.code: finding for finding in nv.audit(nv.load(written.session))}
    assert findings["trained-on-tested"].count == 10
    assert "urban_crossing, winter_frost" in findings["trained-on-tested"].message
    assert findings["trained-beside-tested"].count == 10


def test_a_cancelled_training_leaves_nothing(
    dataset: nv.Dataset, quick: dict[str, Any], tmp_path: Path
):
    def cancel(share: float, words: str) -> None:
        if "boosting" in words:
            assert "left" in words
            raise CancelledError

    with pytest.raises(CancelledError):
        trained(
            dataset, tmp_path / "models" / "m.npz", quick | SMALL, progress=cancel, frames=":99"
        )
    assert not (tmp_path / "models").exists()


def test_what_was_there_stays_until_the_model_is_whole(
    dataset: nv.Dataset, quick: dict[str, Any], tmp_path: Path
):
    def cancel(share: float, _words: str) -> None:
        if share > 0.5:
            raise CancelledError

    out = tmp_path / "m.npz"
    out.write_text("an earlier model")
    quick |= SMALL
    with pytest.raises(CancelledError):
        trained(dataset, out, quick, progress=cancel, frames=":99")
    assert out.read_text() == "an earlier model"
    trained(dataset, out, quick, frames=":99")
    assert read_model(out).about.name == "m"
    assert [path.name for path in tmp_path.iterdir()] == ["m.npz"]


def test_bad_targets_are_refused_before(dataset: nv.Dataset, tmp_path: Path):
    with pytest.raises(nv.NvcoreError, match="is a folder; give the name of a file"):
        nv.train(dataset, tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(nv.NvcoreError, match="cannot be written to; give another file"):
        nv.train(dataset, tmp_path / "file" / "m.npz")
    with pytest.raises(nv.NvcoreError, match="is an input, and would be replaced"):
        nv.train(dataset, SAMPLE.with_name("truth.csv"))
    with pytest.raises(nv.NvcoreError, match="is an input, and would be replaced"):
        nv.train(SAMPLE, SAMPLE)
    with pytest.raises(nv.NvcoreError, match="name: expected 1 to 200 printable characters"):
        nv.train(dataset, tmp_path / "m.npz", name="a\nb")
    with pytest.raises(nv.NvcoreError, match="expected a session, or a dataset that was loaded"):
        nv.train(make_dataset([at(0, 50)]), tmp_path / "m.npz")


def test_too_little_memory_is_said_before(
    dataset: nv.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("nvcore.subjects.detectors.training.run.free_bytes", lambda: 10**8)
    with pytest.raises(nv.NvcoreError, match=r"GB of memory; 0\.1 GB are free. Take fewer"):
        nv.train(dataset, tmp_path / "m.npz", only=TRAINED)

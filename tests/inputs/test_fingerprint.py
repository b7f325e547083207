"""What a dataset's fingerprint depends on, and inputs that change."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from builders import make_dataset
from inputs import drive, session_of, write

from nvcore.dataset.tables import dataset_from_tables, tables_fingerprint
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session, SystemSource
from nvcore.settings.params import Params


def fingerprint(session: Session) -> str:
    return load(session).fingerprint


def test_the_fingerprint_does_not_depend_on_where_the_files_lie(tmp_path: Path):
    places = (tmp_path / "a", tmp_path / "elsewhere" / "b")
    first, second = (fingerprint(session_of(drive(place))) for place in places)
    assert first == second


def test_the_fingerprint_changes_with_one_byte_of_the_input(tmp_path: Path):
    before = fingerprint(session_of(drive(tmp_path)))
    text = (tmp_path / "nir.csv").read_text()
    write(tmp_path / "nir.csv", text.rstrip()[:-1] + "6")
    assert fingerprint(session_of(tmp_path)) != before


def test_the_fingerprint_changes_with_every_setting_of_the_reading(tmp_path: Path):
    session = session_of(drive(tmp_path))
    x, y = session.systems
    changes: list[dict[str, object]] = [
        {},
        {"size": (641, 480)},
        {"fps": 21.0},
        {"frames": "0:18"},
        {"truth": replace(session.truth, classes=("person",))},
        {"systems": (replace(x, offset_frames=1), y)},
        {"systems": (replace(x, scale=(1, 2)), y)},
        {"recordings": (RecordingEntry("urban", horizon=200.0),)},
        {"recordings": (RecordingEntry("urban", tags=("night",)),)},
        {"recordings": (RecordingEntry("urban", context=0.0),)},
        {"recordings": (RecordingEntry("urban", speed_kmh=50.0),)},
    ]
    assert len({fingerprint(replace(session, **change)) for change in changes}) == len(changes)


def test_the_fingerprint_does_not_change_with_live_parameters_and_without_tags(tmp_path: Path):
    session = session_of(drive(tmp_path))
    changed = replace(
        session,
        params=Params(alpha=0.5),
        systems=(SystemSource(("fir.csv",), threshold=0.7), session.systems[1]),
        recordings=(RecordingEntry("urban", tags=()),),
    )
    assert fingerprint(changed) == fingerprint(session)


def test_tables_without_tags_context_and_speed_have_none_and_keep_their_fingerprint():
    dataset = make_dataset(n_frames=2)
    assert dataset.recordings["tags"].tolist() == [()]
    assert dataset.recordings["context"].isna().all()
    frames = [dataset.frames["frame"].to_numpy()]
    again = dataset_from_tables(dataset.recordings, frames, dataset.boxes, dataset.systems)
    assert again.fingerprint == dataset.fingerprint
    # as there were no such columns
    before = dataset.recordings.drop(columns=["tags", "context", "speed_kmh"])
    tables = [before, dataset.frames.drop(columns="speed_kmh"), dataset.boxes]
    assert tables_fingerprint(tables, dataset.systems) == dataset.fingerprint


def test_a_changed_input_is_a_finding(tmp_path: Path):
    session = replace(session_of(drive(tmp_path)), hashes={"truth": "0" * 64, "gone": "1"})
    findings = load(session).findings
    assert [(finding.code, finding.subject, finding.file[-9:]) for finding in findings] == [
        ("input-changed", "truth", "truth.csv")
    ]

"""Write features and estimates of a run."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

from nvcore import __version__
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import write_run
from nvcore.dataset import Dataset
from nvcore.inputs.files.hashes import source_hashes
from nvcore.inputs.session import Session
from nvcore.inputs.session.changes import stated
from nvcore.inputs.session.toml import write_session
from nvcore.subjects.driver.features.feature_record import RECORD_FILE, record_bytes
from nvcore.subjects.driver.inputs.session import DETECTABILITY, DriverTable
from nvcore.subjects.driver.running.estimate import EstimateRun
from nvcore.subjects.driver.running.run import FeatureRun

FEATURES_FILE: Final = "features.csv"
DETECTABILITY_FILE: Final = "detectability.csv"
SESSION_FILE: Final = "session.toml"
FEATURE_OUTPUTS: Final[tuple[str, ...]] = (FEATURES_FILE, RECORD_FILE)
ESTIMATE_OUTPUTS: Final = (DETECTABILITY_FILE, FEATURES_FILE, RECORD_FILE, SESSION_FILE)


@dataclass(frozen=True)
class WrittenFeatures:
    """Files written by `write_features`: the table, and its record."""

    features: Path
    record: Path
    run: FeatureRun


@dataclass(frozen=True)
class WrittenEstimates:
    """Files written by `write_estimates`: a session with the estimates, and their sources."""

    session: Path
    detectability: Path
    features: Path
    record: Path
    run: EstimateRun


def write_features(run: FeatureRun, folder: Path) -> WrittenFeatures:
    """Write the features and their record.

    Raises
    ------
    InputError
        If the folder is not writable.
    """
    content = to_csv_bytes(run.table)
    record = _record(run, {FEATURES_FILE: content})
    write_run(folder, [(FEATURES_FILE, content), (RECORD_FILE, record)], FEATURE_OUTPUTS)
    return WrittenFeatures(folder / FEATURES_FILE, folder / RECORD_FILE, run)


def write_estimates(run: EstimateRun, dataset: Dataset, folder: Path) -> WrittenEstimates:
    """Write the estimates with their features and record, and a session that names them.

    Parameters
    ----------
    dataset
        Dataset of the run, with a `Session` as its settings.

    Raises
    ------
    InputError
        If the folder is not writable, or no pedestrian has an estimate.
    """
    run.refuse_empty()
    session = dataset.settings
    assert isinstance(session, Session)
    contents = {
        DETECTABILITY_FILE: to_csv_bytes(run.table),
        FEATURES_FILE: to_csv_bytes(run.features.table),
    }
    detectability, features, record, path = (folder / name for name in ESTIMATE_OUTPUTS)
    named = replace(
        stated(session, dataset),
        hashes={of: digest for of, digest in source_hashes(dataset).items() if of != DETECTABILITY},
        driver=DriverTable(  # type: ignore[call-arg]
            detectability=str(detectability.absolute()), provenance=str(record.absolute())
        ),
    )
    text = write_session(named, version=__version__, fingerprint=dataset.fingerprint)
    made = _record(run.features, contents, estimator=run.as_json(), estimates=run.counts_json())
    files = [*contents.items(), (RECORD_FILE, made), (SESSION_FILE, text.encode())]
    write_run(folder, files, ESTIMATE_OUTPUTS)
    return WrittenEstimates(path, detectability, features, record, run)


def _record(run: FeatureRun, contents: dict[str, bytes], **more: Any) -> bytes:
    return record_bytes(
        contents,
        **more,
        settings=asdict(run.settings),
        recordings=[
            {
                "name": recording.name,
                "n_boxes": len(recording.table),
                "n_unseen": recording.n_unseen,
                "picture_px": recording.picture_px,
                "notes": list(recording.notes),
            }
            for recording in run.recordings
        ],
    )

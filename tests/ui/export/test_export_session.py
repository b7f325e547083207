"""Sessions that leave the machine: they work beside their inputs and tell nothing of it."""

from __future__ import annotations

import shutil
import zipfile
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import pandas as pd
import pytest
from inputs import drive, mot_layout, nvcore, session_of, write
from places import DATA
from sent_files import Sent

from nvcore.auditing import audit
from nvcore.common.findings import Finding, Severity
from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource
from nvcore.inputs.session.changes import live_session
from nvcore.inputs.session.toml import read_session
from nvcore.report.files import export_files, report_zip
from ui.session.opening import public_text, uploaded_session
from ui.session.uploads import new_upload, store_annotations
from ui.session.workspace import Workspace
from ui.views.export.session import (
    inputs_beside,
    portable_session,
    public_findings,
    with_public_names,
)

TABLES = ("frames", "encounters", "events", "intervals", "recordings")


def uploaded(space: Workspace, **files: Path) -> Session:
    """A session of uploads: truth and one file for each further name."""
    folder = new_upload(space)
    paths = {
        slot: store_annotations(space, folder, slot, [Sent(path.name, path.read_bytes())])
        for slot, path in files.items()
    }
    truth = Source(paths.pop("truth"))
    return Session(folder, truth, tuple(map(SystemSource, paths.values())), size=(640, 480), fps=20)


def sent_drive(space: Workspace, folder: Path) -> Session:
    drive(folder)
    return uploaded(space, truth=folder / "truth.csv", x=folder / "fir.csv", y=folder / "nir.csv")


def analysed(session: Session) -> tuple[Dataset, Result]:
    dataset = load(session)
    return dataset, compare(dataset, replace(dataset.params_of(), alpha=0.6))


def to_write(session: Session, dataset: Dataset, result: Result) -> Session:
    live = live_session(session, dataset, result.params, x=result.x.name, y=result.y.name)
    return portable_session(live, is_upload=True, recordings=dataset.recordings["name"])


def packed_again(space: Workspace, session: Session, beside: Path) -> tuple[bytes, Path]:
    """The zip of a session of uploads, and the folder in which it was unpacked."""
    dataset, result = analysed(session)

    def public(text: object) -> str:
        return public_text(text, [session.folder, space.folder])

    audited = audit(dataset, result.params, x=result.x.name, y=result.y.name)
    named = with_public_names(result, public)
    session_text = to_write(session, dataset, result)
    content = report_zip(named, session_text, public_findings(audited, public))
    with zipfile.ZipFile(BytesIO(content)) as archive:
        archive.extractall(beside)
    return content, beside


def test_the_unpacked_zip_beside_its_inputs_makes_the_same_report(space, tmp_path: Path):
    session = sent_drive(space, tmp_path / "mine")
    fingerprint = load(session).fingerprint
    _, folder = packed_again(space, session, tmp_path / "mine")
    done = nvcore("compare", folder / "session.toml", "--out", tmp_path / "again")
    assert done.exit_code == 0, done.output
    for name in (*(f"{table}.csv" for table in TABLES), "summary.json"):
        assert (tmp_path / "again" / name).read_bytes() == (folder / name).read_bytes(), name
    # the command line tells the folders of a file as well
    again = pd.read_csv(tmp_path / "again" / "findings.csv", dtype=str)
    again["file"] = again["file"].str.rpartition("/")[2]
    assert again.equals(pd.read_csv(folder / "findings.csv", dtype=str))
    # and opens as an upload
    again = new_upload(space)
    files = [
        Sent(name, (folder / name).read_bytes()) for name in ("truth.csv", "fir.csv", "nir.csv")
    ]
    paths = store_annotations(space, again, "files", files)
    content = (folder / "session.toml").read_bytes()
    opened = uploaded_session(content, again, paths, space.sent)
    assert (load(opened).fingerprint, load(opened).findings) == (fingerprint, ())


def test_no_path_of_the_machine_is_in_any_exported_byte(space, tmp_path: Path):
    session = sent_drive(space, tmp_path / "mine")
    bad = write(session.folder / "truth" / "annotations" / "data" / "truth.csv",
                "recording,frame,x,y,w,h,track", "urban,1,100,200,40,100,1",
                "urban,1,300,200,40,100,1")  # fmt: skip
    content, folder = packed_again(space, session, tmp_path / "out")
    assert bad.name in (folder / "findings.csv").read_text()
    parts = {part for part in session.folder.parts[1:] if len(part) > 3} | {"annotations"}
    for path in folder.iterdir():
        written = path.read_text(encoding="utf-8")
        assert [part for part in parts if part in written] == [], path.name
    assert str(tmp_path).encode() not in content


def test_the_sample_is_written_with_bare_names():
    root = DATA.parents[1]
    session = read_session(root / "sample_data" / "session.toml")
    dataset, result = analysed(session)
    live = live_session(session, dataset, result.params, x="FIR", y="NIR")
    written = export_files(result, portable_session(live, is_upload=False))["session.toml"]()
    assert b'path = "truth.csv"' in written
    assert b'pictures = "urban_crossing.mp4"' in written
    assert str(root).encode() not in written
    assert b"sample_data" not in written


def test_folders_of_the_owner_are_kept_where_the_inputs_lie_in_them(tmp_path: Path):
    session = Session(
        tmp_path / "night", Source((str(tmp_path / "night" / "a" / "truth.csv"),)),
        (SystemSource(("../runs/fir.csv",)),),
    )  # fmt: skip
    portable = portable_session(session, is_upload=False)
    assert inputs_beside(portable) == ["a/truth.csv", "../runs/fir.csv"]


def upload(truth: str, system: str, **facts: str) -> Session:
    recordings = (RecordingEntry("one", **facts),) if facts else ()
    return Session(
        Path("/srv/x/upload-1"), Source((truth,)), (SystemSource((system,)),), recordings
    )


@pytest.mark.parametrize(
    ("files", "names"),
    [
        # of one name: folders of their own, or those of the archive
        (
            ("truth/annotations/data/boxes.csv", "system-1/annotations/data/boxes.csv"),
            ["data/truth/boxes.csv", "data/system-1/boxes.csv"],
        ),
        (
            ("files/annotations/data/all/a/boxes.csv", "files/annotations/data/all/b/boxes.csv"),
            ["all/a/boxes.csv", "all/b/boxes.csv"],
        ),
    ],
)
def test_uploads_of_one_name_keep_apart(files: tuple[str, str], names: list[str]):
    assert inputs_beside(portable_session(upload(*files), is_upload=True)) == names


def test_uploaded_pictures_and_frame_lists_are_written_by_their_names():
    files = "truth/annotations/data/t.csv", "system-1/annotations/data/x.csv"
    frames = "files/annotations/data/frames.txt"
    session = upload(*files, pictures="../pictures/night.mp4", frames=frames)
    portable = portable_session(replace(session, frames="0:9"), is_upload=True)
    assert portable.recordings == (
        RecordingEntry("one", pictures="night.mp4", frames="frames.txt"),
    )
    assert portable.frames == "0:9"  # a range stays a range
    assert inputs_beside(portable) == ["t.csv", "x.csv", "frames.txt"]  # pictures are not needed


def test_a_truth_called_gt_txt_keeps_the_name_of_its_recording(space, tmp_path: Path):
    mot_layout(tmp_path / "mot", names=("A",))
    gt, det = (next((tmp_path / "mot").rglob(name)) for name in ("gt.txt", "det.txt"))
    session = uploaded(space, truth=gt, x=det, y=det)
    _, folder = packed_again(space, session, tmp_path / "street")
    portable = read_session(folder / "session.toml")
    for path, source in zip(inputs_beside(portable), (gt, det, det), strict=True):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, folder / path)
    assert b"\ngt," in (folder / "recordings.csv").read_bytes()
    assert load(portable).recordings["name"].tolist() == ["gt"]


def drive_session(folder: Path, *thresholds: float | None, **more: str) -> Session:
    files = ("fir.csv", "nir.csv")
    systems = map(lambda file, at: SystemSource((file,), threshold=at), files, thresholds)
    return session_of(drive(folder), "truth.csv", *systems, **more)


def test_a_live_threshold_of_none_counts_every_detection(tmp_path: Path):
    session = drive_session(tmp_path, 0.8, None)
    dataset = load(session)
    params = replace(dataset.params_of(), threshold_x=None)
    live = live_session(session, dataset, params, x="fir", y="nir")
    assert replace(dataset, settings=live).params_of() == params


def test_swapped_systems_stay_swapped(tmp_path: Path):
    session = drive_session(tmp_path, 0.8, 0.3, x="nir", y="fir")
    dataset = load(session)
    params = dataset.params_of()
    live = live_session(session, dataset, params, x="nir", y="fir")
    again = replace(dataset, settings=live).params_of()
    assert (params.threshold_x, again) == (0.3, params)
    assert [system.threshold for system in live.systems] == [0.8, 0.3]


def test_every_text_of_a_finding_is_made_public():
    secret = Finding(Severity.NOTE, "code", "truth", 1, "a /srv", "b /srv", "c /srv", "d /srv")
    (told,) = public_findings([secret], lambda text: str(text).replace("/srv", "here"))
    shown = told.message, told.advice, told.file, told.example
    assert shown == ("a here", "b here", "c here", "d here")

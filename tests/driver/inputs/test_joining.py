"""Detectability of the truth's boxes: a column of the truth, or a file of estimates."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from inputs import drive, nvcore, session_of, write

from nvcore.auditing import audit
from nvcore.common.errors import FormatError, InputError
from nvcore.common.findings import Severity
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.settings.params import Params
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.driver.inputs.record import EstimateRecord, estimate_json, read_estimate_record
from nvcore.subjects.driver.inputs.session import DriverTable
from nvcore.tables.inputs import finding_entries

HEAD = "recording,frame,track,x,y,w,h,detectability,sd,is_outside,period_s"


def row(
    recording: str, frame: int, value: object, rest: str = ",0.1,0,3.0", *, dx: float = 0
) -> str:
    """A row of estimates about a pedestrian of `drive`."""
    x = {"urban": 100, "rural": 300}[recording] + 3 * frame + dx
    return f"{recording},{frame},1,{x},200,40,{100 + frame},{value}{rest}"


def estimated(folder: Path, *rows: str, head: str = HEAD, **driver: str) -> Session:
    """The session of `drive` with a file of these estimates."""
    write(drive(folder) / "detectability.csv", head, *rows)
    return replace(session_of(folder), driver=DriverTable("detectability.csv", **driver))


def codes(dataset: Dataset) -> list[str]:
    return [f.code for f in audit(dataset) if f.subject == "detectability"]


def known(dataset: Dataset) -> dict[tuple[str, int], float]:
    """The detectability that is known, by recording and frame."""
    frames, value = dataset.frame_columns, dataset.detectability.value
    rows = np.flatnonzero(~np.isnan(value))
    frame_row = dataset.truth.frame_index[rows]
    names = dataset.recordings["name"].to_numpy()[frames.recording[frame_row]]
    return dict(
        zip(zip(names, frames.frame[frame_row].tolist(), strict=True), value[rows], strict=True)
    )


# the column of the truth


def stated(folder: Path, *values: str, name: str = "truth.csv") -> Session:
    """The session of `drive` with detectability in the first rows of the truth."""
    head, *lines = (drive(folder) / "truth.csv").read_text(encoding="utf-8").splitlines()
    values += ("",) * (len(lines) - len(values))
    rows = [f"{line},{value}" for line, value in zip(lines, values, strict=True)]
    write(folder / name, f"{head},detectability", *rows)
    return session_of(folder, name)


def test_a_column_of_the_truth_is_read_and_what_is_empty_is_unknown(tmp_path):
    dataset = load(stated(tmp_path, "0.25", "", "1"))
    assert known(dataset) == {("urban", 0): 0.25, ("urban", 2): 1.0}
    assert dataset.of("driver") is None
    assert not dataset.boxes["detectability"][len(dataset.truth) :].notna().any()


@pytest.mark.parametrize("value", ["-0.1", "1.01", "inf", "50"])
def test_a_share_outside_0_to_1_is_refused_with_file_and_line(tmp_path, value: str):
    with pytest.raises(
        FormatError, match=r"truth.csv, line 3: expected a detectability from 0 to 1"
    ):
        load(stated(tmp_path, "0.5", value))


def test_parquet_and_a_table_in_memory_have_the_column_too(tmp_path):
    session = stated(tmp_path, "0.25", "0.5")
    table = pd.read_csv(tmp_path / "truth.csv")
    table.to_parquet(tmp_path / "truth.parquet")
    expected = {("urban", 0): 0.25, ("urban", 1): 0.5}
    assert known(load(session_of(tmp_path, "truth.parquet"))) == expected
    assert known(load(session, tables={session.truth: table})) == expected


def test_of_detections_the_column_is_left_unused(tmp_path):
    drive(tmp_path)
    write(
        tmp_path / "fir.csv", "recording,frame,x,y,w,h,score,detectability", "urban,0,1,2,3,4,1,9"
    )
    dataset = load(session_of(tmp_path))
    assert "columns left unused: detectability" in dataset.inputs["conversion"][1]
    assert not dataset.has_detectability


@pytest.mark.parametrize("target", ["out.csv", "out.parquet", "out.json"])
def test_convert_keeps_it(tmp_path, target: str):
    stated(tmp_path, "0.25", "0.5")
    done = nvcore("convert", tmp_path / "truth.csv", tmp_path / target)
    assert done.exit_code == 0, done.output
    again = load(session_of(tmp_path, target))
    assert known(again) == {("urban", 0): 0.25, ("urban", 1): 0.5}


def test_convert_writes_no_column_where_none_is_known(tmp_path):
    drive(tmp_path)
    nvcore("convert", tmp_path / "truth.csv", tmp_path / "out.csv")
    head = (tmp_path / "out.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "detectability" not in head


# the file of estimates


def test_rows_are_joined_by_recording_frame_and_box(tmp_path):
    rows = (
        row("rural", 3, 0.75),
        row("urban", 0, 0.25, ",0.05,1,0.5", dx=0.001),
        row("urban", 1, ""),
    )
    dataset = load(estimated(tmp_path, *rows))
    assert known(dataset) == {("urban", 0): 0.25, ("rural", 3): 0.75}
    first = int(np.flatnonzero(dataset.detectability.value == 0.25)[0])
    assert dataset.detectability.sd[first] == 0.05
    assert dataset.detectability.is_outside[first]
    assert len(dataset.left_out) == 0


@pytest.mark.parametrize(
    "bad",
    [
        row("urban", 5, 0.5, dx=0.0011),
        row("urban", 5, 0.5).replace("urban,5,1,", "urban,5,2,"),
        row("urban", 5, 0.5).replace("urban", "nowhere"),
    ],
    ids=["box", "track", "recording"],
)
def test_a_row_of_no_box_is_a_finding_with_file_and_line(tmp_path, bad: str):
    dataset = load(estimated(tmp_path, row("urban", 0, 0.5), bad))
    (finding,) = [f for f in audit(dataset) if f.code == "detectability-without-box"]
    assert (finding.count, finding.file) == (1, "detectability.csv")
    assert finding.example.startswith("line 3, recording ")
    assert finding_entries(dataset, (finding,))[["file", "line"]].to_numpy().tolist() == [
        ["detectability.csv", 3]
    ]
    assert known(dataset) == {("urban", 0): 0.5}


def test_a_second_row_of_the_same_box_is_one_too(tmp_path):
    dataset = load(estimated(tmp_path, row("urban", 0, 0.5), row("urban", 0, 0.7)))
    assert known(dataset) == {("urban", 0): 0.5}
    (finding,) = (of for of in audit(dataset) if of.code == "detectability-without-box")
    assert finding.severity is Severity.WARNING


def test_rows_of_frames_that_are_not_evaluated_are_a_note(tmp_path):
    session = replace(
        estimated(tmp_path, row("urban", 0, 0.5), row("urban", 1, 0.7)), frames="0:18:2"
    )
    dataset = load(session)
    assert codes(dataset) == ["detectability-of-other-frames", "boxes-without-detectability"]
    assert {of.severity for of in audit(dataset) if of.code in codes(dataset)} == {Severity.NOTE}


def test_every_row_of_a_file_is_joined_or_left_out(tmp_path):
    rows = [row("urban", i, 0.5, dx=i % 3) for i in range(20)]
    dataset = load(estimated(tmp_path, *rows))
    assert len(known(dataset)) + len(dataset.left_out) == 20


def test_two_people_at_one_place_are_told_by_their_tracks(tmp_path):
    drive(tmp_path)
    boxes = [f"urban,0,100,200,40,100,{track}" for track in (1, 2)]
    write(tmp_path / "truth.csv", "recording,frame,x,y,w,h,track", *boxes)
    write(
        tmp_path / "detectability.csv",
        "recording,frame,track,x,y,w,h,detectability",
        *(f"urban,0,{track},100,200,40,100,0.{track}" for track in (2, 1)),
    )
    session = replace(session_of(tmp_path), driver=DriverTable("detectability.csv"))
    dataset = load(session)
    assert dataset.detectability.value.tolist() == [0.1, 0.2]


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (row("urban", 1, 1.5), "expected a detectability from 0 to 1, found 1.5"),
        (row("urban", 1, 0.5, ",-1,0,3"), "expected a sd of 0 or more, found -1"),
        (row("urban", 1, "much"), "expected a number as detectability"),
        (row("urban", 1, 0.5, ",0.1,maybe,3"), "expected 0, 1, true or false as is_outside"),
        (row("urban", 1, 0.5).replace("urban", ""), "expected the name of a recording"),
        ("urban,1", "expected 11 fields"),
    ],
)
def test_what_cannot_be_read_is_refused_with_file_and_line(tmp_path, bad: str, words: str):
    with pytest.raises(FormatError, match=rf"detectability.csv, line 3: {words}"):
        load(estimated(tmp_path, row("urban", 0, 0.5), bad))


def test_a_file_without_the_columns_is_refused(tmp_path):
    with pytest.raises(FormatError, match=r"line 1: expected a header line .* missing: h, detect"):
        load(estimated(tmp_path, "urban,0,1,2,3", head="recording,frame,x,y,w"))


def test_a_file_that_is_not_there_is_named(tmp_path):
    session = estimated(tmp_path)
    (tmp_path / "detectability.csv").unlink()
    with pytest.raises(InputError, match=r"detectability\.csv: cannot be opened"):
        load(session)


def test_an_empty_list_of_estimates_makes_nothing_known(tmp_path):
    dataset = load(estimated(tmp_path))
    assert not dataset.has_detectability
    assert codes(dataset) == ["boxes-without-detectability"]


def test_recordings_are_found_by_title_and_by_their_name_in_the_data(tmp_path):
    session = estimated(
        tmp_path, row("urban", 0, 0.5), row("rural", 1, 0.25).replace("rural", "Road")
    )
    entries = RecordingEntry("urban", title="Town"), RecordingEntry("rural", title="Road")
    dataset = load(replace(session, recordings=entries))
    assert known(dataset) == {("Town", 0): 0.5, ("Road", 1): 0.25}


def test_a_part_of_the_recordings_keeps_what_is_known_of_it(tmp_path):
    dataset = load(estimated(tmp_path, row("urban", 0, 0.5), row("rural", 1, 0.25)))
    part = dataset.only(names=["rural"])
    assert known(part) == {("rural", 1): 0.25}
    assert (
        not load(estimated(tmp_path, row("urban", 0, 0.5))).only(names=["rural"]).has_detectability
    )


def test_file_and_record_are_part_of_the_fingerprint(tmp_path):
    plain = load(session_of(drive(tmp_path))).fingerprint
    lower, higher = (load(estimated(tmp_path, row("urban", 0, v))).fingerprint for v in (0.5, 0.6))
    session = estimated(tmp_path, row("urban", 0, 0.6), provenance="d.json")
    (tmp_path / "d.json").write_bytes(estimate_json(EstimateRecord("m", "ab", "all", 4)))
    assert len({plain, lower, higher, load(session).fingerprint}) == 4


def test_the_record_says_who_estimated_and_whether_subjects_were_simulated(tmp_path):
    session = estimated(tmp_path, row("urban", 0, 0.5), provenance="d.json")
    record = EstimateRecord(
        *("driver", "5f1c00112233445566", "all", 12, {}, "nvcore 0.1.0"),
        n_estimates=9,
        n_light_unknown=2,
        outside={"Height": 3},
        no_better_at_s=(0.5, 1.5),
        search="quick",
        other_width={"urban": 480},
    )
    (tmp_path / "d.json").write_bytes(estimate_json(record))
    dataset = load(session)
    assert dataset.of("driver") == record
    conversion = dataset.inputs["conversion"].iloc[-1]
    assert "1 of 1 rows joined" in conversion
    assert "estimated by the estimator driver (12 subjects, fingerprint 5f1c00112233)" in conversion
    assert (
        "learnt from simulated subjects by a quick search, no better than a constant at 0.5 and "
        "1.5 s and in urban made on pictures of another width than in training"
    ) in conversion


@pytest.mark.parametrize(
    "text",
    [
        "[]",
        "{",
        '{"estimator": {"simulated": "perhaps"}}',
        '{"estimator": {"n_subjects": "four"}}',
        '{"estimator": {"search": "slow"}}',
        '{"estimator": {"no_better_at_s": 0.5}}',
        '{"estimator": {"no_better_at_s": ["0.5"]}}',
        '{"estimator": {"no_better_at_s": [NaN]}}',
        '{"estimator": {"of_no_use": 1}}',
        '{"files": []}',
        '{"estimates": {"other_width": {"urban": -1}}}',
        '{"estimates": {"outside": {"Height": "many"}}}',
        "1" * 9,
    ],
)
def test_what_is_no_record_is_refused(tmp_path, text: str):
    path = write(tmp_path / "d.json", text)
    with pytest.raises(FormatError, match=r"d\.json: .*docs/driver-reference\.md"):
        read_estimate_record(path, "d.json")


def test_a_record_of_which_nothing_is_known_is_read(tmp_path):
    assert read_estimate_record(write(tmp_path / "d.json", "{}"), "d.json") == EstimateRecord()


def test_a_record_of_before_is_read_and_gives_the_same_bytes(tmp_path):
    record = EstimateRecord("m", "ab", "no", 4)
    content = estimate_json(record)
    assert b"no_better" not in content
    assert b"search" not in content
    assert b"other_width" not in content
    assert read_estimate_record(write(tmp_path / "d.json", content.decode()), "d.json") == record
    assert record.caution == ""
    assert replace(record, no_better_at_s=(3.0,)).caution == "no better than a constant at 3 s"


def test_a_light_meter_in_doubt_is_a_warning_of_the_audit_and_part_of_what_is_said(tmp_path):
    session = estimated(tmp_path, row("urban", 0, 0.5), provenance="d.json")
    record = EstimateRecord("m", light_doubts={"urban": "one reading in 50 s"})
    (tmp_path / "d.json").write_bytes(estimate_json(record))
    dataset = load(session)
    assert dataset.of("driver") == record
    (finding,) = [finding for finding in dataset.findings if finding.code == "doubtful-light-meter"]
    assert "urban (one reading in 50 s)" in finding.message
    assert record.caution == "in urban by a light meter that may have another unit or clock"


def test_pictures_in_doubt_are_a_warning_of_the_audit_and_part_of_what_is_said(tmp_path):
    session = estimated(tmp_path, row("urban", 0, 0.5), provenance="d.json")
    record = EstimateRecord("m", picture_doubts={"urban": "boxes are scaled by 1.5 across"})
    (tmp_path / "d.json").write_bytes(estimate_json(record))
    dataset = load(session)
    assert dataset.of("driver") == record
    (finding,) = [
        finding for finding in dataset.findings if finding.code == "doubtful-visible-pictures"
    ]
    assert "urban (boxes are scaled by 1.5 across)" in finding.message
    assert record.caution == "in urban from pictures or gaze that may show another view"


def test_estimates_without_a_known_change_of_light_are_for_adapted_eyes(tmp_path):
    rows = row("urban", 0, 0.5, ",0.1,0,3.0"), row("urban", 1, 0.5, ",0.1,0,")
    dataset = load(estimated(tmp_path, *rows))
    known = ~np.isnan(dataset.detectability.value)
    assert dataset.detectability.is_adapted[known].tolist() == [False, True]
    without = load(
        estimated(
            tmp_path, "urban,0,100,200,40,100,0.5", head="recording,frame,x,y,w,h,detectability"
        )
    )
    assert not without.detectability.is_adapted.any()
    with pytest.raises(FormatError, match="expected a period_s of 0 or more, found -1"):
        load(estimated(tmp_path, row("urban", 0, 0.5, ",0.1,0,-1")))


def test_that_the_estimator_is_of_no_use_is_kept(tmp_path):
    record = EstimateRecord("m", "ab", "no", 4, no_better_at_s=(3.0,), of_no_use=True)
    path = write(tmp_path / "d.json", estimate_json(record).decode())
    assert read_estimate_record(path, "d.json") == record
    assert record.caution == "overall no better than a constant"


def test_a_session_is_written_with_both_files_and_the_hash(tmp_path):
    session = estimated(tmp_path, row("urban", 0, 0.5), provenance="d.json")
    (tmp_path / "d.json").write_bytes(estimate_json(EstimateRecord()))
    out = tmp_path / "out" / "session.toml"
    write(out, write_session(session, version="1", fingerprint="x"))
    again = read_session(out)
    assert again.driver.detectability == (tmp_path / "detectability.csv").as_posix()
    assert load(again).fingerprint == load(session).fingerprint


def test_that_a_file_has_changed_since_the_session_was_written_is_said(tmp_path):
    session = replace(estimated(tmp_path, row("urban", 0, 0.5)), hashes={"detectability": "old"})
    assert "input-changed" in codes(load(session))


def test_where_truth_and_file_differ_the_file_is_taken_and_that_is_said(tmp_path):
    session = stated(tmp_path, "0.25", "0.5")
    write(tmp_path / "detectability.csv", HEAD, row("urban", 0, 0.9), row("urban", 1, 0.5))
    dataset = load(replace(session, driver=DriverTable("detectability.csv")))
    assert known(dataset) == {("urban", 0): 0.9, ("urban", 1): 0.5}
    (finding,) = [f for f in dataset.findings if f.code == "detectability-twice"]
    assert finding.count == 1


def test_a_fusion_keeps_what_is_known_of_the_truth(tmp_path):
    dataset = load(estimated(tmp_path, *(row("urban", i, 0.9) for i in range(20))))
    result = compare(dataset, Params())
    assert (
        driver_in(result.fusion).is_seen.tolist()
        == driver_in(result).is_seen.tolist()
        == [True, False]
    )


@pytest.mark.parametrize("is_own", [True, False])
def test_a_record_about_another_file_is_a_warning(tmp_path, is_own: bool):
    session = estimated(tmp_path, row("urban", 0, 0.5), provenance="d.json")
    content = (tmp_path / "detectability.csv").read_bytes() + b" " * (not is_own)
    files = {"detectability.csv": hashlib.sha256(content).hexdigest()}
    (tmp_path / "d.json").write_bytes(estimate_json(EstimateRecord("m", files=files)))
    assert ("detectability-other-record" in codes(load(session))) is not is_own


def test_a_row_without_a_value_leaves_what_the_truth_states(tmp_path):
    session = stated(tmp_path, "0.25", "0.5", "")
    rows = row("urban", 0, ""), row("urban", 2, "0.75"), row("rural", 0, "")
    write(tmp_path / "detectability.csv", HEAD, *rows)
    dataset = load(replace(session, driver=DriverTable("detectability.csv")))
    assert known(dataset) == {("urban", 0): 0.25, ("urban", 1): 0.5, ("urban", 2): 0.75}
    assert dataset.of("driver") is not None
    assert dataset.of("driver").estimated_in == dataset.of("driver").stated_in == {"urban"}

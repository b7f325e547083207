from __future__ import annotations

from pathlib import Path

from inputs import mot_layout, write

from nvcore.common.findings import Finding, Severity
from nvcore.inputs.load import read_source
from nvcore.inputs.readers.base import joined_findings
from nvcore.inputs.session import Source


def finding(file: str, count: int = 1, message: str = "Odd.") -> Finding:
    return Finding(Severity.NOTE, "odd", "truth", count, message, "Look.", file=file, example=file)


def test_findings_of_one_kind_in_several_files_become_one():
    (joined,) = joined_findings([finding("a", 2), finding("b", 3), finding("b", 1)])
    assert (joined.count, joined.message) == (6, "Odd. They stand in 2 files.")
    assert (joined.file, joined.example) == ("a", "a")


def test_a_finding_about_a_single_file_stays_as_it_is():
    assert joined_findings([finding("a")]) == (finding("a"),)


def test_findings_that_say_different_things_stay_apart_and_in_order():
    several = [finding("a", message="B."), finding("b", message="A."), finding("c", message="B.")]
    assert [joined.message for joined in joined_findings(several)] == [
        "B. They stand in 2 files.",
        "A.",
    ]


def test_frames_before_the_first_of_two_files_are_one_finding(tmp_path: Path):
    mot_layout(tmp_path)
    for name in ("A", "B"):
        write(tmp_path / name / "gt" / "gt.txt", "0,1,11,21,30,60,1,1,1")
    (joined,) = read_source(Source((".",)), role="truth", folder=tmp_path).findings
    assert (joined.code, joined.count) == ("frame-before-first", 2)
    assert joined.message.endswith("They stand in 2 files.")

from __future__ import annotations

from audit_comparison import N, codes, dataset, find, walk
from builders import NAN, Box

from nvcore.auditing import audit
from nvcore.findings import Severity
from nvcore.params import Params


def unscored(boxes: list[Box]) -> list[Box]:
    return [box._replace(score=NAN) for box in boxes]


def test_a_system_without_scores_gets_a_note() -> None:
    finding = find(dataset(x=unscored(walk())), "no-scores")
    assert (finding.severity, finding.subject, finding.count) == (Severity.NOTE, "x", N)


def test_some_missing_scores_are_a_warning() -> None:
    made = dataset(x=[*unscored(walk(stop=3)), *walk(first=3)])
    finding = find(made, "missing-score")
    assert (finding.severity, finding.count) == (Severity.WARNING, 3)


def test_a_constant_score_is_a_note() -> None:
    made = dataset(x=[box._replace(score=1.0) for box in walk()])
    assert find(made, "constant-score").severity is Severity.NOTE


def test_scores_outside_0_to_1_are_a_note_with_their_range() -> None:
    made = dataset(x=[box._replace(score=box.score * 10 - 5.5) for box in walk()])
    finding = find(made, "unusual-scores")
    assert finding.severity is Severity.NOTE
    assert "-0.5 to 3.5" in finding.message


def test_a_threshold_that_keeps_nothing_is_an_error() -> None:
    finding = find(dataset(), "threshold-keeps-nothing", Params(threshold_y=5.0))
    assert (finding.severity, finding.subject, finding.count) == (Severity.ERROR, "y", N)
    assert "0.5 to 0.9" in finding.message


def test_a_threshold_that_keeps_everything_is_a_note() -> None:
    finding = find(dataset(), "threshold-keeps-all", Params(threshold_x=0.5))
    assert (finding.severity, finding.subject) == (Severity.NOTE, "x")


def test_a_threshold_within_the_scores_is_no_finding() -> None:
    assert codes(dataset(), Params(threshold_x=0.52, threshold_y=0.52)) == []


def test_a_threshold_without_scores_is_a_warning() -> None:
    made = dataset(x=unscored(walk()))
    found = find(made, "threshold-without-scores", Params(threshold_x=0.5))
    assert found.severity is Severity.WARNING


def test_the_threshold_belongs_to_the_system_that_is_x() -> None:
    (finding,) = audit(dataset(), Params(threshold_x=5.0), x="y", y="x")
    assert (finding.subject, finding.code) == ("y", "threshold-keeps-nothing")

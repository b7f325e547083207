from __future__ import annotations

from collections.abc import Callable

import pytest
from audit_comparison import N, codes, dataset, find, reported, walk
from builders import NAN, Box

from nvcore.auditing import audit
from nvcore.settings.params import Params


@pytest.mark.parametrize(
    ("scores", "threshold", "code", "severity", "count", "words"),
    [
        (lambda _: NAN, None, "no-scores", "note", N, ""),
        (lambda box: NAN if box.frame < 3 else box.score, None, "missing-score", "warning", 3, ""),
        (lambda _: 1.0, None, "constant-score", "note", N, ""),
        (lambda box: box.score * 10 - 5.5, None, "unusual-scores", "note", 25, "-0.5 to 3.5"),
        (lambda box: box.score, 5.0, "threshold-keeps-nothing", "error", N, "0.5 to 0.9"),
        (lambda box: box.score, 0.5, "threshold-keeps-all", "note", N, ""),
        (lambda _: NAN, 0.5, "threshold-without-scores", "warning", N, ""),
    ],
)
def test_odd_scores_and_thresholds_are_reported(
    scores: Callable[[Box], float],
    threshold: float | None,
    code: str,
    severity: str,
    count: int,
    words: str,
) -> None:
    made = dataset(x=[box._replace(score=scores(box)) for box in walk()])
    params = Params(threshold_x=threshold)
    assert reported(made, code, params) == (severity, "x", count)
    assert words in find(made, code, params).message


def test_a_threshold_within_the_scores_is_no_finding() -> None:
    assert codes(dataset(), Params(threshold_x=0.52, threshold_y=0.52)) == []


def test_the_threshold_belongs_to_the_system_that_is_x() -> None:
    (finding,) = audit(dataset(), Params(threshold_x=5.0), x="y", y="x")
    assert (finding.subject, finding.code) == ("y", "threshold-keeps-nothing")

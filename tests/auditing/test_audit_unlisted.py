"""False alarms that look like pedestrians missing from the ground truth."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from builders import Box, Place, make_dataset

from bench import claims
from nvcore.auditing import audit
from nvcore.common.findings import Finding
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.metrics.encounters import encounters_of
from nvcore.metrics.matching import match_system
from nvcore.report.verdict import verdict
from nvcore.report.verdict.points import UNLISTED
from nvcore.settings.params import Params
from nvcore.tables import finding_entries

N = 6
"""Recordings, of 75 frames each."""
PEOPLE = range(5)
"""Pedestrians of each recording, ten frames each, five frames apart."""


def runs(numbers: Any, x: float = 100, *, recordings: int = N, **more: Any) -> list[Box]:
    """Ten boxes for each of the numbered pedestrians, in every recording."""
    given = {"w": 40, "h": 100, "score": 0.8, **more}
    return [
        Box(15 * number + frame, x, 200, recording=recording, track=number, **given)
        for recording in range(recordings)
        for number in numbers
        for frame in range(10)
    ]


def scene(truth: Any = (), x: Any = (), y: Any = (), *, n_by_x: int = 5) -> Dataset:
    """People whom Y detects, and X the first of; low false alarms of both; other boxes."""
    low = runs(PEOPLE, 600, h=20)
    return make_dataset(
        [*runs(PEOPLE), *truth],
        [*(box._replace(x=101) for box in runs(PEOPLE[:n_by_x])), *low, *x],
        [*(box._replace(x=99) for box in runs(PEOPLE)), *low, *y],
        places=[Place(range(75), 640, 480)] * N,
    )


def unlisted(made: Dataset) -> list[Finding]:
    return [finding for finding in audit(made) if finding.code == UNLISTED]


ONE_EACH = runs([1], 400)


def test_false_alarms_of_one_system_that_look_like_its_matches_are_a_warning() -> None:
    made = scene(y=[*ONE_EACH, *runs([2], 500, h=130, recordings=1)])
    (finding,) = unlisted(made)
    assert (finding.severity, finding.subject, finding.count) == ("warning", "y", 7)
    assert finding.message == (
        "y has 7 runs of false alarms as long (10 frames), large (100 px) and sure (score 0.8) as "
        "the upper three quarters of its matches, x has 0: more than chance."
    )
    assert "whom x does not detect" in finding.advice
    entries = finding_entries(made, [finding])
    assert entries["recording"].tolist() == ["r0", "r0", "r1", "r2", "r3", "r4", "r5"]
    assert entries[["frame", "x", "h"]].iloc[0].tolist() == [30, 500, 130]  # the largest first


def test_either_system_may_have_them() -> None:
    (finding,) = unlisted(scene(x=ONE_EACH))
    assert finding.subject == "x"


def test_without_scores_length_and_height_decide() -> None:
    made = scene(y=ONE_EACH)
    without = dataclasses.replace(made, boxes=made.boxes.assign(score=np.nan))
    (finding,) = unlisted(without)
    assert "as long (10 frames), large (100 px) as the" in finding.message


NO_FINDING = {
    "both have as many": {"x": ONE_EACH, "y": ONE_EACH},
    "in four recordings only": {"y": runs([0, 1, 2], 400, recordings=4)},
    "low ones": {"y": runs([1], 400, h=99)},
    "unsure ones": {"y": runs([1], 400, score=0.7)},
    "short ones": {"y": [box for box in ONE_EACH if box.frame < 24]},
    "on ignore regions": {"y": ONE_EACH, "truth": runs([1], 395, w=60, ignore=True)},
    "beside pedestrians": {"y": runs([1], 131)},  # IoU 8 / 72
    "many false alarms in all": {
        "x": runs([0], 400, recordings=1),
        "y": [*ONE_EACH, *(box for x in range(200, 600, 45) for box in runs(PEOPLE, x, h=20))],
    },
}


@pytest.mark.parametrize("case", NO_FINDING)
def test_is_not_reported(case: str) -> None:
    assert unlisted(scene(**NO_FINDING[case])) == []


def on_encounters(made: Dataset) -> tuple[str, str]:
    """What the verdict says of encounters, and of the audit."""
    topics = dict(verdict(compare(made), audit(made)).topics)
    return topics["Encounters"], topics["Audit"]


def test_the_verdict_says_what_it_means_and_nothing_of_a_lead_that_is_not_there() -> None:
    encounters, doubt = on_encounters(scene(x=ONE_EACH))
    assert "false alarms that look like people missing from the ground truth" in doubt
    assert "real" not in encounters


def test_the_verdict_says_that_even_all_of_them_would_not_turn_the_lead() -> None:
    encounters, _ = on_encounters(scene(x=ONE_EACH, n_by_x=4))  # one less in each recording
    assert encounters.endswith(
        "Even if all 6 runs of X's false alarms that look like its matches were real pedestrians, "
        "X would at most equal Y in encounters detected."
    )


def test_one_more_than_the_lead_turns_it() -> None:
    made = scene(x=ONE_EACH)
    of_one = made.boxes["source"].eq(1) & made.boxes["x"].eq(101) & (made.boxes["frame_index"] < 10)
    made = dataclasses.replace(made, boxes=made.boxes[~of_one].reset_index(drop=True))
    encounters, _ = on_encounters(made)
    assert encounters.endswith(
        "Of 6 runs of X's false alarms that look like its matches, at least 2 would have to be "
        "real pedestrians to turn Y's lead in encounters detected at these thresholds."
    )


def test_nothing_is_said_of_the_false_alarms_of_the_leader() -> None:
    encounters, _ = on_encounters(scene(y=ONE_EACH, n_by_x=4))
    assert "real" not in encounters


def study(seed: int, *, is_biased: bool) -> Dataset:
    """Twelve long recordings; if biased, a third of those X misses for half of the time is gone."""
    rng = np.random.default_rng(seed)
    drawn = claims.place_systems(claims.SCENARIOS["equal"], claims.varying(rng, 12), rng)
    if not is_biased:
        return drawn
    matches = match_system(drawn, "x", None, Params())
    of_box = encounters_of(drawn)[1].encounter_of
    share = np.bincount(of_box, matches.is_matched) / np.bincount(of_box)
    gone = (share <= 0.5) & (rng.random(len(share)) < 1 / 3)
    rows = drawn.truth.first_row + np.flatnonzero(gone[of_box])
    return dataclasses.replace(drawn, boxes=drawn.boxes.drop(index=rows).reset_index(drop=True))


def test_people_of_whom_a_third_that_x_misses_is_not_annotated_are_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(claims, "N_FRAMES", 400)  # 80 pedestrians in each recording
    found = {
        is_biased: [
            [of.subject for of in unlisted(study(n, is_biased=is_biased))] for n in range(5)
        ]
        for is_biased in (True, False)
    }
    assert found[True].count(["y"]) >= 3
    assert found[False] == [[]] * 5


@pytest.mark.realdata
def test_on_kaist_a_detector_finds_people_who_are_not_annotated(kaist: Dataset) -> None:
    # 60 of the 71 are detected by two or more of the other four systems, too
    at = Params(threshold_x=0.2, threshold_y=0.2)
    found = audit(kaist, at, x="MLPD", y="GAFF")
    assert [(of.subject, of.count) for of in found if of.code == UNLISTED] == [("GAFF", 71)]

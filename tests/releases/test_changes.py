"""What a new version changed: encounters and false-alert episodes, counted by hand."""

from __future__ import annotations

import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.report.gate import run_gate
from nvcore.report.gate.rules import parse_rule
from nvcore.tables.encounters.changes import (
    CHANGE_COLUMNS,
    Change,
    changes_table,
    count_changes,
    located_changes,
)

FRAMES = range(10, 20)


def high(frame: int, centre: float, **more: object):
    """Box of a false alarm, above all pedestrians."""
    return at(frame, centre, w=10.0, h=20.0, foot=30.0, **more)


def scene() -> Result:
    """One encounter of each kind, and episodes of which one is new, one gone and one the same."""
    truth = [at(frame, 20 * track, track=track) for frame in FRAMES for track in (1, 2, 3, 4)]
    old = [at(frame, centre) for frame in FRAMES for centre in (20, 60)]
    new = [at(frame, centre) for frame in FRAMES for centre in (40, 60)]
    old += [high(frame, 10) for frame in (10, 11)]
    new += [high(frame, 30) for frame in (14, 15, 16)]
    # the same episode, as both have it in frame 12
    old += [high(frame, 50) for frame in (11, 12)]
    new += [high(frame, 52) for frame in (12, 13)]
    # the same place, but not at the same time
    old += [high(11, 90)]
    new += [high(18, 90)]
    return result_of(make_dataset(truth, old, new, places=[Place(FRAMES)]))


def test_each_encounter_and_each_episode_is_one_case_of_its_kind():
    cases = changes_table(scene())
    assert [*cases] == [column.name for column in CHANGE_COLUMNS]
    named = ["kind", "about", "track", "first_frame", "last_frame"]
    told = cases[named].astype(object).where(cases[named].notna(), None)
    assert [*told.itertuples(index=False, name=None)] == [
        ("newly missed", "encounter", 1, 10, 19),
        ("newly false", "false alarm", None, 14, 16),
        ("newly false", "false alarm", None, 18, 18),
        ("fixed", "encounter", 2, 10, 19),
        ("gone", "false alarm", None, 10, 11),
        ("gone", "false alarm", None, 11, 11),
        ("unchanged", "encounter", 4, 10, 19),
        ("unchanged", "encounter", 3, 10, 19),
        ("unchanged", "false alarm", None, 12, 13),
    ]
    assert count_changes(scene()) == {
        Change.NEWLY_MISSED: 1,
        Change.NEWLY_FALSE: 2,
        Change.FIXED: 1,
        Change.GONE: 2,
        Change.UNCHANGED: 3,
    }


def test_severity_is_that_of_each_version_and_a_false_alarm_has_none():
    cases = changes_table(scene()).set_index("kind")
    missed, fixed = cases.loc["newly missed"], cases.loc["fixed"]
    assert missed["severity_s_old"] == fixed["severity_s_new"] == 0
    assert missed["severity_s_new"] > 0
    assert fixed["severity_s_old"] > 0
    alarms = cases[cases["about"] == "false alarm"]
    assert alarms[["severity_s_old", "severity_s_new"]].isna().all(axis=None)
    assert cases.loc["newly false", "duration_s"].tolist() == pytest.approx([0.3, 0.1])


def test_a_false_alarm_is_shown_by_its_tallest_box():
    old = [high(10, 10), high(11, 10), at(12, 10, w=10.0, h=25.0, foot=35.0)]
    result = result_of(make_dataset([], old, [], places=[Place(FRAMES)]))
    (case,) = located_changes(result).itertuples()
    assert (case.kind, case.frame, case.row, case.box, case.encounter) == ("gone", 12, 2, 2, -1)


def test_without_boxes_there_is_no_case():
    result = result_of(make_dataset(n_frames=3))
    assert changes_table(result).empty
    assert set(count_changes(result).values()) == {0}


def test_the_gate_counts_changes_by_the_same_words_and_lists_those_of_a_failed_rule():
    texts = ("newly_missed == 0", "fixed == 1", "newly_false == 0", "gone == 2")
    outcomes, _ = run_gate([*map(parse_rule, texts)], scene(), (), strict=False)
    assert {kind.name.lower() for kind in Change} - {"unchanged"} == {
        text.split()[0] for text in texts
    }
    values = [outcome.value for outcome in outcomes[:4]]
    assert values == [1, 1, 2, 2]
    assert outcomes[0].details == ("r0, track 1, frames 10 to 19",)
    assert outcomes[2].details == ("r0, frames 14 to 16", "r0, frame 18")


def test_an_old_episode_is_that_of_both_new_ones_that_it_overlaps():
    old = [high(12, 50, score=0.9)]
    new = [high(12, 46, score=0.9), high(12, 54, score=0.8)]  # IoU 0.43 with the old one
    result = result_of(make_dataset([at(12, 20, track=1)], old, new, places=[Place(FRAMES)]))
    counts = count_changes(result)
    assert (counts[Change.NEWLY_FALSE], counts[Change.GONE]) == (0, 0)

"""What is told of misses, fusion, saliency and time left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from approach import PLACE, approach, only
from builders import Place, at, make_dataset, result_of

from nvcore.comparison import Result, compare
from nvcore.metrics.venn import Venn, measure_exclusivity
from nvcore.notes import Note
from nvcore.objects import PEDESTRIAN
from nvcore.params import Params
from nvcore.report.words import (
    at_best,
    fusion_gains,
    lead,
    misses,
    saliencies,
    saliency_caveat,
)
from nvcore.sentences import say
from nvcore.sentences.encounters import Gain, NoFusion
from nvcore.sentences.saliency import End, Relevance, Weight
from nvcore.tables.encounters.miss_classes import fusion_table
from nvcore.time_left.facts import (
    Among,
    Confirmed,
    NotUrgent,
    Others,
    Speed,
    Unknown,
    UnknownReason,
    Urgent,
)
from nvcore.time_left.said import confirmed, urgent


@pytest.fixture(scope="module")
def nothing() -> Result:
    return result_of(make_dataset(n_frames=2))


@pytest.mark.parametrize(
    ("both", "x_only", "y_only", "neither", "kind", "correlated", "parted"),
    [
        (5, 2, 2, 1, "some", "few", "even"),  # the paper's first figure
        (20, 12, 0, 5, "some", "known", "uneven"),
        (20, 4, 2, 5, "some", "known", "chance"),
        (20, 3, 4, 0, "exclusive", "few", "chance"),
        (20, 0, 0, 4, "same", "few", "none"),
        (5, 0, 1, 2, "some", "few", "untested"),
        (50, 3, 3, 20, "some", "known", "even"),
        (3, 0, 0, 0, "none", "", ""),
        (0, 0, 0, 0, "nobody", "", ""),
    ],
)
def test_whether_both_miss_the_same_pedestrians(
    nothing: Result,
    both: int,
    x_only: int,
    y_only: int,
    neither: int,
    kind: str,
    correlated: str,
    parted: str,
):
    venn = Venn(both, x_only, y_only, neither, distant=0)
    first, *others = misses(replace(nothing, venn=venn, exclusivity=measure_exclusivity(venn)))
    assert (first.kind, first.n, first.by_both) == (kind, venn.n_near, neither)
    assert [fact.kind for fact in others] == [text for text in (correlated, parted) if text]


def test_misses_in_words(nothing: Result):
    venn = Venn(5, 2, 2, 1, distant=0)
    facts = misses(replace(nothing, venn=venn, exclusivity=measure_exclusivity(venn)))
    assert [say(fact, PEDESTRIAN) for fact in facts] == [
        "Of 10 encounters that count, X does not detect 3 and Y does not detect 3; 1 of the 5 that "
        "at least one misses are missed by both (Jaccard index 0.20).",
        "Too few misses to say whether those of X and Y go together (phi +0.05).",
        "Of the 4 encounters that only one system detects, X detects 2 and Y 2: in this they do "
        "not differ.",
    ]


def test_encounters_of_one_frame_are_not_tested_one_by_one():
    truth = [at(f, 50, track=f) for f in range(12)]
    result = result_of(make_dataset(truth, truth, truth[:2], n_frames=12))
    assert (misses(result)[-1].kind, misses(result)[-1].x) == ("short", 10)


@pytest.mark.parametrize(
    ("lead_s", "kind"),
    [
        ((0.5, 0.3, 0.4), "clear"),
        ((0.0, 0.0), "neither"),
        ((0.9, 0.0, 0.0), "usually"),
        ((1.8, -0.1, -0.1), "apart"),
        ((), "none"),
    ],
)
def test_lead_time_is_told_by_mean_and_median(lead_s: tuple[float, ...], kind: str):
    truth = [at(f, 10 + 8 * i, track=i) for i in range(len(lead_s)) for f in range(20)]
    x, y = (
        [box for box in truth if box.frame >= 10 * max(0, sign * lead_s[box.track])]
        for sign in (-1, 1)
    )
    fact = lead(result_of(make_dataset(truth, x, y), proximity="none"))
    assert (fact.kind, fact.n) == (kind, len(lead_s))
    if kind == "clear":
        assert say(fact, PEDESTRIAN) == (
            "Of 3 encounters that both match, X matches 3 first, Y 0, and both match 0 at the same "
            "time. X's lead is +0.40 s on average, median +0.40 s."
        )


@pytest.fixture
def fusion() -> pd.DataFrame:
    """Tracks 1, 2, 3 in a second; X finds 1 and 2, Y finds 2 and 3 and has a false alarm."""
    truth = [at(f, c, track=t) for f in range(10) for t, c in ((1, 20), (2, 50), (3, 80))]
    x = [at(f, c) for f in range(10) for c in (20, 50)]
    y = [at(f, c) for f in range(10) for c in (50, 80)] + [at(4, 5)]
    return fusion_table(result_of(make_dataset(truth, x, y)))


def test_gain_and_cost_of_a_fusion_are_told_against_the_better_system(fusion: pd.DataFrame):
    gains = fusion_gains(fusion)
    assert [say(gain, PEDESTRIAN) for gain in gains] == [
        "“X or Y” detects 3 of 3 encounters, 1 more than X alone, and costs 1 false-alert episode.",
        "“X and Y” detects 1 of 3 encounters, 1 fewer than X alone, and has as many false-alert "
        "episodes.",
    ]
    fusion.loc[fusion["system"] == "y", "encounters_detected"] = 3
    fusion["gain_on_y"] = fusion["encounters_detected"] - 3
    either, both = fusion_gains(fusion)
    assert (either.gain, either.cost.kind) == (Gain("same", 0, "y"), "same")
    assert (both.gain, both.cost.kind, both.cost.n) == (Gain("fewer", 2, "y"), "fewer", 1)


def test_a_fusion_of_nothing_gains_nothing(nothing: Result):
    assert fusion_gains(fusion_table(nothing)) == (NoFusion(),)


def missed(**params: object) -> Result:
    """Ten frames at 10 fps; X misses frames 2-3 and 8-9, Y nothing."""
    truth = [at(f, 50, track=3) for f in range(10)]
    x = [box for box in truth if box.frame not in (2, 3, 8, 9)]
    return result_of(make_dataset(truth, x, truth), **params)


def test_the_saliency_of_a_recording_is_taken_apart():
    assert [say(each, PEDESTRIAN) for each in saliencies(missed())] == [
        "X: the most salient of 2 events lasts 0.20 s and ends when 100 % of the recording has "
        "passed, which gives it the recency 0.99: 0.20 s × 0.99 = 0.20 s. The missed pedestrians "
        "count (k >= 0.5) throughout.",
        "Y misses nobody by more than the tolerance: its saliency is 0.",
    ]
    of_encounter = saliencies(missed(saliency_scope="encounter"))[0]
    assert of_encounter.event.end.scope == "encounter"
    in_seconds = saliencies(missed(recency_unit="seconds"))[0]
    assert in_seconds.event.end == End("seconds", pytest.approx(0), "recording")
    truth = [at(f, 50, h=60 if f < 5 else 2, track=3) for f in range(10)]
    far = result_of(make_dataset(truth), proximity="height", tolerance=0)
    assert saliencies(far)[0].relevance == Relevance("part", 0.5)


def test_the_sum_of_all_events_is_told_as_one():
    x, _ = saliencies(missed(saliency_aggregate="sum"))
    assert say(x, PEDESTRIAN).startswith(
        "X: 2 events, 0.4 s in all; weighted by recency and added they make 0.25 s. "
    )


def test_the_mean_over_recordings_stands_before_the_largest_event_of_all():
    places = [Place(range(10)), Place(range(10))]
    truth = [at(f, 50, track=3, recording=r) for r in (0, 1) for f in range(10)]
    x = [box for box in truth if box.recording == 0 or box.frame < 8]
    several = make_dataset(truth, x, truth, places=places)
    largest, _ = saliencies(result_of(several))
    assert say(largest, PEDESTRIAN).startswith(
        "X: 1 event. The largest of each recording makes 0.10 s on average; the largest of all "
        "lasts 0.20 s and ends"
    )
    total, _ = saliencies(result_of(several, saliency_aggregate="sum"))
    assert "added they make 0.20 s, 0.10 s a recording. The" in say(total, PEDESTRIAN)


def test_with_risk_an_event_says_what_it_weighs():
    largest, _ = saliencies(missed(saliency_weight="risk", proximity="none"))
    # the pedestrian stands in the middle: weighted distance over half the width is 1
    assert largest.event.weight == Weight("one", pytest.approx(0.2))
    total, _ = saliencies(
        missed(saliency_weight="risk", saliency_aggregate="sum", proximity="none")
    )
    assert total.event.weight == Weight("all", pytest.approx(0.4))


def test_what_follows_from_the_paper_s_rule_is_told_while_it_holds():
    assert "missing both can come out below missing one" in saliency_caveat(Params())
    assert saliency_caveat(Params(saliency_of="each")) == ""


def test_who_is_urgent_at_which_speed_and_why_others_are_not():
    people = [
        *approach(range(40), 5, centre=20, track=1),
        *approach(range(20), 2.1, centre=50, track=2),
        *approach(range(4), 5, centre=70, track=3),
        *(at(f, 85, track=4) for f in range(40)),
    ]
    tall = PLACE._replace(height=4000.0)
    result = result_of(make_dataset(sorted(people), places=[tall]))
    fact = urgent(result)
    assert (fact.kind, {kind.kind: kind.n for kind in fact.others.kinds}) == (
        "one",
        {"no chance": 1, "not urgent": 1, "unknown": 1},
    )
    assert fact.others.kinds[-1].unknown == Unknown((UnknownReason("short", 0),))
    corridor = result_of(result.dataset, corridor=0.5)
    assert urgent(corridor).kind == "none"
    assert NotUrgent("outside", 1) in urgent(corridor).others.kinds


def test_distant_encounters_are_said_to_be_among_those_counted():
    far = [at(f, 85, track=2, h=5) for f in range(40)]
    result = compare(make_dataset([*approach(range(40), 5), *far], places=[PLACE]))
    assert result.venn.distant == 1
    fact = urgent(result)
    assert fact == Urgent(
        "one", Speed("assumed", 50.0), 1, Others((NotUrgent("not urgent", 1),)), Among(2, 1)
    )
    assert say(fact, result.objects) == (
        "1 encounter is urgent at 50 km/h (assumed); 1 not urgent (of all 2 encounters, 1 distant "
        "one among them)"
    )


def test_nobody_urgent_and_nothing_known_are_told_apart():
    still = result_of(make_dataset([at(f, 50, track=1) for f in range(20)]))
    assert urgent(still) == Urgent("none", Speed("assumed", 50.0))
    assert confirmed(still) == ()
    sampled = Place(range(0, 40, 2))
    result = result_of(make_dataset(approach(range(0, 40, 2), 5), places=[sampled]))
    assert urgent(result).unknown == Unknown((UnknownReason("sampled", 0),))
    linked = [box._replace(track=-1) for box in approach(range(40), 5)]
    result = result_of(make_dataset(linked, places=[PLACE]))
    assert urgent(result).unknown == Unknown((UnknownReason("linked", 0),))


def test_the_verdict_tells_who_leaves_time_to_stop():
    boxes = approach(range(40), 5)
    result = result_of(make_dataset(boxes, boxes, only(boxes, range(38, 40)), places=[PLACE]))
    (said,) = confirmed(result)
    assert said == Confirmed(1, 1, 0, 0.0, pytest.approx(50.0), Speed("assumed", 50.0))
    assert say(said, result.objects) == (
        "The only urgent encounter at 50 km/h (assumed) is confirmed in time by X, not by Y; "
        "impact speed 0.0 km/h with X and 50.0 km/h with Y."
    )


def test_speeds_of_recordings_are_told_from_the_assumed_one():
    boxes = [box for r in range(2) for box in approach(range(40), 5, recording=r)]
    dataset = make_dataset(boxes, places=[PLACE] * 2)
    for speeds, speed in (
        ([30.0, np.nan], Speed("some", 50.0, 1)),
        ([30.0, 90.0], Speed("own", 50.0)),
    ):
        stated = replace(dataset, recordings=dataset.recordings.assign(speed_kmh=speeds))
        assert urgent(result_of(stated)).speed == speed


@pytest.mark.parametrize(
    ("n", "units", "expected"),
    [
        (5, (), Note("verdict.at_best", n=5, noun="recording", n_needed=6)),
        (6, (), Note("verdict.at_best", n=6, noun="recording")),
        (7, (), None),
        (7, ("a", "a", *"bcdef"), Note("verdict.at_best", n=6, noun="unit")),
        (10, ("a",) * 10, Note("verdict.at_best", n=1, noun="unit", n_needed=6)),
    ],
)
def test_what_so_many_recordings_could_show_at_best(
    n: int, units: tuple[str, ...], expected: Note | None
):
    dataset = make_dataset(places=[Place(range(3))] * n)
    if units:
        recordings = dataset.recordings.assign(unit=pd.Series(units).array)
        dataset = replace(dataset, recordings=recordings)
    assert at_best(dataset) == (() if expected is None else (expected,))

"""What is told of misses, fusion and saliency."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd
import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.comparison import Result
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

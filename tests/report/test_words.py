"""Sentences about exclusivity, fusion and saliency."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import at, make_dataset, result_of

from nvcore.comparison import Result
from nvcore.metrics.venn import Venn, measure_exclusivity
from nvcore.report.words import describe_fusion, describe_lead, describe_misses, describe_saliency
from nvcore.tables.miss_classes import fusion_table


def counted(both: int, x_only: int, y_only: int, neither: int) -> Result:
    """A result with these counts of encounters; nothing else of it is of interest."""
    venn = Venn(both, x_only, y_only, neither, distant=0)
    result = result_of(make_dataset(n_frames=2))
    return replace(result, venn=venn, exclusivity=measure_exclusivity(venn))


def said(result: Result) -> str:
    return " ".join(describe_misses(result))


def test_the_paper_s_first_figure_in_words():
    text = said(counted(5, 2, 2, 1))
    assert "Of 10 encounters that count, X does not detect 3 and Y does not detect 3" in text
    assert "1 of the 5 that at least one misses are missed by both (Jaccard index 0.20)" in text
    assert "Too few misses to say whether those of X and Y go together (phi +0.05)" in text
    assert "only one system detects, X detects 2 and Y 2: in this they do not differ." in text


def test_an_uneven_split_is_called_unlikely():
    assert "a split so uneven is unlikely if both are equally good" in said(counted(20, 12, 0, 5))


def test_exclusive_misses_are_called_so():
    assert "all 7 misses are exclusive" in said(counted(20, 3, 4, 0))


def test_equal_misses_tell_nothing_apart():
    text = said(counted(20, 0, 0, 4))
    assert "they miss the same 4" in text
    assert "none tells the two apart" in text


def test_a_single_difference_is_told_as_one():
    assert "Only one encounter is detected by a single system, by Y" in said(counted(5, 0, 1, 2))


@pytest.mark.parametrize(
    ("counts", "phi"),
    [((50, 3, 3, 20), "+0.81"), ((4, 20, 20, 2), "-0.74"), ((40, 20, 20, 10), "+0.00")],
)
def test_phi_is_told_with_its_meaning(counts: tuple[int, int, int, int], phi: str):
    assert f"is phi {phi} (0: a miss of one says nothing about the other; 1: both" in said(
        counted(*counts)
    )


def test_an_uneven_split_may_be_chance():
    assert "X detects 4 and Y 2: two equally good systems could well differ so much" in said(
        counted(20, 4, 2, 5)
    )


def test_encounters_of_one_frame_are_not_tested_one_by_one():
    truth = [at(f, 50, track=f) for f in range(12)]
    text = said(result_of(make_dataset(truth, truth, truth[:2], n_frames=12)))
    assert "X detects 10 and Y 0. Most encounters are one frame long" in text
    assert "p =" not in text


def led(*lead_s: float) -> str:
    """The sentence where X matches a pedestrian so much earlier than Y, each of 2 s at 10 fps."""
    truth = [at(f, 10 + 8 * i, track=i) for i in range(len(lead_s)) for f in range(20)]
    x, y = (
        [box for box in truth if box.frame >= 10 * max(0, sign * lead_s[box.track])]
        for sign in (-1, 1)
    )
    return describe_lead(result_of(make_dataset(truth, x, y), proximity="none"))


def test_lead_time_is_told_by_mean_and_median():
    assert led(0.5, 0.3, 0.4) == (
        "Of 3 encounters that both match, X matches 3 first, Y 0, and 0 at once. X's lead is "
        "+0.40 s on average, median +0.40 s."
    )


@pytest.mark.parametrize(
    ("lead_s", "end"),
    [
        ((0.0, 0.0), "median +0.00 s: neither leads."),
        ((0.9, 0.0, 0.0), "the mean comes from those that differ."),
        ((1.8, -0.1, -0.1), "point in different directions, so neither leads clearly."),
    ],
)
def test_a_mean_of_few_is_no_lead(lead_s: tuple[float, ...], end: str):
    assert led(*lead_s).endswith(end)


def test_without_an_encounter_that_both_match_there_is_no_lead():
    assert "no lead time" in describe_lead(result_of(make_dataset(n_frames=2)))


def test_without_a_miss_or_an_encounter_little_is_said():
    assert said(counted(3, 0, 0, 0)) == "Neither system misses any of the 3 encounters that count."
    assert "No pedestrian came near enough" in said(counted(0, 0, 0, 0))


def fused() -> Result:
    """Tracks 1, 2, 3 in a second; X finds 1 and 2, Y finds 2 and 3 and has a false alarm."""
    truth = [at(f, c, track=t) for f in range(10) for t, c in ((1, 20), (2, 50), (3, 80))]
    x = [at(f, c) for f in range(10) for c in (20, 50)]
    y = [at(f, c) for f in range(10) for c in (50, 80)] + [at(4, 5)]
    return result_of(make_dataset(truth, x, y))


def test_gain_and_cost_of_a_fusion_are_told_against_the_better_system():
    either, both = describe_fusion(fusion_table(fused()))
    assert either == (
        "“X or Y” detects 3 of 3 encounters, 1 more than X alone, and costs 1 false-alert episode "
        "(+3600 an hour)."
    )
    assert both == (
        "“X and Y” detects 1 of 3 encounters, 1 fewer than X alone, and has as many false-alert "
        "episodes."
    )


def test_y_is_the_measure_where_it_detects_more():
    table = fusion_table(fused())
    table.loc[table["system"] == "y", "encounters_detected"] = 3
    table["gain_on_y"] = table["encounters_detected"] - 3
    assert "as many as Y alone, and has as many" in describe_fusion(table)[0]
    assert "2 fewer than Y alone, and saves 1 false-alert episode" in describe_fusion(table)[1]


def test_an_unknown_rate_is_not_told():
    table = fusion_table(fused())
    table["more_episodes_per_hour_than_x"] = np.nan
    assert describe_fusion(table)[0].endswith("costs 1 false-alert episode.")


def test_a_fusion_of_nothing_gains_nothing():
    table = fusion_table(result_of(make_dataset(n_frames=2)))
    assert "can neither gain nor lose" in describe_fusion(table)[0]


def missed(**params: object) -> Result:
    """Ten frames at 10 fps; X misses frames 2-3 and 8-9, Y nothing."""
    truth = [at(f, 50, track=3) for f in range(10)]
    x = [box for box in truth if box.frame not in (2, 3, 8, 9)]
    return result_of(make_dataset(truth, x, truth), **params)


def test_the_saliency_of_a_recording_is_taken_apart():
    x, y = describe_saliency(missed())
    assert x == (
        "X: the most salient of 2 events lasts 0.20 s and ends when 100% of the recording has "
        "passed, which gives it the weight 0.99: 0.20 s × 0.99 = 0.20 s."
    )
    assert y == "Y misses nobody by more than the tolerance: its saliency is 0."


def test_a_sum_of_events_is_told_as_one():
    x, _ = describe_saliency(missed(saliency_aggregate="sum"))
    assert x == "X: 2 events, 0.4 s in all; weighted by recency and added they make 0.25 s."


def test_recency_within_the_encounter_is_told_as_such():
    assert "of the encounter has passed" in describe_saliency(missed(saliency_scope="encounter"))[0]

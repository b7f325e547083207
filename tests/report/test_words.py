"""What is told of misses, fusion and saliency."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd
import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.metrics.venn import Venn, measure_exclusivity
from nvcore.notes import Note
from nvcore.report.words import at_best, fusion_gains, lead, misses, saliencies, saliency_caveat
from nvcore.settings.params import Params
from nvcore.tables.encounters.miss_classes import fusion_table


@pytest.fixture(scope="module")
def nothing() -> Result:
    return result_of(make_dataset(n_frames=2))


@pytest.mark.parametrize(
    ("both", "x_only", "y_only", "neither", "keys"),
    [
        (5, 2, 2, 1, "missed few_misses parted"),  # the paper's first figure
        (20, 12, 0, 5, "missed correlated parted"),
        (20, 0, 0, 4, "missed few_misses parted"),
        (3, 1, 0, 0, "missed parted"),  # phi is undefined
        (3, 0, 0, 0, "missed"),
        (0, 0, 0, 0, "missed"),
    ],
)
def test_whether_both_miss_the_same_pedestrians(
    nothing: Result, both: int, x_only: int, y_only: int, neither: int, keys: str
):
    venn = Venn(both, x_only, y_only, neither, distant=0)
    notes = misses(replace(nothing, venn=venn, exclusivity=measure_exclusivity(venn)))
    assert [note.key.removeprefix("encounters.") for note in notes] == keys.split()
    first = notes[0]
    assert (first["n"], first["by_x"], first["by_both"]) == (venn.n_near, y_only + neither, neither)


@pytest.mark.parametrize(
    ("x_only", "y_only", "p", "is_uneven"),
    [(12, 0, 2 / 2**12, True), (4, 2, 0.6875, False), (0, 1, None, False)],
)
def test_the_split_has_its_test(
    nothing: Result, x_only: int, y_only: int, p: float | None, is_uneven: bool
):
    venn = Venn(20, x_only, y_only, 5, distant=0)
    note = misses(replace(nothing, venn=venn, exclusivity=measure_exclusivity(venn)))[-1]
    of_split = {"x": x_only, "y": y_only, "p": p and pytest.approx(p), "is_uneven": is_uneven}
    assert note == Note("encounters.parted", **of_split, is_short=False)


def test_encounters_of_one_frame_are_not_tested_one_by_one():
    truth = [at(f, 50, track=f) for f in range(12)]
    note = misses(result_of(make_dataset(truth, truth, truth[:2], n_frames=12)))[-1]
    assert (note["is_short"], note["x"]) == (True, 10)


def test_lead_time_is_told_by_mean_and_median():
    lead_s = (1.8, -0.1, -0.1, 0.0)
    truth = [at(f, 10 + 8 * i, track=i) for i in range(len(lead_s)) for f in range(20)]
    x, y = (
        [box for box in truth if box.frame >= 10 * max(0, sign * lead_s[box.track])]
        for sign in (-1, 1)
    )
    note = lead(result_of(make_dataset(truth, x, y), proximity="none"))
    assert (note["n"], note["x"], note["y"]) == (4, 1, 2)
    assert (note["mean_s"], note["median_s"]) == (pytest.approx(0.4), pytest.approx(-0.05))
    nobody = lead(result_of(make_dataset(truth, [], y), proximity="none"))
    assert nobody == Note("encounters.lead", n=0)


@pytest.fixture
def fusion() -> pd.DataFrame:
    """Tracks 1, 2, 3 in a second; X finds 1 and 2, Y finds 2 and 3 and has a false alarm."""
    truth = [at(f, c, track=t) for f in range(10) for t, c in ((1, 20), (2, 50), (3, 80))]
    x = [at(f, c) for f in range(10) for c in (20, 50)]
    y = [at(f, c) for f in range(10) for c in (50, 80)] + [at(4, 5)]
    return fusion_table(result_of(make_dataset(truth, x, y)))


def test_gain_and_cost_of_a_fusion_are_told_against_the_better_system(fusion: pd.DataFrame):
    assert fusion_gains(fusion) == (
        fused("x_or_y", detected=3, gain=1, best="x", more_episodes=1),
        fused("x_and_y", detected=1, gain=-1, best="x", more_episodes=0),
    )
    fusion.loc[fusion["system"] == "y", "encounters_detected"] = 3
    fusion["gain_on_y"] = fusion["encounters_detected"] - 3
    assert fusion_gains(fusion) == (
        fused("x_or_y", detected=3, gain=0, best="y", more_episodes=0),
        fused("x_and_y", detected=1, gain=-2, best="y", more_episodes=-1),
    )


def fused(system: str, **values: object) -> Note:
    return Note("encounters.fused", system=system, n=3, **values)


def test_a_fusion_of_nothing_gains_nothing(nothing: Result):
    assert fusion_gains(fusion_table(nothing)) == (Note("encounters.no_fusion"),)


def missed(**params: object) -> Result:
    """Ten frames at 10 fps; X misses frames 2-3 and 8-9, Y nothing."""
    truth = [at(f, 50, track=3) for f in range(10)]
    x = [box for box in truth if box.frame not in (2, 3, 8, 9)]
    return result_of(make_dataset(truth, x, truth), **params)


def test_the_saliency_of_a_recording_is_taken_apart():
    x, y = saliencies(missed())
    assert y == Note("saliency.none", system="y")
    assert x == Note(
        "saliency.largest",
        system="x",
        n=2,
        duration_s=pytest.approx(0.2),
        weight_s=pytest.approx(0.2),
        is_by_risk=False,
        passed=pytest.approx(1),
        scope="recording",
        recency=pytest.approx(0.99, abs=0.005),
        saliency_s=pytest.approx(0.2, abs=0.005),
        relevance=Note("saliency.relevance", share=1),
    )
    assert saliencies(missed(saliency_scope="encounter"))[0]["scope"] == "encounter"
    in_seconds = saliencies(missed(recency_unit="seconds"))[0]
    assert in_seconds["rest_s"] == pytest.approx(0)
    truth = [at(f, 50, h=60 if f < 5 else 2, track=3) for f in range(10)]
    far = result_of(make_dataset(truth), proximity="height", tolerance=0)
    assert saliencies(far)[0]["relevance"]["share"] == 0.5


def test_the_sum_of_all_events_is_told_as_one():
    x, _ = saliencies(missed(saliency_aggregate="sum"))
    assert x == Note(
        "saliency.sum",
        system="x",
        n=2,
        duration_s=pytest.approx(0.4),
        saliency_s=pytest.approx(0.25, abs=0.005),
        relevance=Note("saliency.relevance", share=1),
    )


def test_of_several_recordings_there_is_a_mean():
    places = [Place(range(10)), Place(range(10))]
    truth = [at(f, 50, track=3, recording=r) for r in (0, 1) for f in range(10)]
    x = [box for box in truth if box.recording == 0 or box.frame < 8]
    several = make_dataset(truth, x, truth, places=places)
    largest, _ = saliencies(result_of(several))
    assert (largest["n"], largest["mean_s"]) == (1, pytest.approx(0.1, abs=0.005))
    total, _ = saliencies(result_of(several, saliency_aggregate="sum"))
    assert (total["mean_s"], total["saliency_s"]) == pytest.approx((0.1, 0.2), abs=0.005)


def test_with_risk_an_event_says_what_it_weighs():
    by_risk = {"saliency_weight": "risk", "proximity": "none"}
    largest, _ = saliencies(missed(**by_risk))
    # the pedestrian stands in the middle: weighted distance over half the width is 1
    assert (largest["is_by_risk"], largest["weight_s"]) == (True, pytest.approx(0.2))
    total, _ = saliencies(missed(**by_risk, saliency_aggregate="sum"))
    assert total["weight_s"] == pytest.approx(0.4)


def test_what_follows_from_the_paper_s_rule_is_told_while_it_holds():
    assert saliency_caveat(Params()) == (Note("saliency.side_by_side"),)
    assert saliency_caveat(Params(saliency_of="each")) == ()


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

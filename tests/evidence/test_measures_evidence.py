from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from drives import by_figure, drives
from scipy.signal import lfilter

from nvcore.comparison.compare import compare
from nvcore.comparison.measures.table import measure_of
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence.bootstrap import bootstrap_difference, ratio, studentised_tests
from nvcore.evidence.measures import (
    COLUMNS,
    Judged,
    UnitMeasure,
    correct_together,
    judge_measure,
    run_together,
    significance_table,
)
from nvcore.evidence.paired_tests import swap_test
from nvcore.evidence.units import STRETCH, block_length, find_units
from nvcore.settings.params import Params
from nvcore.settings.primary import DEFAULT, Primary

NUMBERS = ["x", "y", "difference", "low", "high", "p", "p_corrected", "effect"]


def reordered(dataset: Dataset, order: np.ndarray) -> Dataset:
    """The same recordings in another order; all have 20 frames."""
    n_frames = 20
    new_place = np.argsort(order)
    boxes, at_frame = dataset.boxes.copy(), dataset.boxes["frame_index"].to_numpy()
    boxes["frame_index"] = new_place[at_frame // n_frames] * n_frames + at_frame % n_frames
    recordings = dataset.recordings.iloc[order].reset_index(drop=True)
    frames = [np.arange(n_frames)] * len(order)
    return dataset_from_tables(recordings, frames, boxes, dataset.systems)


def test_the_table_has_every_measure_with_its_evidence() -> None:
    result = result_of(drives(12))
    table = significance_table(result)
    assert tuple(table.columns) == COLUMNS
    assert table["figure"].tolist() == [
        "encounters_detected", "encounters_detected_by_unit", "mean_similarity", "share_low",
        "lost_s_per_min", "saliency", "severity_s_per_encounter", "false_alert_episodes_per_hour",
    ]  # fmt: skip
    assert (table["low"] < table["difference"]).all()
    assert (table["difference"] < table["high"]).all()
    assert table[[name for name in NUMBERS if name != "p_corrected"]].notna().all().all()
    assert table["n"].tolist() == [60, *[12] * 7]
    assert table["unit"].tolist() == ["encounters", *["recordings"] * 7]
    assert table["scope"].tolist() == ["these recordings", *["other recordings"] * 7]
    assert (table["note"] == "").all()


def test_the_measures_are_those_of_the_scorecard() -> None:
    result = result_of(drives(12))
    table = by_figure(result)
    for letter, system in (("x", result.x), ("y", result.y)):
        assert table.loc["mean_similarity", letter] == pytest.approx(system.summary.mean)
        assert table.loc["share_low", letter] == pytest.approx(system.summary.share_low)
        assert table.loc["false_alert_episodes_per_hour", letter] == pytest.approx(
            system.false_alarm_summary.episodes_per_hour
        )
        assert table.loc["saliency", letter] == pytest.approx(
            measure_of("saliency").of(result, system)
        )
        share = system.encounters["is_detected"].sum() / result.venn.n_near
        assert table.loc["encounters_detected", letter] == pytest.approx(share)
        assert table.loc["encounters_detected_by_unit", letter] == pytest.approx(share)
    assert table.loc["encounters_detected", "p"] == result.exclusivity.mcnemar_p


def test_no_hypothesis_is_tested_twice_and_the_primary_measure_by_itself() -> None:
    table = by_figure(result_of(drives(12)))
    repeated = ["encounters_detected", "lost_s_per_min"]
    assert table.loc[repeated, "p"].notna().all()
    assert table.loc[repeated, "p_corrected"].isna().all()
    family = table.drop(index=repeated)
    primary = family.loc[DEFAULT]
    assert primary["p_corrected"] == primary["p"]
    others = family.drop(index=DEFAULT)
    assert (others["p_corrected"] >= np.maximum(others["p"], primary["p"])).all()


def test_a_primary_measure_that_was_changed_is_one_of_all() -> None:
    result = result_of(drives(12))
    settings = replace(result.dataset.settings, primary=Primary("saliency", is_changed=True))
    changed = replace(result, dataset=result.dataset.with_settings(settings))
    table, plain = by_figure(changed), significance_table(result, primary="")
    assert table["p_corrected"].tolist() == pytest.approx(
        plain["p_corrected"].tolist(), nan_ok=True
    )
    assert table.loc["saliency", "p_corrected"] >= table.loc["saliency", "p"]


def unit_measure(key: str, parts: np.ndarray) -> UnitMeasure:
    """The mean of some parts, one a recording."""
    ones = np.ones(len(parts))
    x, y = np.column_stack([parts, ones]), np.column_stack([0 * parts, ones])
    return UnitMeasure(key, key, "higher", x, y)


def test_measures_that_say_the_same_cost_each_other_nothing() -> None:
    parts = np.random.default_rng(4).normal(0.5, 1, 12)
    tests = run_together(
        [unit_measure(key, factor * parts) for key, factor in (("a", 1), ("b", 3))]
    )
    corrected = correct_together(tests, "")
    assert tests["a"].p == tests["b"].p
    assert corrected == {"a": pytest.approx(tests["a"].p), "b": pytest.approx(tests["b"].p)}


def test_without_a_difference_one_claim_in_twenty_at_the_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    few = partial(studentised_tests, n_resamples=1000)
    monkeypatch.setattr("nvcore.evidence.measures.studentised_tests", few)
    rng, n_runs = np.random.default_rng(8), 400
    primary_first = together = 0
    for _ in range(n_runs):
        shared = rng.normal(0, 1, (9, 1))
        parts = shared + rng.normal(0, 1, (9, 5))
        measures = [unit_measure(str(i), of) for i, of in enumerate(parts.T)]
        tests = run_together(measures)
        assert set(tests) == set("01234")
        primary_first += min(correct_together(tests, "2").values()) <= 0.05
        together += min(correct_together(tests, "").values()) <= 0.05
    # of 400, more than 32 come in one of 200 runs if 5 % is what is true
    assert primary_first <= 32
    assert 5 <= together <= 32


@pytest.mark.parametrize(("n", "unit", "has_p"), [(5, "blocks", False), (6, "recordings", True)])
def test_p_speaks_of_other_drives_from_six_recordings_on(n: int, unit: str, has_p: bool) -> None:
    table = by_figure(result_of(drives(n))).drop(index="encounters_detected")
    assert set(table["unit"]) == {unit}
    assert table["p"].notna().any() == has_p
    least_p = table.loc["mean_similarity", "least_p"]
    assert least_p == 2 / 2**6 if has_p else np.isnan(least_p)


def test_p_is_the_same_without_intervals() -> None:
    result = result_of(drives(12))
    whole, brief = significance_table(result), significance_table(result, has_intervals=False)
    assert brief["p_corrected"].equals(whole["p_corrected"])
    assert brief["low"].iloc[1:].isna().all()


def test_skewed_differences_do_not_pass_for_a_difference() -> None:
    # a system that errs a little more in most recordings and gravely less in a few is no worse
    rng = np.random.default_rng(3)
    n, n_runs = 16, 150
    units = find_units(result_of(drives(n)))
    n_swapped = n_judged = 0
    for skewed in rng.lognormal(0, 1, (n_runs, n)) - np.exp(0.5):
        x, y = np.column_stack([skewed, np.ones(n)]), np.column_stack([0 * skewed, np.ones(n)])
        measure = UnitMeasure("share", "share", "higher", x, y)
        row = judge_measure(measure, units, has_interval=False)
        exchanged = swap_test(x, y, ratio).p
        assert row.p >= exchanged
        assert ("very skewed" in row.note) == (exchanged <= 0.05 < row.p)
        n_swapped += exchanged <= 0.05
        n_judged += row.p <= 0.05
    assert n_swapped / n_runs > 0.08  # the exchange alone
    assert n_judged / n_runs < 0.08


def test_ten_recordings_for_x_and_one_for_neither_are_evidence() -> None:
    parts = np.r_[np.ones(10), 0.0]
    x, y = np.column_stack([parts, np.ones(11)]), np.column_stack([0 * parts, np.ones(11)])
    measure = UnitMeasure("share", "share", "higher", x, y)
    row = judge_measure(measure, find_units(result_of(drives(11))))
    assert row.p <= 0.01


def test_p_of_similarity_is_the_sign_flip_test_of_the_recordings_traces() -> None:
    result = result_of(drives(12))
    difference = (result.x.similarity - result.y.similarity).reshape(12, 20).mean(axis=1)
    difference = difference[find_units(result).recording]  # draws are made in this order
    row = by_figure(result).loc["mean_similarity"]
    flips = swap_test(difference[:, None], np.zeros((12, 1)), lambda sums: sums[..., 0])
    (skewed,) = studentised_tests(difference[:, None])
    assert row["p"] == pytest.approx(max(flips.p, skewed.p))
    assert row["effect"] == pytest.approx(difference.mean() / difference.std(ddof=1))
    assert row["effect_name"] == "Cohen's d_z"


def test_the_effect_of_units_of_different_length_has_the_sign_of_the_difference() -> None:
    x = np.array([[90, 100], [1, 10], [2, 10], [1, 10], [3, 10], [2, 10]], dtype=float)
    y = np.array([[50, 100], [2, 10], [4, 10], [3, 10], [5, 10], [4, 10]], dtype=float)
    units = find_units(result_of(drives(6)))
    row = judge_measure(UnitMeasure("share", "share", "higher", x, y), units)
    rows = np.arange(6)
    parts = []  # pseudo-values, the plain way
    whole = x[:, 0].sum() / x[:, 1].sum() - y[:, 0].sum() / y[:, 1].sum()
    for i in rows:
        a, b = x[rows != i], y[rows != i]
        without = a[:, 0].sum() / a[:, 1].sum() - b[:, 0].sum() / b[:, 1].sum()
        parts.append(6 * whole - 5 * without)
    assert (x[:, 0] / x[:, 1] - y[:, 0] / y[:, 1]).mean() < 0 < row.difference
    assert row.effect == pytest.approx(whole / np.std(parts, ddof=1))
    assert row.effect > 0


def test_swapping_x_and_y_turns_the_signs_and_nothing_else() -> None:
    dataset = drives(12)
    there = by_figure(compare(dataset, Params(), x="x", y="y"))
    back = by_figure(compare(dataset, Params(), x="y", y="x"))
    assert back["difference"].tolist() == pytest.approx((-there["difference"]).tolist())
    assert back["low"].tolist() == pytest.approx((-there["high"]).tolist())
    assert back["high"].tolist() == pytest.approx((-there["low"]).tolist())
    assert back["p"].tolist() == pytest.approx(there["p"].tolist())
    effects = [1 / there["effect"].iloc[0], *(-there["effect"].iloc[1:])]
    assert back["effect"].tolist() == pytest.approx(effects)


def test_the_order_of_the_recordings_changes_nothing() -> None:
    dataset = drives(18)  # more than 16: random exchanges as well
    order = np.random.default_rng(1).permutation(18)
    there, back = (by_figure(result_of(drawn)) for drawn in (dataset, reordered(dataset, order)))
    assert not np.array_equal(order, np.arange(18))
    for name in NUMBERS:
        assert back[name].tolist() == pytest.approx(there[name].tolist(), rel=1e-9, nan_ok=True), (
            name
        )


def test_one_recording_is_judged_by_blocks_and_says_what_that_means() -> None:
    rng = np.random.default_rng(0)
    n = 600
    is_lost = np.repeat(rng.random(n // 10) < 0.3, 10)
    truth = [at(frame, 50, track=frame // 10) for frame in range(n)]
    y = [at(frame, 50) for frame in range(n) if not is_lost[frame]]
    table = by_figure(result_of(make_dataset(truth, truth, y, n_frames=n)))
    row = table.loc["mean_similarity"]
    assert row["unit"] == "blocks"
    assert row["low"] > 0
    assert np.isnan(row["p"])
    assert row["scope"] == "these recordings"
    assert "one recording only: intervals over blocks of time hold within" in row["note"]
    saliency = table.loc["saliency"]
    assert saliency[["low", "high", "p"]].isna().all()
    assert saliency["y"] > saliency["x"] == 0
    assert "cannot be shared out to blocks" in saliency["note"]
    summed = result_of(make_dataset(truth, truth, y, n_frames=n), saliency_aggregate="sum")
    row = by_figure(summed).loc["saliency"]
    assert row["y"] == pytest.approx(summed.y.saliency_s)
    assert row["high"] < 0


def test_a_short_recording_has_words_instead_of_measures() -> None:
    truth = [at(frame, 50, track=1) for frame in range(6)]
    table = by_figure(result_of(make_dataset(truth, truth[:2], truth[:4], n_frames=6)))
    assert table[["low", "high", "p", "p_corrected"]].isna().all().all()
    assert table["effect"].iloc[1:].isna().all()  # of a few blocks it says nothing
    assert table["note"].str.contains("too few").sum() >= 4
    assert (table["method"] == "").all()
    assert table["difference"].notna().all()


def test_equal_systems_are_said_to_be_the_same() -> None:
    truth = [at(f, 50, track=1, recording=r) for r in range(10) for f in range(5)]
    dataset = make_dataset(truth, truth[::2], truth[::2], places=[Place(range(5))] * 10)
    table = by_figure(result_of(dataset))
    assert (table["difference"] == 0).all()
    assert table.loc["mean_similarity", "note"].startswith("X and Y are the same in all ")
    assert table[["low", "p", "effect"]].iloc[1:].isna().all().all()


def test_encounters_of_one_frame_are_called_frames() -> None:
    truth = [at(f, 50, track=f, recording=r) for r in range(10) for f in range(4)]
    dataset = make_dataset(truth, truth, truth[::2], places=[Place(range(4))] * 10)
    result = result_of(dataset)
    table = by_figure(result)
    row = table.loc["encounters_detected"]
    assert "most encounters are one frame long" in row["note"]
    assert result.exclusivity.mcnemar_p == pytest.approx(2 / 2**20)
    assert row[["low", "high", "p", "p_corrected", "effect"]].isna().all()
    assert row["difference"] == 0.5
    assert table.loc["encounters_detected_by_unit", "difference"] == 0.5


def test_another_measure_from_sums_over_the_same_units_can_be_added() -> None:
    result = result_of(drives(12))
    units = find_units(result)
    n_pedestrians = np.bincount(units.unit_of_frame, weights=result.n_truth)
    missed = [
        np.column_stack(
            [
                np.bincount(units.unit_of_frame, weights=result.n_truth - system.matched),
                n_pedestrians,
            ]
        )
        for system in (result.x, result.y)
    ]
    extra = UnitMeasure("miss_rate", "miss rate", "lower", *missed)
    tested = run_together([extra])["miss_rate"]
    judged = Judged(judge_measure(extra, units, tested=tested), tested)
    table = significance_table(result, [judged], units=units, primary="")
    row = table.iloc[-1]
    assert row["figure"] == "miss_rate"
    assert row["x"] == pytest.approx(1 - result.x.matched.sum() / result.n_truth.sum())
    assert row["low"] < row["difference"] < row["high"] < 0
    assert row["p_corrected"] >= row["p"]
    # one more p-value to correct for
    plain = significance_table(result, primary="")["p_corrected"]
    assert (table["p_corrected"].iloc[:-1].dropna() >= plain.dropna()).all()


def test_blocks_hold_the_true_difference_and_keep_the_level_about_as_they_say() -> None:
    # traces in which a frame resembles the one before (0.8); single frames would hold it in 50 %
    rng = np.random.default_rng(12)
    n, n_runs = 3000, 300
    noise = rng.normal(0, 0.05, (n_runs, n + 300))
    traces = lfilter([1], [1, -0.8], noise, axis=1)[:, 300:]
    held = held_by_frames = rejected = 0
    for trace in traces:
        n_blocks = n // (STRETCH * block_length(trace, np.array([0, n])))
        block = np.arange(n) * n_blocks // n
        sums, size = np.bincount(block, weights=trace), np.bincount(block)
        x, y = np.column_stack([sums, size]), np.column_stack([0 * sums, size])
        interval = bootstrap_difference(x, y, n_resamples=599)
        held += interval.low <= 0 <= interval.high
        held_by_frames += abs(trace.mean()) <= 1.96 * trace.std() / np.sqrt(n)
        rejected += swap_test(x, y, ratio, n_permutations=599).p <= 0.05
    assert 0.90 <= held / n_runs <= 0.98
    assert rejected / n_runs <= 0.10
    assert held_by_frames / n_runs < 0.65

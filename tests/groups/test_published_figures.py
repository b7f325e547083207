"""A thesis on alerts, recomputed from what it prints, to the printed digits.

Reaction times of 11 persons as mean and SD, drives of four groups of 3 with control runs by the
authors. What it publishes stands beside (docs/groups.md says why some of it differs).
"""

from __future__ import annotations

from itertools import chain
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import nvcore as nv
from nvcore.evidence.groups import GroupComparison
from nvcore.evidence.groups.analyses import Groups, anova
from nvcore.evidence.groups.permutation import permute_between

REACTIONS = pd.DataFrame(
    {
        "condition": ["visual", "audio", "haptic"],
        "n": 11,
        "mean": [1678, 2171, 1245],
        "sd": [755.1, 766.2, 389.5],
    }
)
PUBLISHED = {"reactions_p": 0.0098, "times_f": 1.78, "times_p": 0.209}
PRINTED_MEANS = {"times": {"none": 243}, "violations": {"none": 14.7}}
TIMES = {
    "visual": ["4:42", "4:10", "4:43"],
    "audio": ["5:10", "5:03", "4:31"],
    "haptic": ["4:30", "3:44", "5:00"],
    "none": ["3:39", "4:42", "3:37"],
    "control": ["4:52", "4:40", "4:48"],
}
VIOLATIONS = {"visual": [4, 7, 2], "audio": [2, 3, 3], "haptic": [3, 4, 11], "none": [19, 7, 17]}
FEEDBACK = dict.fromkeys(("visual", "audio", "haptic"), "feedback")


def seconds(text: str) -> int:
    minutes, rest = text.split(":")
    return 60 * int(minutes) + int(rest)


def drives() -> pd.DataFrame:
    rows = [
        (f"{condition}{run}", condition, seconds(time), VIOLATIONS.get(condition, [None] * 3)[run])
        for condition, times in TIMES.items()
        for run, time in enumerate(times)
    ]
    return pd.DataFrame(rows, columns=["participant", "condition", "duration_s", "violations"])


def row_of(result: GroupComparison, key: str) -> pd.Series:
    return result.tests.set_index("test").loc[key]


def pairs_of(result: GroupComparison, key: str) -> pd.DataFrame:
    own = result.pairs[result.pairs["test"] == key]
    return own.set_index(own["first"] + "-" + own["second"])


@pytest.fixture(scope="module")
def reactions() -> GroupComparison:
    return nv.groups(REACTIONS, correlation=0.7)


@pytest.fixture(scope="module")
def violations() -> GroupComparison:
    return nv.groups(drives(), "violations")


# reaction times


def test_the_analysis_of_variance_of_the_reaction_times(reactions: GroupComparison):
    test = row_of(reactions, "anova")
    assert (test["df_between"], test["df_within"]) == (2, 30)
    assert f"{test['value']:.4f}" == "5.4120"
    assert f"{test['p']:.6f}" == "0.009842"
    assert f"{test['p']:.4f}" == f"{PUBLISHED['reactions_p']:.4f}"
    assert f"{test['eta2']:.3f} {test['omega2']:.3f} {test['f']:.2f}" == "0.265 0.211 0.60"


def test_its_sums_of_squares():
    within = 10 * (REACTIONS["sd"] ** 2).sum()
    between = 11 * ((REACTIONS["mean"] - REACTIONS["mean"].mean()) ** 2).sum()
    assert (f"{between:,.0f}", f"{within:,.0f}") == ("4,722,718", "13,089,487")
    assert f"{within / 30:,.1f}" == "436,316.2"


def test_sd_with_n_would_give_another_p_so_the_printed_ones_are_with_n_minus_1():
    n, mean, sd = REACTIONS[["n", "mean", "sd"]].to_numpy(dtype=float).T
    assert f"{anova(Groups(n, mean, sd * np.sqrt(11 / 10))).p:.4f}" == "0.0142"


def test_tukeys_comparisons_of_the_reaction_times(reactions: GroupComparison):
    pairs = pairs_of(reactions, "tukey")
    assert [f"{q:.4f}" for q in pairs["value"]] == ["2.4754", "2.1741", "4.6495"]
    assert [f"{p:.4f}" for p in pairs["p_corrected"][:2]] == ["0.2036", "0.2883"]
    assert f"{pairs['p_corrected'].iloc[2]:.5f}" == "0.00707"
    ends = pairs[["difference", "low", "high"]].round().astype(int).to_numpy().tolist()
    assert ends == [[-493, -1187, 201], [433, -261, 1127], [926, 232, 1620]]
    half = (pairs["high"] - pairs["low"]) / 2
    assert [f"{each:.1f}" for each in half] == ["694.4"] * 3
    q_crit = half.iloc[0] / np.sqrt(436_316.2 / 11)
    assert f"{q_crit:.4f}" == "3.4864"


def test_with_unequal_variances_welch_and_games_howell_fit(reactions: GroupComparison):
    assert (reactions.fits, reactions.fits_pairs) == ("welch", "games_howell")
    test = row_of(reactions, "welch")
    assert f"{test['value']:.3f} {test['df_within']:.2f} {test['p']:.4f}" == "6.607 17.90 0.0071"
    pairs = pairs_of(reactions, "games_howell")
    shown = [f"{p:.3f}" for p in pairs["p_corrected"][:2]]
    assert [*shown, f"{pairs['p_corrected'].iloc[2]:.4f}"] == ["0.303", "0.241", "0.0075"]
    ratio = reactions.assumptions.set_index("check").loc["variance_ratio", "value"]
    assert f"{ratio:.1f}" == "3.9"


def test_a_paired_analysis_would_depend_on_the_correlation(reactions: GroupComparison):
    assert (pairs_of(reactions, "assumed")["p"] < 0.03).all()
    of_none = pairs_of(nv.groups(REACTIONS, correlation=0), "assumed")
    assert (of_none["p"] < 0.05).tolist() == [False, False, True]


def test_that_the_same_persons_may_stand_in_all_is_said(reactions: GroupComparison):
    assert reactions.design == "unknown"
    assert reactions.sentences[1].startswith("From means and SD, it cannot be known whether")


# times of the drives


def of_times(table: pd.DataFrame) -> Any:
    by_condition = table.groupby("condition", sort=False)["duration_s"]
    return anova(Groups(*by_condition.agg(["size", "mean", "std"]).to_numpy(dtype=float).T))


def test_the_times_of_four_groups_and_with_the_control_runs_as_a_fifth():
    four = of_times(drives().query("condition != 'control'"))
    assert (four.df_between, four.df_within) == (3, 8)
    assert f"{four.value:.4f} {four.p:.4f}" == "1.7219 0.2395"
    five = of_times(drives())
    assert (five.df_between, five.df_within) == (4, 10)
    assert f"{five.value:.4f} {five.p:.4f}" == "1.8968 0.1876"


def test_the_published_f_and_p_are_of_five_groups():
    assert f"{stats.f.sf(PUBLISHED['times_f'], 4, 10):.4f}" == "0.2094"
    assert f"{stats.f.sf(PUBLISHED['times_f'], 3, 8):.3f}" == "0.229"
    assert abs(0.2094 - PUBLISHED["times_p"]) < 0.0005


def test_one_row_of_the_drives_without_feedback_is_misprinted():
    mean = drives().groupby("condition")["duration_s"].mean()["none"]
    assert f"{mean:.0f}" == f"{seconds('3:59')}"
    assert mean != pytest.approx(PRINTED_MEANS["times"]["none"], abs=1)
    mended = drives().replace({"duration_s": {seconds("3:37"): seconds("3:47")}})
    assert f"{mended.groupby('condition')['duration_s'].mean()['none']:.1f}" == "242.7"
    test = of_times(mended)
    assert f"{test.value:.4f} {test.p:.4f}" == "1.7790 0.2096"


@pytest.mark.parametrize(("run", "mended"), [(0, 20), (1, 8), (2, 18)])
def test_the_printed_mean_of_violations_fits_three_other_rows_alike(run: int, mended: int):
    own = [*VIOLATIONS["none"]]
    assert f"{np.mean(own):.1f}" == "14.3"
    own[run] = mended
    assert f"{np.mean(own):.1f}" == f"{PRINTED_MEANS['violations']['none']:.1f}"


# violations, which the report does not test


def test_the_violations_by_formula(violations: GroupComparison):
    test = row_of(violations, "anova")
    assert f"{test['value']:.4f} {test['p']:.4f}" == "4.8093 0.0337"
    test = row_of(violations, "kruskal")
    assert f"{test['value']:.3f} {test['p']:.3f}" == "6.676 0.083"
    pairs = pairs_of(violations, "tukey")
    shown = pairs[pairs["p_corrected"] <= 0.05]
    assert [f"{p:.3f}" for p in shown["p_corrected"]] == ["0.033"]
    assert [*shown.index] == ["audio-none"]


def test_the_violations_by_all_partitions(violations: GroupComparison):
    assert violations.fits == "permutation"
    of_welch, of_ranks = (row_of(violations, key) for key in ("permutation", "permutation_ranks"))
    assert (of_welch["n_reached"], of_welch["n_ways"], of_ranks["n_ways"]) == (1220, 15_400, 15_400)
    assert f"{of_welch['p']:.4f} {of_ranks['p']:.4f}" == "0.0792 0.0556"
    assert of_welch["is_exact"]
    of_f = permute_between([np.array(own, float) for own in VIOLATIONS.values()], has_welch=False)
    assert f"{of_f.p:.4f}" == "0.0329"


def test_feedback_against_none():
    result = nv.groups(drives(), "violations", rename=FEEDBACK)
    assert result.groups["n"].tolist() == [9, 3]
    assert result.pairs["difference"].iloc[0] == pytest.approx(-10)
    of_t, of_ranks = (row_of(result, key) for key in ("permutation", "permutation_ranks"))
    assert (of_t["n_reached"], of_t["n_ways"], f"{of_t['p']:.4f}") == (12, 220, "0.0545")
    assert (of_ranks["n_reached"], of_ranks["n_ways"], f"{of_ranks['p']:.4f}") == (6, 220, "0.0273")
    with_feedback = [*chain(*(VIOLATIONS[key] for key in FEEDBACK))]
    of_mean = permute_between([np.array(own, float) for own in (with_feedback, VIOLATIONS["none"])],
                              has_welch=False)  # fmt: skip
    assert (of_mean.n_reached, of_mean.n_ways, f"{of_mean.p:.4f}") == (3, 220, "0.0136")
    assert 27 - stats.mannwhitneyu(VIOLATIONS["none"], with_feedback).statistic == 1.5

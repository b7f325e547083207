"""Which test fits, and what is said and shown."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from inputs import nvcore, write

import nvcore as nv
from nvcore.common.arguments.groups import GroupArguments
from nvcore.common.errors import ParameterError
from nvcore.evidence.groups.text import FILES

RNG = np.random.default_rng(3)


def persons(
    n: int, k: int, *, column: str = "value", spread: float = 1.0, same: bool = True
) -> pd.DataFrame:
    """Positive numbers that rise with the condition; the same persons, or others in each."""
    own = RNG.normal(0, spread, n)
    rows = [
        (f"P{i}" if same else f"P{i}c{j}", "abcdefgh"[j], np.exp(own[i] + 0.6 * j + noise))
        for i in range(n)
        for j, noise in enumerate(RNG.normal(0, 0.2, k))
    ]
    return pd.DataFrame(rows, columns=["participant", "condition", column])


# which test fits


def test_the_same_persons_are_compared_with_themselves_and_never_as_independent_groups():
    result = nv.groups(persons(9, 3))
    assert (result.design, result.fits, result.fits_pairs) == ("same", "repeated_gg", "paired")
    assert not {"anova", "welch", "kruskal", "permutation"} & {*result.tests["test"]}
    assert not {"tukey", "games_howell"} & {*result.pairs["test"]}
    assert "The same 9 persons appear in all conditions" in str(result)
    assert result.tests["fits"].sum() == 1


def test_times_of_the_same_persons_are_compared_as_logarithms_of_their_means():
    table = persons(9, 3, column="rt_ms")
    twice = pd.concat([table, table.assign(rt_ms=table["rt_ms"] * 4)])  # geometric mean: twice
    result = nv.groups(twice)
    logs = table.assign(rt_ms=np.log(table["rt_ms"]))
    expected = nv.groups(logs, "rt_ms", scale="numbers")
    names = ["value", "p", "df_within"]
    assert np.allclose(result.tests[names], expected.tests[names], equal_nan=True)
    own = result.pairs[result.pairs["test"] == "paired"]
    of_logs = expected.pairs[expected.pairs["test"] == "paired"]
    assert np.log(own["ratio_low"]).tolist() == pytest.approx(of_logs["low"].tolist())
    assert own["difference"].isna().all()
    means = logs.groupby("condition")["rt_ms"].mean()
    assert result.groups["geometric_mean"].tolist() == pytest.approx([*2 * np.exp(means)])
    assert "Each participant counts once per condition, with the mean of the log times." in str(
        result
    )
    assert re.search(r"[Bb] takes \d\.\d\d times as long as a", str(result))


def test_few_persons_and_counts_are_exchanged_within_persons():
    assert nv.groups(persons(5, 3)).fits == "within"
    counts = persons(9, 3).assign(value=lambda table: np.ceil(table["value"]))
    result = nv.groups(counts.assign(value=counts["value"].clip(upper=99)))
    assert (result.scale, result.fits, result.fits_pairs) == ("counts", "within", "exchanged")


@pytest.mark.parametrize(
    ("n", "factor", "fits", "reason"),
    [
        (6, 1.0, "anova", "Nothing speaks against equal variances (the largest is 1.0 times"),
        (6, 4.0, "welch", "The variances differ (the largest is 16.0 times the smallest). Welch"),
        (5, 1.0, "welch", "The smallest group has 5 values, too few to check whether the varia"),
        (6, 0.0, "permutation", "A group has no spread. A permutation of Welch's F fits"),
        (5, 0.0, "permutation", "A group has no spread. A permutation of Welch's F fits"),
    ],
)
def test_independent_groups_by_their_size_and_variances(
    n: int, factor: float, fits: str, reason: str
):
    z = np.linspace(-1, 1, n)
    rows = [("a", z), ("b", factor * z + 0.3)]
    table = pd.concat(pd.DataFrame({"condition": name, "value": own}) for name, own in rows)
    result = nv.groups(table)
    assert (result.design, result.fits) == ("unknown", fits)
    assert any(sentence.startswith(reason) for sentence in result.sentences)
    if factor:
        typed = table.groupby("condition")["value"].agg(n="size", mean="mean", sd="std")
        assert nv.groups(typed.reset_index()).fits == fits


def test_participants_of_one_condition_each_make_independent_groups():
    result = nv.groups(persons(6, 2, same=False))
    assert result.design == "different"
    assert "No participant appears in two conditions" in str(result)


def test_counts_go_by_permutation_however_many():
    table = pd.DataFrame({"condition": ["a", "b"] * 12, "value": [0, 1, 2, 3] * 6})
    result = nv.groups(table)
    assert result.fits == result.fits_pairs == "permutation"
    assert "Counts are not normally distributed. A permutation of Welch's F fits" in str(result)
    assert nv.groups(table, scale="numbers").fits == "anova"


def test_incomplete_persons_are_left_out_and_named():
    table = persons(8, 3).iloc[:-1]
    result = nv.groups(table)
    assert (result.design, result.groups["n"].tolist()) == ("same", [7, 7, 7])
    assert "Left out: participants without a value in some condition (P7)." in result.sentences


def test_where_some_persons_stand_in_several_conditions_nothing_fits():
    table = persons(8, 2, same=False)
    table.loc[table["participant"] == "P0c1", "participant"] = "P0c0"
    result = nv.groups(table)
    assert (result.design, result.fits) == ("mixed", "")
    assert len(result.tests) == len(result.pairs) == len(result.sizes) == 0
    assert "1 of 15 participants appears in several conditions" in str(result)
    assert "P0c0" not in str(result)


# what is undefined


def test_one_condition_has_means_and_no_test():
    for table in (
        persons(4, 1),
        persons(4, 1).drop(columns="participant"),
        pd.DataFrame({"condition": ["a"], "n": [3], "mean": [1.0], "sd": [1.0]}),
    ):
        result = nv.groups(table)
        assert len(result.groups) == 1
        assert result.groups["low"].notna().all()
        assert result.sentences[-1].endswith("are not tested: there is one condition alone.")


def test_no_value_at_all_is_said():
    result = nv.groups(pd.DataFrame({"condition": ["a"], "value": [np.nan]}), "value")
    assert result.sentences[-1].endswith("are not tested: there is no value.")
    assert len(result.groups) == 0


def test_one_person_in_each_group_or_in_all_has_no_test():
    alone = pd.DataFrame({"condition": ["a", "b"], "value": [1.5, 2.5]})
    for table in (alone, alone.assign(participant=["A", "B"])):
        result = nv.groups(table)
        assert result.tests["p"].drop(2).isna().all()  # Kruskal-Wallis of two is 0.32
        assert result.groups["sd"].isna().all()
        assert "not tested: a group has no spread, or one value alone." in str(result)
    counts = alone.assign(value=[1, 2])
    assert "not tested: there is nothing to exchange." in str(nv.groups(counts))
    counts = pd.concat([counts, counts.iloc[1:]])
    assert "not tested: a group has one value alone." in str(nv.groups(counts))
    assert nv.groups(alone.assign(participant="A")).design == "mixed"
    typed = pd.DataFrame({"condition": ["a", "b"], "n": 1, "mean": [1, 2], "sd": np.nan})
    result = nv.groups(typed, difference=1.0)
    assert result.tests["p"].isna().all()
    assert "too few to check whether the variances are equal" in str(result)
    assert "would show a difference" not in str(result)


def test_equal_values_have_no_test():
    for same in (True, False):
        table = persons(6, 3, same=same).assign(value=1.5)
        result = nv.groups(table)
        assert result.tests["p"].isna().all()
        assert result.pairs["p_corrected"].isna().all()
        assert "are not tested" in str(result)


@pytest.mark.parametrize("n", [11, 2**53 - 1])
def test_an_sd_whose_powers_vanish_is_no_spread(n: int):
    table = pd.DataFrame({"condition": ["a", "b"], "n": [11, n], "mean": 0.0, "sd": [1.0, 1e-160]})
    tests = nv.groups(table).tests.set_index("test")
    assert tests.loc["welch", "reason"] == "a group has no spread, or one value alone"
    assert tests.loc["anova", "p"] == 1


def test_groups_without_spread_that_differ_are_permuted_all_the_same():
    table = pd.DataFrame({"condition": ["a", "b"] * 4, "value": [1.5, 2.5] * 4})
    result = nv.groups(table)
    test = result.tests[result.tests["fits"]].iloc[0]
    assert (test["test"], test["p"]) == ("permutation", pytest.approx(1 / 35))
    assert np.isnan(test["value"])


def test_p_cannot_be_small_for_the_smallest_groups_which_is_said():
    table = pd.DataFrame({"condition": ["a"] * 3 + ["b"] * 3, "value": [1, 2, 3, 17, 18, 19]})
    assert "With these few values, p cannot be below 0.1," in str(nv.groups(table))


def test_deviations_that_do_not_vary_have_no_check_of_variances():
    """Brown and Forsythe's deviations do not vary here, which SciPy divides by."""
    table = pd.DataFrame({"condition": ["a"] * 4 + ["b"] * 4, "value": [0, 0, 2, 2] * 2})
    checks = nv.groups(table).assumptions.set_index("check")
    assert np.isnan(checks.loc["levene", "p"])


# beside the tests


def test_skewed_residuals_are_named_where_the_test_assumes_none():
    value = np.exp(RNG.normal(0, 1.5, 40))
    result = nv.groups(pd.DataFrame({"condition": ["a", "b"] * 20, "value": value}))
    assert result.fits in ("anova", "welch")
    assert "The residuals are not normally distributed (Shapiro–Wilk p = " in str(result)


def test_the_size_of_a_study_for_the_smallest_difference_that_matters():
    typed = pd.DataFrame({"condition": ["a", "b"], "n": 20, "mean": [10, 11], "sd": [2.0, 2.0]})
    result = nv.groups(typed, difference=1.0)  # d = 0.5
    assert result.sizes["n"].tolist() == [64]
    assert "About 64 persons in each group would show a difference of 1 in 80 % of" in str(result)
    result = nv.groups(typed, difference=1e-6)
    assert "No study of a feasible size would show" in str(result)
    same = nv.groups(persons(9, 2, column="rt_s"), difference=0.5)
    assert "persons, each in all conditions, would show a difference of 0.5 in 80" in str(same)
    assert same.sizes["test"].tolist() == ["t"]
    three = nv.groups(persons(9, 3, same=False))
    assert three.sizes["test"].tolist() == ["anova", "t"]
    assert "for the largest difference found" in str(three)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"power": 0.3}, "power: expected 0.5 to 0.99, got 0.3"),
        ({"correlation": 2.0}, "correlation: expected -1 to 1, got 2"),
        ({"correlation": float("nan")}, "correlation: expected -1 to 1, got nan"),
        ({"difference": 0.0}, "difference: expected a number above 0, got 0"),
        ({"scale": "ranks"}, "scale: expected times, counts or numbers, got 'ranks'"),
        ({"correlation": 0.5}, "correlation: values hold it"),
    ],
)
def test_impossible_choices_are_refused(asked: dict[str, object], words: str):
    with pytest.raises(ParameterError, match=words):
        nv.groups(persons(4, 2), **asked)


def test_an_assumed_correlation_needs_one_n():
    table = pd.DataFrame({"condition": ["a", "b"], "n": [3, 4], "mean": [1, 2], "sd": [1, 1]})
    with pytest.raises(ParameterError, match="the same persons in all conditions have one n"):
        nv.groups(table, correlation=0.5)


def test_the_sd_of_assumed_pairs_is_that_of_the_difference():
    table = pd.DataFrame({"condition": ["a", "b"], "n": 4, "mean": [1.0, 2.0], "sd": [0.1, 0.2]})
    (pair,) = nv.groups(table, correlation=0.5).pairs.query("test == 'assumed'").to_dict("records")
    sd = (0.1**2 + 0.2**2 - 2 * 0.5 * 0.1 * 0.2) ** 0.5
    assert abs(pair["d"]) == pytest.approx(1 / sd)
    assert abs(pair["value"]) == pytest.approx(1 / (sd / 4**0.5))


def test_what_users_named_moves_no_cursor():
    table = persons(4, 2).replace({"condition": {"a": "\x1b[31m{one}"}})
    result = nv.groups(table)
    assert "\x1b" not in str(result)
    assert "{one}" in str(result)
    assert repr(result) == "<GroupComparison of 2 conditions: within fits>"


# the command


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "rt.csv"
    persons(8, 3, column="rt_ms").to_csv(path, index=False)
    return path


def test_the_command_prints_what_the_call_prints(table: Path):
    ran = nvcore("groups", table)
    assert ran.exit_code == 0, ran.output
    assert ran.stdout == f"{nv.groups(table)}\n"
    assert "* repeated measures, Greenhouse–Geisser" in ran.stdout
    assert "  exchange within persons, F" in ran.stdout


def test_json_stands_alone_and_undefined_is_null(table: Path):
    content = json.loads(nvcore("groups", table, "--json").stdout)
    assert (content["design"], content["fits"]) == ("same", "repeated_gg")
    assert content["tests"][0]["omega2"] is None
    assert content["sentences"] == nv.groups(table).sentences


def test_out_is_a_folder_with_every_table(table: Path, tmp_path: Path):
    ran = nvcore("groups", table, "--out", tmp_path / "out")
    assert ran.exit_code == 0, ran.output
    assert "written to " in ran.stderr
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {*FILES, "SHA256SUMS"}
    tests = pd.read_csv(tmp_path / "out" / "tests.csv")
    assert tests["p"].tolist() == pytest.approx(nv.groups(table).tests["p"].tolist(), rel=1e-9)
    write(tmp_path / "out" / "groups.csv", "condition,value", "a,1")
    ran = nvcore("groups", tmp_path / "out" / "groups.csv", "--out", tmp_path / "out")
    assert (ran.exit_code, "is an input" in ran.stderr) == (2, True)


def test_an_empty_comparison_is_written_too(tmp_path: Path):
    path = write(tmp_path / "one.csv", "condition,value", "a,1")
    assert nvcore("groups", path, "--out", tmp_path / "out").exit_code == 0
    assert (tmp_path / "out" / "pairs.csv").read_text().startswith("test,first,second,")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--measure", "rt_m"], "measure: no 'rt_m'; did you mean 'rt_ms'"),
        (["--scale", "ranks"], "'ranks' is not one of 'times', 'counts', 'numbers'"),
        (["--rename", "a"], "--rename: expected KEY=VALUE, found 'a'"),
        (["--correlation", "0.5"], "correlation: values hold it"),
    ],
)
def test_what_cannot_be_compared_is_bad_input(table: Path, arguments: list[str], words: str):
    ran = nvcore("groups", table, *arguments)
    assert ran.exit_code == 2
    assert words in ran.stderr


def test_flags_say_what_the_call_takes(table: Path):
    more = ("--rename", "a=ab", "--rename", "b=ab", "--leave-out", "p1", "--difference", "5")
    called = nv.groups(table, rename={"a": "ab", "b": "ab"}, leave_out=["p1"], difference=5.0)
    assert nvcore("groups", table, *more).stdout == f"{called}\n"
    text = nvcore("groups", "--help").stdout
    for field in fields(GroupArguments):
        assert "flag" not in field.metadata or f"--{field.name.replace('_', '-')}" in text

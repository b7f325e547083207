"""Rules for nightly runs: what they say, how they are judged, what CI is given."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from inputs import DATA, nvcore

from nvcore.errors import ParameterError
from nvcore.gate import Outcome, Rule, judge, junit_xml, markdown, parse_rule, parse_rules

SAMPLE = DATA.parents[1] / "sample_data" / "session.toml"


@pytest.mark.parametrize(
    ("text", "name", "comparison", "limit"),
    [
        ("lamr_x <= 0.10", "lamr_x", "<=", 0.1),
        ("new_misses==0", "new_misses", "==", 0),
        (" share_low_y<10% ", "share_low_y", "<", 0.1),
        ("miss_classes.never_y >= 1e-3", "miss_classes.never_y", ">=", 0.001),
        ("saliency_difference > -1.5", "saliency_difference", ">", -1.5),
    ],
)
def test_a_rule_is_a_figure_a_comparison_and_a_number(text, name, comparison, limit):
    rule = parse_rule(text)
    assert (rule.name, rule.comparison, rule.limit) == (name, comparison, pytest.approx(limit))


@pytest.mark.parametrize("text", ["", "lamr_x", "lamr_x = 1", "1 < lamr_x", "x < y", "x < 1.2.3"])
def test_other_texts_are_refused(text):
    with pytest.raises(ParameterError, match="expected a figure"):
        parse_rule(text)


def test_rules_from_lines_may_have_comments():
    rules = parse_rules(["# nightly", "", "new_misses == 0  # none", "lamr_x <= 0.1"])
    assert [rule.text for rule in rules] == ["new_misses == 0", "lamr_x <= 0.1"]


@pytest.mark.parametrize(
    ("comparison", "passes"),
    [("<=", [1, 2]), ("<", [1]), ("==", [2]), ("!=", [1, 3]), (">=", [2, 3]), (">", [3])],
)
def test_comparisons(comparison, passes):
    outcomes = [judge([parse_rule(f"a {comparison} 2")], {"a": value})[0] for value in (1, 2, 3)]
    assert [one.value for one in outcomes if one.is_passed] == passes


def test_an_undefined_figure_breaks_every_rule():
    found = judge([parse_rule("a != 0"), parse_rule("a < 1")], {"a": np.nan})
    assert [one.is_passed for one in found] == [False, False]
    assert found[0].message == "a is undefined"


def test_an_unknown_figure_is_refused_with_what_is_close():
    with pytest.raises(ParameterError, match="did you mean lamr_x"):
        judge([parse_rule("lmr_x < 1")], {"lamr_x": 0.0})


def outcomes() -> list[Outcome]:
    passed = Outcome(Rule("a", "<", 1, "a < 1"), 0.5, True)
    return [passed, Outcome(Rule("b", "<", 1, "b < 1"), 2.0, False)]


def test_junit_has_a_case_for_each_rule():
    root = ElementTree.fromstring(junit_xml(outcomes(), "X <& Y"))
    suite = root.find("testsuite")
    assert suite.attrib == {"name": "X <& Y", "tests": "2", "failures": "1", "errors": "0"}
    assert [case.attrib["name"] for case in suite] == ["a < 1", "b < 1"]
    assert suite[0].find("failure") is None
    assert suite[1].find("failure").attrib["message"] == "b is 2; wanted b < 1"


def test_markdown_names_the_failing_rules_first():
    lines = markdown(outcomes(), "X|Y").splitlines()
    assert lines[0] == r"## X\|Y: 1 of 2 rules failed"
    assert lines[4] == "| `b < 1` | 2 | **failed** |"
    assert lines[5] == "| `a < 1` | 0.5 | passed |"


def test_the_command_fails_with_the_rules_that_do_not_hold(tmp_path: Path):
    rules = tmp_path / "rules.txt"
    rules.write_text("new_misses == 8  # X alone detects 8\nlamr_x <= 0.10\n")
    written = ["--junit", tmp_path / "ci" / "gate.xml", "--markdown", tmp_path / "gate.md"]
    ran = nvcore("gate", SAMPLE, "--rules", rules, "--rule", "lamr_difference < 0", *written)
    assert ran.exit_code == 1, ran.output
    assert [line.split()[0] for line in ran.stdout.splitlines()] == ["passed", "passed", "FAILED"]
    assert "FAILED  lamr_x <= 0.10  (lamr_x is 0.627" in ran.stdout
    suite = ElementTree.parse(tmp_path / "ci" / "gate.xml").getroot()
    assert suite.attrib["failures"] == "1"
    assert "1 of 3 rules failed" in (tmp_path / "gate.md").read_text()


def test_the_command_passes_where_all_rules_hold():
    ran = nvcore("gate", SAMPLE, "--rule", "encounters == 38", "--rule", "mcnemar_p > 0.5")
    assert ran.exit_code == 0, ran.output


def test_nothing_to_miss_passes_no_rule(tmp_path: Path):
    for name in ("truth", "one", "two"):
        (tmp_path / f"{name}.csv").write_text("frame,x,y,w,h,score\n1,5,5,10,20,0.5\n")
    (tmp_path / "truth.csv").write_text("frame,x,y,w,h,ignore\n1,5,5,10,20,1\n")
    flags = [part for letter, name in (("truth", "truth"), ("x", "one"), ("y", "two"))
             for part in (f"--{letter}", tmp_path / f"{name}.csv")]  # fmt: skip
    ran = nvcore("gate", *flags, "--size", "640x480", "--fps", 10, "--rule", "new_misses == 0")
    assert ran.exit_code == 1, ran.output
    assert "new_misses is undefined" in ran.stdout


def test_the_protocol_changes_the_figures_of_the_curve():
    every = nvcore("gate", SAMPLE, "--list").stdout
    near = nvcore("gate", SAMPLE, "--list", "--protocol", "near").stdout
    differing = {
        one.split()[0] for one, other in zip(every.splitlines(), near.splitlines(), strict=True)
        if one != other
    }  # fmt: skip
    assert "lamr_x" in differing
    assert "mean_similarity_x" not in differing


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "give a rule"),
        (["--rule", "lamr_x"], "expected a figure"),
        (["--rule", "nothing_x < 1"], "there is no figure 'nothing_x'"),
        (["--rule", "lamr_x < 1", "--protocol", "best"], "there is no protocol 'best'"),
        (["--rules", "absent.txt"], "cannot be read"),
    ],
)
def test_what_cannot_be_judged_is_bad_input(arguments, words):
    ran = nvcore("gate", SAMPLE, *arguments)
    assert ran.exit_code == 2
    assert words in ran.output


def test_outcomes_that_cannot_be_written_are_told(tmp_path: Path):
    (tmp_path / "file").write_text("")
    ran = nvcore("gate", SAMPLE, "--rule", "encounters > 0", "--junit", tmp_path / "file" / "x.xml")
    assert ran.exit_code == 2
    assert "cannot be written" in ran.output

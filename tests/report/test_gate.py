"""Rules for nightly runs: what they say, how they are judged, what people and CI are given."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from places import ROOT

from nvcore.errors import ParameterError
from nvcore.findings import Finding, Severity
from nvcore.protocols import PROTOCOLS
from nvcore.report.gate import (
    SUMMARY_NAMES,
    Outcome,
    Rule,
    audit_rules,
    encounters_of,
    explain,
    gate_measures,
    judge,
    measure_names,
    parse_rule,
    read_rules,
)
from nvcore.report.gate_results import (
    is_gate_result,
    junit_error,
    junit_xml,
    markdown,
    markdown_error,
    terminal_lines,
)
from nvcore.schema import Category

HOSTILE = "</failure>|<b>`x`\n# [a](http://b)\x1b[31m"
WARNING = Finding(Severity.WARNING, "a-code", "NIR", 3, "Three are odd.", "Look at them.")
ERROR = Finding(Severity.ERROR, "a-code", HOSTILE, 1, "One is wrong.", "Mend it.")


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
def test_a_rule_is_a_measure_a_comparison_and_a_number(text, name, comparison, limit):
    rule = parse_rule(text)
    assert (rule.name, rule.comparison, rule.limit) == (name, comparison, pytest.approx(limit))
    assert not rule.allows_undefined


@pytest.mark.parametrize("text", ["a <= 1 or undefined", "a<=100%or  undefined"])
def test_a_rule_may_allow_an_undefined_measure(text):
    rule = parse_rule(text)
    assert (rule.name, rule.limit, rule.allows_undefined) == ("a", 1, True)


@pytest.mark.parametrize(
    "text",
    ["", "lamr_x", "1 < lamr_x", "x < y", "x < 1.2.3", "x < 1 or", "x < 1or undefined", "x < 1 2"],
)
def test_other_texts_are_refused(text):
    with pytest.raises(ParameterError, match="expected a figure"):
        parse_rule(text)


@pytest.mark.parametrize(
    ("wrong", "meant"), [("=", "=="), ("=<", "<="), ("=>", ">="), ("<>", "!="), ("≤", "<=")]
)
def test_a_wrong_comparison_is_refused_with_the_one_that_is_meant(wrong, meant):
    with pytest.raises(ParameterError, match=f"did you mean 'a {meant} 1'"):
        parse_rule(f"a {wrong} 1")


def test_a_comparison_that_means_nothing_is_refused_with_all_that_there_are():
    with pytest.raises(ParameterError, match="'!<'; there are <= >= == != < >"):
        parse_rule("a !< 1")


def test_rules_from_lines_may_have_comments():
    lines = [("1", "# nightly"), ("2", ""), ("3", "a == 0  # none"), ("4", "b <= 0.1")]
    rules, problems = read_rules(lines, ["a", "b"])
    assert [rule.text for rule in rules] == ["a == 0", "b <= 0.1"]
    assert problems == []


def test_all_that_is_wrong_with_the_rules_is_told_with_its_place():
    lines = [("r, line 1", "lamr_y = 1"), ("r, line 2", "lamr_y < 1"), ("r, line 3", "lmr_y < 1")]
    rules, problems = read_rules(lines, ["lamr_y"])
    assert [rule.text for rule in rules] == ["lamr_y < 1"]
    assert [one.split(": ")[0] for one in problems] == ["r, line 1", "r, line 3"]
    assert "did you mean 'lamr_y == 1'?" in problems[0]
    assert "there is no figure 'lmr_y'; did you mean lamr_y?" in problems[1]


def test_the_rules_to_copy_from_the_page_can_be_judged():
    page = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```ini\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    rules, problems = read_rules((("", line) for line in example.splitlines()), measure_names())
    assert problems == []
    assert len(rules) == 5


@pytest.mark.parametrize(
    ("comparison", "passes"),
    [("<=", [1, 2]), ("<", [1]), ("==", [2]), ("!=", [1, 3]), (">=", [2, 3]), (">", [3])],
)
def test_comparisons(comparison, passes):
    outcomes = [judge([parse_rule(f"a {comparison} 2")], {"a": value})[0] for value in (1, 2, 3)]
    assert [one.value for one in outcomes if one.is_passed] == passes


def test_an_undefined_measure_breaks_every_rule():
    found = judge([parse_rule("a != 0"), parse_rule("a < 1")], {"a": np.nan})
    assert [one.is_passed for one in found] == [False, False]
    assert found[0].message == "a is undefined; add 'or undefined' to the rule if that is fine"


def test_an_undefined_measure_passes_a_rule_that_allows_it():
    rule = parse_rule("a <= 1 or undefined")
    outcomes = [judge([rule], {"a": value})[0] for value in (np.nan, 1, 2)]
    assert [one.is_passed for one in outcomes] == [True, True, False]
    assert outcomes[0].message == "a is undefined, which the rule allows"


def test_an_unknown_measure_is_refused_with_what_is_close():
    with pytest.raises(ParameterError, match="did you mean lamr_x"):
        judge([parse_rule("lmr_x < 1")], {"lamr_x": 0.0})


def test_the_audit_is_judged_by_rules_that_a_rule_can_replace():
    given = [parse_rule("audit_errors <= 2")]
    assert [one.text for one in audit_rules([], strict=False)] == ["audit_errors == 0"]
    assert [one.text for one in audit_rules(given, strict=False)] == []
    assert [one.text for one in audit_rules(given, strict=True)] == ["audit_warnings == 0"]


def scene(n_recordings: int = 1):
    """In each recording X detects track 7, Y track 8, both track 9; the frames are 3 to 5."""
    truth, x, y = [], [], []
    for recording in range(n_recordings):
        for frame in (3, 4, 5):
            for track, centre, systems in ((7, 10, [x]), (8, 50, [y]), (9, 90, [x, y])):
                truth.append(at(frame, centre, track=track, recording=recording))
                for system in systems:
                    system.append(at(frame, centre, recording=recording))
    places = [Place(range(3, 6))] * n_recordings
    return result_of(make_dataset(truth, x, y, places=places))


def test_encounters_are_told_by_recording_track_and_frames():
    assert encounters_of(scene(), Category.X_ONLY) == ["r0, track 7, frames 3 to 5"]
    assert encounters_of(scene(), Category.NEITHER) == []


def test_an_encounter_of_one_frame_is_told_with_one():
    result = result_of(make_dataset([at(4, 10, track=1)], [at(4, 10)], frames=range(6)))
    assert encounters_of(result, Category.X_ONLY) == ["r0, track 1, frame 4"]


def test_of_many_encounters_the_first_ten_are_told_and_how_many_more():
    told = encounters_of(scene(12), Category.X_ONLY)
    assert len(told) == 11
    assert told[9:] == ["r9, track 7, frames 3 to 5", "and 2 more"]


def test_a_failed_rule_has_what_it_counts_and_a_passed_one_has_nothing():
    rules = [parse_rule(text) for text in ("new_misses == 0", "mended_misses == 1",
             "audit_warnings == 0", "audit_errors == 0", "venn.neither == 1")]  # fmt: skip
    result = scene()
    wanted = [rule.name for rule in rules]
    values = gate_measures(result, [WARNING], PROTOCOLS["all"], wanted)
    outcomes = explain(judge(rules, values), result, [WARNING])
    assert [one.is_passed for one in outcomes] == [False, True, False, True, False]
    assert outcomes[0].details == ("r0, track 7, frames 3 to 5",)
    assert outcomes[2].details == ("NIR: Three are odd.",)
    assert [len(one.details) for one in outcomes] == [1, 0, 1, 0, 0]


def test_every_measure_that_can_be_named_is_there_and_no_other():
    values = gate_measures(scene(), [], PROTOCOLS["all"], measure_names())
    assert sorted(values) == sorted(measure_names())
    chosen = ("venn.both", "frames", "fusion.x_or_y.encounters_detected")
    assert [values[name] for name in chosen] == [1, 3, 3]


def test_measures_that_take_time_are_left_out_where_no_rule_names_them():
    values = gate_measures(scene(), [], PROTOCOLS["all"], ["new_misses"])
    assert values["new_misses"] == 1
    assert not {*SUMMARY_NAMES, "lamr_x"} & {*values}


def outcomes() -> list[Outcome]:
    passed = Outcome(Rule("a", "<", 1, "a < 1"), 0.5, True)
    return [passed, Outcome(Rule("b", "<", 1, "b < 1"), 2.0, False, ("one", HOSTILE))]


def test_the_terminal_shows_what_failed_rules_count_one_line_each():
    lines = terminal_lines(outcomes())
    assert lines[:3] == ["passed  a < 1  (a is 0.5)", "FAILED  b < 1  (b is 2)", "        one"]
    assert len(lines) == 4
    assert lines[3].isprintable()


def test_junit_has_a_case_for_each_rule_and_the_audit_beside():
    root = ElementTree.fromstring(junit_xml(outcomes(), "X <& Y", [WARNING, ERROR]))
    suite = root.find("testsuite")
    assert suite.attrib == {"name": "X <& Y", "tests": "2", "failures": "1", "errors": "0"}
    passed, failed = suite.findall("testcase")
    assert [passed.attrib["name"], failed.attrib["name"]] == ["a < 1", "b < 1"]
    assert passed.find("failure") is None
    assert failed.find("failure").attrib["message"] == "b is 2; wanted b < 1"
    lines = failed.find("failure").text.splitlines()
    assert lines[:2] == ["b is 2; wanted b < 1", "one"]
    assert lines[2].startswith("</failure>|<b>`x`\\n# ")
    assert suite.find("system-out").text.startswith("Audit: 1 error, 1 warning.\n")
    assert "NIR: Three are odd." in suite.find("system-out").text


def test_markdown_names_the_failing_rules_first_and_what_they_count():
    lines = markdown(outcomes(), "X|Y").splitlines()
    assert lines[0] == "## Gate: 1 of 2 rules failed"
    assert lines[2] == r"X\|Y"
    assert lines[6:8] == ["| `b < 1` | 2 | **failed** |", "| `a < 1` | 0.5 | passed |"]
    assert lines[9:12] == ["`b < 1` failed:", "", "- one"]
    assert lines[-1] == "### Audit: nothing found"


def test_markdown_has_the_audit_once():
    rule = parse_rule("audit_warnings == 0")
    failed = Outcome(rule, 1, False, ("NIR: Three are odd.",))
    text = markdown([failed], "X", [WARNING])
    assert "### Audit: 1 warning\n\n- warning, NIR: Three are odd\\." in text
    assert text.count("Three are odd") == 1


def test_names_from_files_stay_text_in_markdown():
    text = markdown(outcomes(), HOSTILE, [ERROR])
    assert text.count(r"\<b\>\`x\`\\n\# \[a\]\(http\:\/\/b\)".replace(r"\/", "/")) == 3
    assert "<b>" not in text
    assert "\x1b" not in text


def test_an_undefined_measure_is_told_so_in_markdown():
    undefined = Outcome(Rule("a", "<", 1, "a < 1"), np.nan, False)
    assert "| `a < 1` | undefined | **failed** |" in markdown([undefined], "X")


def test_a_gate_that_cannot_be_run_is_an_error_for_ci():
    root = ElementTree.fromstring(junit_error(f"first\nsecond {HOSTILE}"))
    suite = root.find("testsuite")
    counts = {"tests": "1", "failures": "0", "errors": "1"}
    assert suite.attrib == {"name": "nvcore gate", **counts}
    assert root.attrib == {"name": "nvcore gate", **counts}
    assert suite.find("testcase/error").text.startswith("first\nsecond </failure>|<b>")


def test_a_gate_that_cannot_be_run_is_told_so_in_markdown():
    text = markdown_error("<b>first\nsecond")
    assert text == "## Gate: could not be run\n\n\\<b\\>first\n\nsecond\n"


def test_the_results_of_a_gate_are_told_from_other_files():
    own = [junit_xml(outcomes(), "X"), markdown([], "X").encode(), junit_error("a"),
           markdown_error("a").encode()]  # fmt: skip
    assert all(is_gate_result(one) for one in own)
    others = [b"", b"recording,frame\n", b"## Gate rules\n", b"<?xml version='1.0'?><annotation/>"]
    assert not any(is_gate_result(one) for one in others)

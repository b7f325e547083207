"""Rules for nightly runs: what they say, how they are judged, what people and CI are given."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from approach import PLACE, approach, only
from builders import Place, at, make_dataset, result_of
from drives import by_figure, drives
from places import ROOT

from nvcore.common.errors import ParameterError
from nvcore.common.findings import Finding, Severity
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Measure
from nvcore.comparison.measures.table import MEASURES
from nvcore.dataset.schema import Category
from nvcore.report.gate import audit_rules, run_gate
from nvcore.report.gate.details import encounters_of, explain
from nvcore.report.gate.measures import SUMMARY_NAMES, gate_measures, measure_names
from nvcore.report.gate.outcomes import RuleOutcome, judge, value_text
from nvcore.report.gate.results import (
    is_gate_result,
    junit_error,
    junit_xml,
    markdown,
    markdown_error,
    terminal_lines,
    what_is_not_asked,
)
from nvcore.report.gate.rules import Rule, parse_rule, read_rules
from nvcore.settings.protocols import PROTOCOLS
from nvcore.tables.result import recordings_table
from nvcore.tables.scorecard import score_rows
from nvcore.tables.summary import summary

HOSTILE = "</failure>|<b>`x`\n# [a](http://b)\x1b[31m"
WARNING = Finding(Severity.WARNING, "a-code", "NIR", 3, "Three are odd.", "Look at them.")
ERROR = Finding(Severity.ERROR, "a-code", HOSTILE, 1, "One is wrong.", "Mend it.")


@pytest.mark.parametrize(
    ("text", "name", "comparison", "limit", "allows_undefined"),
    [
        ("lamr_x <= 0.10", "lamr_x", "<=", 0.1, False),
        ("newly_missed==0", "newly_missed", "==", 0, False),
        (" share_low_y<10% ", "share_low_y", "<", 0.1, False),
        ("miss_classes.never_y >= 1e-3", "miss_classes.never_y", ">=", 0.001, False),
        ("saliency_difference > -1.5", "saliency_difference", ">", -1.5, False),
        ("a<=100%or  undefined", "a", "<=", 1, True),
    ],
)
def test_a_rule_is_a_measure_a_comparison_and_a_number(
    text, name, comparison, limit, allows_undefined
):
    rule = parse_rule(text)
    assert (rule.name, rule.comparison, rule.limit) == (name, comparison, pytest.approx(limit))
    assert rule.allows_undefined is allows_undefined


@pytest.mark.parametrize(
    "text",
    ["", "lamr_x", "1 < lamr_x", "x < y", "x < 1.2.3", "x < 1 or", "x < 1or undefined", "x < 1 2"],
)
def test_other_texts_are_refused(text):
    with pytest.raises(ParameterError, match="expected a measure"):
        parse_rule(text)


@pytest.mark.parametrize(
    ("wrong", "meant"),
    [("=", "=="), ("=<", "<="), ("=>", ">="), ("<>", "!="), ("≤", "<="), ("!<", None)],
)
def test_a_wrong_comparison_is_refused_with_the_one_that_is_meant(wrong, meant):
    hint = f"did you mean 'a {meant} 1'" if meant else "there are <= >= == != < >"
    with pytest.raises(ParameterError, match=hint):
        parse_rule(f"a {wrong} 1")


def test_all_that_is_wrong_with_the_rules_is_told_with_its_place():
    lines = [
        ("r, line 1", "lamr_y = 1"),
        ("r, line 2", "lamr_y < 1  # nightly"),
        ("r, line 3", "# only a comment"),
        ("r, line 4", "lmr_y < 1"),
    ]
    rules, problems = read_rules(lines, ["lamr_y"])
    assert [rule.text for rule in rules] == ["lamr_y < 1"]
    assert [text.split(": ")[0] for text in problems] == ["r, line 1", "r, line 4"]
    assert "did you mean 'lamr_y == 1'?" in problems[0]
    assert "there is no measure 'lmr_y'; did you mean lamr_y?" in problems[1]
    with pytest.raises(ParameterError, match="did you mean lamr_x"):
        judge([parse_rule("lmr_x < 1")], {"lamr_x": 0.0})


def test_an_undefined_measure_breaks_every_rule_that_does_not_allow_it():
    rules = [parse_rule(text) for text in ("a != 0", "a < 1", "a <= 1 or undefined")]
    different, less, allowed = judge(rules, {"a": np.nan})
    assert [different.is_passed, less.is_passed, allowed.is_passed] == [False, False, True]
    assert less.message == "a is undefined; add 'or undefined' to the rule if that is fine"
    assert allowed.message == "a is undefined, which the rule allows"
    assert [judge(rules[2:], {"a": value})[0].is_passed for value in (1, 2)] == [True, False]


def test_encounters_are_told_by_recording_track_and_frames_the_first_ten_of_many():
    assert encounters_of(scene(), Category.X_ONLY) == ["r0, track 7, frames 3 to 5"]
    assert encounters_of(scene(), Category.NEITHER) == []
    single = result_of(make_dataset([at(4, 10, track=1)], [at(4, 10)], frames=range(6)))
    assert encounters_of(single, Category.X_ONLY) == ["r0, track 1, frame 4"]
    many = encounters_of(scene(12), Category.X_ONLY)
    assert len(many) == 11
    assert many[9:] == ["r9, track 7, frames 3 to 5", "and 2 more"]


def test_every_measure_that_can_be_named_is_there_and_those_that_take_time_only_if_named():
    values = gate_measures(scene(), [], PROTOCOLS["all"], measure_names())
    assert sorted(values) == sorted(measure_names())
    chosen = ("venn.both", "frames", "fusion.x_or_y.encounters_detected")
    assert [values[name] for name in chosen] == [1, 3, 3]
    quick = gate_measures(scene(), [], PROTOCOLS["all"], ["newly_missed"])
    assert quick["newly_missed"] == 1
    assert not {*SUMMARY_NAMES, "lamr_x"} & {*quick}
    nobody = result_of(make_dataset(n_frames=3))
    values = gate_measures(nobody, [], PROTOCOLS["all"], ["newly_missed", "longest_episode_s_x"])
    assert np.isnan([values["newly_missed"], values["longest_episode_s_x"]]).all()


def test_no_rule_passes_because_nobody_is_urgent():
    names = ["late_y", "never_difference", "fusion.x_or_y.late", "miss_classes.late_y"]
    values = gate_measures(scene(), [], PROTOCOLS["all"], measure_names())
    assert [bool(np.isnan(values[name])) for name in names] == [True, True, True, False]
    boxes = approach(range(40), 5)
    urgent = result_of(make_dataset(boxes, boxes, only(boxes, range(35, 40)), places=[PLACE]))
    values = gate_measures(urgent, [], PROTOCOLS["all"], measure_names())
    assert [values[name] for name in names[:3]] == [1, 0, 0]
    assert (values["urgent"], values["in_time_x"], values["in_time_difference"]) == (1, 1, 1)


@pytest.mark.parametrize(("seconds", "rate"), [(599, None), (600, 6)])
def test_a_rate_that_no_table_shows_decides_no_rule(seconds: int, rate: int | None):
    """One false alarm in a recording of one frame a second."""
    frames = range(seconds)
    result = result_of(
        make_dataset([at(0, 50)], [at(9, 20)], places=[Place(frames, fps=1)]), alerts="policy"
    )
    value = pytest.approx(np.nan if rate is None else rate, nan_ok=True)
    name = "false_alert_episodes_per_hour"
    names = [f"{name}_x", f"fusion.x_or_y.{name}", "alerts_unwanted_per_hour_x"]
    values = gate_measures(result, [], PROTOCOLS["all"], names)
    assert [values[name] for name in names[:2]] == [value] * 2
    assert np.isnan(values[names[2]]) == (rate is None)
    assert summary(result)["x"][name] == rate
    assert recordings_table(result)[names[0]].tolist() == [value]
    assert (name in {row.key for row in score_rows(result)}) == (rate is not None)
    (outcome, *_), _ = run_gate(
        [parse_rule(f"{names[0]} <= 9 or undefined")], result, [], strict=False
    )
    assert outcome.is_passed
    says = ("No rate per hour is given of less than 10 min: the recordings last 599 s",)
    assert outcome.details == (says if rate is None else ())


def test_the_rules_to_copy_from_the_page_can_be_judged():
    page = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```ini\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    rules, problems = read_rules((("", line) for line in example.splitlines()), measure_names())
    assert problems == []
    assert len(rules) == 7


@pytest.mark.parametrize(
    ("comparison", "passes"),
    [("<=", [1, 2]), ("<", [1]), ("==", [2]), ("!=", [1, 3]), (">=", [2, 3]), (">", [3])],
)
def test_comparisons(comparison, passes):
    outcomes = [judge([parse_rule(f"a {comparison} 2")], {"a": value})[0] for value in (1, 2, 3)]
    assert [outcome.value for outcome in outcomes if outcome.is_passed] == passes


def test_the_audit_is_judged_by_rules_that_a_rule_can_replace():
    given = [parse_rule("audit_errors <= 2")]
    assert [rule.text for rule in audit_rules([], strict=False)] == ["audit_errors == 0"]
    assert [rule.text for rule in audit_rules(given, strict=False)] == []
    assert [rule.text for rule in audit_rules(given, strict=True)] == ["audit_warnings == 0"]


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


def test_a_failed_rule_has_what_it_counts_and_a_passed_one_has_nothing():
    rules = [parse_rule(text) for text in ("newly_missed == 0", "fixed == 1",
             "audit_warnings == 0", "audit_errors == 0", "venn.neither == 1")]  # fmt: skip
    result = scene()
    wanted = [rule.name for rule in rules]
    values = gate_measures(result, [WARNING], PROTOCOLS["all"], wanted)
    outcomes = explain(judge(rules, values), result, [WARNING])
    assert [outcome.is_passed for outcome in outcomes] == [False, True, False, True, False]
    assert outcomes[0].details == ("r0, track 7, frames 3 to 5",)
    assert outcomes[2].details == ("NIR: Three are odd.",)
    assert [len(outcome.details) for outcome in outcomes] == [1, 0, 1, 0, 0]


def outcomes() -> list[RuleOutcome]:
    passed = RuleOutcome(Rule("a", "<", 1, "a < 1"), 0.5, True)
    return [passed, RuleOutcome(Rule("b", "<", 1, "b < 1"), 2.0, False, ("one", HOSTILE))]


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
    undefined = RuleOutcome(Rule("c", "<", 1, "c < 1"), np.nan, False)
    lines = markdown([*outcomes(), undefined], "X|Y").splitlines()
    assert lines[0] == "## Gate: 2 of 3 rules failed"
    assert lines[2] == r"X\|Y"
    assert lines[6:9] == [
        "| `b < 1` | 2 | **failed** |",
        "| `c < 1` | undefined | **failed** |",
        "| `a < 1` | 0.5 | passed |",
    ]
    assert lines[10:13] == ["`b < 1` failed:", "", "- one"]
    assert lines[-1] == "### Audit: nothing found"
    failed = RuleOutcome(parse_rule("audit_warnings == 0"), 1, False, ("NIR: Three are odd.",))
    text = markdown([failed], "X", [WARNING])
    assert "### Audit: 1 warning\n\n- warning, NIR: Three are odd\\." in text
    assert text.count("Three are odd") == 1  # not under its rule as well


def test_names_from_files_stay_text_in_markdown():
    text = markdown(outcomes(), HOSTILE, [ERROR])
    assert text.count(r"\<b\>\`x\`\\n\# \[a\]\(http\:\/\/b\)".replace(r"\/", "/")) == 3
    assert "<b>" not in text
    assert "\x1b" not in text


def test_a_gate_that_cannot_be_run_is_an_error_for_ci():
    root = ElementTree.fromstring(junit_error(f"first\nsecond {HOSTILE}"))
    suite = root.find("testsuite")
    counts = {"tests": "1", "failures": "0", "errors": "1"}
    assert suite.attrib == root.attrib == {"name": "nvcore gate", **counts}
    assert suite.find("testcase/error").text.startswith("first\nsecond </failure>|<b>")
    text = markdown_error("<b>first\nsecond")
    assert text == "## Gate: could not be run\n\n\\<b\\>first\n\nsecond\n"


def test_the_results_of_a_gate_are_told_from_other_files():
    own = [junit_xml(outcomes(), "X"), markdown([], "X").encode(), junit_error("a"),
           markdown_error("a").encode()]  # fmt: skip
    assert all(is_gate_result(content) for content in own)
    others = [b"", b"recording,frame\n", b"## Gate rules\n", b"<?xml version='1.0'?><annotation/>"]
    assert not any(is_gate_result(content) for content in others)


def test_how_much_worse_a_system_may_be_is_the_end_of_the_interval_over_recordings_against_it():
    result = result_of(drives(12))
    names = ["encounters_detected_worse_x", "encounters_detected_worse_y", "share_low_worse_y"]
    values = gate_measures(result, [], PROTOCOLS["all"], names)
    rows = by_figure(result)
    detected, low = rows.loc["encounters_detected_by_unit"], rows.loc["share_low"]
    assert [values[name] for name in names] == [-detected["low"], detected["high"], -low["low"]]
    (rule,), _ = read_rules([("", "encounters_detected_worse_x <= 3%")], measure_names())
    assert judge([rule], values)[0].is_passed
    few = gate_measures(result_of(drives(3)), [], PROTOCOLS["all"], names)
    assert np.isnan([few[name] for name in names]).all()
    assert "share_low_worse_y" not in gate_measures(result, [], PROTOCOLS["all"], ["frames"])


def test_how_much_worse_a_system_may_be_is_undefined_at_unequal_operating_points():
    # Y has an alarm in every frame, X none
    truth = [at(f, 50, track=1, recording=r) for r in range(8) for f in range(4)]
    x = [box for box in truth if box.frame or box.recording % 3]
    y = truth + [at(f, 5, recording=r) for r in range(8) for f in range(4)]
    result = result_of(make_dataset(truth, x, y, places=[Place(range(4))] * 8))
    rules = [
        parse_rule("mean_similarity_worse_y <= 3%"),
        parse_rule("mean_similarity_worse_y <= 3% or undefined"),
    ]
    outcomes, values = run_gate(rules, result, [], strict=False)
    assert np.isnan(values["mean_similarity_worse_y"])
    assert [outcome.is_passed for outcome in outcomes[:2]] == [False, True]
    lines = terminal_lines(outcomes)
    why = (
        "        X and Y are set to different operating points (X has 0 and Y has 1 false boxes "
        "per frame), so nothing is claimed: set confidence thresholds that give equal false alarms"
    )
    assert (lines[1], lines[3]) == (why, why)
    assert why.strip() in junit_xml(outcomes, "X").decode().replace("&gt;", ">")
    assert "or undefined` passed:" in markdown(outcomes, "X")


def test_evidence_is_computed_once_for_claims_and_for_how_much_worse(monkeypatch):
    result = result_of(drives(12))
    monkeypatch.setattr("nvcore.report.gate.measures.judge_key", None)  # not called
    names = ["claims_x", "encounters_detected_worse_x"]
    values = gate_measures(result, [], PROTOCOLS["all"], names)
    row = by_figure(result).loc["encounters_detected_by_unit"]
    assert values["encounters_detected_worse_x"] == -row["low"]


def test_claims_of_the_verdict_can_be_limited():
    # X detects the pedestrians of all eleven recordings, Y those of one
    truth = [at(f, 50, track=1, recording=r) for r in range(11) for f in range(4)]
    y = [box for box in truth if box.recording == 0]
    result = result_of(make_dataset(truth, truth, y, places=[Place(range(4))] * 11))
    values = gate_measures(result, [], PROTOCOLS["all"], ["claims_x"])
    assert values["claims_x"] > 0 == values["claims_y"]
    assert "claims_x" not in gate_measures(result, [], PROTOCOLS["all"], ["newly_missed"])
    same = [Finding(Severity.WARNING, "same-boxes", "truth", 1, "Same.", "Look.")]
    assert gate_measures(result, same, PROTOCOLS["all"], ["claims_x"])["claims_x"] == 0


def two_classes() -> Result:
    """Two cross, of whom X detects both and Y one; one at the side whom only X detects."""
    crossing = [at(f, 30 + 20 * f, h=10.0, track=1) for f in range(3)]
    again = [at(f, 30 + 20 * (f - 3), h=10.0, track=2) for f in range(3, 6)]
    aside = [at(f, 5, h=10.0, track=3) for f in range(6, 9)]
    truth = [*crossing, *again, *aside]
    return result_of(make_dataset(truth, truth, crossing))


def test_a_rule_may_be_about_one_class_of_encounters_and_lists_its_members():
    texts = ["newly_missed == 0", "newly_missed.crossing == 0", "encounters.crossing == 2"]
    rules, problems = read_rules((("", text) for text in texts), measure_names())
    assert problems == []
    outcomes, _ = run_gate(rules, two_classes(), [], strict=False)
    of_all, of_class, count, _ = outcomes
    assert [outcome.value for outcome in (of_all, of_class, count)] == [2, 1, 2]
    assert of_class.details == ("r0, track 2, frames 3 to 5",)
    assert count.is_passed


def test_misses_of_a_class_without_encounters_are_undefined():
    rules = [parse_rule(text) for text in ("newly_missed.child == 0", "encounters.child == 0")]
    misses, count, *_ = run_gate(rules, two_classes(), [], strict=False)[0]
    assert np.isnan(misses.value)
    assert not misses.is_passed
    assert count.value == 0


def test_only_counts_of_encounters_have_classes():
    with pytest.raises(ParameterError, match=r"there is no measure 'saliency_x\.child'"):
        judge([parse_rule("saliency_x.child == 0")], {"saliency_x": 0.0})
    with pytest.raises(ParameterError, match=r"there is no measure 'newly_missed\.'"):
        judge([parse_rule("newly_missed. == 0")], {"newly_missed": 0.0})


def test_a_value_of_minus_nothing_is_nothing():
    assert (value_text(-0.0), value_text(-0.5)) == ("0", "-0.5")


@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.key)
def test_a_rule_that_a_system_firing_everywhere_passes_gets_a_hint(measure: Measure):
    of_misses = [parse_rule("newly_missed == 0")]
    of_measure = [parse_rule(f"{measure.rule or measure.key}_x <= 0")]
    assert what_is_not_asked(of_misses)
    if measure.is_worsened_by_alarms:
        assert not what_is_not_asked(of_measure)
        assert not what_is_not_asked([*of_misses, *of_measure])
    else:
        assert what_is_not_asked(of_measure)
        assert what_is_not_asked([*of_misses, *of_measure])


def test_counts_by_who_detects_and_limits_of_how_much_worse_get_the_hint_like_their_measures():
    for name in (
        "venn.x_only",
        "driver_venn.nobody",
        "newly_missed.child",
        "useful_alerts_worse_y",
    ):
        assert what_is_not_asked([parse_rule(f"{name} <= 0")])
    for name in ("claims_x", "lamr_worse_y", "encounters", "audit_errors"):
        assert not what_is_not_asked([parse_rule(f"{name} <= 0")])

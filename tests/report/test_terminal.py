"""The comparison in words."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd
import pytest
from builders import NAN, Place, at, make_dataset, result_of

from nvcore.comparison import Result
from nvcore.evidence.table import evidence_table
from nvcore.findings import Finding, Severity
from nvcore.report.terminal import (
    describe_exclusivity,
    render_dataset,
    render_findings,
    render_inputs,
    render_scorecard,
)
from nvcore.report.verdict import verdict
from nvcore.wording import number, one_line


def lines_of(result: Result) -> list[str]:
    return render_scorecard(result).splitlines()


def cells(result: Result, label: str) -> list[str]:
    """The three cells of a row of the table."""
    (line,) = [
        one for one in lines_of(result) if one.strip().startswith((f"{label}  ", f"{label},"))
    ]
    return line.split()[-4:-1]


@pytest.fixture(scope="module")
def result() -> Result:
    """Twenty frames, two people; X sees both, Y one of them and a false alarm in two frames."""
    truth = [at(f, c, track=t) for f in range(20) for t, c in ((1, 40), (2, 70))]
    x = [at(f, c, score=0.9) for f in range(20) for c in (40, 70)]
    y = [at(f, 40, score=0.9) for f in range(20)]
    y += [at(f, 5, score=0.8) for f in (3, 4)]
    return result_of(make_dataset(truth, x, y), threshold_x=0.5)


def test_the_heading_names_both_systems_and_what_counts(result: Result):
    assert lines_of(result)[:3] == [
        "X = x, score >= 0.5",
        "Y = y, all scores",
        "1 recording, 20 frames, 2.0 s, 40 pedestrian boxes, 2 encounters (and 0 distant, not "
        "counted)",
    ]


def test_several_recordings_are_in_the_plural():
    dataset = make_dataset(places=[Place(range(3)), Place(range(3))])
    assert lines_of(result_of(dataset))[2].startswith("2 recordings, 6 frames, 0.6 s")


def test_counts_and_shares_stand_side_by_side_with_their_difference(result: Result):
    assert cells(result, "encounters detected") == ["2", "1", "+1"]
    assert cells(result, "never") == ["0", "1", "-1"]
    assert cells(result, "boxes matched") == ["40", "20", "+20"]
    assert cells(result, "false alarms per frame") == ["0.000", "0.100", "-0.100"]
    assert cells(result, "false-alert episodes") == ["0", "1", "-1"]
    assert cells(result, "per hour") == ["0.0", "1800.0", "-1800.0"]


def test_the_difference_of_shares_is_in_percentage_points(result: Result):
    (line,) = [one for one in lines_of(result) if one.startswith("frames with")]
    assert line.split()[-6:] == ["0.9", "0.0%", "100.0%", "-100.0", "pp", "lower"]


def test_a_difference_too_small_to_show_has_no_minus_sign():
    truth = [at(f, 50, track=1) for f in range(10)]
    x = [at(f, 50, score=1.0) for f in range(10)]
    y = [at(f, 50 - 1e-5, score=1.0) for f in range(10)]
    result = result_of(make_dataset(truth, y, x))
    assert result.x.summary.mean < result.y.summary.mean
    assert cells(result, "mean similarity") == ["1.0000", "1.0000", "+0.0000"]


def test_what_is_undefined_is_a_dash_and_has_no_difference(result: Result):
    assert cells(result, "longest (s)") == ["–", "0.20", "–"]


def test_every_row_says_which_way_is_better(result: Result):
    lines = lines_of(result)
    at_ = next(i for i, line in enumerate(lines) if line.endswith("better"))
    rows = [line for line in lines[at_ + 1 : lines.index("", at_)] if not line.endswith(":")]
    assert rows[0].startswith("mean similarity ")
    assert rows[-1].startswith("  no failure ")
    assert {line.split()[-1] for line in rows} == {"higher", "lower"}


def test_the_columns_are_headed_by_letter_and_name(result: Result):
    (line,) = [one for one in lines_of(result) if one.endswith("better")]
    assert line.split() == ["X:", "x", "Y:", "y", "X", "-", "Y", "better"]


def test_a_long_name_is_shortened_in_the_head_only(result: Result):
    long = "thermal-camera-generation-2"
    text = render_scorecard(result_of(replace(result.dataset, systems=(long, "y"))))
    assert text.count(f"X = {long}") == 1
    assert "X: thermal-camera-…" in text


def test_saliency_stands_as_the_mean_over_recordings_as_well():
    truth = [at(f, 50, track=1, recording=r) for r in range(2) for f in range(20)]
    seen_by_y = [at(f, 50, recording=0) for f in range(20)]
    places = [Place(range(20)), Place(range(20))]
    result = result_of(make_dataset(truth, truth, seen_by_y, places=places))
    row = next(one for one in lines_of(result) if one.startswith("  mean over recordings (s)"))
    assert row.split()[4:6] == ["0.000", f"{result.y.saliency_s / 2:.3f}"]


@pytest.mark.parametrize(
    ("aggregate", "words"), [("max", "saliency, largest event"), ("sum", "saliency, sum of events")]
)
def test_the_label_of_saliency_says_what_is_added_up(result: Result, aggregate: str, words: str):
    text = render_scorecard(result_of(result.dataset, saliency_aggregate=aggregate))
    assert words in text


def test_the_venn_counts_are_in_one_line(result: Result):
    assert (
        "encounters detected by: both 1, only X 1, only Y 0, neither 0 (0 distant, not counted)"
        in lines_of(result)
    )


def test_lead_time_is_told_for_the_encounters_that_both_match():
    truth = [at(f, c, track=t) for f in range(20) for t, c in ((1, 40), (2, 70))]
    x = [at(f, c, score=1.0) for f in range(20) for c in (40, 70)]
    y = [at(f, 40, score=1.0) for f in range(4, 20)] + [at(f, 70, score=1.0) for f in range(20)]
    assert (
        "lead time, in the 2 encounters that both match: X is first in 1, Y in 0, at once in 1; X "
        "leads by +0.20 s on average, median +0.20 s"
    ) in lines_of(result_of(make_dataset(truth, x, y)))


def test_lead_time_without_a_common_encounter_is_not_told():
    truth = [at(f, 50, track=1) for f in range(5)]
    result = result_of(make_dataset(truth, truth[:0], truth[:0]))
    assert "lead time: no encounter is matched by both systems" in lines_of(result)


def test_detections_on_ignored_people_are_told_for_both_systems():
    truth = [at(f, 50, ignore=True) for f in range(5)]
    x = [at(f, 50, score=1.0) for f in range(3)]
    text = render_scorecard(result_of(make_dataset(truth, x, x[:1])))
    assert "that the truth ignores, not counted: X 3, Y 1" in text


def test_exclusivity_is_told_with_what_is_inside_what(result: Result):
    text = describe_exclusivity(result.exclusivity, 1, 0)
    assert text == (
        "encounters not detected: 0 by X, 1 by Y, of these 0 by both (Jaccard 0.00, phi –); "
        "McNemar's exact p = 1 for 1 to 0"
    )


def test_two_systems_that_miss_the_same_are_not_told_apart():
    text = render_scorecard(result_of(make_dataset(n_frames=3)))
    assert "none tells the two systems apart" in text


def test_the_scorecard_ends_in_the_verdict(result: Result):
    evidence = evidence_table(result)
    assert lines_of(result)[-1] == "In short: " + " ".join(verdict(result, evidence=evidence))


def test_fusion_is_told_for_both_ways(result: Result):
    found = [line for line in lines_of(result) if line.startswith("fusion")]
    assert found[0].startswith("fusion X or Y: 2 of 2 encounters, 1800.0 false-alert episodes/h")
    assert found[1].startswith("fusion X and Y: 1 of 2 encounters, 0.0 false-alert episodes/h")


def test_the_worst_intervals_come_with_recording_time_and_frames(result: Result):
    lines = lines_of(result)
    at_ = lines.index("worst intervals of Y (y):")
    assert lines[at_ + 1].startswith("  r0  0.00 s to 2.00 s  (frames 0 to 19): severity ")
    assert "worst intervals of X (x): none below 0.9" in lines


def test_at_most_five_intervals_of_a_system_are_shown():
    truth = [at(f, 50, track=1) for f in range(20)]
    x = [at(f, 50, score=1.0) for f in range(0, 20, 2)]
    result = result_of(make_dataset(truth, x, x))
    assert sum(line.startswith("  r0") for line in lines_of(result)) == 10
    assert len(result.x.intervals) == 10


def test_no_finding_is_told():
    assert render_findings(()) == "Audit: nothing found."


def test_a_finding_tells_what_where_and_what_to_do():
    findings = (
        Finding(Severity.ERROR, "no-area", "FIR", 2, "Two boxes.", "Mend them.", "a.csv", "line 4"),
        Finding(Severity.WARNING, "odd", "truth", 1, "Odd.", "Look."),
        Finding(Severity.WARNING, "odd", "truth", 1, "Odd.", "Look.", example="frame 3"),
    )
    assert render_findings(findings).splitlines() == [
        "Audit: 1 error, 2 warnings.",
        "  error   FIR: Two boxes.",
        "          first: a.csv, line 4",
        "          Mend them.",
        "  warning truth: Odd.",
        "          Look.",
        "  warning truth: Odd.",
        "          first: frame 3",
        "          Look.",
    ]


def inputs(*files: str, subject: str = "truth") -> pd.DataFrame:
    return pd.DataFrame(
        {"subject": subject, "file": files, "sha256": "0", "format": "mot", "conversion": "as is"}
    )


def test_inputs_are_told_with_format_conversion_and_choice_of_frames():
    dataset = replace(
        make_dataset(n_frames=1),
        inputs=pd.concat([inputs("gt.txt"), inputs("a.txt", "b.txt", subject="FIR")]),
        notes=("evaluated frames of r0: as given",),
    )
    assert render_dataset(dataset).splitlines() == [
        "truth: gt.txt (mot; as is)",
        "FIR: 2 files, a.txt ... (mot; as is)",
        "evaluated frames of r0: as given",
    ]


def test_linked_truth_and_missing_distances_are_told():
    truth = [at(f, 50) for f in range(3)]
    result = result_of(make_dataset(truth, truth[:1], truth[:2]), proximity="distance")
    text = render_inputs(result)
    assert "the truth of 1 recording has pedestrians without track ids: they were linked" in text
    assert "3 truth boxes have no distance and are weighted by height" in text
    assert "1 boxes of X have no distance" in text
    assert "2 boxes of Y have no distance" in text


EVIL = "V\x1b[2J\nX = forged\u202e<b>"


@pytest.mark.parametrize("where", ["recording", "system", "input", "finding"])
def test_a_name_cannot_steer_the_terminal_or_forge_a_line(where: str):
    dataset = make_dataset([at(0, 50, track=1)], n_frames=1)
    dataset = replace(
        dataset,
        recordings=dataset.recordings.assign(name=EVIL),
        systems=(EVIL, "y"),
        inputs=inputs(EVIL),
    )
    finding = Finding(Severity.NOTE, "odd", EVIL, 1, EVIL, EVIL, EVIL, EVIL)
    result = replace(result_of(make_dataset([at(0, 50, track=1)])), dataset=dataset)
    result = replace(result, x=replace(result.x, name=EVIL))
    text = {
        "recording": lambda: render_scorecard(result),
        "system": lambda: render_scorecard(result),
        "input": lambda: render_inputs(result),
        "finding": lambda: render_findings([finding]),
    }[where]()
    assert "V\\x1b[2J\\nX = forged\\u202e<b>" in text
    assert all(sign.isprintable() or sign == "\n" for sign in text)
    assert not any(line.startswith("X = forged") for line in text.splitlines())


def test_a_number_is_a_dash_where_it_is_undefined():
    assert (number(NAN, ".2f"), number(0.5, ".2f")) == ("–", "0.50")


def test_letters_of_any_language_are_shown_as_they_are():
    assert one_line("Fußgänger 夜 640×480 – ok") == "Fußgänger 夜 640×480 – ok"

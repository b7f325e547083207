"""The comparison as text for a terminal; its wording is pinned here and nowhere else."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile

import numpy as np
import pandas as pd
import pytest
from builders import NAN, Place, at, make_dataset, result_of
from drives import at_thresholds

from nvcore.common.findings import Finding, Severity
from nvcore.common.wording import difference, number, one_line
from nvcore.comparison.compare import Result
from nvcore.evidence.companions import find_companions
from nvcore.evidence.operating_points import find_equal_alarms
from nvcore.evidence.table import evidence_table
from nvcore.notes import Note
from nvcore.report.terminal import (
    render_dataset,
    render_findings,
    render_inputs,
    render_scorecard,
    render_verdict,
)
from nvcore.report.verdict import verdict
from nvcore.tables.summary import summary


@pytest.fixture(scope="module")
def result() -> Result:
    """Twenty frames, two people; X sees both, Y one of them and a false alarm in two frames."""
    truth = [at(f, c, track=t) for f in range(20) for t, c in ((1, 40), (2, 70))]
    x = [at(f, c, score=0.9) for f in range(20) for c in (40, 70)]
    y = [at(f, 40, score=0.9) for f in range(20)]
    y += [at(f, 5, score=0.8) for f in (3, 4)]
    return result_of(make_dataset(truth, x, y), threshold_x=0.5)


@pytest.fixture(scope="module")
def scorecard(result: Result) -> list[str]:
    return render_scorecard(result).splitlines()


COUNTED = ("both", "only X", "only Y", "neither")


def row(lines: Sequence[str], caption: str, first: str) -> list[str]:
    """Cells of a table's row after the first, which is given."""
    start = next(i for i, line in enumerate(lines) if line.startswith(f"  {caption}"))
    rows = takewhile(lambda line: line.startswith("    "), lines[start + 2 :])
    (found,) = [of for of in (re.split(r" {2,}", line.strip()) for line in rows) if of[0] == first]
    return found[1:]


def flat(result: Result) -> str:
    """The whole text in one line."""
    return " ".join(render_scorecard(result).split())


def cells(lines: list[str], label: str) -> list[str]:
    """X, Y, their difference and the better direction of a row of the table."""
    starts = (f"{label}  ", f"{label},")
    return next(line for line in lines if line.strip().startswith(starts)).split()[-4:]


def test_the_scorecard_line_by_line(result: Result, scorecard: list[str]):
    table = next(i for i, line in enumerate(scorecard) if line.endswith("better"))
    assert scorecard[:table] == [
        "X = x, score >= 0.5",
        "Y = y, all scores",
        "1 recording, 20 frames, 2.0 s, 40 pedestrian boxes, 2 encounters (0 distant, not counted)",
        "",
    ]
    assert scorecard[table].split() == ["X:", "x", "Y:", "y", "X", "-", "Y", "better"]
    end = scorecard.index("", table)
    begin = next(i for i, line in enumerate(scorecard) if line.startswith("In short: "))
    rows = [line for line in scorecard[table + 1 : end] if not line.endswith(":")]
    assert rows[0].startswith("mean similarity ")
    assert rows[-1].startswith("  no failure ")
    assert {line.split()[-1] for line in rows} == {"higher", "lower", "–"}
    between = scorecard[end + 1 : begin]
    titles = [line for line in between if line and not line.startswith(" ")]
    assert titles == [
        "Who detects whom", "Time left", "Similarity", "Saliency", "False alerts",
        "Is the difference real",
    ]  # fmt: skip
    assert [row(between, "Encounters by who", name)[:3] for name in COUNTED] == [
        ["1", "0.00", "0.00"], ["1", "0.00", "1.20"], ["0", "0.00", "0.00"], ["0", "0.00", "0.00"],
    ]  # fmt: skip
    assert row(between, "Boxes of pedestrians", "20") == ["20", "0", "0"]
    fused = [f"{of.summary.mean:.4f}" for of in (result.fusion.x, result.fusion.y)]
    assert row(between, "X and Y as one system", "X or Y") == ["2", "1", fused[0]]
    assert row(between, "X and Y as one system", "X and Y") == ["1", "0", fused[1]]
    depth_s, lowest = result.y.intervals["depth_s"].iloc[0], result.y.similarity.min()
    worst = ["r0", "0 to 19", "0.00", "2.00", f"{depth_s:.3f}", f"{lowest:.3f}"]
    assert row(between, "The worst low intervals", "Y") == worst
    evidence = evidence_table(result)
    companions = find_companions(result, evidence)
    text = verdict(result, evidence=evidence, companions=companions)
    last = scorecard.index("Moments to look at:")
    conclusion = " ".join(" ".join(scorecard[begin:last]).split())
    assert conclusion == " ".join(
        [f"In short: {text.sentences[0]}", *(f"{topic}: {words}" for topic, words in text.topics)]
    )
    doubted = render_verdict(replace(text, doubt=Note("verdict.doubt", known=[], n_others=1)))
    assert doubted.splitlines()[-1].startswith("  Audit: ")


def test_mcnemar_s_p_is_withheld_where_it_means_nothing():
    truth = [at(f, 50, track=f) for f in range(12)]
    frames = result_of(make_dataset(truth, truth, truth[:2], n_frames=12))
    assert frames.exclusivity.mcnemar_p < 0.05
    assert np.isnan(frames.mcnemar_p)  # most encounters are one frame long
    assert "McNemar" not in render_scorecard(frames)
    assert summary(frames)["exclusivity"]["mcnemar_p"] is None
    persons = [at(2 * i + f, 50, track=i) for i in range(9) for f in range(2)]
    for n_seen, is_given in ((3, True), (4, False)):  # of 9: 6 and 5 tell the two apart
        result = result_of(make_dataset(persons, persons, persons[: 2 * n_seen], n_frames=18))
        assert ("exact McNemar test within these drives" in flat(result)) == is_given
        assert (summary(result)["exclusivity"]["mcnemar_p"] is not None) == is_given


def test_measures_that_mean_little_and_rates_of_sampled_frames_are_marked():
    truth = [at(20 * f, 50, track=f) for f in range(12)]
    place = Place(range(0, 240, 20))
    short = render_scorecard(result_of(make_dataset(truth, truth, truth[:6], places=[place])))
    lines = short.splitlines()
    marked = {line.split("  ")[0 if line[0] != " " else 1] for line in lines if " *  " in line}
    assert {"false-alert episodes *", "late *"} <= marked
    assert "severity of missed pedestrians (s) *" in marked
    assert not any("similarity" in label or "alarms per frame" in label for label in marked)
    assert "* means little here: most encounters are one frame long" in lines
    assert any(line.startswith("Only every 20th frame is evaluated: per minute") for line in lines)
    assert any("12 frames (every 20th frame), 24.0 s" in line for line in lines)


def test_a_difference_is_rounded_once():
    assert difference(0.0184, 0.0156, ".3f") == "+0.003"  # not 0.018 - 0.016
    assert difference(2.106, 4.224, ".2f") == "-2.12"
    assert difference(1234.5, 0.0, ".1f") == "+1,234.5"
    assert difference(0.0, 0.00001, ".3f") == "0.000"
    assert difference(0.0046, 0.0068, ".1%") == "-0.2 pp"
    assert difference(0.01, 0.0100001, ".3f") == "0.000"
    assert difference(7, 9, "d") == "-2"


def test_counts_and_shares_stand_side_by_side_with_their_difference(scorecard: list[str]):
    assert cells(scorecard, "encounters detected") == ["2", "1", "+1", "higher"]
    assert cells(scorecard, "never") == ["0", "1", "-1", "lower"]
    assert cells(scorecard, "boxes matched") == ["40", "20", "+20", "higher"]
    assert cells(scorecard, "false alarms per frame") == ["0.000", "0.100", "-0.100", "lower"]
    assert cells(scorecard, "false-alert episodes") == ["0", "1", "-1", "lower"]
    assert not [line for line in scorecard if "per hour" in line]
    assert cells(scorecard, "longest (s)") == ["–", "0.20", "–", "lower"]  # undefined
    (share,) = [line for line in scorecard if line.startswith("frames with")]
    assert share.split()[-8:] == ["0.9", *(["0.0", "%", "100.0", "%", "-100.0", "pp", "lower"])]


def test_a_difference_too_small_to_show_has_no_minus_sign():
    truth = [at(f, 50, track=1) for f in range(10)]
    y = [at(f, 50 - 1e-5, score=1.0) for f in range(10)]
    result = result_of(make_dataset(truth, y, truth))
    assert result.x.summary.mean < result.y.summary.mean
    lines = render_scorecard(result).splitlines()
    assert cells(lines, "mean similarity") == ["1.0000", "1.0000", "0.0000", "higher"]


def test_a_long_name_is_shortened_in_the_head_only(result: Result):
    long = "thermal-camera-generation-2"
    text = render_scorecard(result_of(replace(result.dataset, systems=(long, "y"))))
    assert text.count(f"X = {long}") == 1
    assert "X: thermal-camera-…" in text


def test_saliency_of_several_recordings_stands_as_their_mean_as_well():
    truth = [at(f, 50, track=1, recording=r) for r in range(2) for f in range(20)]
    seen_by_y = [at(f, 50, recording=0) for f in range(20)]
    places = [Place(range(20)), Place(range(20))]
    dataset = make_dataset(truth, truth, seen_by_y, places=places)
    result = result_of(dataset)
    lines = render_scorecard(result).splitlines()
    assert lines[2].startswith("2 recordings, 40 frames, 4.0 s")
    mean = cells(lines, "saliency, mean largest event (s)")
    assert mean[1] == f"{result.y.saliency_s:.3f}"
    assert cells(lines, "largest event of all (s)")[1] == f"{2 * result.y.saliency_s:.3f}"
    assert "saliency, mean sum of events" in render_scorecard(
        result_of(dataset, saliency_aggregate="sum")
    )


def test_of_ignored_people_alone_there_is_nothing_to_tell_apart():
    truth = [at(f, 50, ignore=True) for f in range(5)]
    x = [at(f, 50, score=1.0) for f in range(3)]
    text = flat(result_of(make_dataset(truth, x, x[:1])))
    assert "3 detections of X and 1 detection of Y lie on people or regions" in text
    assert "no lead time" in text


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
    assert render_findings(()) == "Audit: nothing found."


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
    assert "The truth of 1 recording has pedestrians without track ids: they were linked" in text
    assert "3 boxes of the truth have no distance and weigh by height" in text
    assert "1 box of X has no distance and weighs by height" in text
    assert "2 boxes of Y have no distance" in text


def test_borrowed_distances_are_told_with_their_lenders_and_only_where_somebody_lacks_one():
    truth = [at(f, 50, track=1) for f in range(3)]
    x = [at(0, 50, distance_m=20.0), at(2, 50, distance_m=18.0)]
    settings = {"proximity": "distance", "missing_distance": "borrow"}
    text = render_inputs(result_of(make_dataset(truth, x), **settings))
    assert "3 truth boxes borrowed a distance: 2 as x (2) reports, 1 between those" in text
    assert "of the truth have no distance" not in text
    own = [box._replace(distance_m=20.0) for box in truth]
    assert "borrow" not in render_inputs(result_of(make_dataset(own, x), **settings))
    assert "No match reports" in render_inputs(result_of(make_dataset(truth), **settings))


EVIL = "V\x1b[2J\nX = forged\u202e<b>"


def test_a_name_cannot_steer_the_terminal_or_forge_a_line():
    dataset = make_dataset([at(0, 50, track=1)], n_frames=1)
    dataset = replace(dataset, recordings=dataset.recordings.assign(name=EVIL), inputs=inputs(EVIL))
    finding = Finding(Severity.NOTE, "odd", EVIL, 1, EVIL, EVIL, EVIL, EVIL)
    named = result_of(replace(dataset, systems=(EVIL, "y")))
    for text in (
        render_scorecard(result_of(dataset)),  # the recording
        render_scorecard(named),
        render_inputs(named),
        render_findings([finding]),
    ):
        assert "V\\x1b[2J\\nX = forged\\u202e<b>" in text
        assert all(sign.isprintable() or sign == "\n" for sign in text)
        assert not any(line.startswith("X = forged") for line in text.splitlines())


def test_a_number_is_a_dash_where_it_is_undefined_and_letters_of_any_language_stay():
    assert (number(NAN, ".2f"), number(0.5, ".2f")) == ("–", "0.50")
    assert one_line("Fußgänger 夜 640×480 – ok") == "Fußgänger 夜 640×480 – ok"


def test_the_operating_points_of_all_numbers_are_said_once_above_them():
    result = at_thresholds()
    equal = find_equal_alarms(result)
    as_set, at_equal = map(render_scorecard, (result, equal))
    heading = as_set.split("\n\n")[0].splitlines()[-1]
    assert heading.startswith("As set, at unequal operating points: X has ")
    assert as_set.count("Nothing is claimed from these numbers.") == 1
    heading = at_equal.split("\n\n")[0].splitlines()[-1]
    assert heading.startswith(
        "At equal false alarms, not as set (X at a confidence threshold of 0."
    )
    for text, of in ((as_set, result), (at_equal, equal)):
        assert cells(text.splitlines(), "mean similarity")[0] == number(of.x.summary.mean, ".4f")


def test_sections_are_marked_at_unequal_operating_points():
    result = at_thresholds()
    assert np.isfinite(result.mcnemar_p)
    sections = render_scorecard(result).split("\n\n")[2:-2]  # then verdict and moments
    assert len(sections) == 6
    for section in sections:
        assert section.splitlines()[1].startswith("  As set, at unequal operating points")


def test_nothing_is_marked_at_equal_operating_points(result: Result):
    assert "unequal" not in render_scorecard(result)


def test_severities_of_the_four_groups_add_up_to_the_scorecards():
    result = at_thresholds()
    lines = render_scorecard(result).splitlines()
    shown = [row(lines, "Encounters by who", name)[1:3] for name in COUNTED]
    for of_system, (_, system) in zip(zip(*shown, strict=True), result.sides, strict=True):
        total_s = sum(map(float, of_system))
        assert total_s == pytest.approx(system.failures["severity_s"].sum(), abs=0.02)

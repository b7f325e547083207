"""The comparison as text for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from nvcore.comparison import Result
from nvcore.dataset import Dataset
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.operating_points import point_note
from nvcore.evidence.table import judge_both
from nvcore.findings import Finding, Severity
from nvcore.metrics.encounter_classes import classes_of, shown_class
from nvcore.metrics.proximity.horizon import estimate_horizons
from nvcore.notes import Note, phrase, say
from nvcore.protocols import PROTOCOLS, Protocol
from nvcore.report.plan import verdict_plan
from nvcore.report.verdict import Verdict, verdict
from nvcore.report.words import (
    FUSION_RULE,
    lead,
    missed,
    n_frames_text,
    parted,
    saliency_caveat,
    sampling_note,
    scorecard_cells,
)
from nvcore.schema import Category
from nvcore.scoring import SystemResult
from nvcore.subjects import contributed
from nvcore.tables.encounters.miss_classes import class_counts
from nvcore.tables.inputs import inputs_table
from nvcore.tables.result import worst_intervals
from nvcore.wording import count_text, number, one_line, shortened

SHORT_ROWS = "* means little here: most encounters are one frame long"
"""What the mark in the scorecard says."""
MOST_RECORDINGS = 40
"""Recordings whose pictures or estimated horizons are printed."""
MOST_CODES = 12
"""Codes whose encounters are printed."""
COUNTED = {
    Category.BOTH: "both",
    Category.X_ONLY: "only X",
    Category.Y_ONLY: "only Y",
    Category.NEITHER: "neither",
}
NAME_WIDTH = 16
"""Longest name of a system in the head of a column; the full name is above the table."""


def render_scorecard(
    result: Result,
    findings: Sequence[Finding] = (),
    protocol: Protocol = PROTOCOLS["all"],
    *,
    evidence: pd.DataFrame | None = None,
    companions: Companions | None = None,
    plan: tuple[Note, ...] | None = None,
) -> str:
    """Scorecard of both systems, Venn counts, fusion, worst moments, and the verdict.

    Parameters
    ----------
    findings
        Of the audit; the verdict says on which of them it depends.
    protocol
        Which pedestrians count in the detection measures.
    evidence, companions
        ``evidence_table(result, protocol)``, ``find_companions(result, evidence)``, if already
        computed.
    plan
        ``verdict_plan(result, evidence, companions)``, likewise.
    """
    if evidence is None:
        evidence, companions = judge_both(result, protocol)
    elif companions is None:
        companions = find_companions(result, evidence, protocol)
    plan = verdict_plan(result, evidence, companions) if plan is None else plan
    conclusion = verdict(result, findings, evidence=evidence, companions=companions, plan=plan)
    caveat = result.objects.say(saliency_caveat(result.params))
    cells = scorecard_cells(result, indent="  ", mark=" *" if result.is_short else "")
    parts = [
        "\n".join(heading_lines(result)),
        "\n".join([*table_lines(result, cells), *measure_notes(result)]),
        _venn(result),
        _fusion(result),
        *([f"saliency: {caveat[0].lower()}{caveat[1:-1]}"] if caveat else []),
        *(_worst(result, letter, system) for letter, system in result.sides),
        render_verdict(conclusion),
    ]
    return "\n\n".join(parts)


def render_verdict(conclusion: Verdict) -> str:
    """The headline, a line for each topic, and what it all depends on."""
    lines = (f"  {topic}: {text}" for topic, text in conclusion.topics)
    return _text([f"In short: {conclusion.say(conclusion.headline)}", *lines])


def findings_count(findings: Sequence[Finding]) -> str:
    """How many findings of each severity there are."""
    counts = [
        count_text(n, kind.value)
        for kind in Severity
        if (n := sum(finding.severity == kind for finding in findings))
    ]
    return f"Audit: {', '.join(counts) or 'nothing found'}."


def render_findings(findings: Sequence[Finding]) -> str:
    """The audit's findings, one paragraph each, in the order given."""
    lines = [findings_count(findings)]
    for finding in findings:
        lines.append(f"  {finding.severity.value:<8}{finding.subject}: {finding.message}")
        if finding.place:
            lines.append(f"          first: {finding.place}")
        lines.append(f"          {finding.advice}")
    return _text(lines)


def render_dataset(dataset: Dataset) -> str:
    """What was read, how it was converted, and which frames are evaluated."""
    lines = []
    for row in inputs_table(dataset).to_dict("records"):
        first, n_files = row["first_file"], row["n_files"]
        files = first if n_files == 1 else f"{n_files} files, {first} ..."
        lines.append(f"{row['subject']}: {files} ({row['format']}; {row['conversion']})")
        if row["left_out"]:
            lines.append(f"  left out: {row['left_out']}")
    return _text([*lines, *dataset.notes])


def render_pictures(table: pd.DataFrame) -> str:
    """Which picture shows which frame, a line for each recording; empty: none has pictures."""
    lines = []
    for row in table.head(MOST_RECORDINGS).to_dict("records"):
        first, *others = (
            f"frame {row[f'{which}_frame']} shows {row[f'{which}_picture']}"
            for which in ("first", "middle", "last")
        )
        without = f"; {row['n_without']:,} of {row['n_frames']:,} frames have none"
        lines.append(
            f"  {row['recording']} ({row['pictures']}): {first}, {', '.join(others)}"
            f"{without if row['n_without'] else ''}"
        )
    if not lines:
        return ""
    more = len(table) - len(lines)
    return _text(["pictures:", *lines, *([f"  and of {more:,} more recordings"] if more else [])])


def render_horizons(dataset: Dataset) -> str:
    """Where the horizon seems to be in recordings that do not state it; empty: nothing to say."""
    is_open = dataset.recordings["horizon"].isna()
    horizons = [
        f"{name}: {dataset.objects.say(horizon.text)}"
        for name, horizon, is_asked in zip(
            dataset.recordings["name"], estimate_horizons(dataset), is_open, strict=True
        )
        if is_asked and horizon is not None
    ]
    if not horizons:
        return ""
    more = len(horizons) - MOST_RECORDINGS
    return _text(
        [
            "horizon, which is not stated, as box heights and foot rows tell (give it as horizon "
            "in the session file, or in a table of recordings, which this command can write):",
            *(f"  {text}" for text in horizons[:MOST_RECORDINGS]),
            *([f"  and of {more:,} more, in that table"] if more > 0 else []),
        ]
    )


def render_inputs(result: Result) -> str:
    """`render_dataset`, and the gaps that the analysis had to fill."""
    lines = [render_dataset(result.dataset)]
    n = len(result.tracks.linked_recordings)
    if n:
        lines.append(
            f"the truth of {n} recording{'s' if n > 1 else ''} has {result.objects.plural} without "
            "track ids: they were linked to encounters by overlap from frame to frame"
        )
    borrowed = result.borrowed
    if borrowed is not None and borrowed.n_borrowed + borrowed.n_unknown:
        lines.append(borrowed.text)
    for of_source, without in (
        ("of the truth", result.k_truth.n_without_distance),
        ("of X", result.x.weights.n_without_distance),
        ("of Y", result.y.weights.n_without_distance),
    ):
        if without:
            boxes = count_text(without, f"box {of_source} has", f"boxes {of_source} have")
            lines.append(
                f"{boxes} no distance and {'weighs' if without == 1 else 'weigh'} by height"
            )
    return "\n".join(lines)


def heading_lines(result: Result) -> list[str]:
    """X, Y, how much is compared, and at which operating points where they are unequal."""
    one = result.objects.singular
    lines = [
        f"{letter.upper()} = {system.name}"
        + (f", score >= {system.threshold:g}" if system.threshold is not None else ", all scores")
        for letter, system in result.sides
    ]
    lines.append(
        f"{count_text(len(result.dataset.recordings), 'recording')}, "
        f"{n_frames_text(result)}, {result.duration_s:,.1f} s, "
        f"{count_text(int(result.n_truth.sum()), f'{one} box', f'{one} boxes')}, "
        f"{count_text(result.venn.n_near, 'encounter')} "
        f"({result.venn.distant:,} distant, not counted)"
    )
    note = point_note(result)
    lines += [say(note, result.objects)] if note else []
    return [one_line(line) for line in lines]


def table_lines(result: Result, cells: Sequence[tuple[str, ...]]) -> list[str]:
    """Measures below the names of both systems, see `score_cells`."""
    heads = [_head(letter, system) for letter, system in result.sides]
    rows = [("", *heads, "X - Y", "better"), *cells]
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    lines = [
        "  ".join([row[0].ljust(widths[0]), *(row[i].rjust(max(widths[i], 9)) for i in (1, 2, 3))])
        + f"  {row[4]}"
        for row in rows
    ]
    return [one_line(line.rstrip()) for line in lines]


def measure_notes(result: Result) -> list[str]:
    """What to know of the rates, and of measures that need encounters of several frames."""
    notes = [SHORT_ROWS] if result.is_short else []
    sampling = sampling_note(result.dataset.frame_columns)
    of_subjects = (
        say(fact, result.objects)
        for remarks in contributed("remarks")
        for fact in remarks.note(result)
    )
    return [one_line(note) for note in (*notes, sampling, *of_subjects) if note]


def _head(letter: str, system: SystemResult) -> str:
    return f"{letter.upper()}: {shortened(one_line(system.name), NAME_WIDTH)}"


def _venn(result: Result) -> str:
    counts = result.venn.counts()
    detected = ", ".join(f"{words} {counts[kind]}" for kind, words in COUNTED.items())
    x, y = (result.severity_of(system) for _, system in result.sides)
    weights = "; ".join(
        f"{words}: X misses {x[kind]:.2f} s and Y {y[kind]:.2f} s"
        for kind, words in COUNTED.items()
    )
    lines = [
        f"encounters detected by: {detected} ({result.venn.distant:,} distant, not counted)",
        f"severity (1 s: {result.objects.say('{a_one}')} straight ahead and near is missed for "
        f"1 s), of encounters detected by {weights}",
    ]
    lines += code_lines(result)
    notes = missed(result), parted(result)
    lines.append("; ".join(phrase(note, result.objects, "terminal") for note in notes))
    lines.append(phrase(lead(result), result.objects, "terminal"))
    for lines_of in contributed("lines"):
        lines += lines_of(result)
    boxes = result.boxes
    lines.append(
        f"boxes matched by: both {boxes.both:,}, only X {boxes.x_only:,}, "
        f"only Y {boxes.y_only:,}, neither {boxes.neither:,} (all boxes, distant ones too)"
    )
    n_absorbed = [
        f"{letter.upper()} {system.matches.n_absorbed:,}" for letter, system in result.sides
    ]
    lines.append(
        result.objects.say(
            "detections on {people} or regions that the truth ignores, not counted: "
        )
        + ", ".join(n_absorbed)
    )
    return _text(lines)


def code_lines(result: Result) -> list[str]:
    """Who detects the encounters of each code; empty: nothing is coded."""
    coded, counts = classes_of(result.dataset).coded, class_counts(result).to_dict("index")
    shown = [code for code in coded if code in counts]
    lines = [
        f"encounters with {shown_class(code)}, detected by: "
        + ", ".join(f"{words} {counts[code][kind.value]}" for kind, words in COUNTED.items())
        for code in shown[:MOST_CODES]
    ]
    more = len(shown) - len(lines)
    lines += [f"and with {more:,} more codes"] if more else []
    return lines or ["no encounter overlaps a coded interval"] if coded else []


def _fusion(result: Result) -> str:
    fusion = result.fusion
    lines = []
    for label, system in (("X or Y", fusion.x), ("X and Y", fusion.y)):
        n_detected = int(system.encounters["is_detected"].sum())
        lines.append(
            f"fusion {label}: {n_detected} of {result.venn.n_near} encounters, "
            f"{count_text(system.false_alarm_summary.episodes, 'false-alert episode')}, "
            f"mean similarity {number(system.summary.mean, '.4f')}"
        )
    lines.append(f"fusion: {FUSION_RULE[0].lower()}{FUSION_RULE[1:-1]}")
    return "\n".join(lines)


def _worst(result: Result, letter: str, system: SystemResult) -> str:
    table = worst_intervals(result, letter)
    name = f"worst intervals of {letter.upper()} ({system.name})"
    if table.empty:
        return one_line(f"{name}: none below {result.params.low:g}")
    lines = [f"{name}, weighted by what similarity lacks to {result.params.low:g}:"]
    lines += [
        f"  {row['recording']}  {row['start_s']:.2f} s to "
        f"{row['start_s'] + row['duration_s']:.2f} s  "
        f"(frames {row['first_frame']} to {row['last_frame']}): weighs {row['depth_s']:.2f} "
        f"s, lowest {row['min_similarity']:.3f} at frame {row['worst_frame']}"
        for row in table.to_dict("records")
    ]
    return _text(lines)


def _text(lines: Sequence[str]) -> str:
    """The lines as text; names in them cannot start lines of their own."""
    return "\n".join(one_line(line) for line in lines)

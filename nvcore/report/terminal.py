"""Render the comparison as text for a terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, Final

import pandas as pd

from nvcore.common.findings import Finding, Severity
from nvcore.common.wording import aligned, capitalised, count_text, one_line, shortened
from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset import Dataset
from nvcore.evidence.operating_points import point_note
from nvcore.metrics.proximity.horizon import estimate_horizons
from nvcore.notes import Note, phrase, say
from nvcore.report.decisive_moments import Moment, main_moments
from nvcore.report.plan import planned_verdict
from nvcore.report.remarks import remarks_on
from nvcore.report.section import (
    IN_THE_FILE,
    Block,
    Fold,
    Paragraphs,
    Section,
    Table,
    Text,
    worded_texts,
)
from nvcore.report.sections import result_sections, with_cautions
from nvcore.report.sections.results import significance_section
from nvcore.report.verdict import Verdict
from nvcore.report.words import n_frames_text, sampling_note, scorecard_cells
from nvcore.settings.objects import Objects
from nvcore.tables.inputs import inputs_table

MOST_RECORDINGS = 40
"""Maximum number of recordings for printing pictures or estimated horizons."""
WIDTH = 100
"""Maximum length of lines of text, in characters."""
RECORDING_WIDTH: Final = 24
"""Maximum length of a recording's name, and of a finding's subject."""
NAME_WIDTH = 16
"""Maximum length of a system's name in a column heading. The full name is above the table."""


def render_scorecard(result: Result, conclusion: Verdict | None = None) -> str:
    """Return the scorecard, the sections on measures, and the verdict as text.

    Parameters
    ----------
    conclusion
        None: `nvcore.report.plan.planned_verdict` of the result.
    """
    conclusion = conclusion or planned_verdict(result)
    cells = scorecard_cells(result, indent="  ", mark=" *" if result.is_short else "")
    sections = result_sections(result)
    if conclusion.evidence is not None:
        sections.append(significance_section(result, conclusion.evidence))
    parts = [
        "\n".join(heading_lines(result)),
        "\n".join([*table_lines(result, cells), *measure_notes(result)]),
        *(render_section(section, result.objects) for section in with_cautions(sections, result)),
        render_verdict(conclusion),
        "\n".join(chain(*moment_lines(result))),
    ]
    return "\n\n".join(filter(None, parts))


def render_section(section: Section, objects: Objects) -> str:
    """Return a section's notes and tables as text, including folded ones. Figures are omitted."""
    worded = section.worded(objects)
    return _text([worded.title, *block_lines(worded.blocks)])


def block_lines(blocks: Sequence[Block]) -> Iterator[str]:
    """Yield the lines of paragraphs and tables, without those that a report's CSV file has."""
    for block in blocks:
        if isinstance(block, Fold) and block.where != IN_THE_FILE:
            yield f"  {block.title}: {block.where}"
        elif isinstance(block, Fold):
            yield from block_lines(block.blocks)
        elif isinstance(block, Paragraphs):
            for text in block.texts:
                yield from fold(f"  {text}")
        elif isinstance(block, Table):
            yield f"  {block.title}:" if block.rows else f"  {block.title}: none"
            yield from (f"    {line}" for line in _rows(block))
            for note in block.notes:
                yield from fold(f"    {note}")


def _rows(block: Table) -> list[str]:
    if not block.rows:
        return []
    rows = block.rows
    if block.marks:
        marked = zip(rows, block.marks, strict=True)
        rows = tuple(
            (f"{first} ({mark})" if mark else first, *others) for (first, *others), mark in marked
        )
    return aligned([block.head, *rows], block.right)


def moment_lines(result: Result) -> list[list[str]]:
    """Return the lines of each moment to look at, the first with a heading."""
    of_moments = [_moment(result, moment) for moment in main_moments(result)]
    if of_moments:
        of_moments[0] = ["Moments to look at:", *of_moments[0]]
    return of_moments


def _moment(result: Result, moment: Moment) -> list[str]:
    """Return where a moment is, which system misses whom, and what the miss costs."""
    dataset, encounter = result.dataset, moment.encounter
    frame = dataset.frames.iloc[moment.row]
    recording = str(dataset.recordings["name"].iloc[int(frame["recording"])])
    what: dict[str, Any] = {"reason": moment.text}
    if moment.title.startswith("Only "):
        letter = "y" if moment.loser == "x" else "x"
        name = shortened(one_line(result.system(letter).name), NAME_WIDTH)
        severity_s = result.system(moment.loser).failures["severity_s"]
        what = {"winner": f"{name} ({letter.upper()})", "seconds": severity_s.iloc[encounter]}
        what["track"] = result.encounters.track[encounter]
    note = Note(
        "terminal.moment",
        recording=shortened(one_line(recording), RECORDING_WIDTH),
        frame=int(frame["frame"]),
        time_s=frame["time_s"],
        **what,
    )
    return fold(f"  {phrase(note, result.objects)}")


def fold(text: str, most: int | None = None) -> list[str]:
    """Wrap a text at `WIDTH` characters, indenting all lines but the first more deeply.

    Parameters
    ----------
    most
        Maximum number of lines. An ellipsis replaces the rest.
    """
    indent = " " * (len(text) - len(text.lstrip()) + 2)
    return textwrap.wrap(
        one_line(text),
        WIDTH,
        subsequent_indent=indent,
        max_lines=most,
        placeholder=" …",
        break_on_hyphens=False,
    )


def render_verdict(conclusion: Verdict) -> str:
    """Return the verdict's headline, followed by a paragraph for each topic."""
    texts = [f"In short: {conclusion.say(conclusion.headline)}"]
    texts += [f"  {topic}: {text}" for topic, text in conclusion.topics]
    return "\n".join(line for text in texts for line in fold(text))


def findings_count(findings: Sequence[Finding]) -> str:
    """Return the number of findings of each severity."""
    counts = [
        count_text(n, kind.value)
        for kind in Severity
        if (n := sum(finding.severity == kind for finding in findings))
    ]
    return f"Audit: {', '.join(counts) or 'nothing found'}."


def render_findings(findings: Sequence[Finding]) -> str:
    """Return the audit's findings, one paragraph each, in the order given."""
    lines = [findings_count(findings)]
    for finding in findings:
        lines.append(f"  {finding.severity.value:<8}{finding.subject}: {finding.message}")
        if finding.place:
            lines.append(f"          first: {finding.place}")
        lines.append(f"          {finding.advice}")
    return _text(lines)


def render_dataset(dataset: Dataset) -> str:
    """Return the inputs with their conversions, and notes on the dataset, as text."""
    lines = []
    for row in inputs_table(dataset).to_dict("records"):
        first, n_files = row["first_file"], row["n_files"]
        files = first if n_files == 1 else f"{n_files} files, {first} ..."
        lines.append(f"{row['subject']}: {files} ({row['format']}; {row['conversion']})")
        if row["left_out"]:
            lines.append(f"  left out: {row['left_out']}")
    return _text([*lines, *dataset.notes])


def render_pictures(table: pd.DataFrame) -> str:
    """Return which frames show which pictures, a line per recording, or "" without pictures."""
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
    """Return estimated horizons of recordings that state none, or "" without an estimate."""
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
    """Return the inputs, and how the analysis filled gaps in tracks and distances, as text."""
    n_linked, borrowed = len(result.tracks.linked_recordings), result.borrowed
    texts = [say(Note("sections.linked", n=n_linked), result.objects)] if n_linked else []
    if borrowed is not None and borrowed.n_borrowed + borrowed.n_unknown:
        texts.append(f"{capitalised(borrowed.text)}.")
    texts += [
        say(Note("sections.no_distance", source=source, n=n), result.objects)
        for source, n in (
            ("the truth", result.k_truth.n_without_distance),
            ("X", result.x.weights.n_without_distance),
            ("Y", result.y.weights.n_without_distance),
        )
        if n
    ]
    return "\n".join([render_dataset(result.dataset), *map(one_line, texts)])


def heading_lines(result: Result) -> list[str]:
    """Return lines on X, Y, the amount of data, and operating points if they are unequal."""
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
    """Return the lines of a table of measures, with the names of both systems as headings.

    `cells` are as from `score_cells`.
    """
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
    """Return cautions about rates from sampled frames and measures that need longer encounters.

    Remarks of subjects are included.
    """
    little = [Note("sections.means_little")] if result.is_short else []
    sampling = sampling_note(result.dataset.frame_columns)
    notes: list[Text] = [*little, *([sampling] if sampling else []), *remarks_on(result)]
    return [one_line(text) for text in worded_texts(notes, result.objects)]


def _head(letter: str, system: SystemResult) -> str:
    return f"{letter.upper()}: {shortened(one_line(system.name), NAME_WIDTH)}"


def _text(lines: Sequence[str]) -> str:
    """Join lines to one text and escape line breaks in names."""
    return "\n".join(one_line(line) for line in lines)

"""The comparison on one screen of a terminal, with the most important facts first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.common.findings import Finding, Severity
from nvcore.common.wording import UNDEFINED, one_line, shortened
from nvcore.comparison.compare import Result
from nvcore.report.plan import planned_verdict
from nvcore.report.terminal import (
    RECORDING_WIDTH,
    WIDTH,
    findings_count,
    fold,
    heading_lines,
    measure_notes,
    moment_lines,
    table_lines,
)
from nvcore.report.verdict import HOW_SURE, Verdict
from nvcore.report.words import score_cells
from nvcore.tables.scorecard import LEADING, pick_rows, score_rows

MOST_LINES: Final = 35
MOST_FINDINGS: Final = 3
"""Maximum number of shown errors and warnings of the audit. Others are counted."""
FULL_ONLY: Final = ("Operating points", "Question", "Other measures", HOW_SURE)
"""Topics of the verdict that are omitted: heading, scorecard and headline cover most of them."""


def render_brief(
    result: Result,
    findings: Sequence[Finding] = (),
    conclusion: Verdict | None = None,
    *,
    next_steps: Sequence[str] = (),
    most_lines: int = MOST_LINES,
) -> str:
    """Return audit, main measures, verdict and moments to look at, short enough for one screen.

    Table, headline, how sure it is and the worst finding are always shown. Operating points,
    remarks on measures, other findings, moments and topics of the verdict follow if there is room,
    in this order.

    Parameters
    ----------
    findings
        Findings of the audit, worst first, as the terminal shows them.
    conclusion
        None: `nvcore.report.plan.planned_verdict` of the result.
    next_steps
        Commands to run next, a line each.
    most_lines
        Maximum number of lines, unless the parts that are always shown need more.
    """
    conclusion = conclusion or planned_verdict(result, findings)
    rows = pick_rows(result, score_rows(result), LEADING)
    cells = score_cells(rows, indent="", mark=" *" if result.is_short else "")
    x, y, extent, *point = heading_lines(result)
    systems = [f"{x}; {y}"]
    if len(systems[0]) > WIDTH:
        systems = [shortened(line, WIDTH) for line in (x, y)]
    count, *of_audit = _audit(findings)
    audit = [*count, *of_audit.pop(0)] if of_audit else []
    heading = [*systems, *fold(extent, 2), *([] if audit else count)]
    table = table_lines(result, cells)
    if (excess := max(map(len, table)) - WIDTH) > 0:
        longest = max(len(label) for label, *_ in cells) - excess
        table = table_lines(result, [(shortened(label, longest), *of) for label, *of in cells])
    decision = fold(f"In short: {conclusion.say(conclusion.headline)}")
    topics = conclusion.topics
    how_sure = dict(topics).get(HOW_SURE, UNDEFINED)
    if not how_sure.startswith(UNDEFINED):
        decision += fold(f"  {HOW_SURE}: {how_sure}")
    moments: list[str] = []
    blocks = [audit, heading, table, decision, moments, [*next_steps]]
    room = most_lines - sum(len(block) + 1 for block in blocks if block) + 1
    for block, optional in (
        (heading, [fold(note) for note in point]),
        (table, [fold(note) for note in measure_notes(result)]),
        (audit, of_audit),
        (moments, moment_lines(result)),
        (decision, [fold(f"  {of}: {text}") for of, text in topics if of not in FULL_ONLY]),
    ):
        for lines in optional:
            needed = len(lines) + (not block)  # an empty line goes before a new block
            if needed <= room:
                block += lines
                room -= needed
    return "\n\n".join("\n".join(block) for block in blocks if block)


def _audit(findings: Sequence[Finding]) -> list[list[str]]:
    """Return lines that count the findings, then lines for the first errors and warnings.

    Only the worst finding comes with its fix.
    """
    serious = [finding for finding in findings if finding.severity is not Severity.NOTE]
    parts = [[findings_count(findings)]]
    for finding in serious[:MOST_FINDINGS]:
        is_worst = finding is serious[0]
        subject = shortened(one_line(finding.subject), RECORDING_WIDTH)
        label = f"  {finding.severity.value:<8}{subject}: "
        parts.append(fold(label + finding.message, 4 if is_worst else 1))
        if is_worst:
            where = finding.place
            parts[-1] += fold(f"    {where and f'First: {where}. '}{finding.advice}", 3)
    return parts

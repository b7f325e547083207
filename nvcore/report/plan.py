"""Study plan behind the verdict, as text for the terminal and as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import pandas as pd

from nvcore.common.arguments.plan import PlanArguments
from nvcore.common.findings import Finding
from nvcore.common.wording import duration_text, percent
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import difference_text
from nvcore.evidence.companions import Companions
from nvcore.evidence.looks import ONLY_LOOK, Look, correct_for_looks
from nvcore.evidence.measures import evidence_of, primary_of
from nvcore.evidence.operating_points import are_unequal
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.planning.notes import (
    ASSUMPTIONS,
    QUESTION,
    notes_before_plan,
    notes_for_verdict,
)
from nvcore.evidence.planning.plan import Plan, plan_recordings
from nvcore.evidence.table import judge_both
from nvcore.notes import Note
from nvcore.report.verdict import Verdict, verdict
from nvcore.settings.protocols import PROTOCOLS, Protocol
from nvcore.tables.summary import without_nan


def verdict_plan(
    result: Result,
    evidence: pd.DataFrame | None,
    companions: Companions | None,
    *,
    plans: Mapping[str, Plan] | None = None,
    command: str = "",
) -> tuple[Note, ...]:
    """Plan how many recordings would show a difference in the primary measure.

    Empty if a difference is shown already, or nothing can be planned. For unequal operating points,
    the plan is for the comparison at equal false alarms.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result.
    companions
        `nvcore.evidence.companions.find_companions` of the result.
    plans
        Plans of the result for differences as found, by key, if already computed.
    command
        Name this command, which plans, instead of planning: that takes seconds.
    """
    key, basis = primary_of(result.dataset).key, result
    if are_unequal(result):
        if companions is None or companions.equal is None:
            return ()
        basis, evidence = companions.equal, companions.evidence
    row = None if evidence is None else evidence_of(evidence, key)
    if row is None or row.p_corrected <= SIGNIFICANT:
        return ()
    if command:
        return notes_before_plan(row, command)
    plan = (plans or {}).get(key) if basis is result else None
    plan = plan or plan_recordings(basis, PlanArguments(measure=key), evidence=row)
    return notes_for_verdict(plan)


def planned_verdict(
    result: Result,
    findings: Sequence[Finding] = (),
    protocol: Protocol = PROTOCOLS["all"],
    *,
    plan_command: str = "",
    look: Look = ONLY_LOOK,
) -> Verdict:
    """Compute the verdict with its tests, comparisons at equal false alarms, and a study plan.

    Parameters
    ----------
    findings
        Findings of the audit. The verdict names those that affect it.
    protocol
        Selection of the pedestrians for the detection measures.
    plan_command
        Command that plans, to be named in place of a plan.
    look
        Number and factor of this look at the data (`nvcore.evidence.looks`).
    """
    evidence, companions = correct_for_looks(*judge_both(result, protocol), look)
    plan = verdict_plan(result, evidence, companions, command=plan_command)
    return verdict(result, findings, evidence=evidence, companions=companions, plan=plan, look=look)


def render_plan(plan: Plan) -> str:
    """Return the plan in sentences, and the power for each simulated number of recordings."""
    lines = [QUESTION, *(f"  {sentence}" for sentence in plan.sentences)]
    for size in plan.sizes:
        if not size.points:
            continue
        amount = difference_text(size.difference, plan.evidence.figure)
        lines += ["", f"{ASSUMPTIONS[size.assumption]} ({amount})"]
        lines.append("  recordings  encounters       time  power  95 % Monte Carlo")
        for row in plan.curve[plan.curve["assumption"] == size.assumption].to_dict("records"):
            n = row["n_recordings"]
            seconds = plan.duration_s / max(plan.evidence.n, 1) * n
            ends = f"{percent(row['low'])} to {percent(row['high'])}"
            mark = "  <" if n == size.n_recordings else ""
            lines.append(
                f"  {n:>10,}  {row['n_encounters']:>10,}  {duration_text(seconds):>9}"
                f"  {percent(row['power']):>5}  {ends}{mark}"
            )
    return "\n".join(lines)


def plan_values(plan: Plan) -> dict[str, Any]:
    """Return the plan as numbers and texts for JSON, with None for undefined values."""
    row = plan.evidence
    content = {
        "measure": row.figure,
        "label": row.label,
        **{name: getattr(row, name) for name in ("x", "y", "difference", "low", "high", "p")},
        "n": row.n,
        "unit": row.unit,
        "n_encounters": plan.n_encounters,
        "duration_s": plan.duration_s,
        "power": plan.power,
        "n_tests": plan.n_tests,
        "noninferiority": None if plan.noninferiority is None else asdict(plan.noninferiority),
        "sizes": [
            {
                **{name: of for name, of in vars(size).items() if name != "points"},
                "points": [point._asdict() for point in size.points],
            }
            for size in plan.sizes
        ],
        "sentences": list(plan.sentences),
    }
    values: dict[str, Any] = without_nan(content)
    return values


def plan_json(plan: Plan) -> str:
    """Return the plan as JSON text."""
    return json.dumps(plan_values(plan), indent=2, ensure_ascii=False, allow_nan=False) + "\n"

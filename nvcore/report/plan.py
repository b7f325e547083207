"""A plan for the terminal and as JSON."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import Any, Final

from nvcore.evidence.planning.study import Assumption, StudyPlan
from nvcore.evidence.planning.words import (
    QUESTION,
    describe_plan,
    difference_text,
    duration_text,
    percent,
)

ASSUMPTIONS: Final[dict[Assumption, str]] = {
    "as found": "difference as found",
    "as named": "difference as named",
    "equal": "X and Y equal",
}
"""What is assumed of the true difference, in words."""


def render_plan(plan: StudyPlan) -> str:
    """The plan in sentences, and the power of every size that was simulated."""
    lines = [QUESTION, *(f"  {sentence}" for sentence in describe_plan(plan))]
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


def plan_values(plan: StudyPlan) -> dict[str, Any]:
    """The plan as numbers and texts for JSON; None is undefined."""
    row = plan.evidence
    return {
        "measure": row.figure,
        "label": row.label,
        **{
            name: _defined(getattr(row, name))
            for name in ("x", "y", "difference", "low", "high", "p")
        },
        "n": row.n,
        "unit": row.unit,
        "n_encounters": plan.n_encounters,
        "duration_s": plan.duration_s,
        "power": plan.power,
        "n_tests": plan.n_tests,
        "noninferiority": None
        if plan.noninferiority is None
        else {name: _defined(value) for name, value in asdict(plan.noninferiority).items()},
        "sizes": [
            {
                **{
                    name: _defined(getattr(size, name))
                    for name in size.__dataclass_fields__
                    if name != "points"
                },
                "points": [point._asdict() for point in size.points],
            }
            for size in plan.sizes
        ],
        "sentences": list(describe_plan(plan)),
    }


def plan_json(plan: StudyPlan) -> str:
    """The plan as JSON text."""
    return json.dumps(plan_values(plan), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _defined(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value

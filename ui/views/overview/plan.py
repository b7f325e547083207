"""Overview page: how many recordings would show a difference, computed on request."""

from __future__ import annotations

from functools import partial
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.arguments.plan import PlanArguments
from nvcore.common.progress import Progress, part_of
from nvcore.common.wording import capitalised, count_text
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import count_recordings, inference_of
from nvcore.evidence.companions import Companions
from nvcore.evidence.measures import primary_of
from nvcore.evidence.operating_points import are_unequal
from nvcore.evidence.planning import PLAN_KEYS, Plan, plan_recordings
from nvcore.evidence.planning.pilot import too_few_for_pilot
from nvcore.evidence.units import WHOLE, count_whole
from nvcore.figures.dots import power_plot
from nvcore.notes import Note
from nvcore.report.plan import verdict_plan
from nvcore.settings.protocols import Protocol
from ui.jobs.computed import Computation
from ui.jobs.page_run import PageRun
from ui.session import state, store
from ui.session.results import comparison_key
from ui.widgets.charts import draw_chart
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import docs_link, plain

DIFFERENCE: Final = "difference"
QUESTIONS: Final = {
    DIFFERENCE: "Is there a difference?",
    "x": "Is X at most so much worse?",
    "y": "Is Y at most so much worse?",
}


class _Answer(NamedTuple):
    plan: Plan
    of_verdict: tuple[Note, ...]


RUN: Final = PageRun[_Answer]("study_plan", "plan", "Simulating studies")


def known_plan(result: Result) -> tuple[Note, ...]:
    """Return the verdict's notes on recordings still needed, or () before a plan is computed."""
    notes: tuple[Note, ...] | None = state.known("verdict_plan", comparison_key(result))
    return notes or ()


def draw(result: Result, evidence: pd.DataFrame, companions: Companions | None) -> None:
    """Draw the controls of a study plan, and the plan once it is computed."""
    if not evidence["unit"].isin(WHOLE).any():
        n_independent, _ = count_whole(result.dataset)
        reason = too_few_for_pilot(count_recordings(result), n_independent)
        st.markdown(f"{capitalised(reason)}.")
        return
    asked = _ask(result, evidence)
    if companions is None and are_unequal(result):
        st.markdown("Possible once the comparison at equal false alarms is known.")
    elif asked is not None:
        _draw_answer(result, evidence, companions, asked)
    st.caption(
        "Studies are simulated from these recordings, each drawn as a whole, and tested as in "
        "the table above: computed within seconds when this part is opened "
        f"({docs_link('Significance', 'how-much-more-would-it-take', doc='significance')})."
    )


def _ask(result: Result, evidence: pd.DataFrame) -> PlanArguments | None:
    """Draw the inputs of a study plan and return them, or None while a margin is missing."""
    labels = dict(zip(evidence["figure"], evidence["label"], strict=True))
    question = choose_side_by_side("Question", QUESTIONS, "plan_question", default=DIFFERENCE)
    left, right = st.columns(2, vertical_alignment="bottom")
    names = [name for name, key in PLAN_KEYS.items() if key in labels]
    keys, primary = [PLAN_KEYS[name] for name in names], primary_of(result.dataset).key
    if store.PLAN_MEASURE.get() not in names:  # left over from data with other measures
        store.PLAN_MEASURE.pop()
    measure = left.selectbox(
        "Measure",
        names,
        index=keys.index(primary) if primary in keys else 0,
        format_func=lambda name: capitalised(labels[PLAN_KEYS[name]]),
        key=store.PLAN_MEASURE.key,
        persist_state="session",
    )
    scale = inference_of(PLAN_KEYS[measure]).scale
    unit = "percentage points" if scale.is_share else scale.unit or "0 to 1"
    is_margin = question != DIFFERENCE
    amount: float | None = right.number_input(
        f"{'At most worse by' if is_margin else 'Smallest difference that matters'} ({unit})",
        0.0,
        99.0 if scale.is_share else None,
        None,
        key=f"plan_{question}_{measure}",
        placeholder="a margin chosen beforehand" if is_margin else "as found",
        persist_state="session",
    )
    n_tested = int(np.isfinite(evidence["p_corrected"]).sum())
    is_corrected = not is_margin and st.toggle(
        f"Corrected for {count_text(n_tested, 'measure')}",
        key="plan_corrected",
        persist_state="session",
        help="Else p of this measure by itself, as the primary one is tested.",
    )
    size = amount / (100 if scale.is_share else 1) if amount else None
    if is_margin and size is None:
        st.markdown("Give the margin: by how much it may be worse and still be taken.")
        return None
    return PlanArguments(
        measure=measure,
        difference=None if is_margin else size,
        margin=size if is_margin else None,
        candidate="x" if question == "x" else "y",
        n_tests=max(n_tested, 1) if is_corrected else 1,
    )


def _draw_answer(
    result: Result, evidence: pd.DataFrame, companions: Companions | None, asked: PlanArguments
) -> None:
    work = Computation(
        RUN,
        (*comparison_key(result), asked, state.protocol()),
        partial(_answer, result, evidence, companions, asked, state.protocol()),
    )
    if store.PLAN_ASKED.pop() and state.known(RUN.name, work.key) is None:
        work.start()
    answer = work.draw_or_offer("Simulate studies", "query_stats", is_quick=False)
    if answer is None:
        return
    space, key = state.workspace(), comparison_key(result)
    if space.peek("verdict_plan", key) is None:
        space.cached("verdict_plan", key, lambda: answer.of_verdict)
        st.rerun()  # the verdict above shows it
    st.markdown("\n".join(f"- {plain(sentence)}" for sentence in answer.plan.sentences))
    if any(size.points for size in answer.plan.sizes):
        draw_chart(power_plot(answer.plan, theme=state.theme()), "power")


def _answer(
    result: Result,
    evidence: pd.DataFrame,
    companions: Companions | None,
    asked: PlanArguments,
    protocol: Protocol,
    progress: Progress,
) -> _Answer:
    plan = plan_recordings(result, asked, protocol=protocol, progress=part_of(progress, 0.0, 0.7))
    progress(0.7, "the verdict")
    return _Answer(plan, verdict_plan(result, evidence, companions))

"""Both systems at equal false alarms and strictly paired: for the verdict, and shown in its place.

Pages that show what the verdict is about let a person choose between that and X and Y as set.
"""

from __future__ import annotations

from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison import Result
from nvcore.evidence.claims import Basis
from nvcore.evidence.companions import Companions, are_unequal, find_companions
from nvcore.progress import Progress
from nvcore.report.equal_alarms import equal_alarms_of, equal_alarms_title
from ui.jobs.computed import Computation
from ui.session import state
from ui.session.results.evidence import comparison_key, measure_evidence
from ui.shell.messages import draw_as_set_note
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import plain

KIND: Final = "companions"
MOST: Final = 4
QUICK_BOXES: Final = 50_000
"""Up to so many boxes it takes a fraction of a second and is done at once."""
BASES: Final = {Basis.AS_SET: "As set", Basis.EQUAL_ALARMS: "At equal false alarms"}


def is_quick(result: Result) -> bool:
    """Whether the companions are computed at once."""
    return len(result.dataset.boxes) <= QUICK_BOXES


def known_companions(result: Result) -> Companions | None:
    """The companions of the comparison, if they are computed already."""
    companions: Companions | None = state.known(KIND, comparison_key(result))
    return companions


def wait_for_companions(result: Result, evidence: pd.DataFrame) -> Companions | None:
    """The companions of the comparison; None while they are computed in the background."""

    def compute(_: Progress) -> Companions:
        return find_companions(result, evidence)

    computation = Computation(
        kind=KIND,
        key=comparison_key(result),
        compute=compute,
        thing="the comparison at equal false alarms",
        doing="comparing",
        most=MOST,
    )
    companions, is_missing = computation.draw(is_quick=is_quick(result))
    job = state.workspace().job(computation.kind)
    if is_missing and (job is None or job.key != computation.key):  # not one that was cancelled
        computation.start()
        computation.draw(is_quick=False)
    return companions


def companions_if_needed(result: Result) -> Companions | None:
    """The companions where the verdict is about another comparison than that as set.

    None where it is not, or while they are computed in the background.
    """
    if not are_unequal(result):
        return None
    known = known_companions(result)
    if known is not None:
        return known
    with st.spinner("Comparing at equal false alarms"):
        evidence = measure_evidence(result)
        return wait_for_companions(result, evidence)


def choose_comparison(result: Result, companions: Companions | None, page: str) -> Result:
    """The comparison that is shown, with what it is: that of the verdict unless another is chosen.

    Without another one in the verdict the comparison as set, which may be at unequal operating
    points.

    Parameters
    ----------
    companions
        Of the comparison; None: not known yet, or not needed.
    page
        Begins the keys of the widgets.
    """
    equal = equal_alarms_of(result, companions)
    if equal is None:
        draw_as_set_note(result)
        return result
    assert companions is not None
    basis = choose_side_by_side(
        "What is compared",
        BASES,
        f"{page}_basis",
        default=Basis.EQUAL_ALARMS,
        label_visibility="collapsed",
    )
    if basis is Basis.AS_SET:
        draw_as_set_note(result)
        return result
    text, button = st.columns([3, 2], vertical_alignment="center")
    text.markdown(plain(f"{equal_alarms_title(companions)}, as in the verdict."))
    moved = companions.moved
    button.button(
        "Set this threshold",
        key=f"{page}_set_equal_alarms",
        on_click=state.set_threshold,
        args=(moved, equal.system(moved).threshold),
        width="stretch",
        help="The whole page, and every other, is then at equal false alarms.",
    )
    return equal

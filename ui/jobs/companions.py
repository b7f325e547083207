"""Both systems at equal false alarms and strictly paired: for the verdict, and shown in its place.

Pages that show what the verdict is about let a person choose between that and X and Y as set.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

import pandas as pd
import streamlit as st

from nvcore.comparison import Result
from nvcore.evidence.claims import Basis
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.operating_points import EqualAlarms, are_unequal, find_equal_alarms
from nvcore.evidence.units import find_units
from nvcore.progress import Progress
from nvcore.report.equal_alarms import equal_alarms_of
from nvcore.sentences.facts import AtEqualAlarms
from ui.jobs.background import Output
from ui.jobs.computed import Computation
from ui.session import state
from ui.session.results.evidence import comparison_key, miss_rate_kept_by
from ui.shell.messages import draw_as_set_note
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import plain

KIND: Final = "companions"
ALIKE: Final = "equal_alarms"
"""The kind of the comparison at equal false alarms alone."""
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
    protocol = state.protocol()  # not to be asked in the background
    miss_rate = miss_rate_kept_by(state.cached, result, find_units(result), protocol)
    return _wait_for(
        result, KIND, lambda _: find_companions(result, evidence, protocol, miss_rate=miss_rate)
    )


class Alternative(NamedTuple):
    """What the verdict is about instead of the comparison as set."""

    equal: EqualAlarms | None = None
    """None: there is none, or not yet."""
    is_awaited: bool = False
    """Whether it is still being computed."""


def wait_for_equal_alarms(result: Result) -> Alternative:
    """The comparison at equal false alarms, where the verdict is about that.

    It takes a part of the time of the companions, which have it with its evidence.
    """
    if not are_unequal(result):
        return Alternative()
    known = known_companions(result)
    if known is not None:
        return Alternative(equal_alarms_of(result, known))
    with st.spinner("Comparing at equal false alarms"):
        found = _wait_for(result, ALIKE, lambda _: (find_equal_alarms(result),))
    if found is not None:
        return Alternative(found[0])
    job = state.workspace().job(ALIKE)
    return Alternative(None, job is not None and job.is_busy)


def _wait_for(result: Result, kind: str, compute: Callable[[Progress], Output]) -> Output | None:
    computation = Computation(
        kind=kind,
        key=comparison_key(result),
        compute=compute,
        thing="the comparison at equal false alarms",
        doing="comparing",
        most=MOST,
    )
    output, is_missing = computation.draw(is_quick=is_quick(result))
    job = state.workspace().job(computation.kind)
    if is_missing and (job is None or job.key != computation.key):  # not one that was cancelled
        computation.start()
        computation.draw(is_quick=False)
    return output


def choose_comparison(result: Result, other: Alternative, page: str) -> Result | None:
    """The comparison that is shown, with what it is: that of the verdict unless another is chosen.

    Parameters
    ----------
    other
        What `wait_for_equal_alarms` gives; without one, that as set is shown, which may be at
        unequal operating points.
    page
        Begins the keys of the widgets.

    Returns
    -------
    None while the one that was chosen is being computed: the other does not take its place.
    """
    equal = other.equal
    if equal is None and not other.is_awaited:
        draw_as_set_note(result)
        return result
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
    if equal is None:
        st.markdown("The comparison at equal false alarms is being computed.")
        return None
    text, button = st.columns([3, 2], vertical_alignment="center")
    text.markdown(plain(f"{state.say(AtEqualAlarms(equal.setting))}, as in the verdict."))
    button.button(
        "Set this threshold",
        key=f"{page}_set_equal_alarms",
        on_click=state.set_threshold,
        args=(equal.moved, equal.result.system(equal.moved).threshold),
        width="stretch",
        help="The whole page, and every other, is then at equal false alarms.",
    )
    return equal.result

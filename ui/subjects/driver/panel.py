"""Driver page, beside the picture: the pedestrian's features and estimate in the current frame."""

from __future__ import annotations

from html import escape
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.subjects.driver.features import FEATURES
from nvcore.subjects.driver.illumination.clock import AdaptationClock
from nvcore.subjects.driver.running.estimate import EstimateRun
from ui.session import state
from ui.subjects.driver import basis
from ui.widgets.text import UNDEFINED, docs_link, number

ADAPTED: Final = (
    "The eyes count as adapted: the estimator of the longest period{longest} is taken, of "
    "eyes in the dark after a change. In a bright picture, or with glare, take it with care."
)
UNLIT: Final = (
    "It is not known when the light last changed: the estimator of the longest period{longest} is "
    "taken, as if the eyes were adapted. Just after a change, fewer drivers would see the "
    "{one}."
)
NOT_RUN: Final = f"They are not known here: {basis.NOT_RUN}"
FROM_FILE: Final = (
    "They are not known here: only estimates came with the session. *Estimate*, above, computes "
    "them."
)
UNKNOWN: Final = "by which feature, *Estimate* would tell"
FORMS: Final = {"px": ".1f", "grey levels": ".1f", "ΔE": ".1f", "bins": ".2f"}


def draw(
    course: pd.DataFrame,
    features: pd.DataFrame | None,
    clock: AdaptationClock | None,
    simulated: pd.DataFrame | None,
    *,
    caution: str = "",
    run: EstimateRun | None = None,
    is_estimated: bool = False,
    has_run: bool = False,
) -> None:
    """Draw what is known about the pedestrian in the current frame.

    Parameters
    ----------
    course
        Table from `nvcore.subjects.driver.comparison.encounters.detectability_course`.
    features, simulated
        Rows as in the course. None: unknown, or nothing is simulated. `features` include
        ``estimate``, NaN if the run has none.
    clock
        Clock of the recording. None: the light is unknown.
    caution
        Doubts about the estimates, in a few words. Empty: none are known.
    run
        Run behind the estimates and features. None: they come from a file.
    is_estimated
        Whether an estimator of nvcore gave the detectability.
    has_run
        Whether a run of this session made estimates, for this recording or others.
    """
    row = state.row_in_all()
    frames = state.opened().dataset.frames
    st.markdown(f"**Frame {frames['frame'].iloc[row]}**, {frames['time_s'].iloc[row]:.2f} s")
    here = np.flatnonzero(course["row"].to_numpy() == row)
    if not len(here):
        st.caption(state.say("The {one} is not in this frame."))
        return
    at = int(here[0])
    estimate = course.iloc[at]
    would = None if simulated is None else simulated.iloc[at]
    is_simulated = would is not None and bool(would["is_simulated"])
    own = None if run is None or features is None else features.iloc[at]
    is_by_run = own is not None and is_estimated and bool(np.isfinite(own["estimate"]))
    by = _by(run, own if is_by_run else None)
    rows = [(f"Detectability{by}{f' ({caution})' if caution else ''}", _share(estimate))]
    if would is not None:
        by = _by(run, would) if is_simulated else by
        rows.append((f"the same, after a simulated change{by}", _share(would)))
    rows.append(("Since the change", _since(clock, is_simulated=is_simulated)))
    st.html(_table(rows))
    _draw_outside(estimate, own, would if is_simulated else None, run)
    _draw_features(features, at, NOT_RUN if has_run else FROM_FILE)
    if is_estimated and not is_simulated and _has_no_period(own, clock):
        longest = "" if run is None else f" ({basis.longest_words(run)})"
        is_lit = clock is not None and bool(clock.is_known[state.row()])
        st.caption(state.say(ADAPTED if is_lit else UNLIT, longest=longest))


def _draw_features(features: pd.DataFrame | None, at: int, why_none: str) -> None:
    """Draw the eight features of one row of the course, or why they are unknown."""
    st.markdown(f"**{docs_link('Features', 'features', doc='driver-reference')}**")
    if features is None:
        st.caption(why_none)
        return
    values = features.iloc[at]
    st.html(
        _table(
            [(feature.label, _with_unit(values[feature.key], feature.unit)) for feature in FEATURES]
        )
    )


def _by(run: EstimateRun | None, part: pd.Series | None) -> str:
    """Return ", estimator of 7.5 s" with the adaptation period, or "" if it is unknown."""
    if run is None or part is None:
        return ""
    return f", estimator of {basis.period_words(run, part['period_s'])}"


def _draw_outside(
    estimate: pd.Series, own: pd.Series | None, would: pd.Series | None, run: EstimateRun | None
) -> None:
    """Draw a warning that names the features outside of the training range, if there are any."""
    parts = {"Detectability": estimate} | ({} if would is None else {"After the change": would})
    for name, part in parts.items():
        if not part["is_outside"]:
            continue
        words = []
        if run is not None and own is not None:
            period_s = own["period_s"] if part is estimate else part["period_s"]
            words = basis.outside_words(run, own, period_s)
        which = "; ".join(words) or UNKNOWN
        text = f"{name}, outside of the training: {which}. Take it with care."
        st.warning(text, icon=":material/warning:")


def _has_no_period(own: pd.Series | None, clock: AdaptationClock | None) -> bool:
    """Whether no change of light is known before the frame.

    This comes from the run, or without a run from the clock.
    """
    if own is not None:
        return bool(np.isnan(own["period_s"]))
    return clock is not None and bool(np.isnan(clock.period_s[state.row()]))


def _share(estimate: pd.Series) -> str:
    share, sd = estimate["detectability"], estimate["sd"]
    if not np.isfinite(share):
        return UNDEFINED
    return f"{share:.2f}" + (f" ± {sd:.2f}" if np.isfinite(sd) else "")


def _since(clock: AdaptationClock | None, *, is_simulated: bool) -> str:
    if clock is None or not clock.is_known[state.row()]:
        return "not known"
    seconds = clock.period_s[state.row()]
    if np.isnan(seconds):
        return "eyes adapted"
    return f"{seconds:.2f} s{', simulated' if is_simulated else ''}"


def _with_unit(value: float, unit: str) -> str:
    text = number(value, FORMS.get(unit, ".2f"))
    return text if text == UNDEFINED else f"{text} {unit}"


def _table(rows: list[tuple[str, str]]) -> str:
    body = "".join(
        f'<tr><th scope="row">{escape(label)}</th><td>{escape(text)}</td></tr>'
        for label, text in rows
    )
    return f'<table class="nv-numbers">{body}</table>'

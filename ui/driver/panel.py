"""Driver page, beside the picture: features and estimate of the pedestrian on the frame."""

from __future__ import annotations

from html import escape
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.driver.features import FEATURES
from nvcore.driver.illumination.clock import AdaptationClock
from ui.session import state
from ui.widgets.text import UNDEFINED, docs_link, number

OUTSIDE: Final = (
    "The features are outside of what the estimator was trained on: take the estimate with care."
)
FORMS: Final = {"px": ".1f", "grey levels": ".1f", "ΔE": ".1f", "bins": ".2f"}


def draw(
    course: pd.DataFrame,
    features: pd.DataFrame | None,
    clock: AdaptationClock | None,
    simulated: pd.DataFrame | None,
    *,
    caution: str = "",
) -> None:
    """What is known of the pedestrian on the frame that is shown.

    Parameters
    ----------
    course
        Of `nvcore.tables.encounters.driver.detectability_course`.
    features, simulated
        Rows as of the course; None: not known, nothing is simulated.
    clock
        Of the recording; None: nothing is known of the light.
    caution
        Whose answers the estimates rest on, where some were simulated.
    """
    row = state.row_in_all()
    frames = state.opened().dataset.frames
    st.markdown(f"**Frame {frames['frame'].iloc[row]}**, {frames['time_s'].iloc[row]:.2f} s")
    here = np.flatnonzero(course["row"].to_numpy() == row)
    if not len(here):
        st.caption(state.words("The pedestrian is not in this frame."))
        return
    at = int(here[0])
    estimate = course.iloc[at]
    label = f"Detectability{f' ({caution})' if caution else ''}"
    rows = [(label, _share(estimate))]
    would = None if simulated is None else simulated.iloc[at]
    if would is not None:
        rows.append(("the same, after a simulated change", _share(would)))
    is_simulated = would is not None and bool(would["is_simulated"])
    rows.append(("Since the change", _since(clock, is_simulated=is_simulated)))
    st.html(_table(rows))
    if estimate["is_outside"] or (would is not None and would["is_outside"]):
        st.warning(state.words(OUTSIDE), icon=":material/warning:")
    st.markdown(f"**{docs_link('Features', 'features', doc='driver')}**")
    if features is None:
        st.caption(
            "They are not known here: only estimates came with the session. *Estimate*, below, "
            "computes them."
        )
        return
    own = features.iloc[at]
    st.html(
        _table(
            [(feature.label, _with_unit(own[feature.key], feature.unit)) for feature in FEATURES]
        )
    )


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

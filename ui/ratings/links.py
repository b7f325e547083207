"""Rating sessions in addresses and on disk: who takes part, who conducts, where ratings are kept.

A participant's address is ``ratings?study=TOKEN&participant=NAME``, the conductor's
``ratings?conduct=SECRET``; neither follows from the other.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final
from urllib.parse import quote, urlsplit

import click
import streamlit as st

from nvcore.errors import InputError
from nvcore.studies.ratings.store import RatingStore, Study
from ui.session import state

VARIABLE: Final = "NVCORE_RATINGS"
STUDY: Final = "study"
PARTICIPANT: Final = "participant"
CONDUCT: Final = "conduct"
OWN: Final = "rating_studies"
OPEN: Final = "rating_open"
LOCAL: Final = ("localhost", "127.0.0.1", "::1")


def store() -> RatingStore:
    """The file of all rating sessions: ``$NVCORE_RATINGS``, or in the user's own folder.

    Raises
    ------
    InputError
        If it cannot be used.
    """
    return RatingStore(_file())


def _file() -> Path:
    folder = os.environ.get(VARIABLE)
    return Path(folder) if folder else Path(click.get_app_dir("nvcore")) / "ratings.sqlite"


def is_participant() -> bool:
    """Whether the address is a participant's: then nothing but the clips is shown."""
    return STUDY in st.query_params


def conducted() -> Study | None:
    """The rating session that this person conducts, from the address or this session.

    Raises
    ------
    InputError
        If the address names none that there is.
    """
    key = st.query_params.get(CONDUCT)
    secret: str | None = key or st.session_state.get(OPEN)
    if secret is None:
        return None
    study = store().study_of_conductor(secret)
    if study is None:
        st.session_state.pop(OPEN, None)
        st.query_params.pop(CONDUCT, None)
        raise InputError("there is no rating session of the name in the address")
    conduct(study)
    return study


def conduct(study: Study) -> None:
    """Make this the rating session that is conducted, in the address as well."""
    st.session_state.setdefault(OWN, set()).add(study.token)
    st.session_state[OPEN] = study.conductor
    if st.query_params.get(CONDUCT) != study.conductor:
        st.query_params[CONDUCT] = study.conductor


def is_own(study: Study) -> bool:
    """Whether this browser session conducts it."""
    return study.token in st.session_state.get(OWN, set())


def close() -> None:
    """Conduct none; the link of the one that was open opens it again."""
    st.session_state.pop(OPEN, None)
    st.query_params.pop(CONDUCT, None)


def links(study: Study) -> tuple[str, str]:
    """Addresses of this page for participants and for the conductor."""
    page = str(st.context.url or "ratings").partition("?")[0]
    return f"{page}?{STUDY}={quote(study.token)}", f"{page}?{CONDUCT}={quote(study.conductor)}"


def is_local(address: str) -> bool:
    """Whether the address leads to the machine that it is opened on, whichever that is.

    Examples
    --------
    >>> is_local("http://localhost:8501/ratings?study=a"), is_local("http://lab-3:8501/ratings")
    (True, False)
    """
    return urlsplit(address).hostname in LOCAL


def shown_thresholds() -> dict[str, float | None]:
    """Score threshold of each compared system, by name."""
    settings = state.params()
    values = (settings.threshold_x, settings.threshold_y)
    return {
        name: value for name, value in zip(state.systems(), values, strict=True) if name is not None
    }


def thresholds_apart(study: Study) -> dict[str, tuple[float | None, float | None]]:
    """Compared systems whose threshold is not that of the clips, by name: of the clips, and now."""
    live, apart = shown_thresholds(), {}
    for name, value in live.items():
        span = state.score_span(name)
        if span is None or name not in study.thresholds:
            continue
        threshold = study.thresholds[name]
        if threshold is not None:
            threshold = None if threshold <= span[0] else min(threshold, span[1])
        if value != threshold:
            apart[name] = threshold, value
    return apart


def set_thresholds(of: Mapping[str, float | None]) -> None:
    """Give the compared systems of these names these thresholds in the next run."""
    for letter, name in zip("xy", state.systems(), strict=True):
        if name is not None and name in of:
            state.set_threshold(letter, of[name])

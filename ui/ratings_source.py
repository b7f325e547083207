"""Where the ratings come from: simulated, a file, typed in, a rating session."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.analysis import Result
from nvcore.errors import InputError
from nvcore.ratings.reading import check_ratings, parse_ratings, read_ratings
from nvcore.sample.ratings import RATINGS_FILE
from ui import ratings_links, state
from ui.text import plain

SIMULATED: Final = "Simulated"
FILE: Final = "CSV file"
TYPED: Final = "Typed in"
SESSION: Final = "Rating session"
MOST_MB: Final = 5
COLUMNS: Final = ["participant", "clip", "system", "rating"]


@dataclass(frozen=True)
class Given:
    """Ratings to look at.

    Attributes
    ----------
    ratings
        Of `nvcore.ratings.reading`.
    system
        Whose boxes were shown where the ratings do not say; empty: they say it.
    """

    ratings: pd.DataFrame
    system: str


def choose(result: Result) -> Given | None:
    """The ratings that are chosen; None while there are none."""
    sources = [FILE, TYPED, SESSION]
    if state.workspace().label == state.SAMPLE_LABEL and _simulated_file().exists():
        sources.insert(0, SIMULATED)
    source = st.segmented_control(
        "Ratings from", sources, default=sources[0], required=True,
        key=f"ratings_source_{len(sources)}", persist_state="session",
    )  # fmt: skip
    try:
        ratings = {SIMULATED: _simulated, FILE: _file, TYPED: _typed, SESSION: _session}[source](
            result
        )
    except InputError as error:
        st.error(plain(str(error)))
        return None
    if ratings is None or ratings["rating"].notna().sum() == 0:
        if ratings is not None:
            st.info("There is no rating yet.")
        return None
    if (ratings["system"] != "").all():
        return Given(ratings, "")
    names = (result.x.name, result.y.name)
    system = st.radio(
        "The ratings do not say whose boxes were shown. It was", names, key="ratings_system",
        format_func=lambda one: f"{'X' if one == names[0] else 'Y'} {one}", horizontal=True,
    )  # fmt: skip
    return Given(ratings, system)


def _simulated(_: Result) -> pd.DataFrame:
    st.warning(
        "These ratings are **simulated: nobody was asked**. They show what this page does, and say "
        "nothing about saliency.", icon=":material/science:",
    )  # fmt: skip
    return read_ratings(_simulated_file())


def _simulated_file() -> Path:
    return state.SAMPLE.parent / RATINGS_FILE


def _file(_: Result) -> pd.DataFrame | None:
    sent = st.file_uploader(
        "Ratings (CSV with the columns participant, clip, rating, and system if both were shown)",
        type=["csv", "txt"], key="ratings_file", max_upload_size=MOST_MB,
        help="The clip is the name of a recording, the system that of X or Y. A higher rating is "
        "more annoying; only the order counts, so any scale will do. An empty rating is missing.",
    )  # fmt: skip
    return None if sent is None else parse_ratings(sent.getvalue(), name=sent.name)


def _typed(result: Result) -> pd.DataFrame | None:
    if "ratings_typed" not in st.session_state:  # drawn anew: with what was typed before
        empty = pd.DataFrame({name: pd.Series(dtype=object) for name in COLUMNS})
        before = st.session_state.get("ratings_typed_last", empty.astype({"rating": float}))
        st.session_state["ratings_typed_start"] = before
    systems = [result.x.name, result.y.name]
    typed = st.data_editor(
        st.session_state["ratings_typed_start"], num_rows="dynamic", hide_index=True,
         key="ratings_typed", height=280,
        column_config={
            "participant": st.column_config.TextColumn("Participant", max_chars=64, required=True),
            "clip": st.column_config.SelectboxColumn(
                "Clip", options=state.recording_names(), required=True
            ),
            "system": st.column_config.SelectboxColumn("Boxes of", options=systems),
            "rating": st.column_config.NumberColumn("Rating (higher = more annoying)"),
        },
    )  # fmt: skip
    st.session_state["ratings_typed_last"] = typed.reset_index(drop=True)
    st.caption("It lasts as long as this browser tab: download it below before you close that.")
    filled = typed.dropna(how="all")
    if filled.empty:
        return None
    rating = filled["rating"].map(lambda one: "" if pd.isna(one) else f"{one:.15g}")
    text = filled.astype(object).where(filled.notna(), "").astype(str).assign(rating=rating)
    return check_ratings(text.reset_index(drop=True), name="the table above")


def _session(result: Result) -> pd.DataFrame | None:
    study = ratings_links.conducted()
    if study is None:
        st.info('None is open. Start one under "Rating session", or open the conductor\'s link.')
        return None
    if study.fingerprint != result.dataset.fingerprint:
        st.warning("These ratings are of another comparison than the one that is open.")
    return ratings_links.store().ratings(study)


def digest(given: Given) -> int:
    """A number that differs where the ratings do."""
    rows = pd.util.hash_pandas_object(given.ratings, index=False).to_numpy()
    return hash((given.system, rows.tobytes(), np.shape(rows)))

"""Sources of ratings: simulated, a file, typed in, a rating session."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import fold_name
from nvcore.comparison.compare import Result
from nvcore.subjects.ratings.reading import DELAY, RATINGS_FILE, parse_ratings, read_ratings
from ui.session import state
from ui.shell.messages import errors_shown
from ui.subjects.ratings import typed
from ui.subjects.ratings.sessions import SESSIONS
from ui.subjects.ratings.thresholds import set_thresholds, thresholds_apart
from ui.widgets.choices import ask_for_file, choose_side_by_side
from ui.widgets.text import plain

SIMULATED: Final = "Simulated"
FILE: Final = "CSV file"
TYPED: Final = "Typed in"
SESSION: Final = "Rating session"


@dataclass(frozen=True)
class RatingSource:
    """Ratings and the system whose boxes were shown, which is empty if each rating names it.

    Simulated ratings are not from people.
    """

    ratings: pd.DataFrame
    system: str
    is_simulated: bool

    def rows(self, *more: str) -> np.ndarray:
        """Return a hash of participant, clip and system for each rating, uint64.

        Columns in `more` are hashed as well.
        """
        ratings = self.ratings.dropna(subset="rating")
        ratings = ratings.assign(
            participant=ratings["participant"].map(fold_name),
            system=ratings["system"].where(ratings["system"] != "", self.system),
        )[["participant", "clip", "system", *more]]
        return pd.util.hash_pandas_object(ratings.astype(str), index=False).to_numpy()

    def digest(self) -> int:
        """Return a hash of the ratings and of their delays after the clips."""
        delays = self.ratings.get(DELAY, pd.Series(dtype=float)).to_numpy(dtype=float)
        return hash((self.rows("rating").tobytes(), delays.tobytes()))


@errors_shown()
def choose(result: Result) -> RatingSource | None:
    """Return the chosen ratings, or None while there are none."""
    sources = [FILE, TYPED, SESSION]
    if state.opened().label == state.SAMPLE_LABEL and _simulated_file().exists():
        sources.insert(0, SIMULATED)
    key = f"ratings_source_{len(sources)}"
    source = choose_side_by_side("Ratings from", sources, key, default=sources[0])
    ratings = READERS[source](result)
    if ratings is None:
        return None
    if ratings["rating"].isna().all():
        st.info("There is no rating yet.")
        return None
    if (ratings["system"] != "").all():
        return RatingSource(ratings, "", source == SIMULATED)
    names = result.names
    system = st.radio(
        "The ratings do not say whose boxes were shown. It was",
        names,
        key="ratings_system",
        format_func=lambda name: f"{'X' if name == names[0] else 'Y'} {name}",
        horizontal=True,
    )
    return RatingSource(ratings, system, source == SIMULATED)


def _simulated(_: Result) -> pd.DataFrame:
    st.warning(
        "These ratings are **simulated: nobody was asked**. They show what this page does, and say "
        "nothing about saliency.",
        icon=":material/science:",
    )
    return read_ratings(_simulated_file())


def _simulated_file() -> Path:
    return state.SAMPLE.parent / RATINGS_FILE


def _file(_: Result) -> pd.DataFrame | None:
    sent = ask_for_file(
        "Ratings (CSV with the columns participant, clip, rating, and system if both were shown)",
        "ratings_file",
        "The clip is the name of a recording, the system that of X or Y. A higher rating is more "
        "annoying; only the order counts, so any scale will do. An empty rating is missing.",
    )
    return None if sent is None else parse_ratings(sent[0], name=sent[1])


def _session(result: Result) -> pd.DataFrame | None:
    conducted = SESSIONS.conducted()
    if conducted is None:
        st.info('None is open. Start one under "Rating session", or open the conductor\'s link.')
        return None
    store, study = conducted
    if study.fingerprint != result.dataset.fingerprint:
        st.warning("These ratings are of another comparison than the one that is open.")
    elif apart := thresholds_apart(study):
        _draw_apart(result, apart)
    return store.ratings(study)


def _draw_apart(result: Result, apart: dict[str, tuple[float | None, float | None]]) -> None:
    """Warn that the clips showed other boxes than those that saliency is computed from."""
    clips_shown = [
        f"{'X' if name == result.x.name else 'Y'} {plain(name)}: clips at "
        f"{_threshold(of_clips)}, now {_threshold(live)}"
        for name, (of_clips, live) in apart.items()
    ]
    st.warning(
        "The clips showed **other boxes than those compared below**: the score thresholds have "
        f"moved since. {'; '.join(clips_shown)}.",
        icon=":material/warning:",
    )
    st.button(
        "Set the thresholds of the clips",
        key="ratings_thresholds",
        icon=":material/undo:",
        on_click=set_thresholds,
        args=({name: of_clips for name, (of_clips, _) in apart.items()},),
    )


def _threshold(value: float | None) -> str:
    return "every detection" if value is None else plain(f"{value:.4g}")


READERS: Final = {SIMULATED: _simulated, FILE: _file, TYPED: typed.typed, SESSION: _session}

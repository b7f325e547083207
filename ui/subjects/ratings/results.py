"""Ratings page, results: whether people agree, and whether saliency agrees with them."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import count_text, minus, p_text, p_value
from nvcore.comparison.compare import Result
from nvcore.subjects.ratings.agreement import Agreement, measure_agreement, rank_ratings
from nvcore.subjects.ratings.clips import compare_clips
from nvcore.subjects.ratings.figures import participants_plot, rating_plot
from nvcore.subjects.ratings.validation import (
    Correlation,
    clip_saliency,
    correlate,
    join_clips,
    mean_delay,
    split_known,
)
from ui.session import state
from ui.shell.messages import errors_shown
from ui.subjects.ratings import applied_fit, drivers, fit, source
from ui.subjects.ratings.applied_fit import AppliedFit
from ui.subjects.ratings.source import RatingSource
from ui.widgets.charts import draw_chart
from ui.widgets.choices import download_csv
from ui.widgets.table import TableColumn, draw_table, own_headings
from ui.widgets.text import UNDEFINED, docs_link, number, plain

STRONG: Final = 0.7
MODERATE: Final = 0.4
MOST_KEPT: Final = 8
MOST_NAMED: Final = 8
METHOD: Final = docs_link("how", "saliency-against-mean-rank", doc="ratings")


@errors_shown()
def draw(result: Result) -> None:
    """Draw ratings, agreement, saliency against the mean rank, and the fit."""
    rating_source = source.choose(result)
    if rating_source is None:
        return
    of_clips = _of_clips(result, rating_source)
    saliency = clip_saliency(of_clips)
    ratings, unknown = split_known(rating_source.ratings, saliency, system=rating_source.system)
    _draw_unknown(ratings, unknown)
    digest = rating_source.digest()
    left_out = _people(ratings, digest)
    included = ratings[~ratings["participant"].isin(left_out)]
    ranks = rank_ratings(included)
    if ranks.empty:
        st.info("Nobody is left." if left_out else "No clip of this comparison is rated.")
        return
    clips = join_clips(ranks, clip_saliency(of_clips, mean_delay(included)))
    rating_source = replace(rating_source, ratings=included)
    fit_in_use = applied_fit.in_use(result, rating_source)
    st.header("Does saliency say what people say?")
    _cautions(result, rating_source, len(ranks), fit_in_use)
    _against_saliency(result, clips)
    drivers.draw(result, ranks, clips, (digest, tuple(left_out)))
    fit.draw(result, of_clips, clips, (digest, tuple(left_out)), rating_source, fit_in_use)
    st.header("Files")
    with st.container(horizontal=True):
        download_csv("Ratings (CSV)", lambda: included, "ratings.csv", "ratings_csv")
        download_csv("Ranks (CSV)", lambda: _long(ranks), "ranks.csv", "ranks_csv")


def _of_clips(result: Result, rating_source: RatingSource) -> Result:
    """Return the comparison whose recordings are the clips that were rated."""
    names = tuple(rating_source.ratings["clip"].unique())
    if set(names) <= set(state.recording_names()):
        return result
    return state.workspace().cached(
        "rating_clips",
        (result.dataset.fingerprint, result.params, result.x.name, result.y.name, names),
        lambda: compare_clips(result, names),
        most=2,
    )


def _draw_unknown(ratings: pd.DataFrame, unknown: pd.DataFrame) -> None:
    """Draw a list of rated clips, with their raters, that are not in this comparison."""
    if unknown.empty:
        return
    clips = unknown[["clip", "system"]].drop_duplicates()
    clip_names = [f"{clip} ({system})" for clip, system in clips.head(MOST_NAMED).to_numpy()]
    more = ", ..." if len(clips) > MOST_NAMED else ""
    vanished = sorted(set(unknown["participant"]) - set(ratings["participant"]))
    note = f" Nothing is left of {plain(', '.join(vanished[:MOST_NAMED]))}." if vanished else ""
    st.warning(
        f"{count_text(len(clips), 'rated clip')} not in this comparison, left out of all numbers "
        f"with {count_text(len(unknown), 'rating')}: {plain(', '.join(clip_names))}{more}.{note}",
        icon=":material/link_off:",
    )


def _agreement(ratings: pd.DataFrame, key: object) -> Agreement:
    return state.workspace().cached(
        "rating_agreement", key, lambda: measure_agreement(rank_ratings(ratings)), most=MOST_KEPT
    )


def _people(ratings: pd.DataFrame, digest: int) -> list[str]:
    """Draw how much participants agree, and return the participants to exclude."""
    st.header("Do people agree?")
    everybody = _agreement(ratings, (digest, ()))
    people = everybody.participants
    left_out = st.multiselect(
        "Leave out participants",
        people["participant"].tolist(),
        key="ratings_left_out",
        placeholder="nobody is left out",
        help="Who took the scale the wrong way round, or did not watch. Everybody who is left out "
        "is told here and counts in nothing below.",
    )
    others = ratings[~ratings["participant"].isin(left_out)]
    agreement = _agreement(others, (digest, tuple(left_out)))
    if left_out:
        st.warning(
            f"{count_text(len(left_out), 'participant')} left out by hand: "
            f"{plain(', '.join(left_out))}. All numbers are without them.",
            icon=":material/person_off:",
        )
    columns = st.columns(4)
    columns[0].metric("Kendall's W", number(agreement.w, ".2f"), help=agreement.method)
    columns[1].metric("participants", f"{agreement.n_participants:,}")
    columns[2].metric("clips", f"{agreement.n_clips:,}")
    columns[3].metric("ratings missing", f"{agreement.n_missing:,}")
    text = plain(_concordance(agreement))
    if np.isfinite(agreement.w) and not agreement.is_more_than_chance:
        st.warning(text, icon=":material/warning:")
    else:
        st.markdown(text)
    outliers = people.loc[
        people["is_outlier"] & ~people["participant"].isin(left_out), "participant"
    ]
    if len(outliers):
        names = plain(", ".join(outliers.head(MOST_NAMED)))
        st.caption(
            f"{names}: ranks the clips differently from the others. Find out why before you leave "
            "anybody out."
        )
    draw_chart(participants_plot(everybody, theme=state.theme()), "rating_participants")
    return left_out


def _concordance(agreement: Agreement) -> str:
    """Return Kendall's W in plain words."""
    if not np.isfinite(agreement.w):
        return f"{UNDEFINED}: {agreement.method}."
    p = p_text(agreement.p, agreement.p)
    if not agreement.is_more_than_chance:
        return (
            f"The participants do not agree more than by chance ({p}): their mean ranks mean "
            f"little. Ranks by chance have a W of {1 / agreement.n_participants:.2f} on average "
            f"with {agreement.n_participants} participants."
        )
    degree = "moderately and" if agreement.w >= MODERATE else "little, but"
    degree = "strongly and" if agreement.w >= STRONG else degree
    return (
        f"The participants agree {degree} more than by chance ({p}): W is 0 for no agreement on "
        "which clips are more annoying, and 1 for the same ranks."
    )


def _cautions(
    result: Result, rating_source: RatingSource, n_people: int, fit_in_use: AppliedFit | None
) -> None:
    """Draw reasons why plot and correlations may not be evidence."""
    if fit_in_use is not None:
        share = fit_in_use.share_seen(rating_source)
        percent = min(max(round(100 * share), 1), 99)
        st.warning(
            "These settings were **fitted to these ratings**: plot and correlations are training "
            "numbers, no evidence."
            if share == 1
            else f"The fit behind these settings has **seen {percent} % of these ratings** (same "
            "participant, clip and system): plot and correlations are partly training numbers, no "
            "evidence.",
            icon=":material/warning:",
        )
    if applied_fit.of_simulated(result, rating_source):
        st.warning(
            "The settings in use were fitted to **simulated ratings**.", icon=":material/science:"
        )
    if n_people == 1:
        st.warning(
            "These are the ratings of **one participant**. The numbers say how saliency follows "
            "that person; intervals and p say nothing about people.",
            icon=":material/person:",
        )


def _against_saliency(result: Result, clips: pd.DataFrame) -> None:
    names = result.names
    with st.spinner("Correlating"):
        correlations = state.workspace().cached(
            "rating_correlations",
            clips[["mean_rank", "saliency_s"]].to_numpy().tobytes(),
            lambda: correlate(clips["saliency_s"].to_numpy(), clips["mean_rank"].to_numpy()),
            most=MOST_KEPT,
        )
    draw_chart(
        rating_plot(clips, correlations, names, theme=state.theme()),
        "rating_plot",
        help="Dotted: the straight line through the clips; the band is its 95 % interval, by "
        "resampling the recordings. Named: the clips more than three robust standard deviations "
        "(1.4826 times the median distance) from it, five at most.",
    )
    table = _correlations(correlations)
    draw_table(
        table,
        own_headings(table),
        key="rating_correlations",
        name="Ratings against saliency",
        is_sortable=False,
    )
    st.caption(
        "1: the more annoying people find a clip, the higher its saliency; 0: no connection. "
        "Intervals are from resampling the clips. Intervals and p take the clips as independent; "
        "two clips of one recording are not, so the intervals are somewhat too narrow and p "
        f"somewhat too small ({METHOD})."
    )
    with st.expander("Mean rank of each clip", key="rating_clips_open"):
        draw_table(
            clips.sort_values("mean_rank", ascending=False, kind="stable"),
            {
                "clip": TableColumn("Clip", is_head=True),
                "system": TableColumn("Boxes of"),
                "mean_rank": TableColumn("Mean rank", "1 is the least annoying clip.", ".1f"),
                "n_ratings": TableColumn("Ratings"),
                "saliency_s": TableColumn("Saliency (s)", form=".2f"),
                "loss_miss": TableColumn("Loss to misses", "Before alpha weighs it.", ".3f"),
                "loss_false": TableColumn("Loss to false alarms", "Before alpha weighs it.", ".4f"),
            },
            key="rating_clips",
            name="Mean rank of each clip",
        )


def _correlations(correlations: list[Correlation]) -> pd.DataFrame:
    """Return the coefficients as text, undefined ones with the reason."""
    table = pd.DataFrame(
        {
            "Coefficient": [row.name for row in correlations],
            "Value": [number(row.value, ".2f") for row in correlations],
            "95 % interval": [
                minus(f"{row.low:.2f} to {row.high:.2f}") if np.isfinite(row.low) else UNDEFINED
                for row in correlations
            ],
            "p": [p_value(row.p) if np.isfinite(row.p) else UNDEFINED for row in correlations],
            "Why there is none": [row.note for row in correlations],
        }
    )
    return table if any(row.note for row in correlations) else table.iloc[:, :-1]


def _long(ranks: pd.DataFrame) -> pd.DataFrame:
    """Return one row for each participant and clip."""
    table = ranks.melt(ignore_index=False, value_name="rank").reset_index()
    return table[["participant", "clip", "system", "rank"]]

"""Overview page: the verdict, in a box whose space is reserved from the start."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.common.findings import Finding
from nvcore.common.wording import count_text, percent
from nvcore.comparison.compare import Result
from nvcore.evidence.claims import decided_on
from nvcore.evidence.companions import Companions
from nvcore.evidence.looks import ONLY_LOOK, correct_for_looks
from nvcore.evidence.operating_points import are_delivered
from nvcore.notes import Note
from nvcore.report.tiles import tiles
from nvcore.report.verdict import HOW_SURE, verdict
from nvcore.report.verdict.points import counts_of
from nvcore.report.words import sampling_note
from nvcore.tables.influence import leads
from ui.session import state, store
from ui.shell.navigate import open_page
from ui.streamlit_inside.types import DeltaGenerator
from ui.subject import count_look
from ui.views.overview.tiles import tiles_html
from ui.widgets.buttons import button
from ui.widgets.text import docs_link, plain, short_names

BARS: Final = " Bars: 95 % interval of X − Y, drawn from Y better (left) to X better (right)."


class VerdictBox:
    """Box of the verdict. It shows results as they become known, without moving the page."""

    def __init__(self, result: Result) -> None:
        self._result = result
        with st.container(border=True, key="verdict"):
            self.headline: DeltaGenerator = st.container(key="verdict_headline")
            # until they are drawn, they show the content of the last run
            self._words = self.headline.container()
            self._tiles = st.container(key="verdict_tiles")
            self._basis = st.container(key="verdict_basis")
            self._rest = st.expander("What this rests on")

    def _opening(self) -> tuple[object, ...]:
        """Return the data and systems of the verdict, for comparison with the last one drawn."""
        return state.opened().dataset.fingerprint, self._result.x.name, self._result.y.name

    def holds_last(self) -> bool:
        """Return whether the box still shows a verdict on these systems, with any settings."""
        return store.LAST_VERDICT.get() == self._opening()

    def draw_known(self, evidence: pd.DataFrame | None) -> None:
        """Draw the tiles with the evidence known so far, before the differences are tested."""
        self._words = self._words.markdown("## :gray[The differences are being tested.]")
        self._basis = self._basis.caption(self._draw_tiles(evidence, None))

    def _draw_tiles(self, evidence: pd.DataFrame | None, companions: Companions | None) -> str:
        """Draw the tiles, and return what they are about."""
        result = self._result
        four = tiles(result, evidence, companions, is_being_tested=True)
        self._tiles = self._tiles.html(tiles_html(four, result.objects, short_names(result)))
        return _short_extent(result) + (BARS if any(tile.bar for tile in four) else "")

    def draw(
        self,
        findings: Sequence[Finding],
        evidence: pd.DataFrame,
        companions: Companions | None,
        plan: tuple[Note, ...],
    ) -> None:
        """Draw the verdict, what it depends on, and how much more data it would take."""
        result, look = self._result, ONLY_LOOK
        if companions is not None:  # the settings are at rest
            look = count_look(result)
            evidence, companions = correct_for_looks(evidence, companions, look)
        conclusion = verdict(
            result, findings, evidence=evidence, companions=companions, plan=plan, look=look
        )
        about, _ = decided_on(result, evidence, companions)
        reasons = " ".join([conclusion.reason, *map(state.say, leads(about))])
        words = plain(conclusion.in_short), plain(reasons)
        self._words = self._words.markdown("## {}\n\n{}".format(*words))
        store.SHOWN_VERDICT.set(state.opened().dataset.fingerprint)
        store.LAST_VERDICT.set(self._opening())
        extent = self._draw_tiles(evidence, companions)
        with self._basis.container():
            for point in conclusion.points:
                if point.topic == HOW_SURE:
                    st.markdown(
                        plain(conclusion.say(*point.notes)), help=_meaning(result, companions)
                    )
            st.caption(extent)
            for point in conclusion.points:
                if point.is_warning:
                    st.markdown(f":material/warning: {plain(conclusion.say(*point.notes))}")
            if conclusion.doubt:
                _draw_doubt(conclusion.say(conclusion.doubt))
        with self._rest:
            st.markdown(
                "\n".join(
                    f"- **{plain(point.topic)}:** {plain(conclusion.say(*point.notes))}"
                    for point in conclusion.points
                )
            )
            st.caption(_extent(result))
            if note := sampling_note(result.dataset.frame_columns):
                st.caption(note)


def _meaning(result: Result, companions: Companions | None) -> str | None:
    """Return what the probability is of, None if there is none."""
    graded = None if companions is None else companions.graded
    if graded is None or graded.reason:
        return None
    values = {"is_delivered": are_delivered(result), **counts_of(graded)}
    return state.say(Note("verdict.graded_means", **values))


def _draw_doubt(doubt: str) -> None:
    with st.container(horizontal=True, vertical_alignment="center"):
        st.markdown(f":material/warning: {plain(doubt)}", width="stretch")
        if button("See the findings on the Data page", key="see_findings"):
            open_page("data")


def _short_extent(result: Result) -> str:
    return (
        f"X is {plain(result.x.name)}, Y {plain(result.y.name)}; "
        f"{count_text(len(result.dataset.recordings), 'recording')}, "
        f"{count_text(len(result.dataset.frames), 'frame')}, {result.duration_s:,.1f} s."
    )


def _extent(result: Result) -> str:
    venn = result.venn
    return state.say(
        "{recordings}, {frames}, {duration_s:,.1f} s. An encounter is one {one} from first to last "
        "annotated frame; {near:,} came near enough to count, {distant:,} stayed distant. A "
        "system detects it by matching it in at least {coverage} of the frames in which it is "
        "near. Severity: what failures weigh, 1 s for each second that {a_one} straight ahead and "
        "near is missed. p, where given: how often recordings in which X and Y could be exchanged "
        "would differ as much, by itself and corrected for what is tested together ({link}).",
        recordings=count_text(len(result.dataset.recordings), "recording"),
        frames=count_text(len(result.dataset.frames), "frame"),
        duration_s=result.duration_s,
        near=venn.n_near,
        distant=venn.distant,
        coverage=percent(result.params.coverage),
        link=docs_link("Significance", "other-measures", doc="significance"),
    )

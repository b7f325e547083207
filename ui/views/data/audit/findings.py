"""Data page: findings of the audit, worst first, with buttons that apply corrections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import streamlit as st

from nvcore.common.findings import TRUTH_NAME, Finding, Severity, worst_first
from nvcore.inputs.session.changes import applied
from ui.session import state
from ui.session.opening import corrected
from ui.session.results import input_findings
from ui.shell.messages import without_paths
from ui.shell.recordings_filter import filter_text
from ui.shell.remedies import BUTTONS, ways_text
from ui.shell.review import subject_text
from ui.views.data.audit import entries
from ui.views.data.opening import try_to_open
from ui.widgets.buttons import button
from ui.widgets.text import plain

BADGES: Final = {
    Severity.ERROR: ":red-badge[:material/error: Error]",
    Severity.WARNING: ":orange-badge[:material/warning: Warning]",
    Severity.NOTE: ":gray-badge[:material/info: Note]",
}
KINDS: Final = {
    Severity.ERROR: ("error that makes numbers wrong", "errors that make numbers wrong"),
    Severity.WARNING: ("warning that may change numbers", "warnings that may change numbers"),
    Severity.NOTE: ("note to look at", "notes to look at"),
}
MOST_SHOWN: Final = 4
"""Largest number of errors and warnings shown unfolded. Without any, a note is shown."""


def draw() -> None:
    """Draw the name of the open session and all audit findings about it."""
    findings = worst_first(input_findings())
    label, n = state.opened().label, len(state.recording_names())
    which = filter_text() or f"{n:,} recording{'s' if n > 1 else ''}"
    st.header(f"Open now: {plain(label)} ({plain(which)})")
    if not findings:
        st.success(
            f"The audit of {plain(label)} found nothing to mind.", icon=":material/check_circle:"
        )
        return
    n_urgent = sum(finding.severity is not Severity.NOTE for finding in findings)
    if n_urgent:
        st.subheader("What to mind before trusting the numbers")
        st.caption(_counts(findings))
    n_shown = min(n_urgent, MOST_SHOWN) or 1
    for number, finding in enumerate(findings[:n_shown]):
        _draw_one(finding, number)
    if further := findings[n_shown:]:
        has_open_list = any(entries.is_open(finding) for finding in further)
        with st.expander(f"And {_counts(further)}", expanded=has_open_list):
            for number, finding in enumerate(further, start=n_shown):
                _draw_one(finding, number)


def _counts(findings: Sequence[Finding]) -> str:
    """Return the number of findings by severity. Those about pictures are counted separately."""
    words = []
    of_numbers = [finding for finding in findings if not finding.is_of_pictures]
    for severity, (singular, plural) in KINDS.items():
        n = sum(finding.severity is severity for finding in of_numbers)
        if n:
            words.append(f"{n} {singular if n == 1 else plural}")
    if n := len(findings) - len(of_numbers):
        words.append(f"{n} about pictures, on which no number depends")
    return ", ".join(words)


def _draw_one(finding: Finding, number: int) -> None:
    with st.container(border=True):
        st.markdown(
            f"{BADGES[finding.severity]} **{plain(subject_text(finding))}:** "
            f"{plain(without_paths(finding.message))}"
        )
        where = ", ".join(part for part in (without_paths(finding.file), finding.example) if part)
        if where:
            st.caption(f"First seen in {plain(where)}")
        _draw_ways(finding, number)
        if finding.code == "mixed-weighting":
            _draw_weighting(finding, number)
        elif finding.suggestion and finding.subject in state.opened().dataset.systems:
            if "threshold" in dict(finding.suggestion):
                _draw_threshold(finding, number)
            else:
                _draw_correction(finding, number)
        entries.draw(finding, number)


def _draw_ways(finding: Finding, number: int) -> None:
    """Draw suggested fixes, with buttons for those that only change the session."""
    opened = state.opened()
    ways = [(step, applied(opened.session, step, opened.dataset.systems)) for step in finding.steps]
    steps = [step for step, session in ways if session is None]
    by_hand = ways_text(steps, state.systems(), opened.dataset.objects)
    advice = without_paths(f"{finding.advice} {by_hand}".strip())
    st.markdown(f"*What to do:* {plain(advice)}")
    with st.container(horizontal=True):
        for at, (step, session) in enumerate(ways):
            if session is not None and button(
                plain(BUTTONS[step.remedy].format(value=step.value.replace(",", ", "))),
                key=f"step_{number}_{at}",
                icon=":material/build:",
            ):
                try_to_open(replace(session, params=state.params()), label=opened.label)


def _draw_weighting(finding: Finding, number: int) -> None:
    """Draw buttons that make all boxes weighted in the same way, by height or by distance."""
    with st.container(horizontal=True):
        st.button(
            "Weigh by height",
            key=f"apply_{number}",
            icon=":material/height:",
            on_click=state.set_params,
            kwargs={"proximity": "height"},
        )
        if finding.subject == TRUTH_NAME and state.params().missing_distance != "borrow":
            st.button(
                "Borrow distances from the systems",
                key=f"borrow_{number}",
                icon=":material/straighten:",
                on_click=state.set_params,
                kwargs={"missing_distance": "borrow"},
                help=state.say(
                    "{A_one} takes the distance that matching detections report, along the track."
                ),
            )


def _draw_threshold(finding: Finding, number: int) -> None:
    """Draw a button that sets the threshold suggested by the finding."""
    value = dict(finding.suggestion)["threshold"]
    letters = dict(zip(state.systems(), "xy", strict=True))
    letter = letters.get(finding.subject)
    if letter is not None:
        st.button(
            f"Set {value:g} for {letter.upper()}",
            key=f"apply_{number}",
            icon=":material/tune:",
            on_click=state.set_threshold,
            args=(letter, value),
        )


def _draw_correction(finding: Finding, number: int) -> None:
    """Draw a button that corrects the boxes of a system."""
    words = ", ".join(f"{name} {value:g}" for name, value in finding.suggestion)
    is_wanted = button(
        "Apply to the session",
        key=f"apply_{number}_{hash((finding.subject, finding.suggestion))}",
        icon=":material/build:",
        help=f"Corrects the boxes of this system when they are read: {words}. The files stay as "
        "they are; a saved session holds the correction.",
    )
    if is_wanted:
        opened = state.opened()
        session = corrected(opened.session, opened.dataset, finding)
        try_to_open(replace(session, params=state.params()), label=opened.label)

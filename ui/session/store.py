"""Values that the app keeps for a browser session between runs of the script.

Streamlit holds them in ``st.session_state``, which only this module reads and writes. An entry for
a widget's value has the widget's key. Data that must survive a reload of the page is in the notes
of the workspace instead (`ui.session.workspace.Workspace`).
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

import streamlit as st

if TYPE_CHECKING:
    import pandas as pd

    from nvcore.settings.defaults import OperatingPoint
    from nvcore.settings.params import Params
    from nvcore.subjects.driver.comparison.judging import DriverRegion
    from ui.session.workspace import Caching, Workspace
    from ui.shell.operating_point import Move
    from ui.shell.review import ListKey, Review
    from ui.subjects.detectors.trial import Levels
    from ui.views.data.form_session import Chosen, Purpose
    from ui.views.data.opening import Trouble
    from ui.widgets.drawing import Look

T = TypeVar("T")


@dataclass(frozen=True)
class Entry(Generic[T]):
    """Value kept for the session. Until it is set, it is a copy of the shared `default`."""

    key: str
    default: T

    @property
    def is_set(self) -> bool:
        """True if there is a value."""
        return self.key in st.session_state

    def get(self) -> T:
        """Return the value."""
        value: T = st.session_state.get(self.key, copy(self.default))
        return value

    def set(self, value: T) -> None:
        """Replace the value."""
        st.session_state[self.key] = value

    def setdefault(self, value: T) -> T:
        """Return the value. If there is none, set it to `value` first."""
        current: T = st.session_state.setdefault(self.key, value)
        return current

    def pop(self) -> T:
        """Return the value and forget it."""
        value: T = st.session_state.pop(self.key, copy(self.default))
        return value


@dataclass(frozen=True)
class Family(Generic[T]):
    """Entries of one kind whose keys end differently, such as with the name of a page."""

    name: str
    default: T

    def of(self, member: object) -> Entry[T]:
        """Return the entry of one member."""
        return Entry(f"{self.name}_{member}", self.default)

    def known(self) -> list[Entry[T]]:
        """Return the entries that have a value."""
        keys = [str(key) for key in st.session_state]
        return [Entry(key, self.default) for key in keys if key.startswith(f"{self.name}_")]


def widget(key: str, default: Any = None) -> Entry[Any]:
    """Return the entry with the value of the widget that has this key."""
    return Entry(key, default)


def set_widgets(**values: object) -> None:
    """Set the values of widgets by key, before they are drawn."""
    st.session_state.update(values)


def sent(key: str, *names: str) -> Any:
    """Return what a component's browser side sent under these nested names, or else None."""
    value = st.session_state.get(key)
    for name in names:
        value = value.get(name) if isinstance(value, Mapping) else None
    return value


def clear() -> None:
    """Forget all values of the session."""
    st.session_state.clear()


# The open comparison and the settings. An opening is a number of `Workspace.n_opened`.

WORKSPACE: Entry[Workspace | None] = Entry("workspace", None)
LEFT_WORKSPACE: Entry[Workspace | None] = Entry("left_workspace", None)
"""Workspace before a reload restored another. The page still shows its pictures for a while."""
FIRST_QUERY: Entry[dict[str, str]] = Entry("first_query", {})
"""Address that the session began with."""
PAGE_LINK: Entry[dict[str, str] | None] = Entry("page_link", None)
"""Address that led to the page, or a request by another page, until the page has read it."""
BAD_LINK = Entry("bad_link", "")
"""Parts of the address that could not be applied, until they are reported."""
SEEN_OPENING: Entry[int | None] = Entry("seen_opening", None)
"""Opening of the last run."""
PLACE = Entry("place", (0, 0))
"""Current recording, and row in it."""
SEEK = Entry("seek", 0)
"""Number of changes of the frame by anything but the viewer."""
PARAMS: Entry[Params | None] = Entry("params", None)
"""Live parameters (None: those of the open session)."""
NEW_PARAMS: Entry[dict[str, Any]] = Entry("new_params", {})
"""Settings for the next run."""
WANTS_RESET = Entry("wants_reset", False)
"""True if the next run begins with the parameters of the open session."""
SETTINGS: Entry[dict[str, Any]] = Entry("settings", {})
"""Settings that the visitor has made."""
SETTINGS_SHOWN: Entry[dict[str, Any]] = Entry("settings_shown", {})
"""Values given to the widgets of this run."""
SETTINGS_RELEASED: Entry[frozenset[str]] = Entry("settings_let_go", frozenset())
"""Settings whose widgets reported a change before this run."""
SETTING_MOVING: Entry[tuple[str, Any] | None] = Entry("settings_moving", None)
"""Setting whose slider is being dragged, and the value that Streamlit has meanwhile."""
WIDGETS_SHOWN: Family[dict[str, Any]] = Family("shown", {})
"""Values of widgets by key, for widgets that have shown a value, newest last."""
SLIDER_ENDS: Family[tuple[tuple[float, float, float] | None, tuple[float, float]]] = Family(
    "ends", (None, (0.0, 0.0))
)
"""Ends and step of a setting's slider without the set value, and ends extended to it."""
ENCOUNTER: Entry[tuple[int | None, str]] = Entry("encounters_chosen", (None, ""))
"""Encounter that all pages show: the opening, and its name in an address."""
LOOK: Entry[Look | None] = Entry("look", None)
"""Look of the pictures."""
STRETCH: Entry[tuple[float, float] | None] = Entry("stretch", None)
"""Percentiles of the display stretch."""
SHOWN_VERDICT: Entry[str | None] = Entry("verdict_shown_on", None)
"""Fingerprint of the data on which a verdict was shown."""

# Around the pages

NEXT_PAGE: Entry[str | None] = Entry("wanted_page", None)
TITLE: Entry[str | None] = Entry("document_title", None)
TAB_IS_SETTLED = Entry("tab_is_settled", False)
"""True once the tab's comparison is known. The tab then stops claiming a workspace."""
TAB_CLAIMS = Entry("tab_claims", 0)
"""Number of times that the tab has claimed its previous workspace."""
PRESET: Entry[tuple[int | None, str]] = Entry("preset_chosen", (None, ""))
"""Opening, and the preset chosen last for it."""
OPERATING_POINT: Entry[OperatingPoint] = Entry("operating_point", "equal-alarms")
BEFORE_DELIVERED: Entry[OperatingPoint] = Entry("before_delivered", "equal-alarms")
"""Operating point to return to from delivered products."""
THRESHOLD_MOVE: Entry[Move | None] = Entry("point_moved", None)
"""Last move to equal false alarms."""
TAGS_REFUSED = Entry("tags_refused", "")
"""Reason why recordings with these tags cannot be compared, until it is reported."""
LIVE_ANSWERED = Entry("live_answered", 0)
"""Number of the last message of a slider being dragged."""
REVIEW: Entry[Review | None] = Entry("review", None)
"""List that is viewed entry by entry."""
ENTRIES_SEEN: Entry[dict[ListKey, frozenset[int]]] = Entry("entries_seen", {})
"""Entries that were viewed, by list."""
CLICKED: Entry[tuple[str, Any] | None] = Entry("clicked", None)
"""Widget clicked last, and the part clicked, until its page has asked or is drawn."""
JOB_SEEN: Family[Hashable] = Family("job_seen", None)
"""Key of the job whose choices the widgets show, by kind."""
MODEL_FILE_SEEN: Family[str | None] = Family("model_seen", None)
"""File that was taken from a field, by the field's key."""
MODEL_TROUBLE: Family[str] = Family("model_trouble", "")
"""Reason why that file cannot be used."""
OWN_STUDIES: Family[frozenset[str]] = Family("studies", frozenset())
"""Tokens of the studies conducted in this session, by kind."""
CONDUCTED: Family[str | None] = Family("conducted", None)
"""Secret of the open study, by kind."""

# Data

WAYS_OPEN = Entry("data_ways", False)
"""True if the box with all ways to open something is unfolded."""
SCROLLS = Entry("data_scrolls", False)
"""True if the page is to scroll to that box."""
TROUBLES: Family[Trouble | None] = Family("data_trouble", None)
"""Reason why something could not be opened, by part of the page."""
LAST_OPENED = Entry("data_opened", ("", "", 0))
"""Part of the page that opened something, its label, and the opening before."""
OPENED_WORDS = Entry("data_opened_words", "")
"""What was changed by the last opening."""
OPENING_SHOWN: Entry[int | None] = Entry("data_opened_shown", None)
"""Opening that the page has reported."""
OPENING_DRAWN: Family[int | None] = Family("data_drawn", None)
"""Opening that a part of the page has drawn."""
FILE_CHECKS: Entry[Caching | None] = Entry("file_checks", None)
PROPOSED_NAMES: Family[str] = Family("told", "")
"""Name that the files propose, by field."""
ASKED_ONCE: Family[frozenset[str]] = Family("asked_once", frozenset())
"""Questions that a form has asked, which pressing its button again answers."""
ASKED_FACTS: Family[frozenset[str]] = Family("asked", frozenset())
"""Facts that a form asks for because the files lack them."""
FORM_PURPOSE: Family[Purpose] = Family("form_purpose", "new")
MORE_SYSTEMS = Family("more_systems", 0)
"""Number of fields for systems beyond the usual number, by form."""
UPLOAD_CHOSEN = Entry("upload_chosen", False)
"""True if files were chosen in the form."""
UPLOADED: Family[Chosen | None] = Family("uploaded", None)
"""Stored files of a field of the form, by the field's key."""
LOCAL_FOLDER = Entry("local_folder", "")
LOCAL_NEXT: Entry[str | None] = Entry("local_next", None)
"""Folder to go to."""
CHOICE: Family[str] = Family("choice", "")
"""System ``x`` and ``y``, and the ``primary`` measure."""
EXACT_THRESHOLD: Family[float | None] = Family("data_threshold", None)
"""Threshold typed for X or Y."""
LOWEST_THRESHOLD = Entry("threshold_at_lowest", ("", 0.0))
"""Letter of a system and its threshold that was just typed, if it leaves nothing out."""
NAMES_CHANGED = Entry("names_changed", False)
"""True if names were just changed."""
N_NAME_CHANGES = Entry("names_n_changes", 0)
OPEN_ENTRIES: Entry[tuple[str, str, str] | None] = Entry("entries_open", None)
"""Finding whose list is open."""
NO_FRAME = Entry("entries_no_frame", False)
"""True if the entry that was clicked has no frame."""

# Overview

OVERVIEW_PART: Entry[str | None] = Entry("overview_more", None)
LAST_VERDICT: Entry[tuple[object, ...] | None] = Entry("last_verdict", None)
"""Data and systems of the headline that is still visible."""
WORST_ROW: Entry[int | None] = Entry("overview_open", None)
"""Frame row of the failure that was clicked."""
WINDOW_ROW: Entry[int | None] = Entry("clicked_window", None)
"""Frame row of the window that was clicked."""
PLAN_ASKED = Entry("plan_asked", False)
"""True if the plan was just opened. It is then computed at once, later plans on a click."""
PLAN_MEASURE: Entry[str | None] = Entry("plan_measure", None)

# Encounters, timeline, saliency, detection, stability, time left, export

ENCOUNTERS_PART: Entry[str | None] = Entry("encounters_more", None)
TIME_LEFT_PART: Entry[str | None] = Entry("time_left_more", None)
ENCOUNTER_IS_NEW = Entry("encounters_just_chosen", False)
"""True if the encounter was just chosen on the page."""
HAS_STEPPED = Entry("encounters_stepped", False)
"""True if a button chose the encounter in this run."""
ENCOUNTER_FILTER: Family[Any] = Family("encounters", None)
FILTER_WISH: Family[Any] = Family("encounters_set", None)
"""Value set for a filter, which may lie outside the listed values."""
ENCOUNTER_ORDER: Entry[str | None] = Entry("encounters_order", None)
IS_DESCENDING = Entry("encounters_descending", True)
ALL_COLUMNS = Entry("encounters_columns", False)
ENCOUNTER_IS_VISIBLE = Entry("encounters_visible", False)
"""True if the encounter is shown in visible light."""
FIRST_LANE = Entry("lanes_first", 0)
LANE_SEEN: Entry[int | None] = Entry("lanes_seen", None)
"""Encounter for which the page of lanes was turned."""
N_CODE_CHANGES = Entry("codes_n_changes", 0)
"""Number of changes of coded stretches. Each change resets the fields for the next one."""
SALIENCY_ROW: Entry[int | None] = Entry("saliency_open", None)
"""Frame row of the event that was clicked."""
SALIENCY_RECORDING: Entry[int | None] = Entry("saliency_wanted", None)
"""Recording that was clicked."""
PROTOCOL_SHOWN: Entry[str | None] = Entry("protocol_shown", None)
PROTOCOL_SHOWN_OF: Entry[tuple[str, int] | None] = Entry("protocol_shown_of", None)
"""Workspace and opening whose protocol the fields show."""
PROTOCOL_RECORDINGS: Entry[list[str]] = Entry("protocol_recordings", [])
"""Recordings that count in the detection measures."""
HAS_SIDES = Entry("own_has_sides", False)
"""True if each side of the picture has its own margin."""
STABILITY_PLANE: Entry[str] = Entry("stability_plane", "")
STABILITY_CRITERION: Entry[str] = Entry("stability_criterion", "")
ALERT_AT = Family("alert_at", -1)
"""Viewed row of a list of alerts, counted from 0 (-1: none)."""
URGENT_ENCOUNTER: Entry[tuple[int, int] | None] = Entry("time_left_open", None)
"""Encounter and frame row that were clicked."""
HTML_DATE = Entry("html_date", "")

# Review

REVIEW_CASE: Entry[str | None] = Entry("review_case", None)
"""Case that was decided on or opened last."""
REVIEW_OPENS = Entry("review_opens", False)
"""True if the Timeline is to show it."""
REVIEW_DELETES: Entry[str | None] = Entry("review_deletes", None)
"""Token of the project that the page asks about deleting."""
REVIEW_FILE: Entry[str | None] = Entry("review_file_added", None)
"""File whose decisions were added last."""
REVIEW_HEARD: Entry[dict[str, Any] | None] = Entry("review_heard", None)
"""Browser's gallery, and the number of its last message that was applied."""

# Driver, detectors, ratings

DRIVER_REGION: Entry[DriverRegion | None] = Entry("driver_region", None)
DRIVER_SHOWN: Entry[tuple[tuple[int, str] | None, int | None]] = Entry("driver_shown", (None, None))
"""Encounter that the page showed last (opening and name), and the one chosen then."""
TUNNEL = Entry("driver_tunnel", False)
"""True if a change of light is simulated."""
TUNNEL_S = Entry("driver_tunnel_s", 0.0)
PRACTISED: Family[int] = Family("study_practised", 0)
"""Practice runs that a participant has seen."""
DETECTOR: Entry[str | None] = Entry("detector", None)
USUAL_DETECTOR: Entry[str | None] = Entry("detector_usual", None)
"""Detector that was chosen by default for the open comparison."""
DETECTOR_BOX: Entry[tuple[object, int]] = Entry("detector_box", (None, 0))
"""Clicked box: detector and frame, and the box's row."""
DETECTOR_LEVELS: Entry[dict[str, Levels]] = Entry("detector_levels", {})
"""Threshold and overlap by detector."""
RATINGS_PART: Entry[Literal["results", "session", "groups"] | None] = Entry("ratings_part", None)
RATING_ALERTS: Entry[Literal["no", "these", "file"]] = Entry("rating_alerts_from", "no")
"""Source of the alerts in a rating session: none, the comparison, or a file."""
RATINGS_EDITOR: Family[Any] = Family("ratings_typed", None)
"""Table for typing ratings, by the number of times it was redrawn."""
N_RATINGS_EDITORS = Entry("ratings_typed_drawn", 0)
RATINGS_EDITOR_OF: Entry[str | None] = Entry("ratings_typed_drawn_of", None)
"""Token of the workspace whose ratings the table shows."""
RATINGS_START: Entry[pd.DataFrame | None] = Entry("ratings_typed_start", None)
"""Initial content of the table."""
RATING_WAITING: Entry[tuple[str, str] | None] = Entry("rating_waiting", None)
"""Participant's link that was opened with another comparison: study and code."""
RATING_CHANGES = Entry("rating_changing", False)
"""True while the last rating is being changed."""
RATING_THRESHOLDS: Entry[dict[str, Any]] = Entry("rating_thresholds_before", {})
"""Thresholds of the study's conductor, while somebody rates on the conductor's screen."""

"""All that the app remembers of a browser session from one run to the next, entry by entry.

Streamlit holds it in ``st.session_state``, which is read and written here only. An entry that is a
widget's value has the widget's key. What has to outlast a reload of the page is in the notes of the
workspace instead (`ui.session.workspace.Workspace`).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

import streamlit as st

from ui.session.workspace import Caching

if TYPE_CHECKING:
    import pandas as pd

    from nvcore.driver.comparison.kinds import DriverRegion
    from nvcore.params import Params
    from nvcore.settings import OperatingPoint
    from nvcore.stages import Stage
    from ui.data.missing_inputs import PictureCheck
    from ui.data.opening import Trouble
    from ui.data.upload import StoredForm
    from ui.detectors.trial import Levels
    from ui.session.workspace import Workspace
    from ui.shell.operating_point import Move
    from ui.shell.review import ListKey, Review
    from ui.widgets.drawing import Look

T = TypeVar("T")


@dataclass(frozen=True)
class Entry(Generic[T]):
    """A value of the session; while there is none, `default`, which all sessions share: a copy."""

    key: str
    default: T

    @property
    def is_set(self) -> bool:
        """Whether there is a value."""
        return self.key in st.session_state

    def get(self) -> T:
        """The value."""
        value: T = st.session_state.get(self.key, copy(self.default))
        return value

    def set(self, value: T) -> None:
        """Replace the value."""
        st.session_state[self.key] = value

    def setdefault(self, value: T) -> T:
        """The value, which is this one if there was none."""
        current: T = st.session_state.setdefault(self.key, value)
        return current

    def pop(self) -> T:
        """The value, which is forgotten."""
        value: T = st.session_state.pop(self.key, copy(self.default))
        return value


@dataclass(frozen=True)
class Family(Generic[T]):
    """Entries of one kind, told apart by the end of their keys: a page, a field, a name."""

    name: str
    default: T

    def of(self, member: object) -> Entry[T]:
        """The entry of one of them."""
        return Entry(f"{self.name}_{member}", self.default)

    def known(self) -> list[Entry[T]]:
        """Those that have a value."""
        keys = [str(key) for key in st.session_state]
        return [Entry(key, self.default) for key in keys if key.startswith(f"{self.name}_")]


@dataclass(frozen=True)
class Collection(Generic[T]):
    """A value that is changed in place; made when it is first asked for."""

    key: str
    make: Callable[[], T]

    def get(self) -> T:
        """The value."""
        if self.key not in st.session_state:
            st.session_state[self.key] = self.make()
        value: T = st.session_state[self.key]
        return value


def widget(key: str, default: Any = None) -> Entry[Any]:
    """The value of the widget with this key."""
    return Entry(key, default)


def set_widgets(**values: object) -> None:
    """Give the widgets with these keys these values; before they are drawn."""
    st.session_state.update(values)


def sent(key: str, *names: str) -> Any:
    """What the browser's part of a component has sent under this name, and below it; else None."""
    value = st.session_state.get(key)
    for name in names:
        value = value.get(name) if isinstance(value, Mapping) else None
    return value


def clear() -> None:
    """Forget everything."""
    st.session_state.clear()


# What is open, and the settings. An opening is a number of `Workspace.n_opened`.

WORKSPACE: Entry[Workspace | None] = Entry("workspace", None)
LEFT_WORKSPACE: Entry[Workspace | None] = Entry("left_workspace", None)
"""The one from before a reload gave back another: the page still shows its pictures for a while."""
FIRST_QUERY: Entry[dict[str, str]] = Entry("first_query", {})
"""Address that the session began with."""
PAGE_LINK: Entry[dict[str, str] | None] = Entry("page_link", None)
"""Address that led to the page, or what another page asks it for; until the page has read it."""
BAD_LINK = Entry("bad_link", "")
"""What in the address could not be followed, until it was said."""
SEEN_OPENING: Entry[int | None] = Entry("seen_opening", None)
"""Opening of the last run."""
PLACE = Entry("place", (0, 0))
"""Current recording, and row in it."""
SEEK = Entry("seek", 0)
"""How often the frame was changed by anything but the viewer."""
PARAMS: Entry[Params | None] = Entry("params", None)
"""The live parameters; None: those of the open session."""
NEW_PARAMS: Entry[dict[str, Any]] = Entry("new_params", {})
"""Settings for the next run."""
WANTS_RESET = Entry("wants_reset", False)
"""Whether the next run begins with the parameters of the open session."""
SETTINGS: Entry[dict[str, Any]] = Entry("settings", {})
"""Settings that the visitor has made."""
SETTINGS_SHOWN: Entry[dict[str, Any]] = Entry("settings_shown", {})
"""Values that the widgets of this run were given."""
SETTINGS_RELEASED: Entry[frozenset[str]] = Entry("settings_let_go", frozenset())
"""Settings whose widgets told of a change before this run."""
SETTING_MOVING: Entry[tuple[str, Any] | None] = Entry("settings_moving", None)
"""Setting whose slider is in motion, and the value that Streamlit has of it meanwhile."""
WIDGETS_SHOWN: Family[dict[str, Any]] = Family("shown", {})
"""Value by key of the widgets that have shown a value, the newest last."""
SLIDER_ENDS: Family[tuple[tuple[float, float, float] | None, tuple[float, float]]] = Family(
    "ends", (None, (0.0, 0.0))
)
"""Of a setting's slider: ends and step without what was set, and the ends that reach to it."""
ENCOUNTER: Entry[tuple[int | None, str]] = Entry("encounters_chosen", (None, ""))
"""Encounter that all pages show: the opening, and its name in an address."""
LOOK: Entry[Look | None] = Entry("look", None)
"""How pictures are seen."""
STRETCH: Entry[tuple[float, float] | None] = Entry("stretch", None)
"""Percentiles of the display stretch."""
SHOWN_VERDICT: Entry[str | None] = Entry("verdict_shown_on", None)
"""Fingerprint of the data on which a verdict was shown."""

# Around the pages

NEXT_PAGE: Entry[str | None] = Entry("wanted_page", None)
TITLE: Entry[str | None] = Entry("document_title", None)
TAB_IS_SETTLED = Entry("tab_is_settled", False)
"""Whether it is known what the tab has open: nothing is claimed any more."""
TAB_CLAIMS = Entry("tab_claims", 0)
"""How often the tab has claimed what it had open."""
SIDEBAR_SHOWN: Entry[tuple[Stage, ...]] = Entry("sidebar_shown", ())
"""Stages that the page shows."""
SIDEBAR_OWN: Entry[tuple[Stage, ...]] = Entry("sidebar_own", ())
"""Stages that the page is about."""
SIDEBAR_CONTROLS: Entry[tuple[str, ...]] = Entry("sidebar_controls", ())
"""Settings that the page itself has buttons for."""
SIDEBAR_IDLE: Entry[frozenset[str]] = Entry("sidebar_idle", frozenset())
"""Settings without effect on the page as it is now."""
SIDEBAR_CHANGED: Entry[dict[str, Any]] = Entry("sidebar_changed", {})
"""Settings that were moved, and the values that they had."""
PRESET: Entry[tuple[int | None, str]] = Entry("preset_chosen", (None, ""))
"""Preset that was chosen last, after the opening for which it was."""
OPERATING_POINT: Entry[OperatingPoint] = Entry("operating_point", "equal-alarms")
THRESHOLD_MOVE: Entry[Move | None] = Entry("point_moved", None)
"""The last move to equal false alarms."""
TAGS_REFUSED = Entry("tags_refused", "")
"""Why recordings of these tags cannot be compared, until it was said."""
LIVE_ANSWERED = Entry("live_answered", 0)
"""Number of the last message of a slider in motion."""
REVIEW: Entry[Review | None] = Entry("review", None)
"""List that is walked through."""
ENTRIES_SEEN: Collection[dict[ListKey, frozenset[int]]] = Collection("entries_seen", dict)
"""Entries that were looked at, by their list."""
CLICKED: Entry[tuple[str, Any] | None] = Entry("clicked", None)
"""Widget that was clicked last, and what in it, until its page has asked or is drawn."""
JOB_SEEN: Family[Hashable] = Family("job_seen", None)
"""Key of the job whose choices the widgets have, by kind."""
MODEL_FILE_SEEN: Family[str | None] = Family("model_seen", None)
"""The file that was taken from a field, by its key."""
MODEL_TROUBLE: Family[str] = Family("model_trouble", "")
"""Why that file cannot be used."""
OWN_STUDIES: Family[frozenset[str]] = Family("studies", frozenset())
"""Tokens of the studies that are conducted in this session, by kind."""
CONDUCTED: Family[str | None] = Family("conducted", None)
"""Secret of the study that is open, by kind."""

# Data

WAYS_OPEN = Entry("data_ways", False)
"""Whether the box with all ways to open something is unfolded."""
TROUBLES: Family[Trouble | None] = Family("data_trouble", None)
"""Why something could not be opened, by part of the page."""
LAST_OPENED = Entry("data_opened", ("", "", 0))
"""Part of the page in which something was opened, its label, and the opening before."""
OPENING_SHOWN: Entry[int | None] = Entry("data_opened_shown", None)
"""Opening of which the page has told."""
OPENING_DRAWN: Family[int | None] = Family("data_drawn", None)
"""Opening that a part of the page has drawn."""
FILE_CHECKS = Collection("file_checks", Caching)
PICTURE_CHECKS: Collection[dict[Hashable, PictureCheck]] = Collection("picture_checks", dict)
PROPOSED_NAMES: Family[str] = Family("told", "")
"""Name that the files propose, by its field."""
ASKED_NAMES: Family[tuple[str, ...]] = Family("asked_names", ())
"""Systems for whose names a form has asked."""
ASKED_FACTS: Family[frozenset[str]] = Family("asked", frozenset())
"""Facts for which a form asks, since the files turned out to lack them."""
UPLOAD_SYSTEMS = Entry("upload_systems", 2)
"""Systems that the form has fields for."""
UPLOAD_CHOSEN = Entry("upload_chosen", False)
"""Whether files were chosen in the form."""
UPLOAD_STORED: Entry[StoredForm | None] = Entry("upload_stored", None)
LOCAL_FOLDER = Entry("local_folder", "")
LOCAL_NEXT: Entry[str | None] = Entry("local_next", None)
"""Folder to go to."""
CHOICE: Family[str] = Family("choice", "")
"""System ``x`` and ``y``, and the ``primary`` measure."""
EXACT_THRESHOLD: Family[float | None] = Family("data_threshold", None)
"""Threshold that is typed for X or Y."""
LOWEST_THRESHOLD = Entry("threshold_at_lowest", ("", 0.0))
"""Letter and threshold of who was just given one that leaves nothing out."""
NAMES_CHANGED = Entry("names_changed", False)
"""Whether names were changed just now."""
N_NAME_CHANGES = Entry("names_n_changes", 0)
OPEN_ENTRIES: Entry[tuple[str, str, str] | None] = Entry("entries_open", None)
"""Finding whose list is open."""
NO_FRAME = Entry("entries_no_frame", False)
"""Whether the entry that was clicked has no frame."""

# Overview

OVERVIEW_PART: Entry[str | None] = Entry("overview_more", None)
LAST_VERDICT: Entry[tuple[object, ...] | None] = Entry("last_verdict", None)
"""What the headline that is still in sight was about."""
WORST_ROW: Entry[int | None] = Entry("overview_open", None)
"""Frame row of the failure that was clicked."""
WINDOW_ROW: Entry[int | None] = Entry("clicked_window", None)
"""Frame row of the window that was clicked."""
PLAN_ASKED = Entry("plan_asked", False)
"""Whoever opens this part asks its first question; later ones, of settings moved, cost a click."""
PLAN_MEASURE: Entry[str | None] = Entry("plan_measure", None)

# Encounters, timeline, saliency, detection, stability, time left, export

ENCOUNTERS_PART: Entry[str | None] = Entry("encounters_more", None)
TIME_LEFT_PART: Entry[str | None] = Entry("time_left_more", None)
ENCOUNTER_IS_NEW = Entry("encounters_just_chosen", False)
"""Whether the encounter was chosen on the page just now."""
HAS_STEPPED = Entry("encounters_stepped", False)
"""Whether a button chose it in this run."""
ENCOUNTER_FILTER: Family[Any] = Family("encounters", None)
FILTER_WISH: Family[Any] = Family("encounters_set", None)
"""What a filter was set to, which may be outside of what is listed."""
ENCOUNTER_ORDER: Entry[str | None] = Entry("encounters_order", None)
IS_DESCENDING = Entry("encounters_descending", True)
ALL_COLUMNS = Entry("encounters_columns", False)
ENCOUNTER_IS_VISIBLE = Entry("encounters_visible", False)
"""Whether the encounter is shown in visible light."""
FIRST_LANE = Entry("lanes_first", 0)
LANE_SEEN: Entry[int | None] = Entry("lanes_seen", None)
"""Encounter for which the page of lanes was turned."""
N_CODE_CHANGES = Entry("codes_n_changes", 0)
"""How often coded stretches were changed: fields for the next one begin anew."""
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
"""Whether each side of the picture has a margin of its own."""
STABILITY_PLANE: Entry[str] = Entry("stability_plane", "")
STABILITY_CRITERION: Entry[str] = Entry("stability_criterion", "")
ALERT_AT = Family("alert_at", -1)
"""Which row of a list of alerts is looked at, counted from 0; -1: none."""
URGENT_ENCOUNTER: Entry[tuple[int, int] | None] = Entry("time_left_open", None)
"""Encounter and frame row that were clicked."""
HTML_DATE = Entry("html_date", "")

# Driver, detectors, ratings

DRIVER_REGION: Entry[DriverRegion | None] = Entry("driver_region", None)
DRIVER_SHOWN: Entry[tuple[tuple[int, str] | None, int | None]] = Entry("driver_shown", (None, None))
"""Whom the page showed last, as opening and name, and who was chosen then."""
TUNNEL = Entry("driver_tunnel", False)
"""Whether a change of light is simulated."""
TUNNEL_S = Entry("driver_tunnel_s", 0.0)
N_PRACTICE = Entry("study_n_practice", 1)
PRACTISED: Family[int] = Family("study_practised", 0)
"""Practice runs that a participant has seen."""
DETECTOR: Entry[str | None] = Entry("detector", None)
USUAL_DETECTOR: Entry[str | None] = Entry("detector_usual", None)
"""What was chosen at first with what was open."""
DETECTOR_BOX: Entry[tuple[object, int]] = Entry("detector_box", (None, 0))
"""Box that was clicked: detector and frame, and its row."""
DETECTOR_LEVELS: Collection[dict[str, Levels]] = Collection("detector_levels", dict)
"""Threshold and overlap by detector."""
RATINGS_PART: Entry[Literal["results", "session", "groups"] | None] = Entry("ratings_part", None)
RATING_ALERTS: Entry[Literal["no", "these", "file"]] = Entry("rating_alerts_from", "no")
"""Which alerts a rating session asks of: none, those of the comparison, those of a file."""
RATINGS_EDITOR: Family[Any] = Family("ratings_typed", None)
"""Table in which ratings are typed, by how often it was drawn anew."""
N_RATINGS_EDITORS = Entry("ratings_typed_drawn", 0)
RATINGS_EDITOR_OF: Entry[str | None] = Entry("ratings_typed_drawn_of", None)
"""Token of the workspace whose ratings it shows."""
RATINGS_START: Entry[pd.DataFrame | None] = Entry("ratings_typed_start", None)
"""What the table began with."""
RATING_WAITING: Entry[tuple[str, str | None] | None] = Entry("rating_waiting", None)
"""Link of a participant that was opened with another comparison: study and name."""
RATING_NAME = Entry("rating_known_name", "")
"""Name that somebody has entered who has rated before."""
RATING_CHANGES = Entry("rating_changing", False)
"""Whether the last rating is being changed."""
RATING_THRESHOLDS: Entry[dict[str, Any]] = Entry("rating_thresholds_before", {})
"""Thresholds of who conducts, while somebody rates on that screen."""

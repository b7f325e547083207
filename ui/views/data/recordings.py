"""Data page: the table of the open recordings, and names of systems."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import PurePosixPath
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.errors import InputError, NvcoreError, SessionError
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.dataset import Dataset
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.settings.defaults import MAX_FPS, MIN_FPS
from nvcore.settings.params.traffic import context_word, count_contexts, parse_context
from ui.session import state, store
from ui.session.chosen import rename_chosen
from ui.session.opening import with_recordings
from ui.shell.messages import shown_error
from ui.views.data.opening import WAYS, try_to_open
from ui.widgets.buttons import submit_button
from ui.widgets.text import UNDEFINED, docs_link, plain

NO_PICTURES: Final = "no pictures"
NAMES: Final = "Change the names of the systems"
"""Label of the box with the names of systems."""
NAMES_ALONE: Final = frozenset({"title", "tags"})
"""Fields that can be changed without reading the files again."""


def _stated(text: str) -> float:
    if not text:
        raise ValueError("expected a positive number, found nothing")
    return float(text)


def _frame_number(text: str) -> int:
    number = float(text)
    if not number.is_integer():
        raise ValueError(f"expected a frame number, found {number:g}")
    return int(number)


def _name(text: str) -> str:
    if not text:
        raise ValueError("expected a name, found nothing")
    return text


def _tags(text: str) -> tuple[str, ...]:
    tags = [tag.strip() for tag in text.replace(",", ";").split(";")]
    return tuple(dict.fromkeys(tag for tag in tags if tag))


class _Column(NamedTuple):
    """Column of the table: its look, and the value of a cell's text, stripped.

    Numbers that are optional may be empty. `key` is the field of `RecordingEntry`.
    """

    look: Any
    parse: Callable[[str], Any]
    is_optional: bool = False
    key: str = ""


_number = partial(st.column_config.NumberColumn, format="%g")
COLUMNS: Final = {
    "name": _Column(
        st.column_config.TextColumn("Recording", help="What it is called on every page."),
        _name,
        key="title",
    ),
    "width": _Column(_number("Width (px)", width=95, min_value=1), _stated),
    "height": _Column(_number("Height (px)", width=98, min_value=1), _stated),
    "fps": _Column(
        _number(
            "Frames/s",
            width=88,
            min_value=MIN_FPS,
            max_value=MAX_FPS,
            help="Frames per second of the camera.",
        ),
        _stated,
    ),
    "context": _Column(
        st.column_config.TextColumn(
            "Traffic",
            help="How much a miss to the side costs: urban, rural, or a number from 0 (urban) to 1 "
            "(rural); empty: not stated, which counts as urban.",
        ),
        parse_context,
        is_optional=True,
    ),
    "speed_kmh": _Column(
        _number(
            "Speed (km/h)",
            width=116,
            min_value=0,
            help="Of the car, for the time left to brake; empty: not stated, then the sidebar's "
            "speed is assumed.",
        ),
        float,
        is_optional=True,
    ),
    "horizon": _Column(
        _number(
            "Horizon (px)",
            width=110,
            format="%.4g",
            help="Row of the horizon, from the top of the picture, for nearness by horizon; empty: "
            "not known.",
        ),
        float,
        is_optional=True,
    ),
    "tags": _Column(
        st.column_config.TextColumn(
            "Tags", help="Words such as night; rain, separated by semicolons."
        ),
        _tags,
    ),
    "unit": _Column(
        st.column_config.TextColumn(
            "Part of",
            help="A drive, a route or a car that several recordings are of: they are not "
            "independent, so tests and intervals take them as one. Empty: it stands by itself.",
        ),
        str,
        is_optional=True,
    ),
    "pictures": _Column(None, str),
    "first_picture": _Column(
        _number(
            "First picture",
            step=1,
            format="%d",
            help="Only where boxes and pictures do not belong together: the number, as in the "
            "truth, of the frame that the first picture shows. Empty: from the file names.",
        ),
        _frame_number,
        is_optional=True,
    ),
}
NUMBERS: Final = ("width", "height", "fps", "speed_kmh", "horizon", "first_picture")
RESULTS: Final = {
    "frames": _number("Frames", width=70, format="localized", help="Number of evaluated frames."),
    "note": st.column_config.TextColumn("Which picture shows which frame"),
}
"""Columns that cannot be edited."""


def _context_text(value: float | None) -> str:
    if value is None or np.isnan(value):
        return ""
    word = context_word(value)
    return word if isinstance(word, str) else f"{word:g}"


def editable(dataset: Dataset, session: Session, labels: Mapping[str, str]) -> pd.DataFrame:
    """Make the table of the open recordings. Only the session knows the first picture's frame."""
    names = dataset.recordings["name"].tolist()
    entries = session.entries(names)
    first = [entries[name].first_picture if name in entries else None for name in names]
    recordings = dataset.recordings
    table = recordings.assign(
        first_picture=np.array(first, dtype=object),
        context=recordings["context"].map(_context_text),
        tags=recordings["tags"].map("; ".join),
        unit=[unit or "" for unit in recordings["unit"]],
        pictures=[labels.get(name, NO_PICTURES) for name in names],
    )
    return table[list(COLUMNS)].astype(dict.fromkeys(NUMBERS, float))


def saved(dataset: Dataset, session: Session) -> bytes:
    """Write the recordings as a CSV file that `nvcore.inputs.session.recordings_file` reads.

    Recordings are named as in the data, with their names on the pages as titles. Pictures have no
    folders.
    """
    names = dataset.recordings["name"].tolist()
    entries = session.entries(names)
    own = [entries.get(name, RecordingEntry(name)) for name in names]
    shown = editable(dataset, session, {})
    titles = [name if name != entry.name else "" for name, entry in zip(names, own, strict=True)]
    columns: dict[str, Any] = {
        "recording": [entry.name for entry in own],
        "tags": [";".join(tags) for tags in dataset.recordings["tags"]],
        "pictures": [PurePosixPath(entry.pictures or "").name for entry in own],
        "first_picture": shown["first_picture"].astype("Int64"),
        "title": titles,
    }
    return to_csv_bytes(shown.rename(columns={"name": "recording"}).assign(**columns))


def changes_in(
    before: pd.DataFrame, after: pd.DataFrame, pictures: Mapping[str, str | None]
) -> dict[str, dict[str, Any]]:
    """Return fields of `RecordingEntry` that differ, by the recording's name before.

    Parameters
    ----------
    pictures
        Path of each label of pictures.

    Raises
    ------
    InputError
        If a value is invalid, with the recording.
    """
    changes: dict[str, dict[str, Any]] = {}
    rows = zip(before.to_dict("records"), after.to_dict("records"), strict=True)
    for old, new in rows:
        change: dict[str, Any] = {}
        for name in [name for name in COLUMNS if name in after]:
            column, text = COLUMNS[name], _text(new[name])
            if old[name] == new[name] or _text(old[name]) == text == "":
                continue
            try:
                value = None if column.is_optional and not text else column.parse(text)
                change[column.key or name] = pictures.get(text) if name == "pictures" else value
                RecordingEntry(str(old["name"]), **change)  # the rules for a session's
            except ValueError as error:
                raise InputError(f"recording {old['name']!r}: {name}: {error}") from error
            except SessionError as error:
                raise InputError(f"recording {old['name']!r}: {error}") from error
        if change:
            changes[str(old["name"])] = change
    return changes


def _text(value: Any) -> str:
    """Return the text of a cell, or "" if it is empty."""
    return "" if value is None or value == "" or pd.isna(value) else str(value).strip()


def draw_open(
    choices: Mapping[str, str | None], labels: Mapping[str, str], notes: Mapping[str, str]
) -> None:
    """Draw the table of the open recordings, and the button that applies changes in it.

    Parameters
    ----------
    choices
        Pictures to choose from: their paths, by label.
    labels
        Label of the pictures of each recording that has some.
    notes
        Rule that assigns a recording's pictures to its frames, or why there are none.
    """
    opened = state.opened()
    before = editable(opened.whole, opened.session, labels)
    results: dict[str, Any] = {
        "frames": np.diff(opened.whole.frame_columns.first),
        "note": [notes.get(name, "") for name in before["name"]],
    }
    _draw_words(opened.whole)
    key = f"recordings_editor_{state.workspace().n_opened}_{store.N_NAME_CHANGES.get()}"
    with st.form(f"{key}_form", border=False):
        columns = list(COLUMNS)
        pictures = st.column_config.SelectboxColumn(
            "Pictures",
            options=[NO_PICTURES, *choices],
            required=True,
            help=f"Send pictures under “{WAYS}”, Upload; they appear here.",
        )
        looks = {name: column.look for name, column in COLUMNS.items()} | RESULTS
        after = st.data_editor(
            before.assign(**results),
            hide_index=True,
            num_rows="fixed",
            width="stretch",
            column_order=[*columns[:-2], "frames", *columns[-2:], "note"],
            column_config={**looks, "pictures": pictures},
            disabled=[*RESULTS],
            placeholder=UNDEFINED,
            key=key,
        )
        is_wanted = submit_button(
            "Apply to the recordings", icon=":material/check:", key="apply_recordings"
        )
    st.download_button(
        "Save the table (CSV)",
        partial(saved, opened.whole, opened.session),
        "recordings.csv",
        "text/csv",
        on_click="ignore",
        icon=":material/download:",
        key="recordings_save",
        help="As it is in use now, to be edited elsewhere. “Add or replace files” takes it back.",
    )
    if is_wanted:
        _apply(before, after, choices)


def _draw_words(whole: Dataset) -> None:
    """Draw the purpose of the table, and the traffic context in use."""
    st.caption(
        "Click a cell to change it, then apply the table. Drag the corner of a cell to repeat it "
        "below; paste cells from a spreadsheet. Sizes and rates that the files state need no "
        "change. The names are used on every page, in links and in exports. Traffic "
        f"({docs_link('context', 'context', doc='formats')}): "
        f"{count_contexts(whole.recordings['context'])}."
    )
    if state.params().edge_weight is not None:
        st.info(
            "The sidebar's traffic context has a value now, which holds for all recordings "
            "whatever they state.",
            icon=":material/info:",
        )


def _apply(before: pd.DataFrame, after: pd.DataFrame, choices: Mapping[str, str | None]) -> None:
    try:
        changes = changes_in(before, after, choices)
        if not changes:
            st.info("Nothing was changed in the table.", icon=":material/info:")
            return
        if {field for change in changes.values() for field in change} <= NAMES_ALONE:
            use_names({}, changes)
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")
        return
    opened = state.opened()
    session = with_recordings(opened.session, before["name"].tolist(), changes)
    try_to_open(replace(session, params=state.params()), label=opened.label)


def draw_names_changed() -> None:
    """Say that names were changed just now."""
    if store.NAMES_CHANGED.pop():
        st.success("The names and tags are used from now on.", icon=":material/check_circle:")


def draw_systems() -> None:
    """Draw a field for the name of each system, and the button that applies them."""
    names = state.opened().whole.systems
    version = f"{state.workspace().n_opened}_{store.N_NAME_CHANGES.get()}"
    with st.form(f"system_names_{version}", border=False):
        typed = [
            st.text_input(
                f"Name of {plain(name)}", name, max_chars=200, key=f"system_name_{version}_{i}"
            )
            for i, name in enumerate(names)
        ]
        is_wanted = submit_button("Use these names", icon=":material/check:", key="use_names")
    if not is_wanted:
        return
    new = {old: text.strip() or old for old, text in zip(names, typed, strict=True)}
    try:
        use_names(new, {})
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")


def use_names(systems: Mapping[str, str], changes: Mapping[str, Mapping[str, Any]]) -> None:
    """Rename systems and recordings without reading anything again, and rerun the page.

    Parameters
    ----------
    systems
        New names of systems, by the old ones.
    changes
        New titles and tags of recordings, by their names.

    Raises
    ------
    InputError
        If two would have the same name.
    """
    opened = state.opened()
    titles = {name: change["title"] for name, change in changes.items() if "title" in change}
    own = opened.whole.recordings
    tags = [
        changes.get(name, {}).get("tags", tags)
        for name, tags in zip(own["name"], own["tags"], strict=True)
    ]
    whole = opened.whole.with_settings(opened.session).renamed(systems, titles)
    session = whole.settings
    assert isinstance(session, Session)
    if tags != own["tags"].tolist():
        column = pd.Series(tags, dtype=object).array
        whole = replace(whole, recordings=whole.recordings.assign(tags=column))
    others = {
        titles.get(name, name): {key: value for key, value in change.items() if key != "title"}
        for name, change in changes.items()
    }
    state.compare_as(_tagged(session, whole, others), whole)
    rename_chosen(titles)
    store.N_NAME_CHANGES.set(store.N_NAME_CHANGES.get() + 1)
    store.NAMES_CHANGED.set(True)
    st.rerun()


def _tagged(session: Session, whole: Dataset, changes: Mapping[str, Mapping[str, Any]]) -> Session:
    """Return the session with changed tags of recordings.

    Its filter by tags is dropped if none of its compared recordings matches it any more.
    """
    names, tags = whole.recordings["name"].tolist(), whole.recordings["tags"]
    is_left = any(
        {*session.only_tags} <= {*of_one}
        for name, of_one in zip(names, tags, strict=True)
        if not session.only or name in session.only
    )
    return replace(
        with_recordings(session.of_all, names, changes),
        only_tags=session.only_tags if is_left else (),
        only=session.only,
    )

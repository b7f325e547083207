"""Encounters page: filters that select the encounters to list and plot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import shortened
from nvcore.comparison.compare import Result
from nvcore.dataset.schema import (
    CATEGORY_TEXT,
    CLASS_SEPARATOR,
    MISS_CLASS_TEXT,
    Category,
    MissClass,
)
from nvcore.metrics.encounter_classes import shown_class
from ui.session import state, store
from ui.session.store import Entry
from ui.streamlit_inside.types import DeltaGenerator
from ui.subject import EncounterFilter, subject_pages
from ui.widgets.table_columns import MISS_WORDS, category_words, class_words
from ui.widgets.text import plain, short_names

CATEGORIES: Final = tuple(kind.value for kind in Category)
CLASSES: Final = tuple(kind.value for kind in MissClass)
SEVERITY_STEP_S: Final = 0.05
OF_SUBJECTS: Final[dict[str, EncounterFilter]] = {
    known.name: known for of in subject_pages() for known in of.encounters().filters
}
"""Filters that subjects add, by name."""
LISTS: Final = ("category", "class_x", "class_y", "recording", "class", *OF_SUBJECTS)
"""Names of the filters that are lists. `RANGES` names those that are ranges."""
RANGES: Final = ("position", "height", "pose")
OPEN: Final = (-math.inf, math.inf)
"""Ends of a range that nobody has set. Such a range covers everything that is listed."""
HOW_LISTED: Final = (
    "Click a row to see the encounter, a heading to sort by it. By severity, distant {many}, "
    "which do not count, are last."
)
MOST_WORDS: Final = 80
"""Maximum length of the filters in words, in characters. The widgets show all of them."""


@dataclass(frozen=True)
class Filters:
    """Criteria on columns of ``encounters.csv``. Empty or None accepts all rows.

    A range may be open at one end, which is then infinite.

    Attributes
    ----------
    of_subjects
        Choices in the filters that subjects add, by name. Filters without choices are omitted.
    """

    categories: Sequence[str] = ()
    classes_x: Sequence[str] = ()
    classes_y: Sequence[str] = ()
    recordings: Sequence[str] = ()
    classes: Sequence[str] = ()
    of_subjects: Mapping[str, Sequence[str]] = field(default_factory=dict)
    position: tuple[float, float] | None = None
    height_px: tuple[float, float] | None = None
    pose_z: tuple[float, float] | None = None
    least_severity_s: float = 0.0

    def keep(self, encounters: pd.DataFrame, of_subjects: Mapping[str, np.ndarray]) -> pd.DataFrame:
        """Return the rows of `nvcore.tables.result.encounters_table` that pass, keeping the index.

        Parameters
        ----------
        of_subjects
            Value of each encounter for the filters that subjects add, by name.
        """
        passes = np.ones(len(encounters), dtype=bool)
        for column, chosen in (
            ("category", self.categories),
            ("miss_class_x", self.classes_x),
            ("miss_class_y", self.classes_y),
            ("recording", self.recordings),
        ):
            if chosen:
                passes &= encounters[column].isin(list(chosen)).to_numpy()
        for name, chosen in self.of_subjects.items():
            passes &= np.isin(of_subjects[name], list(chosen))
        if self.classes:
            texts, names = pd.factorize(encounters["classes"])
            has_one = [
                not set(self.classes).isdisjoint(str(name).split(CLASS_SEPARATOR)) for name in names
            ]
            passes &= np.array(has_one, dtype=bool)[texts]
        for column, span in (
            ("lateral_position", self.position),
            ("peak_height", self.height_px),
            ("aspect_z", self.pose_z),
        ):
            if span is not None:
                passes &= encounters[column].between(*span).to_numpy()
        if self.least_severity_s > 0:
            larger_s = encounters[["severity_s_x", "severity_s_y"]].max(axis=1)
            passes &= (larger_s >= self.least_severity_s).to_numpy()
        return encounters[passes]


def class_names(encounters: pd.DataFrame) -> list[str]:
    """Return the sorted class names in rows of `nvcore.tables.result.encounters_table`."""
    texts = encounters["classes"].unique()
    return sorted({name for text in texts for name in str(text).split(CLASS_SEPARATOR) if name})


def _filter(name: str) -> Entry[Any]:
    """Return the store entry of a filter's widget. Each opened data set has its own."""
    return store.ENCOUNTER_FILTER.of(f"{name}_{state.workspace().n_opened}")


def _wish(name: str) -> Entry[Any]:
    """Return the store entry for a filter's intended value, which may exceed the listed range."""
    return store.FILTER_WISH.of(f"{name}_{state.workspace().n_opened}")


def possible(result: Result) -> dict[str, tuple[str, ...]]:
    """Return the choices of each filter that subjects add, by name. () if it does not apply."""
    return {
        name: tuple(known.choices) if known.applies(result) else ()
        for name, known in OF_SUBJECTS.items()
    }


def draw(result: Result, encounters: pd.DataFrame) -> tuple[Filters, pd.DataFrame]:
    """Draw the filters, and return them with the encounters that pass."""
    filters = _draw_widgets(encounters, possible(result), short_names(result))
    values = {name: OF_SUBJECTS[name].values(result) for name in filters.of_subjects}
    return filters, filters.keep(encounters, values)


def draw_count(filters: Filters, n_matching: int, n_all: int) -> None:
    """Draw the number of encounters that pass, active filters, and a button that clears these."""
    words = "; ".join(in_words(filters))
    used = f" · {plain(shortened(words, MOST_WORDS))}" if words else ""
    st.markdown(
        f"**{n_matching:,}** of {n_all:,} encounters{used}",
        width="content",
        help=state.say(HOW_LISTED),
    )
    if filters != Filters():
        st.button(
            "Clear filters",
            key="encounters_clear",
            on_click=clear_filters,
            type="tertiary",
            icon=":material/filter_alt_off:",
        )


def in_words(filters: Filters) -> list[str]:
    """Describe the active filters that the folded panel hides."""
    words = [
        f"{name} {', '.join(chosen)}"
        for name, chosen in (
            ("X", [MISS_WORDS[kind] for kind in filters.classes_x]),
            ("Y", [MISS_WORDS[kind] for kind in filters.classes_y]),
            ("in", filters.recordings),
            ("class", [shown_class(name) for name in filters.classes]),
        )
        if chosen
    ]
    words += [
        f"{name} {_range_words(span)}{unit}"
        for name, span, unit in (
            ("position", filters.position, ""),
            ("height", filters.height_px, " px"),
            ("pose", filters.pose_z, ""),
        )
        if span is not None
    ]
    if filters.least_severity_s > 0:
        words.append(f"severity from {filters.least_severity_s:.2f} s")
    return words


def _range_words(span: tuple[float, float]) -> str:
    low, high = span
    if math.isinf(low):
        return f"up to {high:g}"
    return f"from {low:g}" if math.isinf(high) else f"{low:g} to {high:g}"


def take(filters: Filters) -> None:
    """Set the widgets to these filters. Call this before the widgets are drawn."""
    clear_filters()
    lists = {
        "category": filters.categories,
        "class_x": filters.classes_x,
        "class_y": filters.classes_y,
        "recording": filters.recordings,
        "class": filters.classes,
        **filters.of_subjects,
    }
    for name, chosen in lists.items():
        _filter(name).set(list(chosen))
    for name, span in zip(
        RANGES, (filters.position, filters.height_px, filters.pose_z), strict=True
    ):
        if span is not None:
            _wish(name).set(span)
    if filters.least_severity_s > 0:
        _wish("severity").set((filters.least_severity_s,))


def set_classes(x: str | None, y: str | None) -> None:
    """Set the filters to these miss classes of X and Y. None accepts all. For callbacks."""
    clear_filters()
    for name, classes in (("class_x", x), ("class_y", y)):
        _filter(name).set([] if classes is None else [classes])
    st.toast("The table above lists the encounters that you clicked.", icon=":material/filter_alt:")


def clear_filters() -> None:
    """Clear all filters. For callbacks."""
    for name in LISTS:
        _filter(name).set([])
    for name in (*LISTS, *RANGES, "severity"):
        _wish(name).pop()


def _draw_widgets(
    encounters: pd.DataFrame, of_subjects: Mapping[str, Sequence[str]], names_of: Mapping[str, str]
) -> Filters:
    words = {kind: category_words(kind) for kind in CATEGORIES}
    words |= {f"{letter}_only": f"only {plain(name)}" for letter, name in names_of.items()}
    with st.container(horizontal=True, gap="large"):
        categories = st.pills(
            "Detected by",
            CATEGORIES,
            selection_mode="multi",
            format_func=lambda kind: words[kind],
            key=_filter("category").key,
            persist_state="session",
            width="content",
            help=state.say(
                " ".join(f"*{words[kind]}*: {CATEGORY_TEXT[kind]}" for kind in Category)
            ),
        )
        chosen = {
            name: _choose(OF_SUBJECTS[name], choices)
            for name, choices in of_subjects.items()
            if choices
        }
    place = st.expander("More filters: how and where, recording, class, height, severity")
    left, middle, right = place.columns(3)
    meaning = "  \n".join(f"*{class_words(kind)}*: {MISS_CLASS_TEXT[kind]}" for kind in MissClass)
    classes_x, classes_y = (
        column.multiselect(
            f"Miss class of {letter.upper()}",
            CLASSES,
            format_func=MISS_WORDS.__getitem__,
            placeholder="any",
            key=_filter(f"class_{letter}").key,
            persist_state="session",
            help=state.say(meaning),
        )
        for column, letter in ((left, "x"), (middle, "y"))
    )
    names = state.recording_names()
    _choose_among("recording", names)
    recordings = right.multiselect(
        "Recording", names, placeholder="all", key=_filter("recording").key, persist_state="session"
    )
    position = _range(
        left,
        "Position in the picture",
        "position",
        np.array([-1.0, 1.0]),
        0.05,
        "Mean sideways position: -1 left edge, 0 middle, 1 right edge.",
    )
    height_px = _range(
        middle,
        "Largest height (px)",
        "height",
        encounters["peak_height"].to_numpy(),
        1.0,
        state.say("Height of the {one} where it is tallest: how near it came."),
    )
    pose_z = _range(
        right,
        "Pose z-score",
        "pose",
        encounters["aspect_z"].to_numpy(dtype=float),
        0.1,
        "How unusual the mean height over width is among all encounters: below -2 uncommonly wide "
        "(sitting, cycling, pushing a pram), above 2 uncommonly narrow.",
    )
    names = class_names(encounters)
    from_boxes = ""
    if state.opened().dataset.objects.are_pedestrians:
        from_boxes = (
            ", and what the boxes show: crossing, in the road, in a group, a child (see the "
            "documentation, Metrics)"
        )
    _choose_among("class", names)
    left, right = place.columns(2)
    classes = left.multiselect(
        state.say("Class of {one}"),
        names,
        format_func=shown_class,
        placeholder="any",
        key=_filter("class").key,
        persist_state="session",
        help="Any of these: classes of the truth's column *attributes*, codes of stretches"
        f"{from_boxes}.",
    )
    return Filters(
        categories=tuple(categories),
        classes_x=tuple(classes_x),
        classes_y=tuple(classes_y),
        recordings=tuple(recordings),
        classes=tuple(classes),
        of_subjects={name: tuple(values) for name, values in chosen.items() if values},
        position=position,
        height_px=height_px,
        pose_z=pose_z,
        least_severity_s=_least_severity(right, encounters),
    )


def _choose(known: EncounterFilter, choices: Sequence[str]) -> Sequence[str]:
    """Draw a filter that a subject adds, and return the selected choices. Empty: all pass."""
    chosen: Sequence[str] = st.pills(
        known.label,
        choices,
        selection_mode="multi",
        format_func=known.choices.__getitem__,
        key=_filter(known.name).key,
        persist_state="session",
        width="content",
        help=state.say(known.help),
    )
    return chosen


def _least_severity(place: DeltaGenerator, encounters: pd.DataFrame) -> float:
    """Draw a slider for the least severity, and return its value. 0 lists all encounters."""
    largest = np.nanmax(
        encounters[["severity_s_x", "severity_s_y"]].to_numpy(dtype=float), initial=0.0
    )
    if largest:
        high = round(float(np.floor(largest / SEVERITY_STEP_S) + 1) * SEVERITY_STEP_S, 6)
        (start,) = _give("severity", (0.0,), (0.0, high))
        place.slider(
            "Least severity (s)",
            0.0,
            high,
            start,
            SEVERITY_STEP_S,
            "%.2f",
            key=_filter("severity").key,
            on_change=_set,
            args=("severity", (start,), (0.0,), (0.0,)),
            persist_state="session",
            help=state.say(
                "Lists the encounters in which the failure of X or of Y weighs at least so much: "
                "seconds of {a_one} missed straight ahead and near. 0 lists all."
            ),
        )
    (severity_s,) = _wish("severity").get() or (0.0,)
    return float(severity_s)


def _range(
    place: DeltaGenerator, label: str, name: str, values: np.ndarray, step: float, text: str
) -> tuple[float, float] | None:
    """Draw a slider with two handles. Return its range, or None if it excludes nothing."""
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    low = float(np.round(np.floor(values.min() / step) * step, 6))
    high = float(np.round(max(np.ceil(values.max() / step) * step, low + step), 6))
    form = "%.0f" if step >= 1 else "%.2f" if step < 0.1 else "%.1f"
    start = _give(name, OPEN, (low, high))
    place.slider(
        label,
        low,
        high,
        list(start),
        step,
        form,
        key=_filter(name).key,
        on_change=_set,
        args=(name, start, (low, high), OPEN),
        help=text,
        persist_state="session",
    )
    least, most = _wish(name).get() or OPEN
    span = (least if least > low else -math.inf, most if most < high else math.inf)
    return None if span == OPEN else span


def _give(name: str, unset: tuple[float, ...], limits: tuple[float, float]) -> tuple[float, ...]:
    """Set a slider to the value that the user chose last, clipped to the limits of the data."""
    low, high = limits
    wanted = _wish(name).get() or unset
    inside = tuple(min(max(end, low), high) for end in wanted)
    value = inside if len(inside) > 1 else inside[0]
    slider = _filter(name)
    if slider.is_set and slider.get() != value:
        slider.set(value)
    return inside


def _set(
    name: str, before: tuple[float, ...], ends: tuple[float, ...], unset: tuple[float, ...]
) -> None:
    """Store the slider's moved handles as intended values. For callbacks.

    A handle at its end sets no limit.

    Parameters
    ----------
    before
        Positions of the handles before.
    ends
        Positions at which the handles set nothing.
    """
    value = _filter(name).get()
    handles = value if isinstance(value, tuple) else (value,)
    wish = _wish(name)
    set_before = wish.get() or unset
    value = tuple(
        old if now == was else (free if now == end else now)
        for old, now, was, end, free in zip(set_before, handles, before, ends, unset, strict=True)
    )
    wish.set(value)


def _choose_among(name: str, names: Sequence[str]) -> None:
    """Deselect choices that the list lacks now, and reselect them when the list has them again."""
    choice, wish = _filter(name), _wish(name)
    chosen, waiting = choice.get() or [], wish.get() or []
    if not {*chosen} <= {*names} or not {*waiting}.isdisjoint(names):
        wanted = [*chosen, *waiting]
        choice.set([value for value in names if value in wanted])
        wish.set([value for value in wanted if value not in names])

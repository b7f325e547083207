"""Timeline page: mark, change, remove, save and load coded intervals of the recording."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final, NoReturn

import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.settings.codes import COLUMNS, CodedInterval
from nvcore.tables.result import codes_table
from ui.confined.reading import with_codes_confined
from ui.session import state, store
from ui.session.uploads import new_upload, store_annotations
from ui.shell.messages import shown_error
from ui.widgets.buttons import button
from ui.widgets.choices import download_csv
from ui.widgets.text import docs_link

NEW: Final = "a new one"
HELP: Final = (
    "A code is a class of all {many} that the stretch overlaps: the page Encounters counts and "
    "filters by it ({link}). Times as on the axis, both ends included."
)


def draw(recording: int) -> None:
    """Draw the coded intervals of the recording, with fields for one of them or a new one."""
    name, n = state.recording_names()[recording], store.N_CODE_CHANGES.get()
    every = state.opened().session.codes
    with st.expander("Stretches with a code, such as glare", key="codes", on_change="rerun"):
        st.caption(state.say(HELP, link=docs_link("Metrics", "classes-of-encounters")))
        chosen: CodedInterval | str = st.selectbox(  # type: ignore[assignment]
            "Stretch",
            [NEW, *sorted(of for of in every if of.recording == name)],
            format_func=_words,
            key=f"code_of_{recording}_{n}",
        )
        before = chosen if isinstance(chosen, CodedInterval) else None
        typed = _draw_fields(before, f"{recording}_{n}_{_words(chosen)}")
        others = [of for of in every if of != before]
        with st.container(horizontal=True):
            label = "Mark this stretch" if before is None else "Change"
            if button(label, key="code_use", icon=":material/check:"):
                _mark(name, *typed, others)
            if before is not None and button("Remove", key="code_remove", icon=":material/delete:"):
                _use(others)
            if every:
                download_csv(
                    "Save all (CSV)", lambda: codes_table(every), "codes.csv", key="codes_save"
                )
        _draw_reading(every, f"codes_csv_{n}")


def _words(of: CodedInterval | str) -> str:
    return of if isinstance(of, str) else f"{of.start_s:.2f} to {of.end_s:.2f} s: {of.code}"


def _draw_fields(before: CodedInterval | None, key: str) -> tuple[float, float, str]:
    """Draw fields for start, end and code, initially the shown frame. Return their values."""
    now_s = float(state.opened().dataset.frames["time_s"].iloc[state.row_in_all()])
    columns = st.columns(3)
    ends = []
    for place, end, label in zip(columns, ("start_s", "end_s"), ("Start", "End"), strict=False):
        field = store.widget(f"code_{end}_{key}")
        field.setdefault(now_s if before is None else getattr(before, end))
        with place:
            ends.append(st.number_input(f"{label} (s)", step=0.1, format="%.2f", key=field.key))
            st.button(
                f"{label} at the frame shown",
                key=f"code_{end}_here",
                type="tertiary",
                icon=":material/my_location:",
                on_click=field.set,
                args=(now_s,),
            )
    code = columns[2].text_input(
        "Code", "" if before is None else before.code, key=f"code_{key}", max_chars=80
    )
    return ends[0], ends[1], code.strip()


def _mark(name: str, start_s: float, end_s: float, code: str, others: list[CodedInterval]) -> None:
    try:
        marked = CodedInterval(name, start_s, end_s, code)
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")
        return
    _use([*others, marked])


def _draw_reading(every: Iterable[CodedInterval], key: str) -> None:
    """Draw the upload of a file whose intervals are added."""
    file = st.file_uploader(
        "Add those of a CSV file",
        key=key,
        type=["csv", "tsv", "txt"],
        help=f"Columns {', '.join(COLUMNS)}; times in seconds, of all recordings.",
    )
    if file is None:
        return
    space, session = state.workspace(), state.opened().session
    try:
        folder = new_upload(space)
        (path,) = store_annotations(space, folder, "codes", [file])
        sent = replace(session, folder=folder, codes_file=str(path), codes=())
        read = with_codes_confined(sent, state.opened().whole.recordings["name"].tolist()).codes
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")
        return
    _use([*every, *read])


def _use(codes: Iterable[CodedInterval]) -> NoReturn:
    """Compare with these intervals from now on, and start a new run."""
    state.compare_as(replace(state.opened().session, codes=tuple(dict.fromkeys(codes))))
    store.N_CODE_CHANGES.set(store.N_CODE_CHANGES.get() + 1)
    st.rerun()

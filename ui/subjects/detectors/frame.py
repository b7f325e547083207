"""Detectors page: settings of the chosen detector, and its output where there are pictures."""

from __future__ import annotations

from typing import Any, Final

import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.common.wording import capitalised
from nvcore.dataset.provenance import About, Setting
from nvcore.pictures import Picture
from nvcore.subjects.detectors.registry import DETECTORS, run_settings
from nvcore.subjects.detectors.settings import SettingFacts
from ui.session import state
from ui.shell.messages import shown_error
from ui.subjects.detectors import asking, choose, inside, run, trial
from ui.subjects.detectors.confined import DetectorFacts, DetectorSpec
from ui.subjects.detectors.run import RUN, RunSettings
from ui.widgets.recording import choose_recording_and_frame
from ui.widgets.text import docs_link, plain

NOT_HERE: Final = ("classifier", "threads")
"""Settings that the choice of the detector makes, or that change nothing of its boxes."""
COLUMNS: Final = 3


def draw(own: DetectorSpec) -> RunSettings | None:
    """Draw settings, the current frame, the inside of the model, and the run.

    Returns the settings of the run, or None if the detector cannot run.
    """
    spec = _draw_settings(own, asking.described(own).about)
    what = choose.checked(spec)
    if what is None:
        return None
    if not state.workspace().pictures.sources:
        _draw_no_pictures()
        return None
    st.header("Try it on a frame")
    choose_recording_and_frame("detector_frame")
    if asking.is_trained_frame(what.about):
        st.caption(
            ":material/warning: The detector was trained on this frame: what it finds here says "
            "nothing of frames that it has not seen."
        )
    picture, trouble = asking.picture()
    if picture is None:
        st.info(f"{plain(trouble)} Choose another frame or recording.")
    else:
        _draw_picture(spec, what, picture)
    return run.draw(spec, what)


def _draw_settings(spec: DetectorSpec, about: About) -> DetectorSpec:
    """The detector with the settings of the form; threshold and overlap are moved elsewhere."""
    moved = (DETECTORS[about.kind].threshold, "overlap", *NOT_HERE)
    facts = {name: known for name, known in run_settings(about).items() if name not in moved}
    changed: dict[str, Setting] = {}
    with st.expander("Settings"):
        columns = st.columns(COLUMNS, gap="medium")
        for number, (name, known) in enumerate(facts.items()):
            with columns[number % COLUMNS]:
                own = about.settings[name]
                value = _draw_setting(
                    name, known, own, key=f"detector_{asking.key_of(spec)}_{name}"
                )
                if value != own:
                    changed[name] = value
    return spec.with_settings(changed)


def _draw_setting(name: str, facts: SettingFacts, own: Setting, *, key: str) -> Setting:
    """The field of one setting; its value."""
    words = capitalised(name.replace("_", " "))
    more: dict[str, Any] = {"key": key, "help": plain(facts.meaning), "persist_state": "session"}
    value: Setting
    if facts.choices:
        choices = dict(facts.choices)
        value = st.selectbox(
            words,
            list(choices),
            index=list(choices).index(str(own)),
            format_func=lambda choice: f"{choice}: {choices[choice]}",
            **more,
        )
    elif isinstance(own, bool):
        value = st.toggle(words, own, **more)
    elif isinstance(own, int | float):
        kind = type(own)
        low, high = (None if end is None else kind(end) for end in (facts.low, facts.high))
        form = "%d" if kind is int else "%.4g"
        step = facts.multiple_of  # None: as usual
        value = st.number_input(words, low, high, own, step, form, **more)
    else:
        value = st.text_input(words, str(own or ""), max_chars=2000, **more)
    return value


def _draw_picture(spec: DetectorSpec, what: DetectorFacts, picture: Picture) -> None:
    try:
        trial.draw(spec, what, picture, has_run=RUN.job is not None)
    except NvcoreError as error:  # it takes too long, or too much memory
        st.error(shown_error(error), icon=":material/error:")
        return
    if what.inside is not None:
        inside.draw(spec, what.inside, picture)


def _draw_no_pictures() -> None:
    """Say that there are no pictures, and how to add them."""
    notes = {note for note in state.workspace().pictures.notes.values() if note}
    link = docs_link("how", "the-session-file", doc="formats")
    st.info(
        "A detector needs pictures, and none of the open recordings has any. Send them with ground "
        "truth and systems on the page Data (Upload), or name them in the session file: "
        f'`pictures = "drive.mp4"` below `[[recording]]` ({link}).',
        icon=":material/image_not_supported:",
    )
    for note in sorted(notes):
        st.caption(plain(note))

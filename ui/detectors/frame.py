"""Detectors page: what is done with the chosen detector, where there are pictures."""

from __future__ import annotations

import streamlit as st

from nvcore.errors import NvcoreError
from nvcore.pictures import Picture
from ui.detectors import asking, choose, inside, run, settings, trial
from ui.detectors.confined import DetectorFacts, DetectorSpec
from ui.detectors.run import RUN, RunSettings
from ui.session import state
from ui.shell.messages import shown_error
from ui.widgets.recording import choose_recording_and_frame
from ui.widgets.text import docs_link, plain


def draw(own: DetectorSpec) -> RunSettings | None:
    """Draw settings, the current frame, the inside of the model, and the run.

    Returns the settings of the run, or None if the detector cannot run.
    """
    spec = settings.draw(own, asking.described(own).about)
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

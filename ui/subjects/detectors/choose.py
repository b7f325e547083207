"""Detectors page: choice of the detector, and its description."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.common.wording import count_text, listed, shortened
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.icf.model import MAX_BYTES
from nvcore.subjects.detectors.registry import DETECTORS, kind_of_file
from ui.session import state, store
from ui.shell.messages import error_text, shown_error
from ui.subjects.detectors.asking import described, trained_recordings
from ui.subjects.detectors.confined import DetectorFacts, DetectorSpec
from ui.widgets.models import ModelKind, draw_field, is_sent, model_files
from ui.widgets.text import docs_link, plain

ONLY_LOCAL: Final = (
    "is a network in ONNX. Such a file is a program, and those of visitors do not run here: put it "
    "below the folder that the app is started with (nvcore app --local-root DIR), or run it by "
    "nvcore detect"
)
SENT: Final = "a model that nvcore train wrote (.npz)"


def _check_kind(path: Path) -> None:
    try:
        kind = kind_of_file(path)
    except DetectorError as error:  # names kinds, too, that may not be sent
        reason = error.message.partition(";")[0]
        raise DetectorError(f"{reason}; send {SENT}", file=path.name) from error
    if kind.key != "icf":
        raise DetectorError(ONLY_LOCAL, file=path.name)


KIND: Final = ModelKind("detector", (".npz", ".onnx"), MAX_BYTES, _check_kind)


def draw() -> DetectorSpec | None:
    """Draw the choice. Return it, or None if it cannot be used."""
    left, right = st.columns([3, 2], gap="large")
    with right, st.expander("A model of your own"):
        draw_field(KIND, "Model file (.npz, as nvcore train writes it)", shown=error_text)
        st.caption(
            "It stays on this server while the tab is open. Networks in ONNX are programs: they "
            "are run only from the folder that the app was started with "
            f"({docs_link('why', 'in-the-dashboard', doc='detectors')})."
        )
    options, usual = _options(), _usual()
    with left:
        text = st.selectbox(
            "Detector",
            list(options),
            list(options).index(usual),
            format_func=lambda option: options[option][0],
            key="detector",
            persist_state="session",
        )
        spec = options[text][1]
        what = checked(spec)
        if what is not None:
            _draw_about(what)
    return None if what is None else spec


def _usual() -> str:
    """Return the first choice. It changes with what is open, unless another was chosen.

    The sample's people are drawings, which a detector of people does not find.
    """
    is_sample = state.opened().session.folder == state.SAMPLE.parent
    usual = "icf:sample" if is_sample else "hog"
    before = store.USUAL_DETECTOR.get()
    if before not in (None, usual) and store.DETECTOR.get() == before:
        store.DETECTOR.set(usual)
    store.USUAL_DETECTOR.set(usual)
    return usual


def checked(spec: DetectorSpec) -> DetectorFacts | None:
    """Describe the detector. Draw why it cannot be used and return None otherwise."""
    try:
        return described(spec)
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")
        return None


def _options() -> dict[str, tuple[str, DetectorSpec]]:
    """Return label and detector of each option."""
    options = {
        name: (f"{name}: {words}", DetectorSpec(name))
        for kind in DETECTORS.values()
        for name, words in kind.built_in.items()
    }
    files = {
        key: (file.name, DetectorSpec(str(file.path), file.version))
        for key, file in model_files(KIND).items()
    }
    sent = {key: option for key, option in files.items() if is_sent(key)}
    return {**sent, **options, **files}


def _draw_about(what: DetectorFacts) -> None:
    """Draw its classes, what it was trained on, and its fingerprint."""
    about, inside = what.about, what.inside
    kinds = "class" if len(about.labels) == 1 else "classes"
    parts = [f"Detects the {kinds} {plain(listed([*about.labels]))}."]
    if inside is not None:
        parts.append(
            f"{inside.n_trees:,} trees over windows of {inside.settings.window_width} × "
            f"{inside.settings.window_height} px, "
            f"trained on {inside.n_objects:,} windows of objects and {inside.n_background:,} of "
            "background."
        )
    trained_on = "; ".join(map(str, about.trained_on))
    if trained_on:
        parts.append(f"Trained on: {plain(shortened(trained_on, 300))}.")
        n_all, n_open = len(state.recording_names()), len(trained_recordings(about))
        if n_open:
            parts.append(
                f"That is {n_open} of the {count_text(n_all, 'open recording')}: what it "
                "finds in them says little about others."
            )
    else:
        parts.append("On which recordings it was trained is not known.")
    parts.append(f"Fingerprint {about.fingerprint[:12]}.")
    st.caption(" ".join(parts))

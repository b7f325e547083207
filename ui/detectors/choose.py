"""Detectors page: which detector, and what it is."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import streamlit as st
from streamlit.runtime.uploaded_file_manager import UploadedFile

from nvcore.detectors.icf.model_file import MAX_BYTES
from nvcore.detectors.registry import DETECTORS, kind_of_file
from nvcore.errors import DetectorError, NvcoreError
from nvcore.wording import count_text, listed, shortened
from ui.confined.detectors import DetectorFacts, DetectorSpec
from ui.detectors.asking import described
from ui.session import state
from ui.session.local_files import LocalRoot, local_root
from ui.session.uploads import remove_model, store_model
from ui.shell.page_words import page_text
from ui.widgets.text import docs_link, plain

SENT: Final = "detector_sent"
"""What the page remembers of the model that was sent."""
USUAL: Final = "detector_usual"
ENDINGS: Final = (".npz", ".onnx")
SEEN: Final = "detector_file_seen"
TROUBLE: Final = "detector_file_trouble"
MOST_FOLDERS: Final = 200
MOST_MODELS: Final = 500
ONLY_LOCAL: Final = (
    "is a network in ONNX. Such a file is a program, and those of visitors do not run here: put it "
    "below the folder that the app is started with (nvcore app --local-root DIR), or run it by "
    "nvcore detect"
)


@dataclass(frozen=True)
class SentModel:
    """A model that was sent: where it lies, what it is called, and of which content it is."""

    path: Path
    name: str
    version: str


def draw() -> DetectorSpec | None:
    """The choice; None: what was chosen cannot be used, and why is said."""
    left, right = st.columns([3, 2], gap="large")
    with right, st.expander("A model of your own"):
        _take_model()
    options = _options()
    usual = _usual()
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
        about = checked(spec)
        if about is not None:
            _draw_about(about)
    return None if about is None else spec


def _usual() -> str:
    """What is chosen at first; it goes with what was open, unless another was chosen.

    The sample's people are drawings, which a detector of people does not find.
    """
    is_sample = state.opened().session.folder == state.SAMPLE.parent
    usual = "icf:sample" if is_sample else "hog"
    before = st.session_state.get(USUAL, usual)
    if before != usual and st.session_state.get("detector") == before:
        st.session_state["detector"] = usual
    st.session_state[USUAL] = usual
    return usual


def checked(spec: DetectorSpec) -> DetectorFacts | None:
    """What the detector is; None: it cannot be used, and why is said."""
    try:
        return described(spec)
    except NvcoreError as error:
        st.error(plain(page_text(error)), icon=":material/error:")
        return None


def _options() -> dict[str, tuple[str, DetectorSpec]]:
    """What can be chosen: words, and which detector that is."""
    options = {
        name: (f"{name}: {words}", DetectorSpec(name))
        for kind in DETECTORS.values()
        for name, words in kind.built_in.items()
    }
    sent: SentModel | None = state.workspace().notes.get(SENT)
    if sent is not None:
        spec = DetectorSpec(str(sent.path), sent.version)
        options = {f"sent {sent.version}": (f"{sent.name}, as sent", spec), **options}
    try:
        root = local_root()
    except NvcoreError:  # said on the Data page
        root = None
    for path in [] if root is None else models_below(root):
        assert root is not None
        place = root.find(path)
        status = place.stat()
        spec = DetectorSpec(str(place), f"{status.st_mtime_ns} {status.st_size}")
        options[f"local {path}"] = (path, spec)
    return options


def models_below(root: LocalRoot) -> list[str]:
    """Paths of the files below the local folder that are called like models."""
    folders = [""]
    models: list[str] = []
    for number, folder in enumerate(folders):  # grows meanwhile
        if number >= MOST_FOLDERS or len(models) >= MOST_MODELS:
            break
        try:
            entries = root.entries(folder)
        except NvcoreError:  # it may not be looked into
            continue
        folders += [entry.path for entry in entries if entry.is_folder]
        models += [
            entry.path
            for entry in entries
            if not entry.is_folder and entry.path.lower().endswith(ENDINGS)
        ]
    return models[:MOST_MODELS]


def _take_model() -> None:
    """The field for a model; what was sent stays until another is."""
    file = st.file_uploader(
        "Model file (.npz, as nvcore train writes it)",
        type=["npz"],
        max_upload_size=MAX_BYTES >> 20,
        key="detector_file",
    )
    if file is not None and st.session_state.get(SEEN) != file.file_id:
        st.session_state[SEEN] = file.file_id
        st.session_state[TROUBLE] = _take(file)
    if file is not None and (trouble := st.session_state.get(TROUBLE, "")):
        st.error(plain(trouble), icon=":material/error:")
    st.caption(
        "It stays on this server while the tab is open. Networks in ONNX are programs: they are "
        "run only from the folder that the app was started with "
        f"({docs_link('why', 'in-the-dashboard', doc='detectors')})."
    )


def _take(file: UploadedFile) -> str:
    """Store the model and choose it; why that cannot be done, empty: it is done."""
    notes = state.workspace().notes
    notes.pop(SENT, None)
    st.session_state.pop("detector", None)
    try:
        notes[SENT] = model = _stored(file)
    except NvcoreError as error:
        return page_text(error)
    st.session_state["detector"] = f"sent {model.version}"
    return ""


def _stored(file: UploadedFile) -> SentModel:
    """The model on disk.

    Raises
    ------
    NvcoreError
        If it is too large, no model that may be sent, or there is no room.
    """
    content = file.getbuffer()
    if len(content) > MAX_BYTES:
        raise DetectorError(f"a model has at most {MAX_BYTES >> 20} MiB", file=file.name)
    space = state.workspace()
    path = store_model(space, file)
    try:
        if kind_of_file(path).key != "icf":
            raise DetectorError(ONLY_LOCAL, file=file.name)
    except DetectorError:
        remove_model(space)
        raise
    return SentModel(path, path.name, hashlib.sha256(content).hexdigest()[:12])


def _draw_about(what: DetectorFacts) -> None:
    """What it detects, what it was trained on, by which digits it is known."""
    about, inside = what.about, what.inside
    parts = [f"Detects {plain(listed([*about.labels]))}."]
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
        names = state.recording_names()
        n_open = len({part.recording for part in about.trained_on} & set(names))
        if n_open:
            parts.append(
                f"That is {n_open} of the {count_text(len(names), 'open recording')}: what it "
                "finds in them says little about others."
            )
    else:
        parts.append("On which recordings it was trained is not known.")
    parts.append(f"Fingerprint {about.fingerprint[:12]}.")
    st.caption(" ".join(parts))

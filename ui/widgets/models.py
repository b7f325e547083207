"""Model files that a page accepts: an uploaded one, and those below the local folder."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from typing import Final, NamedTuple

import streamlit as st
from streamlit.typing import UploadedFile

from nvcore.common.errors import InputError, NvcoreError
from ui.access.files import LocalRoot, local_root
from ui.session import state, store
from ui.session.uploads import store_model
from ui.widgets.text import plain

MOST_FOLDERS: Final = 200
MOST_MODELS: Final = 500


@dataclass(frozen=True)
class ModelKind:
    """Kind of model files that a page accepts.

    Attributes
    ----------
    name
        Prefix of the widgets' keys. The choice of the model has it as its key.
    endings
        File extensions to list below the local folder.
    max_bytes
        Maximum size of an uploaded file.
    check
        Raises `NvcoreError` if an uploaded file with this name must not be used.
    sent_endings
        Accepted extensions of an uploaded file.
    """

    name: str
    endings: tuple[str, ...]
    max_bytes: int
    check: Callable[[Path], object]
    sent_endings: tuple[str, ...] = (".npz",)

    @property
    def field(self) -> str:
        """Key of the upload field."""
        return f"{self.name}_file"

    @property
    def sent(self) -> str:
        """Workspace key of the uploaded model."""
        return f"{self.name}_sent"


class ModelFile(NamedTuple):
    """Model file: path, label, and an identifier of its content."""

    path: Path
    name: str
    version: str


def draw_field(kind: ModelKind, label: str, *, shown: Callable[[NvcoreError], str]) -> None:
    """Draw the upload field. An uploaded file is selected, and stays until the next upload.

    Parameters
    ----------
    shown
        Formats an error for the page, before escaping.
    """
    seen, trouble = store.MODEL_FILE_SEEN.of(kind.field), store.MODEL_TROUBLE.of(kind.field)
    # accept all extensions: a rejection by Streamlit itself would keep the old file, and stay
    # visible
    file = st.file_uploader(label, max_upload_size=kind.max_bytes >> 20, key=kind.field)
    if file is not None and seen.get() != file.file_id:
        seen.set(file.file_id)
        trouble.set(_take(kind, file, shown))
    if file is not None and (text := trouble.get()):
        st.error(plain(text), icon=":material/error:")


def model_files(kind: ModelKind) -> dict[str, ModelFile]:
    """Return the selectable files by the value of the choice. An uploaded file comes first."""
    files: dict[str, ModelFile] = {}
    sent: ModelFile | None = state.workspace().notes.get(kind.sent)
    if sent is not None:
        files[f"sent {sent.version}"] = sent._replace(name=f"{sent.name}, as sent")
    try:
        root = local_root()
    except NvcoreError:  # reported on the Data page
        return files
    for path in [] if root is None else models_below(root, kind.endings):
        assert root is not None
        place = root.find(path)
        status = place.stat()
        version = f"{status.st_mtime_ns} {status.st_size}"
        files[f"local {path}"] = ModelFile(place, path, version)
    return files


def is_sent(key: str) -> bool:
    """Whether a key of `model_files` stands for the uploaded file."""
    return key.startswith("sent ")


def models_below(root: LocalRoot, endings: tuple[str, ...]) -> list[str]:
    """Return the paths below the local folder that have a model's extension."""
    files = chain.from_iterable(paths for _, paths in root.walk(MOST_FOLDERS))
    return [*islice((path for path in files if path.lower().endswith(endings)), MOST_MODELS)]


def _take(kind: ModelKind, file: UploadedFile, shown: Callable[[NvcoreError], str]) -> str:
    """Store a model and select it. On failure, keep the previous one and return the reason."""
    try:
        model = _stored(kind, file)
    except NvcoreError as error:
        return shown(error)
    state.workspace().notes[kind.sent] = model
    store.widget(kind.name).set(f"sent {model.version}")
    return ""


def _stored(kind: ModelKind, file: UploadedFile) -> ModelFile:
    """Store an uploaded model on disk.

    Raises
    ------
    NvcoreError
        If it is too large, not an accepted model, or there is no space left.
    """
    if not file.name.lower().endswith(kind.sent_endings):
        expected = " or ".join(kind.sent_endings)
        raise InputError(
            f"cannot be used here; send a file that ends in {expected}", file=file.name
        )
    content = file.getbuffer()
    if len(content) > kind.max_bytes:
        raise InputError(f"a model has at most {kind.max_bytes >> 20} MiB", file=file.name)
    path = store_model(state.workspace(), file, kind.name, kind.check)
    return ModelFile(path, path.name, hashlib.sha256(content).hexdigest()[:12])

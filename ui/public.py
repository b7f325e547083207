"""What may be shown of a text that names files: without the folders of the machine."""

from __future__ import annotations

from pathlib import Path

import streamlit as st

from nvcore.errors import NvcoreError
from ui import local_files, state
from ui.opening import public_text
from ui.text import plain
from ui.workspace import Workspace


def public(text: object) -> str:
    """The text without the paths of the machine; not yet plain."""
    return public_text(text, _folders())


def shown_error(error: BaseException) -> str:
    """The error as Markdown that shows it as it is, without the paths of the machine.

    Opens nothing, so that it also works where the workspace itself could not be opened.
    """
    return plain(public(error))


def _folders() -> list[Path]:
    folders = [state.ROOT]
    try:
        root = local_files.local_root()
    except NvcoreError:  # told where files are chosen
        root = None
    if root is not None:
        folders.append(root.folder)
    space: Workspace | None = st.session_state.get("workspace")
    if space is not None:
        folders += [space.folder, *space.folder.glob("upload-*")]
        if space.session is not None:
            folders.append(space.session.folder)
    return folders

"""Folders with pictures for a study."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from nvcore.common.errors import InputError
from nvcore.subjects.driver.study.pictures import BOXES_FILE
from ui.access.files import local_root
from ui.session import state

SAMPLE: Final = "sample"
LOCAL: Final = "local:"
"""Prefix for names of folders below the app's local folder."""
DEEPEST: Final = 3
"""Maximum depth of searched folders below that folder."""
MOST_FOLDERS: Final = 500
"""Maximum number of folders that are searched."""


def sample_folder() -> Path:
    """Return the folder of the sample's pictures for a study, which need not exist."""
    return state.SAMPLE.parent / "study"


def folders() -> dict[str, str]:
    """Return folders with pictures for a study: label by name in the file of answers.

    Raises
    ------
    InputError
        If the app's local folder cannot be used.
    """
    names: dict[str, str] = {}
    if (sample_folder() / BOXES_FILE).is_file():
        names[SAMPLE] = "Sample pictures (rendered)"
    root = local_root()
    if root is not None:
        for path, files in root.walk(MOST_FOLDERS):
            if path.count("/") >= DEEPEST:  # all that follow are at least as deep
                break
            if f"{path}/{BOXES_FILE}".lstrip("/") in files:
                names[f"{LOCAL}{path}"] = path or "(top folder)"
    return names


def folder_of(name: str) -> Path:
    """Return the folder of a study's pictures.

    Raises
    ------
    InputError
        If the folder does not exist, or is not below the app's local folder.
    """
    if name == SAMPLE:
        return sample_folder()
    root = local_root()
    if root is None or not name.startswith(LOCAL):
        raise InputError(
            "the pictures of this study are below the folder that the app was started with "
            "(--local-root), and now it was started without"
        )
    return root.find(name.removeprefix(LOCAL))

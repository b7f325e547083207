"""Checks the server's configuration before the first visitor comes.

A configuration that cannot work stops the start: otherwise visitors would be the first to find out.
"""

from __future__ import annotations

import os

from nvcore.errors import InputError
from nvcore.inputs.files import find_all
from nvcore.inputs.session_toml import read_session
from ui.session import folders
from ui.session.local_files import local_root
from ui.settings.limits import limits_of_environment
from ui.settings.start import start_file
from ui.subjects import contributed


def check_start() -> None:
    """Check limits, session, local folder, and the folders for uploads and answers.

    Also removes uploads left behind by servers that were killed.

    Raises
    ------
    InputError
        If one of them cannot be used.
    """
    limits_of_environment()
    local_root()
    session = start_file()
    if session is not None:
        find_all(read_session(session))
    for studies in contributed("STUDIES"):
        if os.environ.get(studies.variable):
            studies.store()
    try:
        folders.process_folder(folders.base_folder())
    except OSError as error:
        raise InputError(
            f"uploads cannot be kept there ({error.strerror}); name a folder that the server may "
            f"write to: {folders.ENVIRONMENT}",
            file=error.filename,
        ) from error

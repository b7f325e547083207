"""What the server was started with, looked at before the first visitor comes.

What cannot work ends the start: a server that is there, and says so, but shows an error to
everybody, is found by its visitors.
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
    """Look at limits, session, local folder, and where uploads and answers go.

    What a server that was killed has left of its uploads is removed.

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

"""Upload of pictures and videos to the session's folder, with progress, bypassing Streamlit.

This is a Streamlit component: a field to drop or choose files. Each file goes by PUT to the upload
route. When all have arrived, Python looks for them in the session's folder.
"""

from __future__ import annotations

from pathlib import Path

import streamlit as st

from ui.session.routes import address
from ui.session.uploads import MAX_FILE_BYTES
from ui.session.workspace import PICTURES, Workspace
from ui.widgets.script import read_script

FOLDER = Path(__file__).parent
MOST_LISTED = 6
"""Maximum number of rejected files to list."""

_COMPONENT = st.components.v2.component(
    "nvcore_upload",
    css=(FOLDER / "upload.css").read_text(encoding="utf-8"),
    js=read_script(FOLDER / "upload.js"),
)


def upload_pictures(space: Workspace, *, key: str) -> list[str]:
    """Draw the upload field. A new run starts when files have arrived in ``space.stored``.

    Return a text for each of the last chosen files that was rejected, not escaped.
    """
    state = _COMPONENT(
        data={"url": f"{address(space)}/upload/{PICTURES}", "maxBytes": MAX_FILE_BYTES},
        key=key,
        on_arrived_change=lambda: None,
        on_refused_change=lambda: None,
    )
    refused = getattr(state, "refused", None)
    return [str(text) for text in refused[:MOST_LISTED]] if isinstance(refused, list) else []

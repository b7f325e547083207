"""The Export page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

from inputs import drive, session_of
from streamlit.testing.v1 import AppTest

from nvcore.inputs.load import load
from nvcore.inputs.session import SystemSource
from nvcore.pictures.recordings import RecordingPictures
from pages import checked, part
from ui.session.workspace import Opened, Workspace

PARTS = {
    "link": "ui.views.export.link.draw()",
    "report": "ui.views.export.report.draw(RESULT)",
    "html": "ui.views.export.html.draw(RESULT)",
    "frame": "ui.views.export.frame.choose_frame(RESULT)\nui.views.export.frame.draw(RESULT)",
    "video": "ui.views.export.video.draw(RESULT)",
    "swap": "ui.shell.systems.draw()",
}
SYSTEMS = (SystemSource(("fir.csv",), name="fir"), SystemSource(("nir.csv",), name="nir"))


def opened(*parts: str, space: Workspace | None = None, **address: str) -> AppTest:
    """These parts of the page."""
    return checked(part(*map(PARTS.__getitem__, parts), space=space, **address).run())


def uploads(folder: Path) -> Workspace:
    """A workspace in which truth.csv, fir.csv and nir.csv of the folder are open."""
    session, space = session_of(folder, "truth.csv", *SYSTEMS), Workspace()
    space.show(Opened.of(session, load(session), "Uploaded files"), RecordingPictures())
    return space


def uploaded_drive(folder: Path) -> Workspace:
    """As `uploads`, the files newly written."""
    return uploads(drive(folder))


def downloads(page: AppTest) -> list[str]:
    return [button.proto.label for button in page.get("download_button")]


def job_of(page: AppTest, kind: str):
    return page.session_state["workspace"].job(kind)

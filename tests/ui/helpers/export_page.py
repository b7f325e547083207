"""The Export page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

from inputs import drive
from streamlit.testing.v1 import AppTest

from pages import alone, checked

OPENING = """
import streamlit as st
from pathlib import Path
from nvcore.inputs.session import Session, Source, SystemSource
from ui.session import state
if "is_open" not in st.session_state:
    st.session_state["is_open"] = True
    folder = Path({folder!r})
    systems = tuple(SystemSource((path,), name=name) for name, path in {systems!r})
    state.open_session(Session(folder, Source(("truth.csv",)), systems, size=(640, 480), fps=20),
                       label="Uploaded files")
"""
SYSTEMS = (("fir", "fir.csv"), ("nir", "nir.csv"))


def opened(before: str = "", **address: str) -> AppTest:
    return checked(alone("export", before=before, **address).run())


def opened_folder(folder: Path, *systems: tuple[str, str]) -> AppTest:
    """With truth.csv and the files of these systems, by name, in the folder."""
    return opened(OPENING.format(folder=str(folder), systems=systems or SYSTEMS))


def opened_drive(folder: Path, *systems: tuple[str, str]) -> AppTest:
    """As `opened_folder`, the files newly written."""
    drive(folder)
    return opened_folder(folder, *systems)


def downloads(page: AppTest) -> list[str]:
    return [button.proto.label for button in page.get("download_button")]


def job_of(page: AppTest, kind: str):
    return page.session_state["workspace"].job(kind)

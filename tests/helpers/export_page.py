"""The Export page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

from inputs import drive
from places import DATA
from streamlit.testing.v1 import AppTest

ROOT = DATA.parents[1]
PAGE = f"""
import runpy
from ui.session import state
state.begin_run()
runpy.run_path({str(ROOT / "pages" / "export.py")!r})
"""
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


def checked(page: AppTest) -> AppTest:
    assert [error.message for error in page.exception] == []
    return page


def opened(script: str = PAGE, **address: str) -> AppTest:
    page = AppTest.from_string(script, default_timeout=60)
    for name, value in address.items():
        page.query_params[name] = value
    return checked(page.run())


def opened_folder(folder: Path, *systems: tuple[str, str]) -> AppTest:
    """With truth.csv and the files of these systems, by name, in the folder."""
    return opened(OPENING.format(folder=str(folder), systems=systems or SYSTEMS) + PAGE)


def opened_drive(folder: Path, *systems: tuple[str, str]) -> AppTest:
    """As `opened_folder`, the files newly written."""
    drive(folder)
    return opened_folder(folder, *systems)


def downloads(page: AppTest) -> list[str]:
    return [one.proto.label for one in page.get("download_button")]


def job_of(page: AppTest, kind: str):
    return page.session_state["workspace"].job(kind)

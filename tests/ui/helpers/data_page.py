"""The Data page, driven without a browser, and files to send to it."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pandas as pd
import pytest
import streamlit as st
from inputs import drive, write
from places import ROOT
from streamlit.testing.v1 import AppTest

from pages import checked, part, press, space_of
from ui.session.uploads import receive

READING = (
    "ui.views.data.opening.draw_outcome()", "ui.views.data.choose.draw()",
    "ui.views.data.audit.findings.draw()", "ui.views.data.inputs.draw()",
)  # fmt: skip
"""What files can be opened with, and what is found and read in them."""
COMPARING = (
    "ui.views.data.compare.draw()",
    "ui.shell.systems.draw()",
    "ui.shell.sidebar.draw(wrong, pages.PAGE_OF['data'])",
)
PNG = b"\x89PNG\r\n\x1a\n" + bytes(100)
ASKED = {"width": 640, "height": 480, "fps": 20.0}
"""What the page asks of files that say none of it."""
ON_SAMPLE = "Open now: Sample recordings ("


def opened(*calls: str) -> AppTest:
    """The parts of the page that read files, or these."""
    return checked(part(*(calls or READING)).run())


def press_labelled(page: AppTest, label: str) -> AppTest:
    (button,) = [button for button in page.button if button.label == label]
    return checked(button.click().run())


def send(page: AppTest, key: str, *files: tuple[str, bytes]) -> None:
    page.file_uploader(key=key).set_value([(*file, "application/octet-stream") for file in files])


def sent(truth: bytes, *systems: tuple[str, bytes], calls: tuple[str, ...] = READING) -> AppTest:
    """The form with ground truth and systems, not opened yet."""
    page = opened(*calls)
    send(page, "upload_truth", ("truth.csv", truth))
    for number, file in enumerate(systems):
        send(page, f"upload_system_{number}", file)
    return checked(page.run())


def sent_drive(folder: Path, *systems: str) -> AppTest:
    drive(folder)
    files = [(name, (folder / name).read_bytes()) for name in systems]
    return sent((folder / "truth.csv").read_bytes(), *files)


def answer(page: AppTest, place: str = "upload", **values: float) -> None:
    """Fill in what the page asks for: width, height, fps."""
    for name, value in values.items():
        (field,) = [
            field for field in page.number_input if (field.key or "").startswith(f"{name}_{place}")
        ]
        field.set_value(value)


def asked(page: AppTest) -> dict[str, float | None]:
    fields = (field for field in page.number_input if "upload" in (field.key or ""))
    return {field.label: field.value for field in fields}


def open_files(page: AppTest, **values: float) -> AppTest:
    """Open what was sent, with all that the page asks for, or with these answers."""
    answer(page, **(values or ASKED))
    return press(page, "open_upload")


def opened_drive(folder: Path, *systems: str) -> AppTest:
    return open_files(sent_drive(folder, *systems))


def recordings_of(page: AppTest) -> pd.DataFrame:
    """The table of the recordings that are open, as it is offered for editing."""
    (table,) = [item.value for item in page.dataframe if "note" in item.value]
    return table


def sizes_of(page: AppTest) -> list[tuple[float, float]]:
    return [*recordings_of(page)[["width", "height"]].itertuples(index=False, name=None)]


class Edit:
    """Changes of the first recording in the table of recordings, as by a person."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.changes: dict[str, object] = {}
        editor = st.data_editor

        def edit(table: pd.DataFrame, **more: object) -> pd.DataFrame:
            editor(table, **more)
            after = table.copy().astype(object)
            for column, value in self.changes.items():
                after.loc[0, column] = value
            self.changes = {}
            return after

        monkeypatch.setattr(st, "data_editor", edit)

    def apply(self, page: AppTest, **changes: object) -> AppTest:
        """Change cells, and apply the table."""
        self.changes = changes
        return press_labelled(page, "Apply to the recordings")


def late_drive(folder: Path) -> tuple[bytes, bytes]:
    """Truth of three pedestrians walking across, and detections that are 3 frames late."""
    truth, late = ["frame,x,y,w,h,track"], ["frame,x,y,w,h,score"]
    for frame in range(60):
        for track in range(3):
            x = 20 + 150 * track + 4 * frame
            truth.append(f"{frame},{x},100,20,60,{track}")
            late.append(f"{frame + 3},{x},100,20,60,0.9")
    paths = write(folder / "t.csv", *truth), write(folder / "l.csv", *late)
    return paths[0].read_bytes(), paths[1].read_bytes()


def send_video(page: AppTest, name: str, n_bytes: int | None = None) -> AppTest:
    """As the upload route does it; only the first bytes where their number is given."""

    async def content():
        yield (ROOT / "sample_data" / "odd_pose.mp4").read_bytes()[:n_bytes]

    asyncio.run(receive(space_of(page), name, content()))
    return checked(page.run())


def late_page(folder: Path) -> AppTest:
    """The form with one recording and a system, not opened yet."""
    truth, late = late_drive(folder)
    return sent(truth, ("late.csv", late))

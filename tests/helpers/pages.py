"""Pages run by AppTest, and the small sessions that they are shown."""

from __future__ import annotations

from pathlib import Path

from inputs import drive
from streamlit.testing.v1 import AppTest

from nvcore.inputs.session import Session, Source, SystemSource


def checked(page: AppTest) -> AppTest:
    assert [error.message for error in page.exception] == []
    return page


def texts(page: AppTest) -> str:
    """All that is said in words, markup taken away."""
    kinds = (page.markdown, page.caption, page.warning, page.info, page.header)
    return "\n".join(one.value for kind in kinds for one in kind).replace("\\", "")


def session(folder: Path, *systems: str) -> Session:
    drive(folder)
    return Session(
        folder,
        Source(("truth.csv",)),
        tuple(SystemSource((one,)) for one in systems),
        size=(640, 480),
        fps=20.0,
    )


HEAD = "recording,frame,x,y,w,h,track,score\n"


FRAMES = range(30)


def rows(x: int, *, track: int = 1, score: str = "0.9", recording: str = "night") -> str:
    return "".join(
        f"{recording},{frame},{x + frame},200,40,120,{track},{score}\n" for frame in FRAMES
    )


def write(folder: Path, systems: dict[str, str], *, frames: str = "0:29", truth: str = "") -> Path:
    """A session with one recording without pictures."""
    (folder / "truth.csv").write_text(HEAD.replace(",score", "") + truth.replace(",0.9", ""))
    text = f'[defaults]\nsize = "640x480"\nfps = 10\nframes = "{frames}"\n'
    text += '[truth]\npath = "truth.csv"\n'
    for name, content in systems.items():
        (folder / f"{name}.csv").write_text(HEAD.replace("track,", "") + content)
        text += f'[[system]]\nname = "{name}"\npath = "{name}.csv"\n'
    session = folder / "session.toml"
    session.write_text(text)
    return session

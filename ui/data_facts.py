"""Data page: questions about inputs, asked only where the files do not answer them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.errors import MediaError
from nvcore.media.sources import open_pictures
from nvcore.readers import FORMATS
from nvcore.readers.base import Role
from nvcore.session import Session
from ui.data_opening import FACTS, trouble_of
from ui.opening import checked_frames

MAX_SIZE_PX: Final = 100_000
MAX_FPS: Final = 10_000.0
AUTOMATIC: Final = "told from the content"
FRAME_BASES: Final = {"as usual for the format": None, "the first frame is 0": 0,
                      "the first frame is 1": 1}  # fmt: skip
BOX_BASES: Final = {"as usual for the format": None, "the first pixel is 0": 0,
                    "the first pixel is 1": 1}  # fmt: skip


@dataclass(frozen=True)
class Facts:
    """What a person says of all recordings; None: the files tell."""

    size: tuple[int, int] | None = None
    fps: float | None = None
    frames: str | None = None

    def session(self, **parts: Any) -> Session:
        """A session with these facts.

        Raises
        ------
        SessionError
            If the frames are no range.
        """
        return Session(
            size=self.size, fps=self.fps, frames=checked_frames(self.frames or ""), **parts
        )

    def added_to(self, session: Session) -> Session:
        """A session that was read from a file, with these facts; what is not given stays.

        Raises
        ------
        SessionError
            If the frames are no range.
        """
        given = {
            "size": self.size, "fps": self.fps, "frames": checked_frames(self.frames or ""),
        }  # fmt: skip
        return replace(session, **{k: v for k, v in given.items() if v is not None})


def draw_facts(place: str, pictures: Iterable[Path], lacking: Iterable[str] = ()) -> Facts:
    """Fields for what the files do not say; none if nothing.

    Parameters
    ----------
    place
        Part of the page; see `ui.data_opening`.
    pictures
        Pictures of the recordings, whose size and frame rate are proposed.
    lacking
        What the files are known not to say; what they left open when they were last opened is
        asked as well.
    """
    trouble = trouble_of(place)
    asked = st.session_state.setdefault(f"asked_{place}", set())
    asked |= set(() if trouble is None else trouble.facts)
    asked = asked | set(lacking)
    pictures = list(pictures)
    facts: dict[str, Any] = {}
    if asked:
        words = " and ".join(FACTS[fact] for fact in FACTS if fact in asked)
        st.markdown(f"**Not in the files: {words}**")
    if "size" in asked:
        facts["size"] = _draw_size(place, picture_size(pictures))
    if "fps" in asked:
        facts["fps"] = _draw_rate(place, picture_rate(pictures))
    if "frames" in asked:
        facts["frames"] = st.text_input(
            "Evaluated frames", placeholder="0:299", key=f"frames_{place}",
            help="FIRST:LAST or FIRST:LAST:STEP, by the frame numbers of the truth.",
        )  # fmt: skip
    return Facts(**facts)


def _draw_size(place: str, proposed: tuple[int, int] | None) -> tuple[int, int] | None:
    if st.session_state.get(f"width_{place}_None") is not None:
        proposed = None  # what a person has typed stays
    width, height = proposed or (None, None)
    left, right = st.columns(2)
    wide = left.number_input(
        "Width of the pictures (px)", 1, MAX_SIZE_PX, value=width, step=1,
        key=f"width_{place}_{width}", placeholder="such as 640",
    )  # fmt: skip
    high = right.number_input(
        "Height of the pictures (px)", 1, MAX_SIZE_PX, value=height, step=1,
        key=f"height_{place}_{height}", placeholder="such as 480",
    )  # fmt: skip
    if proposed is not None:
        st.caption("The size of the pictures given; boxes have to be in the same pixels.")
    return None if wide is None or high is None else (int(wide), int(high))


def _draw_rate(place: str, proposed: float | None) -> float | None:
    if st.session_state.get(f"fps_{place}_None") is not None:
        proposed = None  # what a person has typed stays
    rate = st.number_input(
        "Frames per second", 0.01, MAX_FPS, value=proposed, step=1.0,
        key=f"fps_{place}_{proposed}", placeholder="such as 20", format="%.6g",
        help="How many frame numbers make a second: of the numbering in the files, even if only "
        "every tenth frame is annotated. A video is proposed with the rate at which it plays, "
        "which may differ from that of the camera.",
    )  # fmt: skip
    if proposed is not None:
        st.caption(
            "The rate at which the video plays; change it if the camera took the frames at "
            "another one. Times, lead times and rates per minute depend on it."
        )
    return None if rate is None else float(rate)


def forget_facts(place: str) -> None:
    """Ask nothing from now on, until files leave something open again."""
    st.session_state.pop(f"asked_{place}", None)


def draw_reading(role: Role, key: str, changed: Callable[[], None]) -> dict[str, Any]:
    """Fields of `nvcore.session.Source` that hardly ever have to be given."""
    titles = {one.title: one.name for one in FORMATS if role in one.roles}
    title = st.selectbox("Format", [AUTOMATIC, *titles], key=f"format_{key}", on_change=changed)
    frame_base = st.selectbox(
        "Frame numbers", list(FRAME_BASES), key=f"frame_base_{key}", on_change=changed
    )
    box_base = st.selectbox(
        "Coordinates", list(BOX_BASES), key=f"box_base_{key}", on_change=changed
    )
    classes = st.text_input(
        "Classes that are pedestrians", key=f"classes_{key}", on_change=changed,
        placeholder="as usual for the format", help="Names or numbers, with commas between them.",
    )  # fmt: skip
    given = tuple(name.strip() for name in classes.split(",") if name.strip())
    return {
        "format": titles.get(title),
        "frame_base": FRAME_BASES[frame_base],
        "box_base": BOX_BASES[box_base],
        "classes": given or None,
    }


def picture_size(paths: Iterable[Path]) -> tuple[int, int] | None:
    """Size of the first pictures that can be opened."""
    return next((one.size for one in map(look_at_pictures, paths) if one.size), None)


def picture_rate(paths: Iterable[Path]) -> float | None:
    """Frame rate of the first pictures that state one, within what can be given."""
    rates = (one.fps for one in map(look_at_pictures, paths))
    return next((rate for rate in rates if rate is not None and 0.01 <= rate <= MAX_FPS), None)


@dataclass(frozen=True)
class PictureLook:
    """What pictures turn out to be.

    Attributes
    ----------
    size
        (width, height) px; None: they cannot be opened.
    fps
        Frame rate that they state, 1/s.
    trouble
        Why they cannot be opened.
    """

    size: tuple[int, int] | None = None
    fps: float | None = None
    trouble: str = ""


def look_at_pictures(path: Path) -> PictureLook:
    """Open pictures to see what they are; once for the file as it is."""
    try:
        status = path.stat()
    except OSError as error:
        return PictureLook(trouble=f"cannot be opened ({error.strerror})")
    return _look_at_pictures(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=256)
def _look_at_pictures(path: Path, changed_ns: int, n_bytes: int) -> PictureLook:  # noqa: ARG001
    """Kept for the file as it is: a long video takes time to open."""
    try:
        pictures = open_pictures(path)
    except MediaError as error:
        return PictureLook(trouble=error.message)
    found = PictureLook((int(pictures.width), int(pictures.height)), pictures.fps)
    pictures.close()
    return found

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
from ui.data_opening import trouble_of
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


def draw_facts(place: str, pictures: Iterable[Path]) -> Facts:
    """Fields for what the files did not say when they were last opened; none if nothing.

    Parameters
    ----------
    place
        Part of the page; see `ui.data_opening`.
    pictures
        Pictures of the recordings, whose size is proposed.
    """
    trouble = trouble_of(place)
    asked = st.session_state.setdefault(f"asked_{place}", set())
    asked |= set(() if trouble is None else trouble.facts)
    facts: dict[str, Any] = {}
    if "size" in asked:
        proposed = picture_size(pictures)
        width, height = proposed or (None, None)
        left, right = st.columns(2)
        wide = left.number_input(
            "Width of the pictures (px)", 1, MAX_SIZE_PX, value=width, step=1,
            key=f"width_{place}_{width}",
        )  # fmt: skip
        high = right.number_input(
            "Height of the pictures (px)", 1, MAX_SIZE_PX, value=height, step=1,
            key=f"height_{place}_{height}",
        )  # fmt: skip
        if proposed is not None:
            st.caption(
                "The size is that of the pictures sent; boxes have to be in the same pixels."
            )
        facts["size"] = None if wide is None or high is None else (int(wide), int(high))
    if "fps" in asked:
        facts["fps"] = st.number_input(
            "Frames per second", 0.01, MAX_FPS, value=None, step=1.0, key=f"fps_{place}",
            help="How many frame numbers make a second: of the numbering in the files, even if "
            "only every tenth frame is annotated.",
        )  # fmt: skip
    if "frames" in asked:
        facts["frames"] = st.text_input(
            "Evaluated frames", placeholder="0:299", key=f"frames_{place}",
            help="FIRST:LAST or FIRST:LAST:STEP, by the frame numbers of the truth.",
        )  # fmt: skip
    return Facts(**facts)


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
    for path in paths:
        try:
            status = path.stat()
        except OSError:  # told when they are shown
            continue
        size = _size_of(path, status.st_mtime_ns, status.st_size)
        if size is not None:
            return size
    return None


@lru_cache(maxsize=256)
def _size_of(path: Path, changed_ns: int, n_bytes: int) -> tuple[int, int] | None:  # noqa: ARG001
    """Size of these pictures, kept for the file as it is: a long video takes time to open."""
    try:
        pictures = open_pictures(path)
    except MediaError:  # told when they are shown
        return None
    size = int(pictures.width), int(pictures.height)
    pictures.close()
    return size

"""Data page: questions about inputs, asked only where the files do not answer them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.errors import MediaError
from nvcore.inputs.box_layouts import KINDS, UNITS, BoxLayout
from nvcore.inputs.facts import FRAME_NAMES as WAYS
from nvcore.inputs.facts import FRAME_RANGE
from nvcore.inputs.proposals import USUAL_INPUTS, UsualInputs
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import Session
from nvcore.settings import MAX_FPS, MIN_FPS
from nvcore.wording import capitalised
from ui.data.opening import MISSING_WORDS
from ui.session import state, store
from ui.session.opening import checked_frames
from ui.widgets.text import plain

MOST_CHECKS: Final = 256
"""Pictures that are remembered: a long video takes time to open."""
MAX_SIZE_PX: Final = 100_000
AUTOMATIC: Final = "by the content"
AS_FORMAT: Final = "as the format has them"
LAYOUTS: Final = {
    str(layout): layout.text
    for layout in (
        *(BoxLayout(kind, yx, unit) for unit in UNITS for kind in KINDS for yx in (False, True)),
        BoxLayout("centres", unit="shares", is_score_first=True),
    )
}
FRAME_BASES: Final = {
    "as usual for the format": None,
    "the first frame is 0": 0,
    "the first frame is 1": 1,
}
BOX_BASES: Final = {
    "as usual for the format": None,
    "the first pixel is 0": 0,
    "the first pixel is 1": 1,
}
FRAME_NAMES: Final = {"by what they look like": None, **{way: way for way in WAYS}}
"""How names of pictures and large frame numbers are understood."""


@dataclass(frozen=True)
class MissingInputs:
    """Inputs that a person gave for all recordings. None: the files state it."""

    size: tuple[int, int] | None = None
    fps: float | None = None
    frames: str | None = None

    def session(self, *, frame_list: str | None = None, **parts: Any) -> Session:
        """Make a session with these inputs and `parts`. A `frame_list` precedes a range.

        Raises
        ------
        SessionError
            If the frames are no range.
        """
        frames = frame_list or checked_frames(self.frames or "")
        return Session(size=self.size, fps=self.fps, frames=frames, **parts)

    @property
    def of_recording(self) -> dict[str, Any]:
        """The inputs as fields of a recording's entry.

        Raises
        ------
        SessionError
            If the frames are no range.
        """
        width, height = self.size or (None, None)
        frames = checked_frames(self.frames or "")
        values = {"width": width, "height": height, "fps": self.fps, "frames": frames}
        return {name: value for name, value in values.items() if value is not None}

    def added_to(self, session: Session) -> Session:
        """Add these inputs to a session that was read from a file. None keeps its own.

        Raises
        ------
        SessionError
            If the frames are no range.
        """
        return replace(
            session,
            size=self.size or session.size,
            fps=self.fps or session.fps,
            frames=checked_frames(self.frames or "") or session.frames,
        )


def ask_for_missing(
    place: str,
    pictures: Iterable[Path],
    unknown: Iterable[str] = (),
    format_name: str = "",
    sizes: Mapping[str, tuple[int, int]] | None = None,
) -> MissingInputs:
    """Fields for what the files do not say (`unknown`, or missing when last opened), if any.

    Size and frame rate of the pictures are proposed, else the `sizes` that boxes point to by
    recording, else those that are usual for the format of the ground truth.
    """
    trouble = store.TROUBLES.of(place).get()
    lacking = store.ASKED_FACTS.of(place)
    lacking.set(lacking.get().union(() if trouble is None else trouble.facts))
    asked = lacking.get() | set(unknown)
    pictures, usual = list(pictures), USUAL_INPUTS.get(format_name)
    if sizes and usual is not None:
        usual = _by_the_edges(usual, sizes)
    values: dict[str, Any] = {}
    if asked:
        words = " and ".join(MISSING_WORDS[fact] for fact in MISSING_WORDS if fact in asked)
        st.markdown(f"**Not in the files: {words}**")
    if "size" in asked:
        values["size"] = _draw_size(place, picture_size(pictures), usual)
    if "fps" in asked:
        values["fps"] = _draw_rate(place, picture_rate(pictures), usual)
    if "frames" in asked:
        values["frames"] = st.text_input(
            "Evaluated frames",
            placeholder="0:299",
            key=f"frames_{place}",
            help=f"{capitalised(FRAME_RANGE)}, by the frame numbers of the truth.",
        )
    return MissingInputs(**values)


def _by_the_edges(usual: UsualInputs, sizes: Mapping[str, tuple[int, int]]) -> UsualInputs:
    """The size at which most recordings' boxes end, in place of the usual one."""
    most = Counter(sizes.values()).most_common(1)[0][0]
    others = {name: size for name, size in sizes.items() if size != most}
    note = "The size at whose right edge the boxes end."
    if others:
        of_others = ", ".join(f"{name} {w} × {h}" for name, (w, h) in others.items())
        note += f" By the same rule other sizes are used for these recordings: {of_others}."
    return replace(usual, size=most, note=note)


def _draw_size(
    place: str, of_pictures: tuple[int, int] | None, usual: UsualInputs | None
) -> tuple[int, int] | None:
    of_format = None if usual is None else usual.size
    if of_format is not None and _is_typed(f"width_{place}", of_format[0]):
        of_pictures = None
    proposed = of_pictures or of_format
    if _is_typed(f"width_{place}", None):
        proposed = None
    width, height = proposed or (None, None)
    left, right = st.columns(2)
    wide = left.number_input(
        "Width of the pictures (px)",
        1,
        MAX_SIZE_PX,
        value=width,
        step=1,
        key=f"width_{place}_{width}",
        placeholder="such as 640",
    )
    high = right.number_input(
        "Height of the pictures (px)",
        1,
        MAX_SIZE_PX,
        value=height,
        step=1,
        key=f"height_{place}_{height}",
        placeholder="such as 480",
    )
    if proposed is not None and of_pictures is not None:
        st.caption("The size of the pictures given; boxes have to be in the same pixels.")
    elif proposed is not None and usual is not None:
        others = f"; some of its recordings have {usual.others}" if usual.others else ""
        usually = f"The usual size in {usual.name}{others}."
        st.caption(plain(usual.note or usually))
    return None if wide is None or high is None else (int(wide), int(high))


def _is_typed(name: str, proposed: float | None) -> bool:
    """Whether a person changed the proposal. Typed values outlast later proposals."""
    return store.widget(f"{name}_{proposed}").get() not in (None, proposed)


def _draw_rate(place: str, of_pictures: float | None, usual: UsualInputs | None) -> float | None:
    of_format = None if usual is None else usual.fps
    if of_format is not None and _is_typed(f"fps_{place}", of_format):
        of_pictures = None
    proposed = of_pictures or of_format
    if _is_typed(f"fps_{place}", None):
        proposed = None
    rate = st.number_input(
        "Frames per second of the camera",
        MIN_FPS,
        MAX_FPS,
        value=proposed,
        step=1.0,
        key=f"fps_{place}_{proposed}",
        placeholder="such as 20",
        format="%.6g",
        help="How many frame numbers of the files make a second, even if only every tenth of them "
        "is annotated. A video is proposed with the rate at which it plays, "
        "which may differ from that of the camera.",
    )
    if proposed is not None and of_pictures is None and usual is not None:
        st.caption(f"The usual rate in {usual.name}.")
    elif proposed is None:
        st.caption("The camera's frame rate, also where only every n-th frame is annotated.")
    else:
        st.caption(
            "The rate at which the video plays; change it if the camera took the frames at "
            "another one. Times, lead times and rates per minute depend on it."
        )
    return None if rate is None else float(rate)


def draw_reading(role: Role, key: str, changed: Callable[[], None]) -> dict[str, Any]:
    """Fields of `nvcore.inputs.session.Source` that are rarely needed."""
    titles = {form.title: form.name for form in FORMATS if role in form.roles}
    title = st.selectbox("Format", [AUTOMATIC, *titles], key=f"format_{key}", on_change=changed)
    frame_base = st.selectbox(
        "Frame numbers", list(FRAME_BASES), key=f"frame_base_{key}", on_change=changed
    )
    box_base = st.selectbox(
        "Coordinates", list(BOX_BASES), key=f"box_base_{key}", on_change=changed
    )
    boxes = st.selectbox(
        "Numbers of a box",
        ["", *LAYOUTS],
        format_func=lambda name: f"{name}: {LAYOUTS[name]}" if name else AS_FORMAT,
        key=f"boxes_{key}",
        on_change=changed,
    )
    frame_names = st.selectbox(
        "Names of pictures", list(FRAME_NAMES), key=f"frame_names_{key}", on_change=changed
    )
    classes = st.text_input(
        "Classes that count",
        key=f"classes_{key}",
        on_change=changed,
        placeholder="as usual for the format",
        help="Names or numbers, with commas between them.",
    )
    class_names = tuple(name.strip() for name in classes.split(",") if name.strip())
    return {
        "format": titles.get(title),
        "frame_base": FRAME_BASES[frame_base],
        "box_base": BOX_BASES[box_base],
        "boxes": boxes or None,
        "frame_names": FRAME_NAMES[frame_names],
        "classes": class_names or None,
    }


def picture_size(paths: Iterable[Path]) -> tuple[int, int] | None:
    """Size of the first pictures that can be opened."""
    return next((check.size for check in map(check_pictures, paths) if check.size), None)


def picture_rate(paths: Iterable[Path]) -> float | None:
    """Frame rate of the first pictures that state one, within what can be given."""
    rates = (check.fps for check in map(check_pictures, paths))
    return next((rate for rate in rates if rate is not None and MIN_FPS <= rate <= MAX_FPS), None)


@dataclass(frozen=True)
class PictureCheck:
    """Size (px) and stated frame rate (1/s) of pictures, or why they cannot be opened."""

    size: tuple[int, int] | None = None
    fps: float | None = None
    trouble: str = ""


def check_pictures(path: Path) -> PictureCheck:
    """Open pictures to see what they are, unless that was done before and the file is the same.

    A folder with trouble is opened again: it does not change when a picture in it is replaced.
    """
    try:
        status = path.stat()
    except OSError as error:
        return PictureCheck(trouble=f"cannot be opened ({error.strerror})")
    checks = store.PICTURE_CHECKS.setdefault({})
    key = (path, status.st_mtime_ns, status.st_size)
    check = checks.pop(key, None) or _check_pictures(path)
    if not (check.trouble and path.is_dir()):
        checks[key] = check  # moved to the end: the least recently used goes first
        while len(checks) > MOST_CHECKS:
            del checks[next(iter(checks))]
    return check


def _check_pictures(path: Path) -> PictureCheck:
    try:
        pictures = state.workspace().picture_process.open(path)
    except MediaError as error:
        return PictureCheck(trouble=error.message)
    check = PictureCheck((int(pictures.width), int(pictures.height)), pictures.fps)
    pictures.close()
    return check

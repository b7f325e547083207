"""Data page: questions about inputs, asked only where the files do not answer them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.common.errors import MediaError
from nvcore.common.wording import capitalised
from nvcore.inputs.box_layouts import KINDS, UNITS, BoxLayout
from nvcore.inputs.facts import FRAME_NAMES, FRAME_RANGE
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import Session
from nvcore.inputs.session.proposals import USUAL_INPUTS, UsualInputs
from nvcore.settings.defaults import MAX_FPS, MIN_FPS
from ui.session import state, store
from ui.session.opening import checked_frames
from ui.views.data.file_check import check_cache
from ui.views.data.opening import MISSING_WORDS
from ui.widgets.text import plain

MOST_CHECKS: Final = 256
"""Largest number of cached checks of pictures. A long video takes time to open."""
MAX_SIZE_PX: Final = 100_000
AS_USUAL: Final = "as usual for the format"
READING: Final[Mapping[str, tuple[str, Mapping[str, Any]]]] = {
    "frame_base": (
        "Frame numbers",
        {AS_USUAL: None, "the first frame is 0": 0, "the first frame is 1": 1},
    ),
    "box_base": (
        "Coordinates",
        {AS_USUAL: None, "the first pixel is 0": 0, "the first pixel is 1": 1},
    ),
    "boxes": (
        "Numbers of a box",
        {"as the format has them": None}
        | {
            f"{layout}: {layout.text}": str(layout)
            for layout in (
                *(
                    BoxLayout(kind, yx, unit)
                    for unit in UNITS
                    for kind in KINDS
                    for yx in (False, True)
                ),
                BoxLayout("centres", unit="shares", is_score_first=True),
            )
        },
    ),
    "frame_names": (
        "Names of pictures",
        {"by what they look like": None, **{way: way for way in FRAME_NAMES}},
    ),
}
"""Labels and options of the choices for reading files, by field of a `Source`."""


@dataclass(frozen=True)
class MissingInputs:
    """Facts that a visitor entered for all recordings. None: the files state them."""

    size: tuple[int, int] | None = None
    fps: float | None = None
    frames: str | None = None
    sizes: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    """Sizes of the recordings that differ, by their boxes."""

    @property
    def of_recording(self) -> dict[str, Any]:
        """Entered facts as fields of a recording's entry.

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
        """Add these inputs to a session. None keeps its own.

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
    """Draw fields for facts that the files lack (`unknown`, or missing when last opened).

    Proposals are size and frame rate of the pictures, or else the `sizes` by recording to which
    boxes point, or else the usual values of the ground truth's format.
    """
    trouble = store.TROUBLES.of(place).get()
    lacking = store.ASKED_FACTS.of(place)
    lacking.set(lacking.get().union(() if trouble is None else trouble.facts))
    asked = lacking.get() | set(unknown)
    usual = USUAL_INPUTS.get(format_name)
    values: dict[str, Any] = {}
    if sizes and usual is not None:
        most = Counter(sizes.values()).most_common(1)[0][0]
        others = {name: size for name, size in sizes.items() if size != most}
        note = "; other recordings: " * bool(others)
        note += ", ".join(f"{name} {w} × {h}" for name, (w, h) in others.items())
        usual = replace(usual, size=most, note=f"The boxes end at this width{note}.")
        values["sizes"] = others
    if asked:
        words = " and ".join(MISSING_WORDS[fact] for fact in MISSING_WORDS if fact in asked)
        st.markdown(f"**Not in the files: {words}**")
    checks = [check_pictures(path) for path in pictures]
    if "size" in asked:
        size = next((check.size for check in checks if check.size), None)
        values["size"] = _draw_size(place, size, usual)
    if "fps" in asked:
        rates = [check.fps for check in checks if check.fps and MIN_FPS <= check.fps <= MAX_FPS]
        values["fps"] = _draw_rate(place, rates[0] if rates else None, usual)
    if "frames" in asked:
        values["frames"] = st.text_input(
            "Evaluated frames",
            placeholder="0:299",
            key=f"frames_{place}",
            help=f"{capitalised(FRAME_RANGE)}, by the frame numbers of the truth.",
        )
    return MissingInputs(**values)


def _draw_size(
    place: str, of_pictures: tuple[int, int] | None, usual: UsualInputs | None
) -> tuple[int, int] | None:
    of_format = None if usual is None else usual.size
    if of_format is not None and _is_typed(f"width_{place}", of_format[0]):
        of_pictures = None
    proposed = None if _is_typed(f"width_{place}", None) else of_pictures or of_format
    sides = [
        column.number_input(
            f"{side.capitalize()} of the pictures (px)",
            1,
            MAX_SIZE_PX,
            value=value,
            step=1,
            key=f"{side}_{place}_{value}",
            placeholder=f"such as {example}",
        )
        for column, side, value, example in zip(
            st.columns(2), ("width", "height"), proposed or (None, None), (640, 480), strict=True
        )
    ]
    if proposed is not None and of_pictures is not None:
        st.caption("The size of the pictures given; boxes have to be in the same pixels.")
    elif proposed is not None and usual is not None:
        others = f"; some of its recordings have {usual.others}" if usual.others else ""
        usually = f"The usual size in {usual.name}{others}."
        st.caption(plain(usual.note or usually))
    wide, high = sides
    return None if wide is None or high is None else (int(wide), int(high))


def _is_typed(name: str, proposed: float | None) -> bool:
    """Whether the visitor changed the proposal. Typed values outlast later proposals."""
    return store.widget(f"{name}_{proposed}").get() not in (None, proposed)


def _draw_rate(place: str, of_pictures: float | None, usual: UsualInputs | None) -> float | None:
    of_format = None if usual is None else usual.fps
    if of_format is not None and _is_typed(f"fps_{place}", of_format):
        of_pictures = None
    proposed = None if _is_typed(f"fps_{place}", None) else of_pictures or of_format
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
    """Draw the fields of `nvcore.inputs.session.Source` that are rarely needed."""
    formats = {form.title: form.name for form in FORMATS if role in form.roles}
    choices = {"format": ("Format", {"by the content": None} | formats), **READING}
    reading: dict[str, Any] = {
        name: options[st.selectbox(label, list(options), key=f"{name}_{key}", on_change=changed)]
        for name, (label, options) in choices.items()
    }
    classes = st.text_input(
        "Classes that count",
        key=f"classes_{key}",
        on_change=changed,
        placeholder="as usual for the format",
        help="Names or numbers, with commas between them.",
    )
    class_names = tuple(name.strip() for name in classes.split(",") if name.strip())
    return reading | {"classes": class_names or None}


@dataclass(frozen=True)
class PictureCheck:
    """Size (px) and stated frame rate (1/s) of pictures, or why they cannot be opened."""

    size: tuple[int, int] | None = None
    fps: float | None = None
    trouble: str = ""


def check_pictures(path: Path) -> PictureCheck:
    """Open pictures to check them, cached by the file's size and time of change.

    A folder with trouble is opened again, since replacing a picture does not change its time.
    """
    try:
        status = path.stat()
    except OSError as error:
        return PictureCheck(trouble=f"cannot be opened ({error.strerror})")
    key = (path, status.st_mtime_ns, status.st_size)
    check = check_cache().cached("pictures", key, lambda: _check_pictures(path), most=MOST_CHECKS)
    return _check_pictures(path) if check.trouble and path.is_dir() else check


def _check_pictures(path: Path) -> PictureCheck:
    try:
        pictures = state.workspace().picture_process.open(path)
    except MediaError as error:
        return PictureCheck(trouble=error.message)
    check = PictureCheck((int(pictures.width), int(pictures.height)), pictures.fps)
    pictures.close()
    return check

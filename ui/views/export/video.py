"""Export page: an interval of a recording as an annotated video."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import streamlit as st

from nvcore.common.progress import Progress
from nvcore.comparison.compare import Result
from nvcore.figures.overlay import FPS_RANGE, write_video
from ui.jobs.page_run import PageRun
from ui.session import state
from ui.views.export.frame import file_stem
from ui.widgets import drawing
from ui.widgets.text import plain

LONGEST_S: Final = 120.0
"""Maximum length of the video. The interval of the recording may be longer."""
USUAL_S: Final = 10.0
"""Length of the proposed interval."""
SPEEDS: Final = {1.0: "real time", 0.5: "half", 0.25: "quarter", 2.0: "double"}
RUN: Final = PageRun[None](
    # boxes and pictures do not depend on estimates
    "video",
    "video",
    "Making {title}",
    folder="video",
    outlasts=True,
    has_time_left=True,
)


class Interval(NamedTuple):
    """Rows within the recording to write, and frames per second of the video."""

    row_start: int
    row_stop: int
    fps: float

    @property
    def n_frames(self) -> int:
        """Number of frames of the video."""
        return self.row_stop - self.row_start

    @property
    def length_s(self) -> float:
        """Duration of the video."""
        return self.n_frames / self.fps


def draw(result: Result) -> None:
    """Draw the choice of an interval, the button that makes the video, and the video."""
    st.header("Interval as video")
    _draw_form(result)
    RUN.draw_file()


@st.fragment
def _draw_form(result: Result) -> None:
    recording, frames = state.recording(), result.dataset.frame_columns
    times = result.dataset.frames["time_s"].to_numpy()[frames.rows_of(recording)]
    end = float(times[-1])
    now_s = float(times[state.row()])
    start = max(min(now_s - USUAL_S / 2, end - USUAL_S), 0.0)
    columns = st.columns([1, 1, 1, 1], vertical_alignment="bottom")
    # one key per place, as the proposal follows the current frame
    key = f"{recording}_{state.row()}"
    first = columns[0].number_input(
        "From (s)", 0.0, end, round(start, 2), 1.0, key=f"video_from_{key}", format="%.2f"
    )
    last = columns[1].number_input(
        "To (s)", 0.0, end, min(start + USUAL_S, end), 1.0, key=f"video_to_{key}", format="%.2f"
    )
    speed = columns[2].selectbox(
        "Speed", list(SPEEDS), format_func=SPEEDS.__getitem__, key="video_speed"
    )
    labels = columns[3].toggle("Track ids and scores", key="video_labels")
    interval = chosen_interval(times, first, last, speed, float(frames.fps[recording]))
    trouble = why_not(interval)
    st.caption(
        f"{plain(state.recording_names()[recording])}: {interval.n_frames:,} frames at "
        f"{interval.fps:.3g} per second, {interval.length_s:.2f} s of video (MP4, at most "
        f"{LONGEST_S:.0f} s each). The parameters are in its caption and inside the file."
    )
    if trouble:
        st.warning(trouble, icon=":material/info:")
    if RUN.start_button("Make the video", "movie", "make_video", is_possible=not trouble):
        _start(result, recording, interval, labels=labels)
        st.rerun()


def chosen_interval(
    times: np.ndarray, first_s: float, last_s: float, speed: float, fps: float
) -> Interval:
    """Return the rows from one time to another, both included, and their frame rate.

    At a speed of 1, evaluated frames follow each other as fast as they were recorded. The
    recording's frame rate is used if there is a single frame.
    """
    step = float(np.median(np.diff(times))) if len(times) > 1 else 1 / fps
    near = step / 100  # fields round to hundredths
    start = int(np.searchsorted(times, first_s - max(near, 0.005)))
    stop = int(np.searchsorted(times, last_s + max(near, 0.005), side="right"))
    return Interval(start, max(stop, start), float(np.clip(speed / step, *FPS_RANGE)))


def why_not(interval: Interval) -> str:
    """Return why there can be no such video and what to change, or ""."""
    if interval.n_frames < 1:
        return "There is no evaluated frame between these times: choose a later end."
    if interval.length_s > LONGEST_S:
        return (
            f"That would be {interval.length_s:.0f} s of video; at most {LONGEST_S:.0f} s are "
            "made at a time. Choose a shorter interval or a faster speed."
        )
    return ""


def _start(result: Result, recording: int, interval: Interval, *, labels: bool) -> None:
    pictures, (lo, hi) = state.workspace().pictures, drawing.stretch()
    numbers = state.frame_numbers(recording)[interval.row_start : interval.row_stop]
    name = f"{file_stem(state.recording_names()[recording])}-{numbers[0]}-{numbers[-1]}.mp4"
    first, folder = int(result.dataset.frame_columns.first[recording]), RUN.new_folder()

    def write(progress: Progress) -> None:
        write_video(
            result,
            pictures.sources,
            recording,
            first + interval.row_start,
            first + interval.row_stop,
            folder / name,
            fps=interval.fps,
            progress=progress,
            indices=pictures.indices.get(recording),
            lo=lo,
            hi=hi,
            labels=labels,
        )

    RUN.start(write, title=name, folder=folder)

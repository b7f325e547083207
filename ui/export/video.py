"""Export page: an interval of a recording as an annotated video."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import streamlit as st

from nvcore.comparison import Result
from nvcore.overlay import FPS_RANGE, write_video
from nvcore.progress import Progress
from ui.export.frame import file_stem
from ui.jobs.background import FileJob, JobState, new_path, while_open
from ui.jobs.progress import draw_file, draw_job
from ui.session import state
from ui.session.workspace import Workspace
from ui.widgets import drawing
from ui.widgets.buttons import button
from ui.widgets.text import plain

LONGEST_S: Final = 120.0
"""Of the video, not of the recording."""
USUAL_S: Final = 10.0
"""Length that is proposed."""
SPEEDS: Final = {1.0: "real time", 0.5: "half", 0.25: "quarter", 2.0: "double"}
JOB: Final = "video"


@dataclass(frozen=True)
class Interval:
    """Rows within the recording that are to be written, and frames per second of the video."""

    row_start: int
    row_stop: int
    fps: float

    @property
    def n_frames(self) -> int:
        """How many frames the video has."""
        return self.row_stop - self.row_start

    @property
    def length_s(self) -> float:
        """How long the video plays."""
        return self.n_frames / self.fps


def draw(result: Result) -> None:
    """The form, or how far the video is."""
    st.header("Interval as video")
    job: FileJob | None = state.workspace().job(JOB)
    _draw_form(result, is_busy=job is not None and job.is_busy)
    if job is None:
        return
    if draw_job(job, JOB, thing="video", doing=f"Making {job.name}") is JobState.DONE:
        st.caption(f"{draw_file(job, JOB)} It stays here until the next one.")


@st.fragment
def _draw_form(result: Result, *, is_busy: bool) -> None:
    recording, frames = state.recording(), result.dataset.frame_columns
    times = result.dataset.frames["time_s"].to_numpy()[frames.rows_of(recording)]
    end = float(times[-1])
    now_s = float(times[state.row()])
    start = max(min(now_s - USUAL_S / 2, end - USUAL_S), 0.0)
    columns = st.columns([1, 1, 1, 1], vertical_alignment="bottom")
    # a key for each place: the proposal follows the current frame
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
    if button(
        "Make the video",
        icon=":material/movie:",
        key="make_video",
        disabled=bool(trouble) or is_busy,
    ) and not (trouble or is_busy):  # a browser can be made to click what is disabled
        _start(result, recording, interval, labels=labels)
        st.rerun()


def chosen_interval(
    times: np.ndarray, first_s: float, last_s: float, speed: float, fps: float
) -> Interval:
    """Rows from one time to another, both included, and how fast they are shown.

    At a speed of 1 evaluated frames follow each other as fast as they were taken; the recording's
    frame rate counts where there is a single frame.
    """
    step = float(np.median(np.diff(times))) if len(times) > 1 else 1 / fps
    near = step / 100  # fields round to hundredths
    start = int(np.searchsorted(times, first_s - max(near, 0.005)))
    stop = int(np.searchsorted(times, last_s + max(near, 0.005), side="right"))
    return Interval(start, max(stop, start), float(np.clip(speed / step, *FPS_RANGE)))


def why_not(interval: Interval) -> str:
    """Why there can be no such video, and what to change; empty: there can."""
    if interval.n_frames < 1:
        return "There is no evaluated frame between these times: choose a later end."
    if interval.length_s > LONGEST_S:
        return (
            f"That would be {interval.length_s:.0f} s of video; at most {LONGEST_S:.0f} s are "
            "made at a time. Choose a shorter interval or a faster speed."
        )
    return ""


def _start(result: Result, recording: int, interval: Interval, *, labels: bool) -> None:
    space = state.workspace()
    space.drop_job(JOB)
    numbers = state.frame_numbers(recording)[interval.row_start : interval.row_stop]
    name = f"{file_stem(state.recording_names()[recording])}-{numbers[0]}-{numbers[-1]}.mp4"
    job = start_job(
        space,
        result,
        recording,
        interval,
        new_path(space, ".mp4"),
        name,
        stretch=drawing.stretch(),
        labels=labels,
    )
    space.put_job(JOB, job)


def start_job(
    space: Workspace,
    result: Result,
    recording: int,
    interval: Interval,
    path: Path,
    name: str,
    *,
    stretch: tuple[float, float],
    labels: bool,
) -> FileJob:
    """Start writing; it ends with the session, and when the session opens something else."""
    pictures, indices = space.pictures.sources, space.pictures.indices.get(recording)
    start = int(result.dataset.frame_columns.first[recording])

    def write(progress: Progress) -> None:
        write_video(
            result,
            pictures,
            recording,
            start + interval.row_start,
            start + interval.row_stop,
            path,
            fps=interval.fps,
            progress=progress,
            indices=indices,
            lo=stretch[0],
            hi=stretch[1],
            labels=labels,
        )

    job = FileJob(path, name, write, while_open(space))
    job.outlasts = True  # boxes and pictures do not depend on what is estimated
    return job

"""Files of the sample data: tables as CSV, pictures as H.264, the session as TOML, a README."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

import av
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.settings.params.traffic import context_word
from tools.sample.camera import FPS, HEIGHT, N_FRAMES, WIDTH
from tools.sample.scene import Recording
from tools.sample.study.scenes import N_PICTURES
from tools.sample.study.trials import N_SUBJECTS
from tools.sample.systems import RANGING, THRESHOLD
from tools.sample.visible.recordings import GLOWS, session_keys
from tools.sample.visible.view import VISIBLE_SIZE, visible_map

VERSIONS: Final = {"NIR 2": 'version_of = "NIR"\n'}
SYSTEM_FILES: Final = {"FIR": "fir.csv", "NIR": "nir.csv", "NIR 2": "nir2.csv"}
TRUTH_FILE: Final = "truth.csv"
_QUALITY: Final = "26"
_COLOUR_QUALITY: Final = "32"
_KEY_EVERY: Final = 40
_RANGES_M: Final = (20, 60)

_FORMATS: Final = {
    "x": "{:.2f}",
    "y": "{:.2f}",
    "w": "{:.2f}",
    "h": "{:.2f}",
    "distance_m": "{:.2f}",
    "score": "{:.3f}",
}


def csv_text(table: pd.DataFrame) -> str:
    """Return a table as CSV with fixed decimals and line feeds, equal on every system."""
    text = table.copy()
    for name, pattern in _FORMATS.items():
        if name in text:
            text[name] = text[name].map(pattern.format)
    return str(text.to_csv(index=False, lineterminator="\n"))


def session_text(recordings: Iterable[Recording]) -> str:
    """Return the session file that names all recordings, the truth and the systems."""
    tables = [
        f'[[recording]]\nname = "{recording.name}"\nwidth = {WIDTH}\nheight = {HEIGHT}\n'
        f'fps = {FPS}\nframes = "0:{N_FRAMES - 1}"\nhorizon = {recording.horizon:.1f}\n'
        f"context = {_context_text(recording.context)}\n"
        f"tags = [{', '.join(map(_quoted, tags_of(recording)))}]\n"
        f'pictures = "{recording.name}.mp4"\n{session_keys(recording)}'
        for recording in recordings
    ]
    source = 'path = "{}"\nformat = "csv"\nframe_base = 0\n'
    tables.append("[truth]\n" + source.format(TRUTH_FILE))
    tables += [
        f'[[system]]\nname = "{name}"\n{VERSIONS.get(name, "")}{source.format(path)}'
        f"threshold = {THRESHOLD}\n"
        for name, path in SYSTEM_FILES.items()
    ]
    return "\n".join(tables)


def tags_of(recording: Recording) -> tuple[str, ...]:
    """Return place, season, and ``night``. The visible-light drives are at dusk."""
    return recording.tags if recording.name in GLOWS else (*recording.tags, "night")


def _quoted(text: str) -> str:
    return f'"{text}"'


def _context_text(context: float) -> str:
    word = context_word(context)
    return f'"{word}"' if isinstance(word, str) else f"{word:g}"


def write_video(path: Path, pictures: Iterable[NDArray[np.uint8]]) -> None:
    """Write grey pictures as an H.264 video. Equal machine and encoder give equal bytes.

    Parameters
    ----------
    pictures
        Pictures of shape (HEIGHT, WIDTH) each.
    """
    colourless = np.full((HEIGHT // 2, WIDTH), 128, dtype=np.uint8)
    planes = (np.concatenate([_studio(picture), colourless]) for picture in pictures)
    frames = (av.VideoFrame.from_ndarray(plane, format="yuv420p") for plane in planes)
    _encode(path, frames, (WIDTH, HEIGHT), _QUALITY)


def write_colour_video(
    path: Path,
    pictures: Iterable[NDArray[np.uint8]],
    size: tuple[int, int],
    *,
    quality: str = _COLOUR_QUALITY,
) -> None:
    """Write colour pictures as an H.264 video.

    Parameters
    ----------
    pictures
        RGB pictures of shape (height, width, 3) each.
    size
        Width and height, both even.
    quality
        Encoder's crf. Larger values give smaller files.
    """
    frames = (
        av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(format="yuv420p")
        for picture in pictures
    )
    _encode(path, frames, size, quality)


def _encode(
    path: Path, frames: Iterable[av.VideoFrame], size: tuple[int, int], quality: str
) -> None:
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=FPS)
        (stream.width, stream.height), stream.pix_fmt = size, "yuv420p"
        stream.codec_context.thread_count = 1
        stream.codec_context.gop_size = _KEY_EVERY
        stream.options = {"crf": quality, "preset": "medium", "threads": "1", "tune": "film"}
        for frame in frames:
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def _studio(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Convert full-range grey to the luma of 16 to 235 that players expect."""
    return np.round(16 + picture * (219 / 255)).astype(np.uint8)


def readme_text(recordings: Iterable[Recording], truth: pd.DataFrame) -> str:
    """Return the README of the folder, with a table of recordings."""
    lines = []
    for recording in recordings:
        rows = truth[truth["recording"] == recording.name]
        tracks = rows[rows["ignore"] == 0]["track"].nunique()
        ignored = rows[rows["ignore"] == 1]["track"].nunique()
        people = f"{tracks}" + (f" + {ignored} ignored" if ignored else "")
        lines.append(f"| `{recording.name}` | {recording.text} | {people} | {len(rows)} |")
    return _README.format(
        table="\n".join(lines),
        seconds=N_FRAMES // FPS,
        fps=FPS,
        ranging=_ranging_text(),
        visible=", ".join(f"`{name}`" for name in GLOWS),
        visible_size="{} x {}".format(*VISIBLE_SIZE),
        visible_map=", ".join(f"{value:g}" for value in visible_map()),
        n_pictures=N_PICTURES,
        n_subjects=N_SUBJECTS,
    )


def _ranging_text() -> str:
    """Describe the standard deviations of the systems' distances."""
    near_m, far_m = _RANGES_M
    words = [
        f"{name} {100 * (at_zero + near_m * per_metre):.1f} and "
        f"{100 * (at_zero + far_m * per_metre):.1f} %"
        for name, (at_zero, per_metre) in RANGING.items()
    ]
    return f"{near_m} and {far_m} m: {', '.join(words)}"


_README: Final = """# Sample data

A night drive that never happened. Everything here is generated: `python -m tools.sample` in a
checkout writes this folder again, the tables byte for byte; another processor or version of the
video library may change grey values of the videos a little. `nvcore sample` copies the folder. It
is there to try the program and to test it; it says nothing about any real system.

A pinhole camera (640 x 480, focal length 1100 px, 1.25 m above the road) drives past walking people
in three dimensions. Boxes, distances, occlusion and pictures come from that one geometry. Pictures
look like far infrared: bright is warm.

| recording | what happens | people | boxes |
|---|---|---|---|
{table}

Each recording lasts {seconds} s at {fps} frames per second.

- `truth.csv`: one row per person and frame, from entry to exit, at least 8 px high and at least
  half inside the picture; who is hidden for a while in between stays annotated. `x, y, w, h` in
  pixels, clipped to the picture; `track` unique within a recording; `ignore` 1 for the cyclist;
  `distance_m` over ground; `occlusion` 0 none, 1 part (from 10 % of the box), 2 much (from 45 %).
- `fir.csv`: a simulated far-infrared system. It sees far, but cold clothes, crouching people and a
  warm night shorten its reach, and hot engines and cabinets give false alarms.
- `nir.csv`: a simulated near-infrared system. It sees as far as its lamp, less with dark clothes,
  little beside dazzling headlamps, and takes some reflecting signs for people.
- `nir2.csv`: the next version of the near-infrared system. Its lamp reaches farther in a narrower
  beam and it is less blind beside headlamps: it mends some misses and has new ones.
- All report `distance_m`, false alarms too. Its error is a share of the distance, larger far away,
  and wanders within a second or so. Its standard deviation
  at {ranging}.
- `session.toml`: all of it as one comparison, of FIR and NIR unless others are chosen; a detection
  counts from a score of 0.5 up. Traffic
  context: rural for the three `rural_` recordings, 0.5 for `oncoming_glare`, urban for the others.
  Tags: `urban`, `village` or `rural`; `summer`, `autumn` or `winter`;
  `night`, but for the drives at dusk (those by visible light).
- `<recording>.mp4`: the pictures, H.264.
- `<recording>_visible.mp4` ({visible}): the same
  drive as a visible-light colour camera would show it at dusk, {visible_size}. Both cameras look
  through one point: `visible_map = [{visible_map}]` takes thermal to visible pixels.
- `<recording>_light.csv`: `time_s,lux` of a simulated light sensor behind the windscreen.
  `urban_sidewalk` and `rural_child` begin under floodlights, as of a building site at night, and
  leave them after some 5 s: about 1,000 lx fall to 10 or less. In `oncoming_glare` headlamps
  come and go.
- `ratings_simulated.csv`: made-up ratings, 1 (not annoying) to 7, of every recording with the boxes
  of each system. Nobody was asked: 16 participants are simulated, one of whom takes the scale the
  wrong way round, and some ratings are missing.

A second, small sample, of [speed signs](../docs/objects.md#speed-alerts):

- `speed_signs/`: three drives of {seconds} s at twilight past speed signs, a session of its own
  (`speed_signs/session.toml`) with truth, two systems that read the signs (`mono.csv`,
  `stereo.csv`), the speed of the car over time (`<recording>_speed.csv`) and pictures. Mono misses
  a sign and reads a plate on a van, Stereo takes a 30 for 80 and misses the end of a limit.

A study that never happened, either, of who sees a pedestrian how long after the light changed. No
study of this kind is public.

- `study/`: {n_pictures} pictures at twilight, rendered, 960 x 540, one pedestrian each.
  `boxes.csv`: where they are, in pixels, and the point of fixation, the middle of the picture.
- `trials_simulated.csv`: {n_subjects} simulated subjects (`device` is `simulated`), each with every
  picture at six times after a change from 1,000 to 10 lx, two pictures a run. Touches are in
  pixels; 200 px stand for 5 degrees. One subject often does not look.
- `trials_simulated_truth.csv`: what the simulated observer says, by picture and time:
  `visibility` (how many times the threshold of contrast), `picking` (chance to pick them out in one
  glance), `probability` (chance that a subject sees them, mean of all). An estimate can be
  compared with it; a real study has no such column. The observer is a contrast-sensitivity filter
  over the picture with and without the pedestrian, whose adaptation recovers with time. Its parts
  are published, some constants are ours; no person was asked, and it says nothing about people
  (`tools/sample/study/observer.py`).

Frames count from 0. Losses and false alarms last for some frames: the systems are range models
with a slowly wandering disturbance, not coin flips.
"""

"""An interval of a recording as an annotated video (MP4 with VP9)."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Final

import av
import numpy as np
from numpy.typing import NDArray

from nvcore import __version__
from nvcore.comparison import Result
from nvcore.errors import MediaError, ParameterError
from nvcore.overlay.annotate import annotate, provenance
from nvcore.overlay.brush import BLANK_RGB, Canvas
from nvcore.pictures.base import Pictures
from nvcore.pictures.index import picture_index
from nvcore.progress import Progress, no_progress
from nvcore.wording import one_line

_CODEC: Final = "libvpx-vp9"
"""Not libx264, whose licence is the GPL (docs/decisions/038)."""
_OPTIONS: Final = {
    "crf": "33",
    "b": "0",  # quality alone decides
    "deadline": "realtime",
    "cpu-used": "8",
    "row-mt": "1",
    "threads": "2",
}
_KEY_EVERY: Final = 40
FPS_RANGE: Final = (0.1, 240.0)
"""Frames per second that a video may have."""


def write_video(
    result: Result,
    pictures: Mapping[int, Pictures],
    recording: int,
    row_start: int,
    row_stop: int,
    path: Path,
    *,
    fps: float,
    progress: Progress = no_progress,
    first_picture: int | None = None,
    indices: NDArray[np.int64] | None = None,
    lo: float = 0.0,
    hi: float = 100.0,
    labels: bool = False,
) -> None:
    """Write frames ``row_start:row_stop`` with boxes and captions.

    Version, fingerprint and settings are in the container's metadata (title, comment).

    Parameters
    ----------
    pictures
        By recording; without those of this one, boxes are drawn on a dark blank.
    recording
        Row of the recordings table.
    row_start, row_stop
        Rows of the frames table, all of this recording.
    path
        A new or old file; it is removed if the writing does not come to its end.
    fps
        Frames per second of the video, 0.1..240.
    progress
        Called after every frame.
    indices
        Picture of every frame of the recording, -1 none, as `nvcore.pictures.picture_index` gives
        it; None: by that function, with `first_picture`.
    first_picture, lo, hi, labels
        See `nvcore.overlay.annotate`.

    Raises
    ------
    ParameterError
        If `fps` is out of range, there are no frames, or `indices` has not one for each frame.
    MediaError
        If the file cannot be written.
    """
    if not FPS_RANGE[0] <= fps <= FPS_RANGE[1]:
        raise ParameterError(f"fps: expected {FPS_RANGE[0]:g} to {FPS_RANGE[1]:g}, got {fps:g}")
    frames = result.dataset.frame_columns
    rows = frames.rows_of(recording)
    first, last = rows.start, rows.stop
    if not first <= row_start < row_stop <= last:
        raise ParameterError(
            f"expected frames of the recording, rows {first} to {last}, got {row_start} to "
            f"{row_stop}"
        )
    source = pictures.get(recording)
    if indices is not None and len(indices) != last - first:
        raise ParameterError(f"indices: expected {last - first} pictures, got {len(indices)}")
    if indices is None and source is not None:
        listed = frames.frame[first:last]
        name = str(result.dataset.recordings["name"].iloc[recording])
        others = result.dataset.unlisted_frames(name)
        rate = float(frames.fps[recording])
        indices = picture_index(listed, source, first_picture, others=others, fps=rate)[0]
    index = [-1] * (last - first) if indices is None else indices.tolist()

    def draw(row: int) -> Canvas:
        return annotate(result, source, index[row - first], row, lo=lo, hi=hi, labels=labels)

    is_done = False
    try:
        with av.open(
            f"file:{path.absolute()}", "w", format="mp4", options={"movflags": "+faststart"}
        ) as container:
            name = str(result.dataset.recordings["name"].iloc[recording])
            container.metadata["title"] = one_line(
                f"{name}, frames {frames.frame[row_start]} to {frames.frame[row_stop - 1]}: "
                f"{result.x.name} and {result.y.name}, nvcore {__version__}"
            )
            container.metadata["comment"] = provenance(result)
            stream = container.add_stream(_CODEC, rate=Fraction(fps).limit_denominator(1001))
            stream.pix_fmt = "yuv420p"
            stream.codec_context.gop_size = _KEY_EVERY
            stream.options = dict(_OPTIONS)
            # long numbers may need one line more in the caption
            height, width = np.maximum(draw(row_start).shape, draw(row_stop - 1).shape)[:2].tolist()
            stream.width, stream.height = width, height
            for row in range(row_start, row_stop):  # a video is made frame by frame
                drawing = draw(row)[:height]
                if len(drawing) < height:
                    margin = np.full((height - len(drawing), width, 3), BLANK_RGB, np.uint8)
                    drawing = np.concatenate([drawing, margin])
                container.mux(stream.encode(av.VideoFrame.from_ndarray(drawing, format="rgb24")))
                progress((row + 1 - row_start) / (row_stop - row_start), "frames")
            container.mux(stream.encode(None))
        is_done = True
    except (av.error.FFmpegError, OSError) as error:
        raise MediaError(
            "the video cannot be written; is there room, and may the folder be written to?",
            file=path.name,
        ) from error
    finally:
        if not is_done and path.is_file():
            path.unlink()

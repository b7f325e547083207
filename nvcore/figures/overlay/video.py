"""Write an interval of a recording as an annotated video (MP4 with VP9)."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Final

import av
import numpy as np
from numpy.typing import NDArray

from nvcore import __version__
from nvcore.common.errors import MediaError, ParameterError
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import one_line
from nvcore.comparison.compare import Result
from nvcore.figures.overlay.annotate import annotate, provenance
from nvcore.figures.overlay.brush import BLANK_RGB, Canvas
from nvcore.pictures.base import PictureReader
from nvcore.pictures.run import PictureRun

_CODEC: Final = "libvpx-vp9"
"""libx264 is not used because its licence is the GPL (docs/decisions/038)."""
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
"""Minimum and maximum frames per second of a video."""


def write_video(
    result: Result,
    pictures: Mapping[int, PictureReader],
    recording: int,
    row_start: int,
    row_stop: int,
    path: Path,
    *,
    fps: float,
    progress: Progress = no_progress,
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
        Pictures by recording. Boxes are drawn on a dark blank if this recording has none.
    recording
        Row of the recordings table.
    row_start, row_stop
        Rows of the frames table, all of this recording.
    path
        The file is replaced, and removed if the run fails or is cancelled.
    fps
        Frames per second of the video, 0.1..240.
    progress
        See `nvcore.pictures.run.PictureRun`.
    indices
        Picture of every frame of the recording, -1 none (`nvcore.pictures.map_frames`). None:
        no frame has a picture.
    lo, hi, labels
        See `nvcore.figures.overlay.annotate`.

    Raises
    ------
    ParameterError
        If `fps` is out of range, there are no frames, or the length of `indices` is wrong.
    MediaError
        If the file cannot be written.
    """
    if not FPS_RANGE[0] <= fps <= FPS_RANGE[1]:
        raise ParameterError(f"fps: expected {FPS_RANGE[0]:g} to {FPS_RANGE[1]:g}, got {fps:g}")
    frames = result.dataset.frame_columns
    own = frames.rows_of(recording)
    if not own.start <= row_start < row_stop <= own.stop:
        raise ParameterError(
            f"expected frames of the recording, rows {own.start} to {own.stop}, got {row_start} to "
            f"{row_stop}"
        )
    if indices is None:
        indices = np.full(own.stop - own.start, -1)
    if len(indices) != own.stop - own.start:
        raise ParameterError(
            f"indices: expected {own.stop - own.start} pictures, got {len(indices)}"
        )
    index = indices[row_start - own.start : row_stop - own.start].tolist()
    numbered = zip(range(row_start, row_stop), index, strict=True)
    name = one_line(str(result.dataset.recordings["name"].iloc[recording]))

    def draw(row: int, index: int) -> Canvas:
        return annotate(result, pictures.get(recording), index, row, lo=lo, hi=hi, labels=labels)

    # long numbers may need one line more in the caption
    ends = [annotate(result, None, -1, row).shape[:2] for row in (row_start, row_stop - 1)]
    height, width = np.maximum(*ends).tolist()
    try:
        with av.open(
            f"file:{path.absolute()}", "w", format="mp4", options={"movflags": "+faststart"}
        ) as container:
            container.metadata["title"] = one_line(
                f"{name}, frames {frames.frame[row_start]} to {frames.frame[row_stop - 1]}: "
                f"{result.x.name} and {result.y.name}, nvcore {__version__}"
            )
            container.metadata["comment"] = provenance(result)
            stream = container.add_stream(_CODEC, rate=Fraction(fps).limit_denominator(1001))
            stream.pix_fmt = "yuv420p"
            stream.codec_context.gop_size = _KEY_EVERY
            stream.options = dict(_OPTIONS)
            stream.width, stream.height = width, height
            # one thread draws while this one encodes
            run = PictureRun(len(index), progress, n_threads=1)
            for drawing in run.map(draw, numbered, name):
                picture = np.full((height, width, 3), BLANK_RGB, np.uint8)
                picture[: len(drawing)] = drawing[:height]
                container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
            container.mux(stream.encode(None))
    except BaseException as error:
        if path.is_file():
            path.unlink()
        if isinstance(error, av.error.FFmpegError | OSError):
            raise MediaError(
                "the video cannot be written; is there room, and may the folder be written to?",
                file=path.name,
            ) from error
        raise

"""A video that is written in the background."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ui.background_job import BackgroundJob, Progress


class VideoJob(BackgroundJob):
    """One video.

    Attributes
    ----------
    path
        Where it is written; there is a file only once the job is done.
    name
        File name for the download.
    """

    def __init__(
        self,
        path: Path,
        name: str,
        write: Callable[[Progress], bool],
        is_wanted: Callable[[], bool],
    ):
        """Start to write; see `BackgroundJob`."""
        self.path, self.name = path, name
        super().__init__(write, is_wanted)

    def discard(self) -> None:
        """Cancel, and remove the video if it is there."""
        self.cancel()
        self.join()
        self.path.unlink(missing_ok=True)

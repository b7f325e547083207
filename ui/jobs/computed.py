"""Values that a page computes at once if that is quick, else in the background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic

from nvcore.progress import Progress, no_progress
from ui.jobs.background import JobState, Output
from ui.jobs.page_run import PageRun
from ui.session import state


@dataclass(frozen=True)
class Computation(Generic[Output]):
    """Computation of a value for a key, and its name in sentences (see `PageRun`)."""

    kind: str
    key: Any
    compute: Callable[[Progress], Output]
    thing: str
    doing: str
    most: int

    @property
    def run(self) -> PageRun[Output]:
        """The kind of background job that computes it."""
        return PageRun(self.kind, self.thing, self.doing)

    def start(self) -> None:
        """Start computing it in the background."""
        self.run.start(self.compute, key=self.key)

    def draw(self, *, is_quick: bool) -> tuple[Output | None, bool]:
        """Return the value, None until computed, and whether the page should offer to `start`."""
        job = self.run.job
        if job is not None and job.key == self.key:
            job_state = self.run.draw(job)
            if job_state.is_busy:
                return None, False
            if job_state is JobState.DONE:
                keep = state.workspace().cached
                return keep(self.kind, self.key, lambda: job.output, most=self.most), False
        if not is_quick and state.known(self.kind, self.key) is None:
            return None, True
        make = partial(self.compute, no_progress)
        return state.cached(self.kind, self.key, make, most=self.most), False

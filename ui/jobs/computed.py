"""Values that a page computes at once if that is quick, else in the background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic

from nvcore.progress import Progress, no_progress
from ui.jobs.background import BackgroundJob, JobState, Output, while_open
from ui.jobs.progress import draw_job
from ui.session import state


@dataclass(frozen=True)
class Computation(Generic[Output]):
    """Computation of a value for a key, and its name in sentences (see `draw_job`)."""

    kind: str
    key: Any
    compute: Callable[[Progress], Output]
    thing: str
    doing: str
    most: int

    def start(self) -> None:
        """Start computing it in the background."""
        space = state.workspace()
        space.put_job(self.kind, BackgroundJob(self.compute, while_open(space), key=self.key))

    def draw(self, *, is_quick: bool) -> tuple[Output | None, bool]:
        """Return the value, None until computed, and whether the page should offer to `start`."""
        space = state.workspace()
        job: BackgroundJob[Output] | None = space.job(self.kind)
        if job is not None and job.key == self.key:
            job_state = draw_job(job, self.kind, thing=self.thing, doing=self.doing)
            if job_state.is_busy:
                return None, False
            if job_state is JobState.DONE:
                output = space.cached(self.kind, self.key, lambda: job.output, most=self.most)
                return output, False
        if not is_quick and state.known(self.kind, self.key) is None:
            return None, True
        make = partial(self.compute, no_progress)
        return state.cached(self.kind, self.key, make, most=self.most), False

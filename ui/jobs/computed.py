"""Values that a page shows at once where they are quickly made, else makes in the background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic

from nvcore.progress import Progress, no_progress
from ui.jobs.background import BackgroundJob, JobState, Output, while_open
from ui.jobs.progress import draw_job
from ui.session import state


@dataclass(frozen=True)
class Computation(Generic[Output]):
    """How a value is made, for which key, and what a sentence calls it (see `draw_job`)."""

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
        """The value, None until computed, and whether the page should offer to `start` it."""
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
        result = state.cached(
            self.kind, self.key, lambda: self.compute(no_progress), most=self.most
        )
        return result, False

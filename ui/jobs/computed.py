"""Values that a page computes at once if that is quick, else in the background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, Generic

import streamlit as st

from nvcore.common.progress import Progress, no_progress
from ui.jobs.background import JobState, Output
from ui.jobs.page_run import PageRun
from ui.session import state

MOST: Final = 8
"""Cached values of a kind."""


@dataclass(frozen=True)
class Computation(Generic[Output]):
    """Computation of a value for a key, in the background by a kind of run."""

    run: PageRun[Output]
    key: Any
    compute: Callable[[Progress], Output]

    def start(self) -> None:
        """Start computing it in the background."""
        self.run.start(self.compute, key=self.key)

    def draw(self, *, is_quick: bool) -> tuple[Output | None, bool]:
        """Return the value, None until computed, and whether the page should offer to `start`."""
        job, kind = self.run.job, self.run.name
        if job is not None and job.key == self.key:
            job_state = self.run.draw(job)
            if job_state.is_busy:
                return None, False
            if job_state is JobState.DONE:
                keep = state.workspace().cached
                return keep(kind, self.key, lambda: job.output, most=MOST), False
        if not is_quick and state.known(kind, self.key) is None:
            return None, True
        return state.cached(kind, self.key, partial(self.compute, no_progress), most=MOST), False

    def draw_or_offer(
        self, label: str, icon: str, hint: str = "", *, is_quick: bool, **options: Any
    ) -> Output | None:
        """Return the value, as `draw`. Draw the button that starts computing it if necessary."""
        output, is_to_start = self.draw(is_quick=is_quick)
        if is_to_start:
            key, icon = f"{self.run.name}_start", f":material/{icon}:"
            st.button(label, key=key, icon=icon, on_click=self.start, **options)
            if hint:
                st.caption(hint)
        return output

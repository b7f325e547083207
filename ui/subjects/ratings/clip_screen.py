"""Screen of a rater: a clip with the boxes of one system and the scale, or an alert."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeVar

import numpy as np
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.pictures.stretch import STRETCH
from nvcore.subjects.ratings.clip_task import Clip, RatingStore, RatingStudy, Shown
from nvcore.subjects.ratings.clips import rows_between
from nvcore.subjects.ratings.worth import ANSWERS, Alert
from ui.session import state
from ui.session.store import RATING_CHANGES
from ui.subjects.people.participant import draw_code
from ui.widgets.buttons import button
from ui.widgets.drawing import viewer_arguments
from ui.widgets.viewer import n_plays_in, viewer

ENDS: Final = ("not annoying at all", "very annoying")
"""Labels of the ends of the scale. (Our choice: the paper gives none.)"""
HEIGHT_PX: Final = 640
BEFORE_S: Final = 5.0
AFTER_S: Final = 2.0
"""Seconds shown before and after an alert. (Our choice.)"""
Letter = Literal["x", "y"]
Choice = TypeVar("Choice", int, str)


@dataclass(frozen=True)
class ClipScreen:
    """Screen of one rater of a session, while its comparison is open."""

    result: Result
    store: RatingStore
    study: RatingStudy
    name: str

    def draw(self, plan: Sequence[Shown], left: Sequence[Shown]) -> bool:
        """Draw the next clip or alert, or the last clip again. Return False if none is left."""
        rated = [shown for shown in plan if shown.table == "rating" and shown not in left]
        if rated and RATING_CHANGES.get():
            self._change(rated[-1].place)
            return True
        if not left:
            return False
        kind, place = left[0]
        alike = [shown for shown in plan if shown.table == kind]
        n, number = len(alike), alike.index(left[0]) + 1
        st.markdown(f"# {'Clip' if kind == 'rating' else 'Alert'} {number} of {n}")
        st.progress((number - 1) / n)
        if len(left) == len(plan):
            draw_code()
        if kind == "worth":
            self._alert(place)
            return True
        key = f"clip_{place}_of_{self.name}"
        if self._has_played(self.study.clips[place], self.study.clips[place].stretch_s, key):
            self._ask(place, key)
        else:
            st.caption("Watch the clip to its end; then say how annoying it was.")
        if rated:
            offer_change()
        return True

    def _change(self, clip: int) -> None:
        """Draw a rated clip again, which may be rated without watching it."""
        rating = self.store.ratings_of(self.study, self.name)[clip]
        key = f"again_{clip}_of_{self.name}"
        st.markdown("# Your last clip")
        st.markdown(f"You gave it **{rating}**. You may watch it again, and give another rating.")
        self._has_played(self.study.clips[clip], self.study.clips[clip].stretch_s, key)
        self._ask(clip, key)
        if button(f"Keep {rating}", key="rating_keep", icon=":material/arrow_forward:"):
            RATING_CHANGES.set(False)
            st.rerun()

    def _ask(self, clip: int, key: str) -> None:
        """Draw the scale, and keep the value of the pressed button."""
        low, high = self.study.low, self.study.high
        with st.container(key="rating_scale"):
            st.markdown("**How annoying would it be to drive with this system?**")
            values = {value: str(value) for value in range(low, high + 1)}
            rating = _press_one(values, f"rating_{clip}")
            left, right = st.columns(2)
            left.caption(f"{low} = {ENDS[0]}")
            right.caption(f"{high} = {ENDS[1]}", text_alignment="right")
        if rating is not None:
            self.store.rate(self.study, self.name, clip, rating, n_plays=n_plays_in(key))
            RATING_CHANGES.set(False)
            st.rerun()

    def _alert(self, number: int) -> None:
        """Draw an alert with what happens around it, and ask whether it was worth it."""
        alert = self.study.alerts[number]
        begin_s = max(0.0, alert.start_s - BEFORE_S)
        st.markdown(
            f"In this clip, after **{alert.start_s - begin_s:.1f} s**, the system alerts the "
            f"driver, for {alert.end_s - alert.start_s:.1f} s: a warning sign then stands in the "
            "picture."
        )
        signs_s = [(alert.start_s, alert.end_s)]
        stretch_s, key = (begin_s, alert.end_s + AFTER_S), f"alert_{number}_of_{self.name}"
        if not self._has_played(alert, stretch_s, key, signs_s=signs_s):
            st.caption("Watch the clip to its end; then say whether the alert was worth it.")
            return
        with st.container(key="rating_scale"):
            st.markdown("**Was this alert worth it?**")
            answer = _press_one(ANSWERS, f"worth_{number}")
        if answer is not None:
            self.store.judge(self.study, self.name, number, answer)
            st.rerun()

    def _has_played(
        self,
        of: Clip | Alert,
        stretch_s: tuple[float, float],
        key: str,
        *,
        signs_s: Sequence[tuple[float, float]] = (),
    ) -> bool:
        """Show a stretch of a recording, and return True once it has played to its end.

        Parameters
        ----------
        stretch_s
            Start and end, s. NaN: the whole recording.
        signs_s
            Starts and ends of warning signs in the picture, s.
        """
        result = self.result
        recording = state.recording_names().index(of.recording)
        letter: Letter = "x" if of.system == result.x.name else "y"
        n_rows = len(state.frame_numbers(recording))
        first = int(result.dataset.frame_columns.first[recording])
        rows, *signs = (
            range(own.start - first, own.stop - first)
            for own in (rows_between(result.dataset, recording, *s) for s in (stretch_s, *signs_s))
        )
        rows = rows or range(n_rows)
        lo, hi = STRETCH
        nothing = np.full(n_rows, np.nan)
        row = viewer(
            **viewer_arguments(result, recording, with_visible=False),
            traces={"x": nothing, "y": nothing},
            low=0.0,
            intervals=([(of.start, of.stop) for of in signs], ()),
            misses=(),
            names=("", ""),
            seek=(rows.start, 0),
            lo=lo,
            hi=hi,
            height_px=HEIGHT_PX,
            key=key,
            only=letter,
            rows=rows,
        )
        return row is None or row == rows[-1]


def offer_change() -> None:
    """Draw the button that shows the last rated clip again."""
    if button(
        "Change my last rating", key="rating_change", type="tertiary", icon=":material/undo:"
    ):
        RATING_CHANGES.set(True)
        st.rerun()


def _press_one(choices: Mapping[Choice, str], key: str) -> Choice | None:
    """Draw a button for each choice, side by side, and return the one that was pressed."""
    pressed = None
    for (choice, label), column in zip(choices.items(), st.columns(len(choices)), strict=True):
        if button(label, key=f"{key}_{choice}", width="stretch", at=column):
            pressed = choice
    return pressed

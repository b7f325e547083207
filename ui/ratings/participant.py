"""What a participant of a rating session sees: one clip after the other, and the scale."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

import numpy as np
import streamlit as st

from nvcore.comparison import Result
from nvcore.errors import InputError
from nvcore.people.participants import MOST_NAME
from nvcore.pictures.stretch import STRETCH
from nvcore.ratings.clips import rows_between
from nvcore.ratings.store import Clip, RatingStore, Study
from nvcore.ratings.worth import ANSWERS, Alert
from nvcore.wording import count_text
from ui.people.form import draw_form
from ui.people.studies import PARTICIPANT, STUDY, enter
from ui.people.terms import draw_consent
from ui.ratings.sessions import SESSIONS, set_thresholds, thresholds_apart
from ui.session import state
from ui.session.store import RATING_CHANGES, RATING_NAME, RATING_THRESHOLDS, RATING_WAITING
from ui.shell.navigate import open_page
from ui.widgets.buttons import button, submit_button
from ui.widgets.drawing import viewer_arguments
from ui.widgets.text import plain
from ui.widgets.viewer import n_plays_in, viewer

ENDS: Final = ("not annoying at all", "very annoying")
"""Words at the ends of the scale; they are ours, the paper gives none."""
HEIGHT_PX: Final = 640
BEFORE_S: Final = 5.0
AFTER_S: Final = 2.0
"""What is shown before and after an alert; ours."""
Letter = Literal["x", "y"]


def draw() -> None:
    """The page for somebody who takes part: nothing else of the app is in sight."""
    token = st.query_params[STUDY]
    store = SESSIONS.store()
    study = store.study(token)
    if study is None:
        st.title("Rate clips")
        st.error("This link leads to no rating session. Ask for it again.")
        return
    result = state.result()
    if result is None or not _is_open(study):
        RATING_WAITING.set((token, st.query_params.get(PARTICIPANT)))
        st.query_params.clear()
        st.rerun()
    RATING_WAITING.pop()
    _show_its_boxes(study)
    name = st.query_params.get(PARTICIPANT, "")
    is_name = 0 < len(name.strip()) <= MOST_NAME
    if not is_name or not store.may_rate(study, name):
        _welcome(study, store)
        return
    order = store.order(study, name)
    rated = store.ratings_of(study, name)
    left = [clip for clip in order if clip not in rated]
    judged = store.judged(study, name) if study.alerts else set()
    alerts = [of for of in store.order(study, name, of="alerts") if of not in judged]
    rated_clips = [clip for clip in order if clip in rated]
    if rated_clips and RATING_CHANGES.get():
        _change(result, study, store, name, rated_clips[-1])
    elif left:
        _clip(result, study, store, name, left)
    elif alerts:
        _alert(result, study, store, name, alerts)
    else:
        _thanks(study)


def draw_waiting() -> None:
    """The page for a participant's link that was opened while another comparison is open."""
    waiting = RATING_WAITING.get()
    if waiting is None:
        return
    token, name = waiting
    study = SESSIONS.store().study(token)
    if study is None:
        RATING_WAITING.pop()
        return
    if not _is_open(study):
        st.warning(
            "The rating session of this link is about another comparison than the one that is "
            "open. Open its files on the Data page, with the same systems as X and Y, then come "
            "back to this page: it goes on from there. Ratings that were given are kept.",
            icon=":material/folder_open:",
        )
        if button("Open the Data page", type="primary", key="rating_open_data"):
            open_page("data")
        return
    st.info("The comparison of the rating session is open now.")
    if button("Go on with the rating session", type="primary", key="rating_go_on"):
        enter(token, name)


def _is_open(study: Study) -> bool:
    """Whether what is open has the clips of the study."""
    systems = {clip.system for clip in study.clips} | {alert.system for alert in study.alerts}
    return state.opened().dataset.fingerprint == study.fingerprint and systems <= set(
        state.systems()
    )


def _show_its_boxes(study: Study) -> None:
    """Take the study's thresholds: everybody sees the same boxes."""
    apart = thresholds_apart(study)
    if not apart:
        return
    if SESSIONS.is_own(study):
        live = {name: of_page for name, (_, of_page) in apart.items()}
        RATING_THRESHOLDS.set(live | RATING_THRESHOLDS.get())
    set_thresholds({name: of_clips for name, (of_clips, _) in apart.items()})
    st.rerun()


def _welcome(study: Study, store: RatingStore) -> None:
    st.title("Rate clips")
    n = len(study.clips)
    st.markdown(
        f"You will see **{n} short clip{'s' if n != 1 else ''}** of drives. A system that "
        "looks out for pedestrians draws a box around everyone it finds.\n\n"
        "Imagine that you drive with this system. After each clip, say **how annoying** its "
        f"mistakes are, from {study.low} ({ENDS[0]}) to {study.high} ({ENDS[1]}). There is no "
        "right or wrong answer. Every rating is kept at once: you may stop at any time and go on "
        "later with the same name."
    )
    if study.alerts:
        st.markdown(
            f"Then you see {count_text(len(study.alerts), 'alert')} of such a system, and say of "
            "each whether it was worth it."
        )
    if study.consent:
        draw_consent(study.consent)
    if study.ends_at is not None:
        st.markdown(
            f"Your ratings are kept until **{study.ends_at:%d %B %Y}** and then deleted, earlier "
            "if you ask for it."
        )
    with st.form("rating_join", border=False):
        answers = {}
        if study.form:
            st.markdown("**About you.** Leave empty what you do not want to say.")
            answers = draw_form(study.form, "rating")
        name = st.text_input(
            "Your name, or the code that you were given",
            key="rating_name",
            max_chars=MOST_NAME,
            autocomplete="off",
            width=420,
        )
        agrees = bool(study.consent) and st.checkbox(
            "I have read this and agree to take part", key="rating_agrees"
        )
        is_sent = submit_button("Begin", type="primary", key="rating_begin")
    if is_sent and not agrees and not store.may_rate(study, name or ""):
        st.warning("Without your agreement nothing is kept, and there is nothing to rate.")
    elif is_sent:
        RATING_NAME.set("")
        typed_name = (name or "").strip()
        if store.ratings_of(study, typed_name):
            RATING_NAME.set(typed_name)
        else:
            _join(study, store, typed_name, answers)
    if known := RATING_NAME.get():
        st.info(
            f"{plain(known)} has rated {len(store.ratings_of(study, known))} of {n} clips already. "
            "If that was somebody else, choose another name."
        )
        if button(f"I am {plain(known)}: go on", key="rating_known"):
            RATING_NAME.set("")
            _join(study, store, known, {})
    _back(study)


def _join(study: Study, store: RatingStore, name: str, answers: dict[str, str]) -> None:
    try:
        store.order(study, name)
        if study.consent:
            store.agree(study, name)
        store.fill_in(study, name, answers)
    except InputError as error:
        st.error(plain(str(error)))
    else:
        st.query_params[PARTICIPANT] = name
        st.rerun()


def _clip(result: Result, study: Study, store: RatingStore, name: str, left: list[int]) -> None:
    clip, n = left[0], len(study.clips)
    number = n - len(left) + 1
    st.markdown(f"# Clip {number} of {n}")
    st.progress((number - 1) / n)
    key = f"clip_{clip}_of_{name}"
    if not _played(result, study.clips[clip], study.clips[clip].stretch_s, key):
        st.caption("Watch the clip to its end; then say how annoying it was.")
    else:
        _ask(study, store, name, clip, key)
    if number > 1:
        _offer_change()


def _offer_change() -> None:
    if button(
        "Change my last rating", key="rating_change", type="tertiary", icon=":material/undo:"
    ):
        RATING_CHANGES.set(True)
        st.rerun()


def _change(result: Result, study: Study, store: RatingStore, name: str, clip: int) -> None:
    """The clip that was rated last, once more; it may be rated without being watched again."""
    rating, key = store.ratings_of(study, name)[clip], f"again_{clip}_of_{name}"
    st.markdown("# Your last clip")
    st.markdown(f"You gave it **{rating}**. You may watch it again, and give another rating.")
    _played(result, study.clips[clip], study.clips[clip].stretch_s, key)
    _ask(study, store, name, clip, key)
    if button(f"Keep {rating}", key="rating_keep", icon=":material/arrow_forward:"):
        RATING_CHANGES.set(False)
        st.rerun()


def _ask(study: Study, store: RatingStore, name: str, clip: int, key: str) -> None:
    with st.container(key="rating_scale"):
        st.markdown("**How annoying would it be to drive with this system?**")
        rating = _scale(study, clip)
    if rating is not None:
        store.rate(study, name, clip, rating, n_plays=n_plays_in(key))
        RATING_CHANGES.set(False)
        st.rerun()


def _scale(study: Study, clip: int) -> int | None:
    """The buttons of the scale; the value of the one that was pressed."""
    values = range(study.low, study.high + 1)
    chosen = None
    for value, column in zip(values, st.columns(len(values)), strict=True):
        if button(str(value), key=f"rating_{clip}_{value}", width="stretch", at=column):
            chosen = value
    left, right = st.columns(2)
    left.caption(f"{study.low} = {ENDS[0]}")
    right.caption(f"{study.high} = {ENDS[1]}", text_alignment="right")
    return chosen


def _alert(result: Result, study: Study, store: RatingStore, name: str, left: list[int]) -> None:
    """An alert with what happens around it, and whether it was worth it."""
    alert, n = left[0], len(study.alerts)
    number = n - len(left) + 1
    shown, key = study.alerts[alert], f"alert_{alert}_of_{name}"
    begin_s = max(0.0, shown.start_s - BEFORE_S)
    stretch_s = (begin_s, shown.end_s + AFTER_S)
    st.markdown(f"# Alert {number} of {n}")
    st.progress((number - 1) / n)
    st.markdown(
        f"In this clip, after **{shown.start_s - begin_s:.1f} s**, the system alerts the driver, "
        f"for {shown.end_s - shown.start_s:.1f} s: a warning sign then stands in the picture."
    )
    if not _played(result, shown, stretch_s, key, signs_s=[(shown.start_s, shown.end_s)]):
        st.caption("Watch the clip to its end; then say whether the alert was worth it.")
        return
    with st.container(key="rating_scale"):
        st.markdown("**Was this alert worth it?**")
        columns = st.columns(len(ANSWERS))
        for (answer, label), column in zip(ANSWERS.items(), columns, strict=True):
            if button(label, key=f"worth_{alert}_{answer}", width="stretch", at=column):
                store.judge(study, name, alert, answer)
                st.rerun()


def _played(
    result: Result,
    of: Clip | Alert,
    stretch_s: tuple[float, float],
    key: str,
    *,
    signs_s: Sequence[tuple[float, float]] = (),
) -> bool:
    """Show a stretch (s; NaN: all) of a recording with a system; whether it was seen to its end.

    From and to the times `signs_s` a warning sign is shown.
    """
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


def _thanks(study: Study) -> None:
    st.title("Thank you")
    alerts = f", all {len(study.alerts)} alerts answered" if study.alerts else ""
    st.success(f"All {len(study.clips)} clips are rated{alerts}, and what you said is kept.")
    _offer_change()
    if button("Next participant", key="rating_next"):
        del st.query_params[PARTICIPANT]
        st.rerun()
    _back(study)


def _back(study: Study) -> None:
    """The way back for who conducts on this very screen."""
    if SESSIONS.is_own(study) and button(
        "Back to the results", key="rating_back", type="tertiary", icon=":material/arrow_back:"
    ):
        st.query_params.clear()
        SESSIONS.conduct(study)
        set_thresholds(RATING_THRESHOLDS.pop())
        st.rerun()

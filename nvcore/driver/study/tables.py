"""Trials, participants and boxes of a study as tables."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import pandas as pd

from nvcore.driver.inputs.picture_boxes import BOX, PEDESTRIAN
from nvcore.driver.inputs.trials import NO_ANSWER, TRIAL_COLUMNS, is_off_time
from nvcore.driver.study.plan import Trial
from nvcore.driver.study.records import Answer, DetectabilityStudy
from nvcore.driver.study.settings import Timing
from nvcore.driver.study.store import DetectabilityStore


def marks_of(trial: Trial, answer: Answer, n_shown: int, timing: Timing) -> list[str]:
    """What was not as it should be, in words; empty: nothing.

    A trial is marked if its picture came more than 50 ms early or late, was to be seen for 50 ms
    less or more than asked, was shown before (the page was loaded again before the answer), was
    never reported as shown, or has no answer in the time given.

    Parameters
    ----------
    n_shown
        How often the browser reported that the picture appears.
    """
    marks = []
    late_s = answer.measured_s - trial.adaptation_s
    if is_off_time(late_s):
        marks.append(f"{abs(late_s):.2f} s {'late' if late_s > 0 else 'early'}")
    if is_off_time(answer.shown_s - timing.show_s):
        marks.append(f"shown for {answer.shown_s:.2f} s")
    if n_shown > 1:
        marks.append(f"shown {n_shown} times")
    if n_shown == 0:
        marks.append("never reported as shown")
    if not answer.is_answered:
        marks.append(NO_ANSWER)
    return marks


def trials_table(store: DetectabilityStore, study: DetectabilityStudy) -> pd.DataFrame:
    """All trials with an answer, or whose time for one is over, as they are handed on.

    Returns
    -------
    The columns `TRIAL_COLUMNS`: ``subject`` is the participant's code; ``run``, ``position`` (in
    the run) and ``order`` (of all trials of the subject) count from 1; seconds and pixels of the
    picture; ``not_seen`` is also true where there is no answer; ``device`` says with what was
    answered and, after "marked:", what was not as it should be (`marks_of`).
    """
    answers, rows = store.answers(study), []
    for participant in store.participants(study):
        of_participant = answers.get(participant.code, {})
        for trial in participant.plan:
            if trial.order not in of_participant:
                continue
            answer, n_shown = of_participant[trial.order]
            rows.append(_row(study, participant.code, trial, answer, n_shown))
    table = pd.DataFrame(rows, columns=list(TRIAL_COLUMNS))
    kinds = dict.fromkeys(("run", "position", "order"), "int64")
    kinds |= dict.fromkeys(TRIAL_COLUMNS[6:11], "float64")
    return table.astype({**kinds, "not_seen": bool})


def _row(
    study: DetectabilityStudy, code: str, trial: Trial, answer: Answer, n_shown: int
) -> tuple[Any, ...]:
    picture = study.pictures[trial.picture]
    marks = marks_of(trial, answer, n_shown, study.settings.timing)
    device = "; ".join(
        part for part in (answer.device, f"marked: {', '.join(marks)}" if marks else "") if part
    )
    return (
        *(code, trial.run, trial.position, trial.order, picture.image, picture.pedestrian),
        *(trial.adaptation_s, answer.measured_s, answer.touch_x, answer.touch_y),
        *(answer.response_s, not answer.is_seen, device),
    )


def participants_table(store: DetectabilityStore, study: DetectabilityStudy) -> pd.DataFrame:
    """Who takes part: a row each.

    Returns
    -------
    ``subject``, ``joined`` (date), ``n_trials``, ``n_answered``, ``n_marked``, and what the form
    asked for; empty where nothing was entered.
    """
    answers, rows = store.answers(study), []
    for participant in store.participants(study):
        of_participant = answers.get(participant.code, {})
        n_marked = sum(
            bool(marks_of(trial, *of_participant[trial.order], study.settings.timing))
            for trial in participant.plan
            if trial.order in of_participant
        )
        numbers = (len(participant.plan), len(of_participant), n_marked)
        form = [participant.form.get(field, "") for field in study.settings.form]
        rows.append(
            (participant.code, participant.consented_at.date().isoformat(), *numbers, *form)
        )
    first = ("subject", "joined", "n_trials", "n_answered", "n_marked")
    return pd.DataFrame(rows, columns=[*first, *study.settings.form])


@dataclass(frozen=True)
class Advance:
    """How far a study has come.

    Attributes
    ----------
    n_participants
        Who has joined.
    n_finished
        Participants who have answered all their trials, or whose time for an answer was over.
    n_trials
        Trials so far, of all participants: the rows of `trials_table`.
    n_marked
        Those of them that are marked (`marks_of`); fewer is better.
    """

    n_participants: int
    n_finished: int
    n_trials: int
    n_marked: int


def advance_of(participants: pd.DataFrame) -> Advance:
    """How far a study has come; all 0 where nobody has joined.

    Parameters
    ----------
    participants
        `participants_table` of the study.

    Examples
    --------
    >>> advance_of(pd.DataFrame({"n_trials": [6, 6], "n_answered": [6, 2], "n_marked": [1, 0]}))
    Advance(n_participants=2, n_finished=1, n_trials=8, n_marked=1)
    """
    is_finished = participants["n_answered"] == participants["n_trials"]
    return Advance(
        len(participants),
        int(is_finished.sum()),
        int(participants["n_answered"].sum()),
        int(participants["n_marked"].sum()),
    )


def boxes_table(study: DetectabilityStudy) -> pd.DataFrame:
    """Where the pedestrians are: ``image``, ``pedestrian``, ``x``, ``y``, ``w``, ``h`` (px)."""
    table = pd.DataFrame([asdict(picture) for picture in study.pictures])
    return table[[*PEDESTRIAN, *BOX]]


def about(study: DetectabilityStudy) -> dict[str, Any]:
    """How the study was done, as values of JSON: settings, facts, pictures, dates; no person."""
    return {
        "begun_at": study.begun_at.isoformat(),
        "deleted_at": study.ends_at.isoformat(),
        **study.settings.to_json(),
        "pictures": [asdict(picture) for picture in study.pictures],
    }

"""Plan of each participant's trials: runs, pictures, and times after the change of light."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from nvcore.common.errors import InputError
from nvcore.subjects.driver.study.settings import Design, Timing

MOST_TRIALS: Final = 3000
"""Maximum number of trials per participant: 500 pictures at six times, some twenty hours."""
SEED: Final = 20_140_051
N_ORDERS: Final = 5
"""Number of random orders of runs to try. The one with the fewest picture repeats is used."""
ANSWER_S: Final = 2.0
"""Assumed time per answer without a time limit, for the expected duration."""
BETWEEN_RUNS_S: Final = 2.0
"""Assumed time to begin the next run, for the expected duration."""


class Trial(NamedTuple):
    """One picture that a participant is shown.

    Attributes
    ----------
    order
        Number among all trials of the participant, from 1.
    run, position
        Number of the run, and position in it, from 1.
    picture
        0-based index of the picture.
    adaptation_s
        Seconds from the change of light to the picture's appearance.
    """

    order: int
    run: int
    position: int
    picture: int
    adaptation_s: float

    @property
    def table(self) -> str:
        """Table of the answer."""
        return "trial"

    @property
    def place(self) -> int:
        """Number of the answer in its table."""
        return self.order


def plan_trials(
    n_pictures: int, participant: int, *, design: Design, timing: Timing
) -> tuple[Trial, ...]:
    """Return the trials of a participant in order. Equal numbers give equal trials.

    With ``all``, every picture is shown at every time, and the two pictures of a run differ. With
    ``latin``, every picture is shown once, and over as many participants as there are times, every
    picture is shown at every time once. If the pictures do not fill all runs, a run has one
    picture. The order of the runs is random, but avoids showing a picture in two consecutive runs.

    Parameters
    ----------
    n_pictures
        Number of pictures.
    participant
        0-based number of the participant.

    Raises
    ------
    InputError
        If there is no picture, only one with ``all``, or there are too many trials.

    Examples
    --------
    >>> trials = plan_trials(6, 0, design="latin", timing=Timing())
    >>> len(trials), trials[-1].run
    (6, 3)
    """
    least = 2 if design == "all" else 1
    if n_pictures < least:
        raise InputError(f"a study of this design needs {least} pictures at least")
    times = timing.adaptation_s
    n_trials = n_pictures * (len(times) if design == "all" else 1)
    if n_trials > MOST_TRIALS:
        raise InputError(
            f"each participant would see {n_trials:,} pictures, and {MOST_TRIALS:,} are the most; "
            "take fewer pictures or fewer times, or show every picture once"
        )
    rng = np.random.default_rng([SEED, participant])
    draw = _every_time if design == "all" else _latin_square
    runs = _in_order(draw(n_pictures, participant, timing.pairs, rng), rng)
    places = [
        (run, position, *shown)
        for run, pictures in enumerate(runs, start=1)
        for position, shown in enumerate(pictures, start=1)
    ]
    return tuple(Trial(order, *place) for order, place in enumerate(places, start=1))


_Run = list[tuple[int, float]]
"""Picture and time of each trial of a run."""
_Times = list[tuple[float, float]]


def _every_time(n: int, _participant: int, times: _Times, rng: np.random.Generator) -> list[_Run]:
    """Draw every picture at every time. First and second pictures have the same order, shifted."""
    runs: list[_Run] = []
    for first_s, second_s in times:
        first = rng.permutation(n)
        second = np.roll(first, int(rng.integers(1, n)))
        pairs = zip(first.tolist(), second.tolist(), strict=True)
        runs += [[(a, first_s), (b, second_s)] for a, b in pairs]
    return runs


def _latin_square(n: int, participant: int, times: _Times, rng: np.random.Generator) -> list[_Run]:
    """Draw every picture once. Neighbours in the list of pictures share a kind of run."""
    at_time: list[list[int]] = [[] for _ in range(2 * len(times))]
    for picture in range(n):
        at_time[(picture + participant) % len(at_time)].append(picture)
    runs: list[_Run] = []
    for k, (first_s, second_s) in enumerate(times):
        first, second = (rng.permutation(at_time[i]).tolist() for i in (2 * k, 2 * k + 1))
        for place in range(max(len(first), len(second))):
            run = [(int(a), first_s) for a in first[place : place + 1]]
            run += [(int(b), second_s) for b in second[place : place + 1]]
            runs.append(run)
    return runs


def _in_order(runs: list[_Run], rng: np.random.Generator) -> list[_Run]:
    """Return the runs in a random order that avoids a picture in two consecutive runs."""
    pictures = [{picture for picture, _ in run} for run in runs]
    orders = []
    for _ in range(N_ORDERS):
        first, *left = rng.permutation(len(runs)).tolist()
        order = [first]
        while left:  # take the first run that shares no picture with the previous one
            last = pictures[order[-1]]
            order.append(next((i for i in left if last.isdisjoint(pictures[i])), left[0]))
            left.remove(order[-1])
        orders.append(order)

    def n_repeats(order: list[int]) -> int:
        return sum(not pictures[a].isdisjoint(pictures[b]) for a, b in pairwise(order))

    return [runs[i] for i in min(orders, key=n_repeats)]


def duration_s(trials: Sequence[Trial], timing: Timing) -> float:
    """Return the expected duration of these trials, s.

    Each answer counts with its time limit, or with 2 s if there is none.
    """
    answer_s = timing.answer_s or ANSWER_S
    last_s: dict[int, float] = {}
    for trial in trials:
        last_s[trial.run] = max(trial.adaptation_s, last_s.get(trial.run, 0.0))
    fixed_s = timing.bright_s + timing.cross_s + timing.show_s + answer_s + BETWEEN_RUNS_S
    return sum(last_s.values()) + len(last_s) * fixed_s + len(trials) * timing.preview_s
